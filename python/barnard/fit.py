"""Fits: parameters of a scene from observed images, with error bars."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _barnard
from ._progress import Listener, listening
from ._tree import tree_of
from ._warn import warn
from .free import Free, FreeKeys, rows_of
from .image import Image

if TYPE_CHECKING:
    from .scene import Scene


class Fit:
    """Result of a fit; `FitModel.fit` and `Scene.fit` make it.

    Attributes
    ----------
    values, sigma, floor : dictionaries of numbers by key
        Best value, standard error, and largest effect of the model's own error, in `units`.
    units : dictionary of texts by key
        Units of the keys in the scene.
    covariance : array, keys × keys
    chi2, pixels : number, integer
        Chi-squared, and the number of data.
    linear : dictionary of booleans by key
        True for keys in which the model is linear.
    degenerate, bounded : lists of keys
        Keys that the data do not distinguish, and keys at a bound.
    converged : boolean
    pictures : integer
        Number of pictures rendered.
    residuals : list of Image
        Data minus model per image, with standard errors; NaN for ignored pixels.
    """

    def __init__(self, keys: list[str], units: list[str], found: _barnard.FitFacts):
        self.keys = keys
        self.units: dict[str, str] = dict(zip(keys, units))
        self.values: dict[str, float] = dict(zip(keys, found["values"]))
        self.covariance: np.ndarray = found["covariance"]
        self.sigma: dict[str, float] = dict(zip(keys, np.sqrt(np.maximum(np.diag(self.covariance), 0)).tolist()))
        self.floor: dict[str, float] = dict(zip(keys, found["floor"]))
        self.linear: dict[str, bool] = dict(zip(keys, found["linear"]))
        self.chi2: float = found["chi2"]
        self.pixels: int = found["pixels"]
        self.pictures: int = found["pictures"]
        self.converged: bool = found["converged"]
        self.degenerate: list[str] = [keys[i] for i in found["degenerate"]]
        self.bounded: list[str] = [keys[i] for i in found["bounded"]]
        self.residuals: list[Image] = [Image(native) for native in found["residuals"]]
        if found["chi2_warning"]:
            warn(found["chi2_warning"])

    @property
    def freedom(self) -> int:
        """Degrees of freedom: data minus free keys."""
        return self.pixels - len(self.keys)

    def __repr__(self) -> str:
        rows = (f"{key} = {value:.6g} +- {self.sigma[key]:.2g} {self.units[key]}".rstrip() for key, value in self.values.items())
        return "\n".join([f"Fit(chi2 {self.chi2:.1f} of {self.freedom} degrees of freedom)", *rows])


class FitModel:
    """A scene as a model of observed images, made by `Scene.fit_model`, for its own fit or for scipy, emcee and other samplers.

    With single scattering, predictions are smooth to double precision, so finite differences of any step work. With multiple
    scattering they have single precision: pass `diff_step` or `jacobian` to optimisers.

    >>> model = scene.fit_model({"star[0].luminosity": None, "dust.scale": bn.Free(0.5, 5)}, "master.fits")
    >>> scipy.optimize.least_squares(model.residuals, model.start, jac=model.jacobian, x_scale=model.x_scale)

    Models can be pickled and copied; unpickling reads the images again.

    Attributes
    ----------
    keys, units : lists of texts
        Free keys of the scene, and their units.
    bounds, start : lists
        (low, high) and start value of each key.
    data : array
        All valid pixels of all images, in one dimension.
    diff_step : number
        Relative step for finite differences, which balances rounding and curvature: the cube root of the rounding error.
    x_scale : array
        Scale of each key: its start value, or the width of its bounds if that is zero.
    """

    def __init__(self, native: _barnard.FitModel, made: tuple[Any, ...]):
        self._native, self._made = native, made
        self.keys: list[str] = native.keys
        self.units: list[str] = native.units
        self.bounds: list[tuple[float, float]] = native.bounds
        self.start: list[float] = native.start
        self.data: np.ndarray = native.data
        self.diff_step: float = native.rounding ** (1 / 3)
        widths = [high - low if np.isfinite(high - low) else 1.0 for low, high in self.bounds]
        self.x_scale: np.ndarray = np.array([abs(value) or width for value, width in zip(self.start, widths)])

    def __reduce__(self):
        return _remade, self._made

    def _numbers(self, values: Sequence[float]) -> list[float]:
        """Values as one number per key."""
        if len(values) != len(self.keys):
            raise ValueError(f"{len(values)} values for {len(self.keys)} keys: {', '.join(self.keys)}")
        return [float(value) for value in values]

    def predict(self, values: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
        """Noise-free data and their standard errors.

        Parameters
        ----------
        values : sequence of numbers
            One per key, in its unit.

        Returns
        -------
        two arrays like `data`
            In the unit of the scene's observation. Standard errors come from the scene's instrument, otherwise from the files.

        Raises
        ------
        SceneError
            If the values are invalid.
        """
        mean, sigma = self._native.predict(self._numbers(values))
        return mean, sigma

    def residuals(self, values: Sequence[float]) -> np.ndarray:
        """Data minus model in standard errors; infinite, with a warning, for invalid values."""
        try:
            return self._residuals(values)
        except _barnard.SceneError as error:
            warn(f"no model at {list(values)}: {error}")
            return np.full_like(self.data, np.inf)

    def _residuals(self, values: Sequence[float]) -> np.ndarray:
        mean, sigma = self.predict(values)
        return (self.data - mean) / sigma

    def jacobian(self, values: Sequence[float]) -> np.ndarray:
        """Derivatives of `residuals`: second-order differences, exact up to rounding for linear keys.

        Parameters
        ----------
        values : sequence of numbers
            One per key, in its unit.

        Returns
        -------
        array, data × keys

        Raises
        ------
        SceneError
            If the values, or values one step away within the bounds, are invalid.
        """
        here = self._numbers(values)
        steps = self.diff_step * np.maximum(np.abs(here), 1e-3 * self.x_scale)

        def at(key: int, by: float) -> np.ndarray:
            return self._residuals([value + by * (key == other) for other, value in enumerate(here)])

        columns = []
        for key, (step, (low, high)) in enumerate(zip(steps, self.bounds)):
            if low <= here[key] - step and here[key] + step <= high:
                columns.append((at(key, step) - at(key, -step)) / (2 * step))
                continue
            # At a bound both are on the one side, of the same order.
            step = step if here[key] + 2 * step <= high else -step
            columns.append((4 * at(key, step) - 3 * at(key, 0.0) - at(key, 2 * step)) / (2 * step))
        return np.stack(columns, axis=1)

    def log_likelihood(self, values: Sequence[float]) -> float:
        """Logarithm of the likelihood, for normal noise; minus infinity for values that are invalid or out of bounds."""
        values = self._numbers(values)
        if any(not low <= value <= high for value, (low, high) in zip(values, self.bounds)):
            return -np.inf
        try:
            mean, sigma = self.predict(values)
        except _barnard.SceneError:
            return -np.inf
        return float(-0.5 * np.sum(((self.data - mean) / sigma) ** 2 + np.log(2 * np.pi * sigma**2)))

    def fit(self, start: Sequence[float] | None = None, *, progress: bool | Listener | None = None) -> Fit:
        """Maximum-likelihood values by variable projection: linear keys are solved exactly, the others by Levenberg-Marquardt.

        Parameters
        ----------
        start : sequence of numbers, optional
            Start values. Default: the values of the scene.
        progress : true or callable (stage, done, all), optional

        Raises
        ------
        SceneError
            If the data do not depend on a key, or values are invalid.
        KeyboardInterrupt
            After Ctrl-C.
        """
        values = self._numbers(self.start if start is None else start)
        with listening(progress) as listener:
            return Fit(self.keys, self.units, self._native.fit(values, progress=listener))


#: An image: a FITS file, a picture, or an array of all bands.
Pixels = str | os.PathLike | Image | np.ndarray
#: One image, or several, each alone or with overrides of its scene.
Images = Pixels | Sequence[Pixels | tuple[Pixels, Mapping[str, Any]]]

#: Keys of an image in memory that are not keys of a scene.
BESIDE = ("sigma", "mask")


def _source(number: int, image: Any, beside: dict[str, Any]) -> Any:
    """A path, or native pixels."""
    if isinstance(image, (str, os.PathLike)):
        for name, value in beside.items():
            if value is not None:
                raise TypeError(f"{name} requires an array or an Image; the file {os.fspath(image)} has its own HDUs: NAME_error or ERR, and mask.NAME or DQ")
        return image
    name = f"image {number}"
    if isinstance(image, Image):
        picture, values = image._native, None
        shape = (len(picture.radiances), *image.shape[1:])
    else:
        picture, values = None, _planes(image, name, None)
        shape = values.shape
    sigma, mask = (None if plane is None else _planes(plane, f"{what} of {name}", shape) for what, plane in beside.items())
    return _barnard.fit_pixels(name, picture, values, sigma, None if mask is None else mask != 0)


def _planes(array: Any, name: str, shape: tuple[int, ...] | None) -> np.ndarray:
    """Numbers of bands × height × width, broadcast to a shape if one is given."""
    array = np.asarray(np.ma.filled(array, np.nan) if np.ma.isMaskedArray(array) else array, dtype=np.float64)
    if shape is not None:
        try:
            return np.ascontiguousarray(np.broadcast_to(array, shape))
        except ValueError:
            raise ValueError(f"{name} has shape {array.shape}, the image {shape}") from None
    array = array[None] if array.ndim == 2 else array
    if array.ndim != 3:
        raise ValueError(f"{name} has shape {array.shape}; give bands × height × width, or height × width of one band")
    return np.ascontiguousarray(array)


def observations(images: list[tuple[Any, Mapping[str, Any]]], empty: Any, beside: dict[str, Any], assumed: tuple[bool, ...]) -> list[tuple[Any, dict[str, Any], tuple[bool, ...]]]:
    """Source, tree of overrides and assumptions of each image; `empty` makes a scene from keywords."""
    found = []
    for number, (image, parts) in enumerate(images):
        stated = {name: parts.get(name, value) for name, value in beside.items()}
        tree = tree_of(empty(**{name: part for name, part in parts.items() if name not in BESIDE}))
        found.append((_source(number, image, stated), tree, assumed))
    return found


#: Metadata that may be assumed.
UNSAID = ("unit", "place")


def model_of(scene: Scene, free: FreeKeys, images: Images, beside: dict[str, Any], assume: str | Sequence[str], listener: Listener | None) -> FitModel:
    """The model of a scene for images."""
    names = [assume] if isinstance(assume, str) else list(assume)
    for name in names:
        if name not in UNSAID:
            raise ValueError(f"assume={name!r} is unknown; known: {', '.join(UNSAID)}")
    scene = scene._twin()
    session = scene._session()
    rows = rows_of(free, session.tree)
    pairs = _pairs(images)
    sources = observations(pairs, type(scene), beside, tuple(name in names for name in UNSAID))
    made = _barnard.fit_model(session.reader, session.tree, session.scene, rows, sources, progress=listener)
    return FitModel(made, (scene, {key: Free(low, high, prior) for key, low, high, prior in rows}, pairs, beside, names))


def _pairs(images: Images) -> list[tuple[Any, Mapping[str, Any]]]:
    """Images with their overrides; paths are absolute, so that a pickle works in any folder."""
    alone = isinstance(images, (str, os.PathLike, Image)) or hasattr(images, "__array__")
    every: Sequence[Any] = [images] if alone else list(images)  # type: ignore[arg-type]
    pairs = [image if isinstance(image, tuple) else (image, {}) for image in every]
    return [(os.path.abspath(image) if isinstance(image, (str, os.PathLike)) else image, parts) for image, parts in pairs]


def _remade(scene: Scene, free: FreeKeys, images: Images, beside: dict[str, Any], assume: list[str]) -> FitModel:
    return model_of(scene, free, images, beside, assume, None)
