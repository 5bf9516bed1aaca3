"""Tables of a scene as objects: their attributes are the keys of scene files, from the same rows."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, ParamSpec, TypeVar

from ._rows import ROWS, Key, Row, scene_error, unknown_key
from ._values import stated_as, written
from ._warn import warn

if TYPE_CHECKING:
    from typing_extensions import Self

P = ParamSpec("P")
T = TypeVar("T")

_SPOKEN = "_said"
_GIVEN = "_given"

#: Classes of tables by their paths.
_CLASSES: dict[str, type[Table]] = {}


def checked(function: Callable[..., Any], place: str) -> Callable[..., Any]:
    """A function whose keywords are keys: one that it does not have is an error that says which it has."""
    known = [name for name in inspect.signature(function).parameters if name != "self"]

    @functools.wraps(function)
    def call(*arguments: Any, **keys: Any) -> Any:
        unknown = [key for key in keys if key not in known]
        if unknown:
            raise unknown_key(place, unknown[0], known)
        return function(*arguments, **keys)

    return call


def renamed(name: str, to: Callable[P, T]) -> Callable[P, T]:
    """A function under its old name, which warns."""

    def call(*arguments: P.args, **keys: P.kwargs) -> T:
        warn(f"{name} is deprecated; use {to.__name__}", DeprecationWarning)
        return to(*arguments, **keys)

    call.__name__ = call.__qualname__ = name
    call.__module__ = __package__ or ""
    call.__signature__ = inspect.signature(to)  # type: ignore[attr-defined]
    call.__doc__ = f"Deprecated name of `{to.__name__}`."
    return call


class Table:
    """One table of a scene.

    Its attributes are the keys that scene files have; one that was not said is None. A value is checked when it is set:
    its name, its type and its unit. Whether it lies in its range is checked where the scene is read.
    """

    _path: ClassVar[str]
    _kind: ClassVar[str | None] = None

    def __init__(self, **keys: Any):
        self._fill(**keys)

    def _fill(self, **keys: Any) -> None:
        """Begins the table and sets its keys; constructors of kinds require some of them."""
        self._begin(keys)
        # The kind says which other keys there are.
        for key in sorted(keys, key=lambda key: key != "kind"):
            if keys[key] is not None:
                setattr(self, key, keys[key])

    def _begin(self, keys: dict[str, Any]) -> None:
        """Makes the table empty, and takes what is no key out of `keys`."""
        object.__setattr__(self, _SPOKEN, {})
        object.__setattr__(self, _GIVEN, {})

    def __init_subclass__(cls, **options: Any):
        super().__init_subclass__(**options)
        if "_path" in cls.__dict__ and "__init__" in cls.__dict__:
            cls.__init__ = checked(cls.__init__, cls._place())  # type: ignore[method-assign]
            if cls._kind is None:
                _CLASSES[cls._path] = cls

    @classmethod
    def of(cls, keys: dict[str, Any]) -> Self:
        """A table of these keys, whether all that are needed are there or not."""
        table = cls.__new__(cls)
        table._fill(**keys)
        return table

    @classmethod
    def _row(cls) -> Row:
        return ROWS[cls._path]

    @classmethod
    def _place(cls) -> str:
        return cls._path.replace(".*", "")

    @property
    def _chosen(self) -> str | None:
        return self._kind or self._said.get("kind")

    def __setattr__(self, key: str, value: Any) -> None:
        row, place = self._row(), self._place()
        if key.startswith("_"):
            raise AttributeError(key)
        if key == "kind" and self._kind is not None:
            if value != self._kind:
                raise scene_error(f"{place}.kind", f"{type(self).__name__} is of the kind {self._kind!r}; make a table of the other kind")
            return
        if key == "kind" and row.kinds:
            if value is not None and value not in list(row.kinds):
                raise scene_error(f"{place}.kind", f"unknown kind {value!r}; known: {', '.join(row.kinds)}")
            self._keep(key, value, value)
            return
        known = row.all_keys(self._chosen)
        if key not in known:
            raise unknown_key(place, key, list(known))
        cls = _CLASSES.get(f"{self._path}.{key}")
        if cls is not None and isinstance(value, dict):
            value = cls.of(value)
        spoken = None if value is None else self._spoken(key, known[key], value)
        self._keep(key, value, spoken)

    def _spoken(self, key: str, row: Key, value: Any) -> Any:
        return stated_as(value, row, f"{self._place()}.{key}")

    def _now(self, key: str) -> Any:
        """Setting of a key: anew where its value may have been changed in place since it was set."""
        given = self._given[key]
        if isinstance(given, (list, tuple, dict)) or getattr(given, "ndim", 0) > 0:
            return self._spoken(key, self._row().all_keys(self._chosen)[key], given)
        return self._said[key]

    def _keep(self, key: str, value: Any, spoken: Any) -> None:
        if value is None:
            self._said.pop(key, None)
            self._given.pop(key, None)
        else:
            self._said[key] = spoken
            self._given[key] = value

    def __getattr__(self, key: str) -> Any:
        if key.startswith("_"):
            raise AttributeError(key)
        if key in self._row().all_keys(self._chosen) or (key == "kind" and self._row().kinds):
            return self._chosen if key == "kind" else self._given.get(key)
        raise AttributeError(str(unknown_key(self._place(), key, list(self._row().all_keys(self._chosen)))))

    def __dir__(self):
        return [*super().__dir__(), *self._row().all_keys(self._chosen)]

    def tree(self) -> dict[str, Any]:
        """The table as scene files have it: texts with units, numbers, lists and dictionaries."""
        return written(self._nodes())

    def _nodes(self) -> dict[str, Any]:
        """The table as the native part takes it: as `tree`, but quantities are (number, unit)."""
        kind = {"kind": self._kind} if self._kind else {}
        return {**kind, **{key: _unfolded(self._now(key)) for key in self._said}}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Table) and other._path == self._path and other._nodes() == self._nodes()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        keys = ", ".join(f"{key}={value!r}" for key, value in self._given.items())
        return f"{type(self).__name__}({keys})"

    def __getstate__(self) -> dict[str, Any]:
        return {_SPOKEN: self._said, _GIVEN: self._given}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            object.__setattr__(self, name, value)


def _unfolded(value: Any) -> Any:
    if isinstance(value, Table):
        return value._nodes()
    if isinstance(value, list):
        return [_unfolded(item) for item in value]
    if isinstance(value, dict):
        return {name: _unfolded(item) for name, item in value.items()}
    return value


def copied(value: Any, memo: dict[int, Any]) -> Any:
    """Tables, lists and dictionaries that can be changed apart from these; anything else, arrays too, is shared."""
    if id(value) in memo:
        return memo[id(value)]
    if isinstance(value, Table):
        twin = memo[id(value)] = type(value).__new__(type(value))
        for name, item in value.__dict__.items():
            object.__setattr__(twin, name, copied(item, memo))
        return twin
    if type(value) is dict:
        pairs = memo[id(value)] = {}
        pairs.update((key, copied(item, memo)) for key, item in value.items())
        return pairs
    if type(value) is list:
        items = memo[id(value)] = []
        items.extend(copied(item, memo) for item in value)
        return items
    return value


AnyTable = TypeVar("AnyTable", bound=Table)


def table_of(cls: type[AnyTable], value: Any, key: str) -> AnyTable:
    """A table as an object: one that is, or a dictionary of its keys."""
    if isinstance(value, cls):
        return value
    if isinstance(value, dict):
        return cls.of(value)
    raise scene_error(key, f"{value!r} is neither a {cls.__name__} nor a dictionary of its keys")
