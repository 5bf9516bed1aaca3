"""Fits: parameters of a scene from observed images, with error bars."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _barnard
from ._progress import Listener, told
from ._tree import tree_of
from .image import Image

if TYPE_CHECKING:
    from .scene import Scene


class Fit:
    """What a fit found; `FitModel.fit` and `Scene.fit` make it.

    `values`, `sigma` and `floor` are dictionaries by key, in the units that the scene writes (`units`): the value, its standard error, and by
    how much it may be wrong at most since the model has an error of its own. `covariance` is an array in the order of the keys. `chi2` is the sum
    over `pixels` data, `linear` says in which keys the model is linear, `degenerate` which keys the data do not tell apart, `bounded` which ended
    at a bound, `converged` whether steps became small, `pictures` how many were made.
    """

    def __init__(self, keys: list[str], units: list[str], found: dict[str, Any]):
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
        #: Data less model of each image, with standard errors; NaN where pixels do not count.
        self.residuals: list[Image] = [Image(own) for own in found["residuals"]]

    @property
    def freedom(self) -> int:
        """Degrees of freedom: pixels less parameters."""
        return self.pixels - len(self.keys)

    def __repr__(self) -> str:
        rows = (f"{key} = {value:.6g} +- {self.sigma[key]:.2g} {self.units[key]}".rstrip() for key, value in self.values.items())
        return "\n".join([f"Fit(chi2 {self.chi2:.1f} of {self.freedom} degrees of freedom)", *rows])


class FitModel:
    """A scene as the model of observed images; `Scene.fit_model` makes it. Other programs may drive it, such as scipy and emcee.

    `keys`, `units`, `bounds` and `start` tell the free numbers, `data` the pixels that count, one after the other.

    >>> model = scene.fit_model("star[0].luminosity, dust.scale=0.5..5", "master.fits")
    >>> scipy.optimize.least_squares(model.residuals, model.start)
    """

    def __init__(self, native: Any):
        self._native = native
        self.keys: list[str] = native.keys
        self.units: list[str] = native.units
        self.bounds: list[tuple[float, float]] = native.bounds
        self.start: list[float] = native.start
        self.data: np.ndarray = native.data

    def _numbers(self, values: Sequence[float]) -> list[float]:
        """One number for each key."""
        if len(values) != len(self.keys):
            raise ValueError(f"{len(values)} values for {len(self.keys)} keys: {', '.join(self.keys)}")
        return [float(value) for value in values]

    def predict(self, values: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
        """What the data would be without noise, and their standard errors.

        Parameters
        ----------
        values : sequence of numbers
            One for each key, in its unit.

        Returns
        -------
        two arrays like `data`
            In the unit of the scene's observation. Standard errors are those of the scene's instrument, or of the files where it has none.

        Raises
        ------
        SceneError
            Where the values cannot be.
        """
        mean, sigma = self._native.predict(self._numbers(values))
        return mean, sigma

    def residuals(self, values: Sequence[float]) -> np.ndarray:
        """Data less model in standard errors."""
        mean, sigma = self.predict(values)
        return (self.data - mean) / sigma

    def log_likelihood(self, values: Sequence[float]) -> float:
        """The logarithm of the probability of the data, normal noise; minus infinity beyond the bounds, and where values cannot be."""
        values = self._numbers(values)
        if any(not low <= value <= high for value, (low, high) in zip(values, self.bounds)):
            return -np.inf
        try:
            mean, sigma = self.predict(values)
        except _barnard.SceneError:
            return -np.inf
        return float(-0.5 * np.sum(((self.data - mean) / sigma) ** 2 + np.log(2 * np.pi * sigma**2)))

    def fit(self, start: Sequence[float] | None = None, *, progress: bool | Listener | None = None) -> Fit:
        """The values where the data are most probable: linear ones are solved inside, the others by Levenberg-Marquardt.

        Parameters
        ----------
        start : sequence of numbers, optional
            Where it begins, in place of what the scene says.
        progress : true or callable (stage, done, all), optional

        Raises
        ------
        SceneError
            Where the data do not depend on a key, or values cannot be.
        KeyboardInterrupt
            Where Ctrl-C stopped it.
        """
        values = self._numbers(self.start if start is None else start)
        with told(progress) as listener:
            return Fit(self.keys, self.units, self._native.fit(values, progress=listener))


#: One image, or images: paths, or pairs of a path and what its scene has in place of the common one.
Images = str | os.PathLike | Sequence[str | os.PathLike | tuple[str | os.PathLike, Mapping[str, Any]]]


def observations(images: Images, empty: Any) -> list[tuple[str, dict[str, Any]]]:
    """Each image as a path and a tree; `empty` makes a scene of keywords."""
    if isinstance(images, Image):
        raise TypeError("an image in memory: write it to a FITS file, and give its path")
    if isinstance(images, (str, os.PathLike)):
        images = [images]
    pairs = [image if isinstance(image, tuple) else (image, {}) for image in images]
    return [(os.fspath(path), tree_of(empty(**dict(parts)))) for path, parts in pairs]


def model_of(scene: Scene, free: str, images: Images, listener: Listener | None) -> FitModel:
    """The model of a scene for images."""
    tree, native = scene._native()
    pairs = observations(images, type(scene))
    return FitModel(_barnard.fit_model(scene._reading(), tree, native, free, pairs, progress=listener))
