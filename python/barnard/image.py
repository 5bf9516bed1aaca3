"""Pictures: band radiances with what is stated of them."""

from __future__ import annotations

import base64
import functools
import html
import os
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _barnard
from ._progress import Listener, listening
from ._report import Certificate, Report, report_of
from ._table import table_of
from .tables import Display, Instrument

if TYPE_CHECKING:
    from .exposures import Exposures


class Image:
    """A rendered picture: linear band radiances with their errors.

    `image["V"]` is one band. Notebooks show an image in the palette and stretch of its scene. Images can be pickled and
    copied, without the volumes of their scenes.

    Attributes
    ----------
    bands : list of texts
        Names of the bands, whole; back end "path" has a band NAME_error of standard errors for each.
    radiance : array, bands × height × width
        All bands, the first row on top [W m-2 sr-1]; float32, or float64 by "reference" and "path". Read-only: it is the
        memory of the image; change a copy.
    parameters : dictionary
        The values that a sweep made it with; empty otherwise.
    """

    def __init__(self, native: _barnard.Image):
        self._native = native
        self._radiance: np.ndarray | None = None
        self._layers: dict[str, np.ndarray] | None = None
        self._report: Report | None = None
        self.parameters: dict[str, Any] = {}
        self._warnings: list[str] = []

    @property
    def bands(self) -> list[str]:
        return self._native.bands

    @property
    def shape(self) -> tuple[int, int, int]:
        """(bands, height, width), that of `radiance` and of `np.asarray(image)`."""
        height, width = self._native.shape
        return len(self.bands), height, width

    @property
    def radiance(self) -> np.ndarray:
        if self._radiance is None:
            self._radiance = self._native.radiance()
            self._radiance.flags.writeable = False
        return self._radiance

    @property
    def layers(self) -> dict[str, np.ndarray]:
        """Layers of the picture, if requested by `[output] layers`; otherwise empty.

        `scattered`, `emission.NAME`, `background` and `stars` are bands × height × width [W m-2 sr-1]; their sum is
        `radiance`. `depth` is height × width: mean distance of the light of dust and gas [pc], infinite without such light.
        `tau` is height × width: optical depth of all dust at V [1]. Masters of instruments have `mask`; see `Exposures.master`.
        """
        if self._layers is None:
            self._layers = self._native.layers
        return self._layers

    def __reduce__(self):
        return _restored, (_barnard.__version__, _barnard.state(self._native), self.parameters, self._warnings)

    def __array__(self, dtype=None, copy=None) -> np.ndarray:
        return np.array(self.radiance, dtype=dtype, copy=True if copy is None else copy)

    def __getitem__(self, band: str) -> Any:
        """Radiances of a band, height × width [W m-2 sr-1]: a Quantity.

        Unambiguous short names are accepted: "V" for "johnson-V", "F656N" for "hst-wfc3-f656n". The Quantity converts to
        mean spectral radiances, such as `image["V"].to("MJy/sr")`: ∫ R I_λ dλ / ∫ R dλ, times λ_pivot²/c for units per frequency.

        Raises
        ------
        KeyError
            If the band is unknown or ambiguous.
        """
        number = self._number(band)
        values = self.radiance[number]
        from ._radiance import BandRadiance

        pivot_um, width_um, _ = self._native.band_details[number]
        return BandRadiance.of(values, pivot_um, width_um)

    def _number(self, band: str) -> int:
        names = self.bands
        if band in names:
            return names.index(band)
        meant = [i for i, name in enumerate(names) if name.rpartition("-")[2].lower() == str(band).lower()]
        if len(meant) != 1:
            raise KeyError(f"{band!r} is {'not a band' if not meant else 'ambiguous'}; the bands are {', '.join(names)}")
        return meant[0]

    def __contains__(self, band: object) -> bool:
        try:
            self._number(band)  # type: ignore[arg-type]
        except KeyError:
            return False
        return True

    def to_html(self, path: str | os.PathLike | None = None, *, limit: float = 4.0, progress: bool | Listener | None = None) -> str:
        """The scene of the image and the explorer as one HTML page, which shows the view of the image and works without a network.

        Parameters and errors are those of `Scene.to_html`.
        """
        from ._bundle import packed, page_of, written

        bake = functools.partial(_barnard.bake_image, self._native)
        return written(page_of(packed(bake, limit, progress)), path)

    def __iter__(self):
        return iter(self.bands)

    def __len__(self) -> int:
        return len(self.bands)

    @property
    def certificates(self) -> dict[str, list[Certificate]]:
        """The largest spectral errors by passband, a `Certificate` for each light; empty for "reference" and "path"."""
        return self.report.certificates

    @property
    def report(self) -> Report:
        """How the image was made and its stated errors, as numbers."""
        if self._report is None:
            self._report = report_of(self._native.report)
        return self._report

    @property
    def keywords(self) -> dict[str, str | int | float]:
        """FITS header: method, steps and errors, such as `image.keywords["SPATERR"]`."""
        return self._native.keywords

    @property
    def notes(self) -> dict[str, str]:
        """Notes of the picture."""
        return dict(self._native.notes)

    @property
    def warnings(self) -> list[str]:
        """Warnings of the render, such as an accuracy that was not reached."""
        return [*self._native.warnings, *self._warnings]

    @property
    def hdus(self) -> Any:
        """The image as an astropy HDUList, as `write("x.fits")` writes it."""
        import io

        from astropy.io import fits

        return fits.open(io.BytesIO(self._native.encode("fits")))

    @property
    def wcs(self) -> Any:
        """World coordinates of the pixels of this object's arrays, an astropy WCS.

        Rows count from the top, as in `radiance` and `image["V"]`: `image.wcs.pixel_to_world(column, row)` is the position
        of `image["V"][row, column]`. Headers of `hdus` and FITS files count rows from the bottom, as their arrays do.
        """
        from astropy.wcs import WCS

        wcs = next(WCS(hdu.header) for hdu in self.hdus if hdu.header["NAXIS"] == 2)
        wcs.wcs.crpix = [wcs.wcs.crpix[0], self.shape[1] + 1 - wcs.wcs.crpix[1]]
        wcs.wcs.pc = wcs.wcs.get_pc() * np.array([[1.0, -1.0]])
        wcs.wcs.set()
        return wcs

    def to_xarray(self) -> Any:
        """An xarray DataArray with dims band, y, x, and the unit in its attributes; needs xarray.

        y (upwards) and x are relative to the optical axis, in degrees, or in pc for orthographic cameras.
        """
        import xarray

        _, height, width = self.shape
        scale = self._native.pixel_scale
        step, unit = scale if scale is not None else (1.0, "pixel")
        right, up = self._native.axis
        y = (0.5 * (height - 1) - np.arange(height) - up) * step
        x = (np.arange(width) - 0.5 * (width - 1) - right) * step
        details = self._native.band_details
        coordinates = {
            "band": self.bands,
            "y": ("y", y, {"units": unit}),
            "x": ("x", x, {"units": unit}),
            "pivot": ("band", [np.nan if pivot is None else pivot for pivot, _, _ in details], {"units": "um"}),
        }
        attributes = {"units": "W m-2 sr-1", "long_name": "band radiance", **self.keywords}
        return xarray.DataArray(self.radiance, dims=("band", "y", "x"), coords=coordinates, attrs=attributes, name="radiance")

    def observe(self, instrument: Instrument | dict[str, Any] | None = None, *, progress: bool | Listener | None = None) -> Exposures:
        """Simulates an observation: telescope, atmosphere, detector and noise.

        Parameters
        ----------
        instrument : Instrument, optional
            Instrument instead of the scene's. Its files are relative to the working directory.
        progress : true or callable (stage, done, all), optional

        Raises
        ------
        SceneError
            If the instrument is invalid.
        BarnardError
            If there is no instrument, the picture is not flat or too coarse for the detector, or sky or mosaic do not match its bands.
        """
        from .exposures import Exposures

        tree = None if instrument is None else table_of(Instrument, instrument, "instrument")._nodes()
        with listening(progress) as listener:
            native = _barnard.observe(self._native, tree, progress=listener)
        return Exposures(native, [self.bands[number] for number in self._native.radiances], (self, tree))

    def rgb(self, **display: Any) -> np.ndarray:
        """Colour picture, height × width × 3 of uint8 in sRGB.

        Parameters
        ----------
        **display : keys of `Display`
            Such as palette="sho" or stretch="log". Default: those of the scene.

        Raises
        ------
        SceneError
            If a key or a value is invalid.
        """
        return self._native.rgb(Display(**display)._nodes() if display else None)

    def png(self, **display: Any) -> bytes:
        """Colour picture as the bytes of a .png; see `rgb`."""
        return self._native.png(Display(**display)._nodes() if display else None)

    def write(self, path: str | os.PathLike) -> None:
        """Writes the image completely or not at all: radiances as .fits, .exr and .npy, colour pictures as .png, .tif and .jpg.

        Raises
        ------
        BarnardError
            If the extension is unknown, or the file cannot be written.
        """
        self._native.write(os.fspath(path))

    def __repr__(self) -> str:
        _, height, width = self.shape
        return f"Image({width} x {height}, {', '.join(self.bands)})"

    def _repr_html_(self) -> str:
        picture = base64.b64encode(self.png()).decode()
        rows = "".join(
            f"<tr><td>{html.escape(band)}</td><td>{_short(of_band)}</td></tr>" for band, of_band in self.certificates.items() if of_band
        )
        notes = "".join(f"<tr><td>{html.escape(key)}</td><td>{html.escape(words)}</td></tr>" for key, words in self.notes.items())
        return (
            f'<div><img src="data:image/png;base64,{picture}" alt="{html.escape(repr(self))}">'
            f"<details><summary>{html.escape(repr(self))}</summary><table>{rows}{notes}</table></details></div>"
        )


def _restored(version: str, state: dict[str, Any], parameters: dict[str, Any], warnings: list[str]) -> Image:
    if version != _barnard.__version__:
        raise _barnard.BarnardError(
            f"the image was pickled by barnard {version}, this is {_barnard.__version__}; store images with Image.write, as .fits"
        )
    image = Image(_barnard.restored(state))
    image.parameters, image._warnings = parameters, warnings
    return image


def _short(of_band: list[Certificate]) -> str:
    worst = max(of_band, key=lambda certificate: certificate.absolute)
    return f"spectral error at most {worst.absolute:.1e} of F(0), {worst.relative:.1e} of F(a), for depths up to {worst.depth:.3g}"
