"""Values of keys: what people hand over, and how a scene says it."""

from __future__ import annotations

import os
import re
from typing import Any

import numpy as np

from ._rows import QUANTITIES, scene_error

#: Quantities that a value may be, where its name is not that of one.
_ALSO = {
    "extinction": ["extinction per length", "extinction per hydrogen column", "extinction per mass"],
}


def spelled(unit: str) -> str:
    """A unit of scene files as astropy and unyt both read it: "mag cm2" as "mag*cm**2", "W/m2/sr" as "W*m**-2*sr**-1"."""
    factors = []
    for sign, word in re.findall(r"([*/ ]?)\s*([A-Za-z]+-?\d*)", unit.replace("1/", "/")):
        name, power = re.fullmatch(r"([A-Za-z]+)(-?\d*)", word).groups()
        power = int(power or 1) * (-1 if sign == "/" else 1)
        factors.append(name if power == 1 else f"{name}**{power}")
    return "*".join(factors)


def number(value: Any) -> str:
    """A number in the fewest digits that are read as the same one."""
    return repr(float(value))


def parsed(value: Any) -> tuple[float, str]:
    """The number and the unit of what a scene says; a plain number has none."""
    if not isinstance(value, str):
        return float(value), ""
    text, unit = re.fullmatch(r"\s*([-+0-9.eE]*[0-9.])\s*(.*?)\s*", value).groups()
    return float(text), unit


def units_of(quantity: str) -> list[str]:
    """Names of the units of a quantity that mean the same to astropy and unyt."""
    # An A of scene files is an angstrom, everywhere else an ampere.
    return [unit for unit, _ in QUANTITIES[quantity][0] if unit != "A"]


def has_unit(value: Any) -> bool:
    """True if a value knows its unit, as those of astropy and unyt do."""
    return hasattr(value, "to_value")


def in_unit(value: Any, quantities: list[str], key: str) -> tuple[Any, str]:
    """The numbers of a value in the first unit of some quantities that it can be turned into, and that unit."""
    for quantity in quantities:
        for unit in units_of(quantity):
            try:
                return np.asarray(value.to_value(spelled(unit))), unit
            except Exception:  # Each library has its own.
                continue
    known = ", ".join(unit for quantity in quantities for unit, _ in QUANTITIES[quantity][0])
    raise scene_error(key, f"{value} is not a {' or '.join(quantities)}; known units: {known}")


def _quantity(value: Any, kind: str, key: str) -> str:
    quantities = _ALSO.get(kind, [kind])
    example = QUANTITIES[quantities[0]][1]
    if isinstance(value, str):
        return value
    if has_unit(value):
        numbers, unit = in_unit(value, quantities, key)
        if numbers.size != 1:
            raise scene_error(key, f"{value} has {numbers.size} numbers; a {kind} must be one")
        return f"{number(numbers.reshape(())[()])} {unit}"
    raise scene_error(key, f'{value!r} is a {kind} without a unit; write it like "{example}", or multiply it by a unit of astropy or unyt')


def _position(value: Any, key: str) -> str:
    if isinstance(value, str):
        return value
    wanted = 'a place is three lengths, such as [0.5, 0, -2] * u.pc or "0.5 0 -2 pc"'
    if not has_unit(value):
        try:
            items = list(value)
        except TypeError:
            raise scene_error(key, f"{value!r} is not a position; {wanted}") from None
        if len(items) != 3 or not all(has_unit(item) for item in items):
            raise scene_error(key, f"{value!r} is a position without a unit; {wanted}")
        lengths = [in_unit(item, ["length"], key) for item in items]
        # The first unit that serves is the same for all lengths.
        return f"{' '.join(number(length) for length, _ in lengths)} {lengths[0][1]}"
    numbers, unit = in_unit(value, ["length"], key)
    if numbers.shape != (3,):
        raise scene_error(key, f"{value} has the shape {numbers.shape}; {wanted}")
    return f"{' '.join(map(number, numbers))} {unit}"


def _times(value: Any, key: str) -> list[str]:
    """Texts of times: of an array with a unit, or of a list."""
    if has_unit(value):
        numbers, unit = in_unit(value, ["time"], key)
        return [f"{number(own)} {unit}" for own in numbers.ravel()]
    return [_quantity(own, "time", f"{key}[{i}]") for i, own in enumerate(_list(value, key))]


def _any(value: Any, key: str) -> Any:
    """Scene value of any kind: a quantity of whatever kind, a place, or a plain value."""
    if has_unit(value):
        numbers, unit = in_unit(value, list(QUANTITIES), key)
        return f"{' '.join(number(own) for own in numbers.ravel())} {unit}"
    return _plain(value, key)


def _list(value: Any, key: str) -> list:
    try:
        return list(value)
    except TypeError:
        raise scene_error(key, f"{value!r} is not a list") from None


def _plain(value: Any, key: str) -> Any:
    """Plain values of Python for those of NumPy; tables as they are, since they may be changed later."""
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value)
    if isinstance(value, str):
        return str(value)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if has_unit(value):
        try:
            return _plain(np.asarray(value.to_value("")), key)
        except Exception:
            raise scene_error(key, f"{value} has a unit, but this key requires a plain value") from None
    if isinstance(value, np.ndarray):
        return _plain(value.tolist(), key)
    if isinstance(value, (list, tuple)):
        return [_plain(item, key) for item in value]
    if isinstance(value, dict):
        return {str(name): _plain(item, f"{key}.{name}") for name, item in value.items()}
    if hasattr(value, "tree"):
        return value
    raise scene_error(key, f"{value!r} is not a valid value of a scene")


def said(value: Any, kind: str, key: str) -> Any:
    """Scene value of a kind such as "length"; a tree of texts, numbers, lists and dictionaries.

    Raises
    ------
    SceneError
        If it is none, or has no unit, or another one; the message says what would be right.
    """
    if kind == "position":
        return _position(value, key)
    if kind in QUANTITIES or kind in _ALSO:
        return _quantity(value, kind, key)
    if kind == "[width, height]" and isinstance(value, (int, np.integer)):
        return [int(value), int(value)]
    if kind in ("path", "text") and not isinstance(value, (str, os.PathLike)):
        raise scene_error(key, f"{value!r} is not a text")
    if kind == "number" and isinstance(value, np.ndarray) and value.shape == ():
        value = value[()]
    if kind == "list of times":
        return _times(value, key)
    if kind == "list of values":
        return [_any(item, f"{key}[{i}]") for i, item in enumerate(_list(value, key))]
    if kind in ("list of numbers", "direction"):
        return [_plain(item, key) for item in _list(value, key)]
    return _plain(value, key)
