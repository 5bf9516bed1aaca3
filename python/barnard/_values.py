"""Values of keys: conversion of Python objects to values of a scene."""

from __future__ import annotations

import os
import re
from typing import Any

import numpy as np

from ._rows import QUANTITIES, Key, scene_error


def spelled(unit: str) -> str:
    """A unit of scene files as astropy and unyt both read it: "mag cm2" as "mag*cm**2", "W/m2/sr" as "W*m**-2*sr**-1"."""
    factors = []
    for sign, name, digits in re.findall(r"([*/ ]?)\s*([A-Za-z]+)(-?\d*)", unit.replace("1/", "/")):
        power = int(digits or 1) * (-1 if sign == "/" else 1)
        factors.append(name if power == 1 else f"{name}**{power}")
    return "*".join(factors)


def number(value: Any) -> str:
    """A number in the fewest digits that are read as the same one."""
    return repr(float(value))


def parsed(value: Any) -> tuple[float, str]:
    """The number and the unit of a value of a scene; a plain number has none."""
    if isinstance(value, tuple):
        return float(value[0]), value[1]
    if not isinstance(value, str):
        return float(value), ""
    match = re.fullmatch(r"\s*([-+0-9.eE]*[0-9.])\s*(.*?)\s*", value)
    if match is None:
        raise ValueError(f"{value!r} is not a number with a unit")
    return float(match[1]), match[2]


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


def is_quantity(value: Any) -> bool:
    """True for a quantity as trees hold it: (number, unit), or (three numbers, unit)."""
    return isinstance(value, tuple) and len(value) == 2 and isinstance(value[1], str)


def written(value: Any) -> Any:
    """A value of a tree as scene files write it: quantities as texts."""
    if is_quantity(value):
        numbers, unit = value
        return " ".join([*map(number, numbers if isinstance(numbers, tuple) else [numbers]), unit])
    if isinstance(value, dict):
        return {name: written(item) for name, item in value.items()}
    if isinstance(value, list):
        return [written(item) for item in value]
    return value


def quantity(value: Any, quantities: list[str], key: str) -> str | tuple[float, str]:
    """A quantity as a text with its unit, or as number and unit."""
    kind = quantities[0]
    example = QUANTITIES[quantities[0]][1]
    if isinstance(value, str) or is_quantity(value):
        return value
    if has_unit(value):
        numbers, unit = in_unit(value, quantities, key)
        if numbers.size != 1:
            raise scene_error(key, f"{value} has {numbers.size} numbers; a {kind} must be one")
        return float(numbers.reshape(())[()]), unit
    raise scene_error(key, f'{value!r} is a {kind} without a unit; write it like "{example}", or multiply it by a unit of astropy or unyt')


def _position(value: Any, key: str) -> str | tuple[tuple[float, ...], str]:
    if isinstance(value, str) or is_quantity(value):
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
        return tuple(float(length) for length, _ in lengths), lengths[0][1]
    numbers, unit = in_unit(value, ["length"], key)
    if numbers.shape != (3,):
        raise scene_error(key, f"{value} has the shape {numbers.shape}; {wanted}")
    return tuple(map(float, numbers)), unit


def _quantities(value: Any, quantities: list[str], key: str) -> str | list[str | tuple[float, str]]:
    """Quantities of an array with a unit, or of a list."""
    if isinstance(value, str) or is_quantity(value):
        return value
    if has_unit(value):
        numbers, unit = in_unit(value, quantities, key)
        return [(float(item), unit) for item in numbers.ravel()]
    return [quantity(item, quantities, f"{key}[{i}]") for i, item in enumerate(_list(value, key))]


def _any(value: Any, key: str) -> Any:
    """Scene value of any type: a quantity, a position, or a plain value."""
    if has_unit(value):
        numbers, unit = in_unit(value, list(QUANTITIES), key)
        return (float(numbers), unit) if numbers.ndim == 0 else (tuple(map(float, numbers.ravel())), unit)
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
    if is_quantity(value):
        return value
    if isinstance(value, (list, tuple)):
        return [_plain(item, key) for item in value]
    if isinstance(value, dict):
        return {str(name): _plain(item, f"{key}.{name}") for name, item in value.items()}
    if hasattr(value, "_nodes"):
        return value
    raise scene_error(key, f"{value!r} is not a valid value of a scene")


def stated_as(value: Any, row: Key, key: str) -> Any:
    """Scene value of a key: a tree of texts, numbers, quantities as (number, unit), lists and dictionaries.

    Raises
    ------
    SceneError
        If the value has another type, no unit, or another unit; the message states the remedy.
    """
    if row.value == "position":
        return _position(value, key)
    if row.quantities:
        return (_quantities if row.value.startswith("list") else quantity)(value, row.quantities, key)
    if row.value == "[width, height]" and isinstance(value, (int, np.integer)):
        return [int(value), int(value)]
    if row.value in ("path", "text") and not isinstance(value, (str, os.PathLike)):
        raise scene_error(key, f"{value!r} is not a text")
    if row.choices and value not in row.choices:
        raise scene_error(key, f"unknown value {value!r}; known: {', '.join(row.choices)}")
    if row.value == "number" and isinstance(value, np.ndarray) and value.shape == ():
        value = value[()]
    if row.value == "list of values":
        return [_any(item, f"{key}[{i}]") for i, item in enumerate(_list(value, key))]
    if row.value in ("list of numbers", "direction"):
        return [_plain(item, key) for item in _list(value, key)]
    return _plain(value, key)
