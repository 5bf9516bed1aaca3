"""Band radiances as quantities of astropy."""

from __future__ import annotations

from typing import Any

import numpy as np
from astropy import constants, units


class BandRadiance(units.Quantity):
    """Radiances through one passband, ∫ R I_λ dλ [W m-2 sr-1], with its pivot wavelength and width.

    They convert to mean radiances per wavelength, ∫ R I_λ dλ / ∫ R dλ, and per frequency, that times λ_pivot²/c, where
    λ_pivot² = ∫ R dλ / ∫ R dλ/λ² for a passband that counts energy. Radiances of different passbands combine to a plain
    Quantity, which has no such conversion.
    """

    #: Pivot wavelength and width ∫ R dλ [um]; none where they are not known.
    _passband: tuple[float | None, float | None] = (None, None)

    @classmethod
    def of(cls, values: np.ndarray, pivot_um: float | None, width_um: float | None) -> BandRadiance:
        """Radiances through a passband of this pivot wavelength and width ∫ R dλ [um]; none where they are not known."""
        quantity = units.Quantity(values, "W / (m2 sr)", copy=False).view(cls)
        quantity._passband = (pivot_um, width_um)
        return quantity

    @property
    def _equivalencies(self) -> list[Any]:
        pivot_um, width_um = self._passband
        if width_um is None:
            return []
        band, per_wavelength = units.Unit("W / (m2 sr)"), 1.0 / width_um
        known = [(band, units.Unit("W / (m2 sr um)"), *_times(per_wavelength))]
        if pivot_um is not None:
            light = constants.c.to_value("um / s")
            known.append((band, units.Unit("W / (m2 sr Hz)"), *_times(per_wavelength * pivot_um**2 / light)))
        return known

    def __array_finalize__(self, obj: Any) -> None:
        super().__array_finalize__(obj)
        if isinstance(obj, BandRadiance):
            self._passband = obj._passband

    def __array_ufunc__(self, function: Any, method: str, *inputs: Any, **keys: Any) -> Any:
        if len(_passbands(inputs)) > 1:
            return getattr(function, method)(*_plain(inputs), **keys)
        return super().__array_ufunc__(function, method, *inputs, **keys)

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if len(_passbands((args, kwargs))) > 1:
            return function(*_plain(args), **_plain(kwargs))
        return super().__array_function__(function, types, args, kwargs)

    def __reduce__(self) -> tuple[Any, ...]:
        return _made, (np.asarray(self.value), str(self.unit), *self._passband)


def _made(values: np.ndarray, unit: str, pivot_um: float | None, width_um: float | None) -> BandRadiance:
    quantity = units.Quantity(values, unit, copy=False).view(BandRadiance)
    quantity._passband = (pivot_um, width_um)
    return quantity


def _times(factor: float):
    return (lambda value: value * factor), (lambda value: value / factor)


def _passbands(value: Any) -> set[tuple[float | None, float | None]]:
    """The passbands of all band radiances within arguments."""
    if isinstance(value, BandRadiance):
        return {value._passband}
    if isinstance(value, dict):
        value = list(value.values())
    return set().union(*map(_passbands, value)) if isinstance(value, (list, tuple)) else set()


def _plain(value: Any) -> Any:
    """Arguments with plain quantities in place of band radiances."""
    if isinstance(value, BandRadiance):
        return value.view(units.Quantity)
    if isinstance(value, dict):
        return {name: _plain(item) for name, item in value.items()}
    return type(value)(map(_plain, value)) if isinstance(value, (list, tuple)) else value
