"""Writes python/barnard/tables.py anew from the rows of the native catalogues: python python/write_tables.py"""

from __future__ import annotations

import json
import re
import sys
import textwrap
import types
from collections.abc import Iterable
from pathlib import Path

if "barnard" not in sys.modules:
    # The package itself may not load while its tables are out of date.
    sys.modules["barnard"] = types.ModuleType("barnard")
    sys.modules["barnard"].__path__ = [str(Path(__file__).parent / "barnard")]

from barnard._rows import ROWS, Key, Kind, Row

#: Classes of tables: path and name. Each kind has a class of its own, such as HenyeyGreensteinPhase.
CLASSES = [
    ("camera.stereo", "Stereo"),
    ("camera.path.key", "Keyframe"),
    ("camera.path", "CameraPath"),
    ("camera", "Camera"),
    ("dust.albedo", "Albedo"),
    ("dust.phase", "Phase"),
    ("dust", "Dust"),
    ("star", "Star"),
    ("star_table", "StarTable"),
    ("emission", "Emission"),
    ("gas", "Gas"),
    ("background.stars", "StarField"),
    ("background.catalogue", "StarCatalogue"),
    ("background", "Background"),
    ("detail", "Detail"),
    ("spectrograph", "Spectrograph"),
    ("band", "Band"),
    ("display.glare", "Glare"),
    ("display", "Display"),
    ("observation", "Observation"),
    ("instrument.psf", "PointSpread"),
    ("instrument", "Instrument"),
    ("output", "Output"),
    ("method.path", "PathTracer"),
    ("method.reference", "Reference"),
    ("method.gpu", "Device"),
    ("method", "Method"),
    ("animation", "Animation"),
    ("sequence", "Frames"),
]

#: Keys whose values are tables of these classes.
TABLES = {
    ("camera", "stereo"): "Stereo",
    ("camera", "path"): "CameraPath",
    ("camera.path", "key"): "Sequence[Keyframe | dict[str, Any]]",
    ("dust", "albedo"): "float | Albedo",
    ("dust", "phase"): "Phase",
    ("background", "stars"): "StarField",
    ("background", "catalogue"): "StarCatalogue",
    ("instrument", "psf"): "Sequence[PointSpread | dict[str, Any]]",
    ("display", "glare"): "Glare",
    ("method", "path"): "PathTracer",
    ("method", "reference"): "Reference",
    ("method", "gpu"): "Device",
}

#: The kind of a table whose kind is not said.
KINDS = {"star": "blackbody"}

TYPES = {
    "text": "str",
    "path": "Path",
    "expression": "str",
    "boolean": "bool",
    "integer": "int",
    "number": "float",
    "list of numbers": "Sequence[float]",
    "text or list of texts": "str | Sequence[str]",
    "list of values": "Sequence[Any] | Quantity",
    "list of tables": "Sequence[dict[str, Any]]",
    "text or list of numbers": "str | Sequence[float]",
    "direction": "Sequence[float]",
    "[width, height]": "int | Sequence[int]",
    "table": "dict[str, Any]",
    "number or table": "float | dict[str, Any]",
    "position": "Position",
}

HEAD = '''"""Tables of a scene. Keywords are the keys of scene files.

This file is made of the rows that the parser of scene files reads: `python python/write_tables.py` writes it.
Quantities are values of astropy or unyt, or texts with units such as "39000 K". None means unset.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Literal, Union

from numpy.typing import ArrayLike

from ._field import Field, Sampled
from ._table import Table, renamed

#: A value with its unit: of astropy, of unyt, or a text such as "0.4 pc".
Quantity = Union[str, Any]
#: Three lengths: [0.5, 0, -2] * u.pc, or "0.5 0 -2 pc".
Position = Union[str, Sequence[Quantity], Any]
Path = Union[str, os.PathLike]
'''


def typed(table: str, key: Key) -> str:
    if key.choices:
        return literal(key.choices)
    if key.quantities and key.value.startswith("list"):
        return "Sequence[Quantity] | Quantity"
    return TABLES.get((table, key.name)) or TYPES.get(key.value, "Quantity")


def literal(names: Iterable[str]) -> str:
    return f"Literal[{', '.join(json.dumps(name) for name in names)}]"


def titled(name: str) -> str:
    return "".join(part.capitalize() for part in name.split("_"))


def sentence(text: str) -> str:
    """A text with a capital, unless it begins with a symbol, and a full stop."""
    text = text.strip()
    text = text if re.match(r"(?!a\b)\w\b|\w*[\d_(]", text) else text[:1].upper() + text[1:]
    return text if text.endswith("...") else text.rstrip(".") + "."


