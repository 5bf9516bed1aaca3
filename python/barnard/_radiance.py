"""Band radiances as quantities of astropy."""

from __future__ import annotations

from typing import Any

import numpy as np
from astropy import constants, units


class BandRadiance(units.Quantity):
    """Radiances through a passband, ∫ R I_λ dλ [W m-2 sr-1], that know how wide it is.

    They can be turned into mean radiances for each wavelength, ∫ R I_λ dλ / ∫ R dλ, and for each frequency, that times
    λ_pivot²/c, where λ_pivot² = ∫ R dλ / ∫ R dλ/λ² for a passband that counts energy.
    """

    @classmethod
    def of(cls, values: np.ndarray, pivot_um: float | None, width_um: float | None) -> BandRadiance:
        """Radiances through a passband of this pivot wavelength and width ∫ R dλ [um]; none where they are not known."""
        quantity = units.Quantity(values, "W / (m2 sr)", copy=False).view(cls)
        if width_um is not None:
            per_wavelength = 1.0 / width_um
            known = [(units.Unit("W / (m2 sr)"), units.Unit("W / (m2 sr um)"), *_times(per_wavelength))]
            if pivot_um is not None:
                light = constants.c.to_value("um / s")
                known.append((units.Unit("W / (m2 sr)"), units.Unit("W / (m2 sr Hz)"), *_times(per_wavelength * pivot_um**2 / light)))
            quantity._equivalencies = known
        return quantity

    def __array_finalize__(self, obj: Any) -> None:
        super().__array_finalize__(obj)
        if isinstance(obj, BandRadiance) and "_equivalencies" in obj.__dict__:
            self._equivalencies = obj._equivalencies


def _times(factor: float):
    return (lambda value: value * factor), (lambda value: value / factor)
