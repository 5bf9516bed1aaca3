"""Reports: how an image was made and its stated errors, as numbers."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from ._barnard import ReportFacts


@dataclass(frozen=True)
class Certificate:
    """Largest error of a spectral rule for one light in one passband, including arithmetic."""

    #: The name of the light.
    light: str
    #: Error relative to the unattenuated light F(0).
    absolute: float
    #: Error relative to the attenuated light F(a).
    relative: float
    #: Largest optical depth at V for which both are valid.
    depth: float


@dataclass(frozen=True)
class SpatialReport:
    """Spatial error measured by pilot rays, relative rms."""

    #: Error of the worst band.
    error: float
    #: Number of pilot rays.
    pilot_rays: int
    #: The part that is due to sampled functions.
    function_samples: float | None = None
    #: Voxels along the longest edge of the coarsest of these.
    samples_per_edge: int | None = None
    #: Error of the fluxes of stars that are seen through sampled functions.
    stars: float | None = None
    #: Number of these stars.
    sampled_stars: int | None = None


@dataclass(frozen=True)
class Report:
    """How an image was made and its stated errors; unknown values are None.

    `barnard render --json` prints this report too, and it is stored in headers of .fits and .exr files.
    """

    #: Name of the back end, with its device.
    backend: str | None = None
    #: Name of the spectral method.
    method: str | None = None
    #: Largest number of scatterings.
    bounces: int | None = None
    #: Spacing of the samples along a ray, as text.
    steps: str | None = None
    #: Requested accuracy.
    accuracy: float | None = None
    #: Largest optical depth at V from the camera to a sample to a star.
    optical_depth: float | None = None
    #: Largest spectral error of all lights and passbands, relative to the unattenuated light.
    spectral_error: float | None = None
    #: Spatial error.
    spatial_error: SpatialReport | None = None
    #: True if the spatial error is larger than requested.
    misses_accuracy: bool = False
    #: Errors of multiple scattering in the picture: `spatial` and `angular`, relative rms.
    scattering_error: dict[str, float] | None = None
    #: Displacement below the voxels: `octaves` and `strength`, relative to the wavelength.
    detail: dict[str, float] | None = None
    #: Sampling of the path tracer: `per_pixel`, `seed` and `skipped`.
    paths: dict[str, int] | None = None
    #: Spectral errors by passband, one for each light.
    certificates: dict[str, list[Certificate]] = field(default_factory=dict)
    #: Number of radiances below zero, over all bands.
    negative_values: int = 0
    #: Further statements by topic.
    notes: dict[str, str] = field(default_factory=dict)

    def to_dict(self) -> dict[str, object]:
        """The report as dictionaries, lists, texts and numbers; unknown values are absent."""
        return cast("dict[str, object]", _plain(self))

    def to_json(self) -> str:
        """The report as JSON."""
        return json.dumps(self.to_dict(), indent=2)


def report_of(facts: ReportFacts) -> Report:
    """The report of facts as the native module states them."""
    certificates = {band: [Certificate(**row) for row in rows] for band, rows in facts["certificates"].items()}
    spatial = facts.get("spatial_error")
    return Report(**{**cast("dict[str, Any]", facts), "certificates": certificates, "spatial_error": None if spatial is None else SpatialReport(**spatial)})


def _plain(value: object) -> object:
    if isinstance(value, (Report, Certificate, SpatialReport)):
        return _plain(vars(value))
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items() if item is not None}
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return value
