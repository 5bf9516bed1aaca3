"""Labelled arrays of xarray: names of axes, coordinates and units, as a grid of a scene takes them."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._arrays import DENSITIES, NO_DENSITY
from ._rows import QUANTITIES, scene_error

AXES = ("x", "y", "z")
#: How far coordinates may be from even steps, relative to a step.
EVEN = 1e-3


def is_labelled(values: Any) -> bool:
    """True if a value is an array with named dimensions and coordinates, as xarray's DataArray is."""
    return hasattr(values, "dims") and hasattr(values, "coords") and hasattr(values, "transpose") and hasattr(values, "attrs")


def unfolded(values: Any, key: str) -> tuple[Any, dict[str, str]]:
    """The array of a labelled array by ascending x, y and z, and what its labels state: `low`, `high` and `unit`.

    Raises
    ------
    SceneError
        If dimensions are not x, y and z, coordinates are uneven, or a unit is unknown.
    """
    names = {str(name).lower(): name for name in values.dims}
    if set(names) != set(AXES):
        dims = ", ".join(map(str, values.dims))
        raise scene_error(key, f"the array's dimensions are {dims}; rename them to x, y and z, or use .values and axes=")
    values = values.transpose(*(names[axis] for axis in AXES))
    stated: dict[str, str] = {}
    edges = {axis: _edges(values, names[axis], key) for axis in AXES if names[axis] in values.coords}
    for axis, (low, high, _) in edges.items():
        if low > high:
            values = values.isel({names[axis]: slice(None, None, -1)})
    units = {unit for _, _, unit in edges.values()}
    if len(edges) == 3 and len(units) == 1 and units != {""}:
        unit = _length(units.pop(), key)
        for name, pick in (("low", min), ("high", max)):
            stated[name] = " ".join(repr(float(pick(edges[axis][:2]))) for axis in AXES) + f" {unit}"
    unit = str(values.attrs.get("units", values.attrs.get("unit", ""))).strip()
    if unit and unit != "dimensionless":
        stated["unit"] = _density(unit, key)
    return values.data if not hasattr(values.data, "dask") else values.values, stated


def _edges(values: Any, name: Any, key: str) -> tuple[float, float, str]:
    """The outer edges of the first and the last cell along a dimension, and the unit of its coordinates."""
    coordinate = values.coords[name]
    places = np.asarray(coordinate.values, dtype=float)
    unit = str(coordinate.attrs.get("units", "")).strip()
    if places.size < 2:
        return 0.0, 1.0, ""
    step = (places[-1] - places[0]) / (places.size - 1)
    if step == 0 or not np.isfinite(places).all() or np.abs(np.diff(places) - step).max() > EVEN * abs(step):
        raise scene_error(key, f"the coordinates of {name} are not uniform; interpolate the array to uniform coordinates first")
    return places[0] - 0.5 * step, places[-1] + 0.5 * step, unit


def _plain(unit: str) -> str:
    return unit.replace("**", "").replace("^", "").replace(" ", "")


def _length(unit: str, key: str) -> str:
    known = [name for name, _ in QUANTITIES["length"][0]]
    if unit not in known:
        raise scene_error(key, f'the coordinates are in "{unit}", an unknown unit of length ({", ".join(known)})')
    return unit


def _density(unit: str, key: str) -> str:
    known = [name for quantity in DENSITIES for name, _ in QUANTITIES[quantity][0]]
    for name in known:
        if _plain(name) == _plain(unit):
            return name
    raise scene_error(key, f'the array is in "{unit}", which is not a {NO_DENSITY} ({", ".join(known)})')
