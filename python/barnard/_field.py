"""Fields: what a density may be made of."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from ._arrays import taken
from ._labelled import is_labelled, unfolded
from ._rows import Key, scene_error
from ._table import Table

_numbers = itertools.count(1)


class Field(Table):
    """A scalar field of a scene, used in expressions by its name in `Scene.fields`."""

    _path = "field.*"


class Sampled(Field):
    """A field whose key `file` may be an array in memory, or one in bricks."""

    def _begin(self, keys: dict[str, Any]) -> None:
        object.__setattr__(self, "_array", None)
        object.__setattr__(self, "_bricks", None)
        object.__setattr__(self, "_copy", keys.pop("copy", True))
        object.__setattr__(self, "_clips", bool(keys.get("clip")))
        super()._begin(keys)

    @property
    def values(self) -> np.ndarray | None:
        """The array, read-only; none where the field is read from a file, or lies in bricks."""
        return self._array

    @property
    def bricks(self) -> Any:
        """The Dask array, each of whose chunks is a brick; none where the field is no such array."""
        return self._bricks

    def _spoken(self, key: str, row: Key, value: Any) -> Any:
        if key != "file" or isinstance(value, str) or hasattr(value, "__fspath__"):
            return super()._spoken(key, row, value)
        if hasattr(value, "chunks") and hasattr(value, "dask"):
            if value.ndim != 3 or value.dtype.kind not in "fiu" or not all(n > 0 for n in value.shape):
                raise scene_error("grid", f"the Dask array has shape {value.shape} and type {value.dtype}; a field must have three axes of known lengths and real numbers")
            object.__setattr__(self, "_bricks", value)
            return f"bricks-{next(_numbers)}"
        if is_labelled(value):
            value, stated = unfolded(value, "grid")
            for name, text in stated.items():
                setattr(self, name, text)
        array, unit = taken(value, "grid", self._copy, self._clips)
        object.__setattr__(self, "_array", array)
        if unit is not None:
            self.unit = unit
        # A name of its own: what is made of an array is kept as long as the array is the same.
        return f"array-{next(_numbers)}"

    def _now(self, key: str) -> Any:
        # An array that was taken is read-only, and what is said of it is its name.
        return self._said[key] if key == "file" else super()._now(key)

    def __setattr__(self, key: str, value: Any) -> None:
        if key == "file":
            object.__setattr__(self, "_array", None)
            object.__setattr__(self, "_bricks", None)
        super().__setattr__(key, value)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Sampled) or (self._array is None) != (other._array is None):
            return NotImplemented if not isinstance(other, Sampled) else False
        if self._array is None:
            return super().__eq__(other)
        nodes, others = ({**field._nodes(), "file": ""} for field in (self, other))
        return nodes == others and np.array_equal(self._array, other._array)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        if self._array is None:
            return super().__repr__()
        keys = "".join(f", {key}={value!r}" for key, value in self._given.items() if key != "file")
        return f"{type(self).__name__}(<{self._array.dtype} {' x '.join(map(str, self._array.shape))}>{keys})"

    def __getstate__(self) -> dict[str, Any]:
        from .cluster import laid_down

        given = {key: value for key, value in self._given.items() if key != "file" or self._array is None}
        path = None if self._array is None else laid_down(self._array)
        array = self._array if path is None else path
        return {**super().__getstate__(), "_given": given, "_array": array, "_bricks": self._bricks, "_copy": True, "_clips": self._clips}

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__(state)
        if isinstance(self._array, str):
            # Pages that all processes of a machine have in common.
            object.__setattr__(self, "_array", np.load(self._array, mmap_mode="r"))
        if self._array is not None:
            self._array.flags.writeable = False
            self._said["file"] = f"array-{next(_numbers)}"
            self._given["file"] = self._array
