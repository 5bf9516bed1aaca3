"""Physically calibrated spectral rendering of nebulae.

>>> import barnard as bn
>>> image = bn.Scene.builtin("barres_neyret").render()
>>> image.write("nebula.png")

`Scene` describes a nebula and its camera; `Scene.render` returns an `Image`, band radiances in W m-2 sr-1 with stated
errors. Keywords are the keys of scene files. Quantities are values of astropy or unyt, or texts with units; fields are
NumPy arrays or formulas.
"""

from __future__ import annotations

import os

from . import _barnard
from ._barnard import BarnardError, DeviceError, MemoryLimitError, SceneError
from ._report import Certificate, Report, SpatialReport
from .bricks import render_bricks
from .cluster import Result, map, tiles  # `map` is not in __all__: Python has one of its own.
from .exposures import Exposures
from .fit import Fit, FitModel
from .free import Free
from .image import Image
from .parameters import Parameter
from .plan import AccuracyWarning, Plan, PlanError
from .plates import Plates
from .scene import Scene
from .sequence import FrameSequence
from . import cache, tables
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
    "Free",
    "Image",
    "MemoryLimitError",
    "Parameter",
    "Plan",
    "PlanError",
    "Plates",
    "Report",
    "Result",
    "Scene",
    "SceneError",
    "SpatialReport",
    "cache",
    "catalogue",
    "catalogues",
    "render_bricks",
    "set_threads",
    "tiles",
    *tables.__all__,
]


def catalogues() -> dict[str, str]:
    """Names and summaries of all catalogues."""
    return dict(_barnard.catalogues())


def catalogue(name: str) -> dict[str, str]:
    """Entries of a catalogue, such as "laws" or "passbands": names and summaries.

    Raises
    ------
    SceneError
        If the catalogue is unknown.
    """
    return dict(_barnard.catalogue(name))


def set_threads(count: int) -> None:
    """Sets the number of threads of all later work; 0 for one per core. Results do not depend on it.

    Raises
    ------
    ValueError
        If the number is out of range.
    """
    if not isinstance(count, int) or not 0 <= count <= 4096:
        raise ValueError(f"{count!r} threads are out of range; give a whole number from 0 (one per core) to 4096")
    _barnard.set_threads(count)


# Threads stay behind when a process forks.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_barnard.after_fork)
