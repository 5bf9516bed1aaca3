"""Recorded data of an instrument: frames of counts, and a master of them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from ._progress import Listener, told
from .image import Image


class Exposures:
    """Instrument response to a picture, for all of its frames; `Image.observe` makes them.

    `len(exposures)` is the number of frames. The same seed records the same counts, whatever the number of threads.
    """

    def __init__(self, native: Any, bands: list[str], made: tuple[Image, dict[str, Any] | None]):
        self._native, self._bands, self._made = native, bands, made

    def __reduce__(self):
        """The picture and the instrument; whoever reads the pickle observes it again, with the same counts."""
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
            From 0 to below the number of frames.

        Returns
        -------
        dictionary of arrays, height × width, uint16
            The first row on top [ADU].

        Raises
        ------
        IndexError
            Where there is no such frame.
        """
        return self._native.frame(self._number(number))

    def mean(self, band: str) -> np.ndarray:
        """Electrons that pixels gather in a frame on the average, without cosmic rays: of the picture, the sky and the dark.

        Returns
        -------
        array, height × width, float64
            The first row on top [e].

        Raises
        ------
        KeyError
            Where there is no such passband.
        """
        if band not in self._bands:
            raise KeyError(f"unknown passband {band}; known: {', '.join(self._bands)}")
        return self._native.mean(self._bands.index(band))

    def write_frame(self, number: int, path: str | os.PathLike) -> None:
        """Writes a frame as a FITS file of unsigned 16-bit integers, whole or not at all.

        Raises
        ------
        IndexError
            Where there is no such frame.
        BarnardError
            Where the file cannot be written, or its name does not end with .fits.
        """
        self._native.write_frame(self._number(number), os.fspath(Path(path)))

    def master(self, *, progress: bool | Listener | None = None) -> Image:
        """All frames, calibrated and combined.

        Returns
        -------
        Image
            Radiances [W m-2 sr-1], a band NAME_error of standard errors for each, and `layers["mask"]`, bands × height × width:
            1 where a frame was saturated, 2 where one was rejected, 4 where none is good.

        Raises
        ------
        KeyboardInterrupt
            After Ctrl-C.
        """
        with told(progress) as listener:
            return Image(self._native.master(progress=listener))
