"""Free keys of fits: bounds and priors."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _barnard
from ._rows import scene_error
from ._values import has_unit, parsed, spelled
from ._warn import warn
from .parameters import parameters_of


@dataclass(frozen=True)
class Free:
    """Freedom of a key in a fit: bounds and a normal prior.

    Values are quantities, texts with units, or numbers in the unit of the scene.

    >>> free = {"star[0].temperature": bn.Free(5e3 * u.K, 4e4 * u.K), "dust.scale": bn.Free(prior=(4, 0.5))}

    Attributes
    ----------
    low, high : quantity, text or number, optional
        Bounds; open without.
    prior : pair, optional
        Mean and standard deviation.
    """

    low: Any = None
    high: Any = None
    prior: tuple[Any, Any] | None = None


#: Free keys of a fit: a dictionary from keys to `Free`, to (low, high) or to None, or a list of keys.
FreeKeys = Mapping[str, Free | tuple[Any, Any] | None] | Iterable[str]

#: A free key: name, bounds, mean and standard deviation of its prior.
Row = tuple[str, float, float, tuple[float, float] | None]


def rows_of(free: FreeKeys, tree: dict[str, Any]) -> list[Row]:
    """Free keys of a scene's tree, in its units."""
    if isinstance(free, str):
        words = "a text of free keys is deprecated; give a dictionary, such as {'star[0].temperature': bn.Free(5e3 * u.K, 4e4 * u.K)}"
        warn(words, DeprecationWarning)
        return _barnard.free_keys(free)
    keys = free if isinstance(free, Mapping) else dict.fromkeys(free)
    units = {path: parameter.unit for path, parameter in parameters_of(tree).items()}
    return [_row(key, value, units.get(key, "")) for key, value in keys.items()]


def _row(key: str, value: Free | tuple[Any, Any] | None, unit: str) -> Row:
    free = value if isinstance(value, Free) else Free(*(value or ()))
    low = -np.inf if free.low is None else _number(free.low, unit, key)
    high = np.inf if free.high is None else _number(free.high, unit, key)
    prior = None if free.prior is None else (_number(free.prior[0], unit, key), _number(free.prior[1], unit, key))
    return key, low, high, prior


def _number(value: Any, unit: str, key: str) -> float:
    """The number of a value in a unit."""
    try:
        if isinstance(value, str):
            number, stated = parsed(value)
            if stated in ("", unit):
                return number
            from astropy.units import Quantity

            value = Quantity(number, spelled(stated))
        if has_unit(value):
            return float(value.to_value(spelled(unit)))
        return float(value)
    except Exception as error:  # Each library of units has its own.
        raise scene_error(key, f"{value} is not a value in {unit or 'no unit'}: {error}") from None
