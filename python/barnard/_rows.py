"""The rows of the native catalogues: which tables a scene has, their keys, and the units of quantities."""

from __future__ import annotations

import difflib
from dataclasses import dataclass, field

from . import _barnard


@dataclass(frozen=True)
class Key:
    """One key of a table."""

    name: str
    #: Meaning in one line.
    summary: str
    #: Type of the value, such as "length" or "list of numbers".
    value: str
    #: The type with its range or choices.
    words: str
    #: Quantities that the value is one of.
    quantities: list[str]
    #: Texts that the value is one of.
    choices: list[str]
    is_required: bool
    #: Default, or what determines it; none for a required key.
    default: str | None
    #: Condition under which an optional key is required.
    condition: str | None
    #: Parts of the scene that it changes, such as "spectra" or "view".
    parts: list[str]


@dataclass(frozen=True)
class Kind:
    """One kind of a table."""

    name: str
    summary: str
    keys: dict[str, Key]


@dataclass(frozen=True)
class Row:
    """One table of a scene."""

    path: str
    text: str
    keys: dict[str, Key]
    kinds: dict[str, Kind] = field(default_factory=dict)

    def all_keys(self, kind: str | None = None) -> dict[str, Key]:
        """The keys of a kind; of every kind where there is none."""
        kinds = self.kinds.values() if kind is None else [self.kinds[kind]] if kind in self.kinds else []
        every: dict[str, Key] = {}
        for each in kinds:
            every.update(each.keys)
        return {**self.keys, **every}


def _keys(rows) -> dict[str, Key]:
    return {row["name"]: Key(**row) for row in rows}


ROWS: dict[str, Row] = {
    path: Row(path, text, _keys(keys), {name: Kind(name, summary, _keys(rows)) for name, summary, rows in kinds})
    for path, text, keys, kinds in _barnard.schema()
}

#: The units of each quantity, name and size, and an example.
QUANTITIES: dict[str, tuple[list[tuple[str, float]], str]] = {name: (units, example) for name, units, example in _barnard.quantities()}


def scene_error(key: str, message: str) -> _barnard.SceneError:
    """The error that something is wrong with a key."""
    error = _barnard.SceneError(f"{key}: {message}")
    error.key = key
    return error


def unknown_key(place: str, key: str, known) -> _barnard.SceneError:
    """The error that a table has no such key, with the nearest that it has."""
    near = difflib.get_close_matches(key, known, 1, 0.5)
    hint = f', did you mean "{near[0]}"?' if near else ""
    return scene_error(f"{place}.{key}" if place else key, f'unknown key "{key}"{hint}; known: {", ".join(known)}')
