"""Physically calibrated spectral rendering of nebulae.

>>> import barnard as bn
>>> image = bn.Scene.builtin("barres_neyret").render()
>>> image.write("nebula.png")

`Scene` is what is in front of the telescope and the telescope; `Scene.render` makes an `Image`, band radiances in
W m-2 sr-1 with a stated error. Keywords are the keys of scene files. Quantities are values of astropy or unyt, or texts
with their unit; fields are arrays of NumPy or formulas.
"""

from __future__ import annotations

import os

from . import _barnard
from ._barnard import BarnardError, DeviceError, MemoryLimitError, SceneError
from .bricks import render_bricks
from .cluster import Result, map, tiles  # `map` is not in __all__: Python has one of its own.
from .exposures import Exposures
from .fit import Fit, FitModel
from .image import Image
from .plan import AccuracyWarning, Certificate, Plan, PlanError
from .plates import Plates
from .scene import Scene
from .sequence import FrameSequence
from . import tables
from .tables import *  # noqa: F403

__version__: str = _barnard.__version__

__all__ = [
    "AccuracyWarning",
    "BarnardError",
    "Certificate",
    "DeviceError",
    "Exposures",
    "Fit",
    "FitModel",
    "FrameSequence",
    "Image",
    "MemoryLimitError",
    "Plan",
    "PlanError",
    "Plates",
    "Result",
    "Scene",
    "SceneError",
    "catalogue",
    "catalogues",
    "render_bricks",
    "set_threads",
    "tiles",
    *tables.__all__,
]


def catalogues() -> dict[str, str]:
    """Names of all catalogues, each with what it holds."""
    return dict(_barnard.catalogues())


def catalogue(name: str) -> dict[str, str]:
    """The entries of a catalogue, such as "laws" or "passbands": name to what it is.

    Raises
    ------
    SceneError
        Where there is no such catalogue.
    """
    return dict(_barnard.catalogue(name))


def set_threads(count: int) -> None:
    """Lets all work from now on take so many threads; 0 for one a core. The results are the same, bit by bit.

    Raises
    ------
    ValueError
        Where the number is none.
    """
    if not isinstance(count, int) or not 0 <= count <= 4096:
        raise ValueError(f"{count!r} is no number of threads; give a whole number from 0 (one per core) to 4096")
    _barnard.set_threads(count)


# Threads stay behind when a process forks.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_barnard.after_fork)