def wrapped(text: str, indent: str) -> str:
    return textwrap.fill(text, 118, initial_indent=indent, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def parameters(row: Row, keys: list[Key], kinds: dict[str, list[str]], indent: str) -> list[str]:
    lines = [f"{indent}Parameters", f"{indent}----------"]
    for key in keys:
        default = "" if not key.default or kinds.get(key.name) else f", {key.default}" if key.condition else f", default {key.default}"
        lines.append(f"{indent}{key.name} : {key.words}{default}")
        needed = ", required there" if key.is_required and kinds.get(key.name) else ""
        of_kinds = f" Of kind {', '.join(kinds[key.name])}{needed}." if kinds.get(key.name) else ""
        lines.append(wrapped(sentence(key.summary) + of_kinds, indent + "    "))
    return lines


def signature(row: Row, keys: list[Key], kind: str | None, of_kinds: dict[str, list[str]], more: str = "") -> list[str]:
    # A background may be stars alone, of which its other keys say nothing.
    required = [key for key in keys if key.is_required and not of_kinds.get(key.name) and row.path != "background"]
    optional = [key for key in keys if key not in required]
    words = [kind] if kind and "=" not in kind else []
    words += [f"{key.name}: {file_type(row, key)}" for key in required]
    words.append("*")
    words += [kind] if kind and "=" in kind else []
    words += [f"{key.name}: {typed(row.path, key)} | None = None" for key in optional]
    words += [more] if more else []
    if words[-1] == "*":
        words.pop()
    return words


def call(before: str, words: list[str], after: str, indent: str) -> list[str]:
    """A call or a signature, in one line where it fits."""
    line = f"{indent}{before}({', '.join(words)}){after}"
    if len(line) <= 118:
        return [line]
    return [f"{indent}{before}(", *(f"{indent}    {word}," for word in words), f"{indent}){after}"]


def file_type(row: Row, key: Key) -> str:
    return "Path | ArrayLike" if row.path == "field.*" and key.name == "file" else typed(row.path, key)


def body(name: str, base: str, row: Row, kind: Kind | None, doc: str) -> str:
    """One class."""
    whole = kind is None and bool(row.kinds)
    keys = list((row.all_keys(kind.name) if kind else row.all_keys()).values())
    of_kinds = {key.name: [name for name, each in row.kinds.items() if key.name in each.keys] for key in keys} if whole else {}
    of_kinds = {name: names for name, names in of_kinds.items() if names}
    lines = [f"class {name}({base}):", f'    """{wrapped(sentence(doc), "    ").strip()}', ""]
    if whole:
        lines += ["    Kinds", "    -----"]
        for each in row.kinds.values():
            lines += [f"    {each.name}", wrapped(sentence(each.summary), "        ")]
        lines.append("")
    sampled = base == "Sampled"
    if keys:
        lines += parameters(row, keys, of_kinds, "    ")
    if sampled:
        lines += ["    copy : boolean, default true", "        Copy arrays. Shared arrays become read-only; do not write to older views."]
        lines += ["", "    `file` may be an array in memory with axes x, y, z (or `axes`), of any float or integer type,"]
        lines += ["    order and stride; units of astropy or unyt are converted."]
        lines += ["    Dimensions, uniform coordinates and units of xarray arrays are used."]
        lines += ["    Chunks of a Dask array are bricks for `render_bricks`."]
    lines += ["", "    Raises", "    ------", "    SceneError", "        If a key or a unit is invalid; ranges are checked when a scene is read.", '    """', ""]
    lines.append(f'    _path = "{row.path}"')
    if kind:
        lines.append(f'    _kind = "{kind.name}"')
    default = KINDS.get(row.path)
    kinds = literal(row.kinds)
    choice = (f'kind: {kinds} = "{default}"' if default else f"kind: {kinds}") if whole else None
    if whole and row.path == "background":
        choice = f"kind: {kinds} | None = None"
    more = "copy: bool = True" if sampled else ""
    names = (["kind"] if choice else []) + [key.name for key in keys] + (["copy"] if sampled else [])
    # The class of a kind sets its keys as the class of all kinds does, without its required ones.
    lines += ["", *call("def __init__", ["self", *signature(row, keys, choice, of_kinds, more)], ":", "    ")]
    lines += [*call("self._fill", [f"{name}={name}" for name in names], "", "        "), ""]
    return "\n".join(lines)


def text() -> str:
    """The text of barnard/tables.py."""
    parts, names = [HEAD], []
    fields = ROWS["field.*"]
    for kind in fields.kinds.values():
        names.append(titled(kind.name))
        base = "Sampled" if "file" in kind.keys else "Field"
        parts.append(body(names[-1], base, fields, kind, kind.summary))
    for path, name in CLASSES:
        names.append(name)
        row = ROWS[path]
        parts.append(body(name, "Table", row, None, row.text.split(": ")[0] if path == "star_table" else row.text))
        for kind in row.kinds.values():
            names.append(titled(kind.name) + name)
            parts.append(body(names[-1], name, row, kind, kind.summary))
            if path == "camera":
                names.append(kind.name)
                parts.append(f'{kind.name} = renamed("{kind.name}", {names[-2]})\n')
    parts.append("__all__ = [" + ", ".join(f'"{name}"' for name in names) + "]\n")
    return "\n\n".join(parts)


if __name__ == "__main__":
    Path(__file__).parent.joinpath("barnard", "tables.py").write_text(text(), encoding="utf-8")
