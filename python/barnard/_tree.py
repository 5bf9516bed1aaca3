"""The tree of a scene file: what a scene says in it, what it says of a scene, and the places in it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from . import tables
from ._field import Field
from ._rows import ROWS, scene_error, unknown_key
from ._table import Table, table_of
from .tables import Animation, Background, Band, Camera, Detail, Display, Dust, Emission, Frames, Gas, Instrument, Method, Observation, Output, Spectrograph, Star, StarTable

if TYPE_CHECKING:
    from .scene import Scene

#: Attributes that are lists of tables: their names in scene files, and their classes.
LISTS: dict[str, tuple[str, type[Table]]] = {
    "emission": ("emission", Emission),
    "stars": ("star", Star),
    "star_tables": ("star_table", StarTable),
    "passbands": ("band", Band),
    "animation": ("animation", Animation),
}
#: Attributes that are one table.
TABLES: dict[str, type[Table]] = {
    "camera": Camera,
    "dust": Dust,
    "gas": Gas,
    "background": Background,
    "detail": Detail,
    "spectrograph": Spectrograph,
    "display": Display,
    "observation": Observation,
    "instrument": Instrument,
    "output": Output,
    "method": Method,
    "sequence": Frames,
}
TEXTS = ("name", "description", "bands")
#: All attributes that say something.
PARTS = [*TEXTS, *TABLES, "fields", "bookmarks", *LISTS]


def take(scene: Scene, tree: dict[str, Any]) -> None:
    """Gives a scene what the tree of a scene file says."""
    parts = {file: name for name, (file, _) in LISTS.items()}
    for key, value in tree.items():
        if key in ("field", "bookmark"):
            for name, table in _tables_by_name(value, key).items():
                getattr(scene, key + "s")[name] = field_of(table, f"field.{name}") if key == "field" else table_of(Camera, table, key)
        elif key in parts:
            cls = LISTS[parts[key]][1]
            if not isinstance(value, list):
                raise scene_error(key, f"{value!r} is not a list of tables; write [[{key}]]")
            setattr(scene, parts[key], [table_of(cls, table, f"{key}[{i}]") for i, table in enumerate(value)])
        elif key in TEXTS or key in TABLES:
            setattr(scene, key, value)
        else:
            raise unknown_key("", key, list(ROWS[""].keys))


def tree_of(scene: Scene, camera: Camera | dict[str, Any] | None = None) -> dict[str, Any]:
    """Scene as the tree of a scene file; by another camera than its own where one is given."""
    tree: dict[str, Any] = {}
    for name in TEXTS:
        value = getattr(scene, name)
        if value is not None:
            tree[name] = list(value) if isinstance(value, tuple) else value
    seen = scene.camera if camera is None else table_of(Camera, camera, "camera")
    for name in TABLES:
        table = seen if name == "camera" else getattr(scene, name)
        if table is not None:
            tree[name] = table._nodes()
    if scene.fields:
        tree["field"] = {name: field_of(field, f"field.{name}")._nodes() for name, field in scene.fields.items()}
    if scene.bookmarks:
        tree["bookmark"] = {name: table_of(Camera, camera, f"bookmark.{name}")._nodes() for name, camera in scene.bookmarks.items()}
    for name, (key, cls) in LISTS.items():
        if getattr(scene, name):
            tree[key] = [table_of(cls, table, f"{key}[{i}]")._nodes() for i, table in enumerate(getattr(scene, name))]
    return tree


def place_of(scene: Scene, place: str) -> tuple[Any, str]:
    """The object and the key that a place such as "star[0].temperature" means."""
    lists = {file: name for name, (file, _) in LISTS.items()}
    owner: Any = scene
    *way, key = re.findall(r"[^.\[\]]+", place) or [""]
    for i, part in enumerate(way):
        if owner is scene:
            part = lists.get(part, {"field": "fields", "bookmark": "bookmarks"}.get(part, part))
        try:
            if isinstance(owner, list):
                owner = owner[int(part)]
            elif isinstance(owner, dict):
                owner = owner[part]
            else:
                owner = getattr(owner, part)
        except (LookupError, ValueError, AttributeError):
            raise scene_error(place, f'the scene has no "{".".join(way[: i + 1])}"') from None
    if isinstance(owner, Table):
        known = list(owner._row().all_keys(owner._chosen))
    elif owner is scene:
        known = PARTS
    else:
        raise scene_error(place, "the path is not a key of a table, such as star[0].temperature")
    if key not in known:
        raise unknown_key(place.rpartition(".")[0], key, known)
    return owner, key


def field_of(value: Any, key: str) -> Field:
    """A field as an object: one that is, or a dictionary with its kind."""
    if isinstance(value, Field):
        return value
    classes = [cls for name in tables.__all__ if isinstance(cls := getattr(tables, name), type) and issubclass(cls, Field)]
    kinds = {cls._kind: cls for cls in classes if cls._kind is not None}
    if isinstance(value, dict):
        keys = dict(value)
        kind = keys.pop("kind", None)
        if kind not in kinds:
            raise scene_error(f"{key}.kind", f"unknown kind {kind!r}; known: {', '.join(kinds)}")
        return kinds[kind].of(keys)
    raise scene_error(key, "the value is not a field; an array requires a box: Grid(array, low=[-1, -1, -1] * u.pc, high=[1, 1, 1] * u.pc)")


def list_of(value: Any, name: str) -> list[Any]:
    """The tables of a list; one alone is an error that says how to write it."""
    if isinstance(value, (Table, Mapping, str)) or not hasattr(value, "__iter__"):
        raise scene_error(name, f"{name} is a list of tables; write {name}=[...] around the {type(value).__name__}")
    return list(value)


def _tables_by_name(value: Any, key: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise scene_error(key, f"{value!r} is not a table; write [{key}.NAME]")
    return value
