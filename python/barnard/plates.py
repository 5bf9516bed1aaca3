"""Plates: a picture stored per light, to change spectra without rendering again."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _barnard
from ._values import number, quantity
from .image import Image

if TYPE_CHECKING:
    from .scene import Scene


class Plates:
    """A picture stored per light, made by `Scene.plates` or read by `Plates.read`.

    `lights` is the number of plates, `bytes` their size, `range` the wavelength range [um], `shape` (height, width) in pixels.

    >>> plates = scene.plates(range=("380 nm", "1 um"))
    >>> scene.stars[0].temperature = "12000 K"
    >>> image = plates.expose(scene)
    """

    def __init__(self, native: _barnard.Plates):
        self._native = native

    def __reduce__(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "own.plates"
            self.write(path)
            return _restored, (path.read_bytes(),)

    def __repr__(self) -> str:
        height, width = self.shape
        low, high = (1e3 * end for end in self.range)
        return f"Plates({self.lights} lights, {width} x {height} pixels, {low:.1f} to {high:.1f} nm, {self.bytes / 2**20:.1f} MiB)"

    @property
    def shape(self) -> tuple[int, int]:
        return self._native.shape

    @property
    def lights(self) -> int:
        return self._native.lights

    @property
    def bytes(self) -> int:
        return self._native.bytes

    @property
    def range(self) -> tuple[float, float]:
        return self._native.range

    def expose(self, scene: Scene) -> Image:
        """Picture of a scene with other spectra, luminosities, passbands, albedo or amount of dust.

        Returns
        -------
        Image
            The picture of `Scene.render`, within the stated errors.

        Raises
        ------
        SceneError
            If the scene differs in anything else, or light or dust exceeds the range of the plates.
        """
        return Image(self._native.expose(scene._session().scene))

    def write(self, path: str | os.PathLike) -> None:
        """Writes the plates completely or not at all.

        Parameters
        ----------
        path : path
            The file, an archive for `numpy.load`, usually named .plates.

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        self._native.write(os.fspath(path))

    @classmethod
    def read(cls, path: str | os.PathLike, memory: float = 16) -> Plates:
        """Reads plates from a file.

        Parameters
        ----------
        path : path
            File written by `write` or `barnard plates`.
        memory : number, default 16
            Memory limit of one array [GiB].

        Raises
        ------
        SceneError
            If the file cannot be read, or has no plates.
        MemoryLimitError
        """
        return cls(_barnard.read_plates(os.fspath(path), int(memory * 2**30)))


def _restored(file: bytes) -> Plates:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "own.plates"
        path.write_bytes(file)
        return Plates.read(path)


def wavelengths(range: Any) -> tuple[str, str] | None:
    """A range of wavelengths as texts; none where none is said."""
    if range is None:
        return None
    low, high = range
    return _text(low), _text(high)


def _text(wavelength: Any) -> str:
    """A wavelength as a text with its unit."""
    value = quantity(wavelength, ["wavelength"], "range")
    return value if isinstance(value, str) else f"{number(value[0])} {value[1]}"
