"""Arrays as fields: checked, and taken without a copy where that can be."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._rows import QUANTITIES, scene_error
from ._values import has_unit, spelled


#: What values with a unit may be.
DENSITIES = ("number density", "mass density", "extinction per length")
NO_DENSITY = ", no ".join(DENSITIES)


def taken(values: Any, key: str, copy: bool, clip: bool = False) -> tuple[np.ndarray, str | None]:
    """An array of three axes, contiguous, read-only, of float32 or float64, and the unit of its values.

    The array is a copy unless `copy` is false: then one of float32 or float64 that is contiguous and owns its memory is
    shared, and marked read-only. Older views of a shared array must not be written to. Masked values become zero where
    `clip` is true.

    Raises
    ------
    SceneError
        If it is no array of three axes, empty, masked, or of numbers that no density can be.
    """
    if np.ma.isMaskedArray(values):
        if clip:
            values = values.filled(0)
        elif np.ma.is_masked(values):
            count = int(np.ma.count_masked(values))
            raise scene_error(key, f"{count} values are masked; set them to zero with clip=True, or values.filled(0)")
        else:
            values = values.data
    elif hasattr(values, "unmasked") and hasattr(values, "mask"):
        # Masked arrays and quantities of astropy.
        if np.any(values.mask) and not clip:
            raise scene_error(key, f"{int(np.sum(values.mask))} values are masked; set them to zero with clip=True, or .filled(0)")
        values = values.filled(0) if np.any(values.mask) else values.unmasked
    unit = _unit(values, key)
    array = np.asarray(values)
    if array.dtype.kind not in "fiu":
        remedy = "give its real part" if array.dtype.kind == "c" else "give an array of float32 or float64"
        raise scene_error(key, f"the array's values are of type {array.dtype}; {remedy}")
    if array.ndim != 3:
        raise scene_error(key, f"the array has {array.ndim} axes, its shape is {array.shape}; a field must have three, x, y and z")
    if array.size == 0:
        raise scene_error(key, f"the array is empty, its shape is {array.shape}")
    small = array.dtype.itemsize <= (4 if array.dtype.kind == "f" else 2)
    wanted = np.dtype(np.float32 if small else np.float64)
    contiguous = array.flags.c_contiguous or array.flags.f_contiguous
    if copy or array.dtype != wanted or not contiguous or not _is_owned(values, array):
        array = np.array(array, dtype=wanted, order="K" if contiguous else "C", copy=True)
    # Whoever holds the same array cannot change a field behind the back of those who read it.
    array.flags.writeable = False
    if isinstance(values, np.ndarray) and np.may_share_memory(values, array):
        values.flags.writeable = False
    return array, unit


def _unit(values: Any, key: str) -> str | None:
    """The unit of densities or extinctions that a value's own unit is, where it has one: "cm-3" times a factor is not."""
    if not has_unit(values):
        return None
    unit = getattr(values, "unit", None)
    unit = getattr(values, "units", None) if unit is None else unit
    if unit is None or str(unit) in ("", "dimensionless"):
        return None
    for kind in DENSITIES:
        names = [name for name, _ in QUANTITIES[kind][0]]
        try:
            sizes = [float((1.0 * unit).to_value(spelled(name))) for name in names]
        except Exception:  # Each library has its own.
            continue
        for name, size in zip(names, sizes):
            if abs(size - 1.0) < 1e-12:
                return name
        raise scene_error(key, f"the values are in {unit}; convert them first with .to('{spelled(names[0])}')")
    raise scene_error(
        key,
        f"the values are in {unit}, which is not a {NO_DENSITY}; give plain numbers, and choose the scale of dust or gas accordingly",
    )


def _is_owned(values: Any, array: np.ndarray) -> bool:
    """True if nobody can write into the memory of an array but through `values` itself."""
    if not isinstance(values, np.ndarray):
        return False
    base = values.base
    while isinstance(base, np.ndarray):
        if base.flags.writeable:
            return False
        base = base.base
    return values.flags.owndata or not values.flags.writeable or base is None
