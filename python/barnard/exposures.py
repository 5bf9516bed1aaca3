"""Recorded data of an instrument: frames of counts, and a master of them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from . import _barnard
from ._progress import Listener, listening
from .image import Image


class Exposures:
    """Instrument response to a picture, for all of its frames; `Image.observe` makes them.

    `len(exposures)` is the number of frames. The same seed records the same counts, whatever the number of threads.
    """

    def __init__(self, native: _barnard.Exposures, bands: list[str], made: tuple[Image, dict[str, Any] | None]):
        self._native, self._bands, self._made = native, bands, made

    def __reduce__(self):
        """Picture and instrument; unpickling repeats the observation, with the same counts."""
        return Image.observe, self._made

    def __len__(self) -> int:
        return self._native.frames

    def __repr__(self) -> str:
        height, width = self.shape
        return f"Exposures({len(self)} frames of {width} x {height} pixels through {', '.join(self._bands)})"

    @property
    def shape(self) -> tuple[int, int]:
        """(height, width) in pixels of the detector."""
        return self._native.shape

    def _number(self, number: int) -> int:
        if not 0 <= number < len(self):
            raise IndexError(f"frame {number} does not exist; there are {len(self)}, from 0 on")
        return number

    def frame(self, number: int) -> dict[str, np.ndarray]:
        """Counts of a frame by passband, or of the one "mosaic" of a colour sensor.

        Parameters
        ----------
        number : integer
            Index of the frame, from 0.

        Returns
        -------
        dictionary of arrays, height × width, uint16
            Counts, first row on top [ADU].

        Raises
        ------
        IndexError
            If the frame does not exist.
        """
        return self._native.frame(self._number(number))

    def mean(self, band: str) -> np.ndarray:
        """Expected electrons per pixel and frame from picture, sky and dark current, without cosmic rays.

        Returns
        -------
        array, height × width, float64
            Electrons, first row on top [e].

        Raises
        ------
        KeyError
            If the passband is unknown.
        """
        if band not in self._bands:
            raise KeyError(f"unknown passband {band}; known: {', '.join(self._bands)}")
        return self._native.mean(self._bands.index(band))

    def write_frame(self, number: int, path: str | os.PathLike) -> None:
        """Writes a frame completely or not at all, as a FITS file of unsigned 16-bit integers.

        Raises
        ------
        IndexError
            If the frame does not exist.
        BarnardError
            If the name does not end with .fits, or the file cannot be written.
        """
        self._native.write_frame(self._number(number), os.fspath(Path(path)))

    def master(self, *, progress: bool | Listener | None = None) -> Image:
        """Calibrates and combines all frames.

        Returns
        -------
        Image
            Radiances [W m-2 sr-1], their standard errors as bands NAME_error, and `layers["mask"]`, bands × height × width:
            1 if a frame is saturated, 2 if a frame was rejected, 4 if no frame is valid.

        Raises
        ------
        KeyboardInterrupt
            After Ctrl-C.
        """
        with listening(progress) as listener:
            return Image(self._native.master(progress=listener))
