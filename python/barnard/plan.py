"""Plans: precomputed data of a scene for many pictures."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import _barnard
from ._progress import Listener, told
from ._rows import scene_error
from ._table import table_of
from .image import Image
from .tables import Camera

if TYPE_CHECKING:
    from .scene import Scene


class AccuracyWarning(UserWarning):
    """A picture is less exact than its scene requests; raised once per plan."""


class PlanError(_barnard.BarnardError):
    """Use of a plan after its scene changed; `key` is the changed key."""

    key: str


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


def certificates(bands: list[str], rows: list[list[tuple[str, float, float, float]]]) -> dict[str, list[Certificate]]:
    """Certificates by passband, one per light in it."""
    return {band: [Certificate(*row) for row in of_band] for band, of_band in zip(bands, rows)}


#: Parts of a scene that a plan does not depend on.
PASSED = ("camera", "observation", "instrument")


class Plan:
    """Precomputed data of a scene, made by `Scene.plan`.

    It renders the scene at its creation from any camera.

    Attributes: `method` (spectral method), `terms` (exponentials per sample and star), `steps` (distance of samples, as
    text), `bytes` (size of tables and volumes), `accuracy` (requested), `spatial_error` (relative rms error of the worst
    band and number of pilot rays), `certificates` (spectral errors by passband), `notes` (dictionary of texts).
    """

    def __init__(self, owner: Scene, tree: dict[str, Any], scene: Any, plan: Any, backend: str):
        self._owner, self._tree, self._scene, self._plan, self._backend = owner, tree, scene, plan, backend
        self._warned = False

    @property
    def method(self) -> str:
        return self._plan.method

    @property
    def terms(self) -> int:
        return self._plan.terms

    @property
    def steps(self) -> str:
        return self._plan.steps

    @property
    def bytes(self) -> int:
        return self._plan.bytes

    @property
    def accuracy(self) -> float:
        return self._plan.accuracy

    @property
    def misses_accuracy(self) -> bool:
        """True if pilot rays found a larger error than requested."""
        return self._plan.misses_accuracy

    @property
    def spatial_error(self) -> tuple[float, int] | None:
        return self._plan.spatial_error

    @property
    def certificates(self) -> dict[str, list[Certificate]]:
        return certificates(self._scene.bands, self._plan.certificates)

    @property
    def camera(self) -> Camera:
        """Camera of the plan."""
        return table_of(Camera, self._tree["camera"], "camera")

    @property
    def notes(self) -> dict[str, str]:
        return dict(self._plan.notes)

    def __reduce__(self):
        """The scene; unpickling plans it again, with the same bits."""
        self._check(self._tree.get("camera"))
        return _planned, (self._owner, self._tree.get("camera"), self._backend)

    def __repr__(self) -> str:
        return f"Plan({self.method}, {self.terms} terms per sample, {self.steps}, {self.bytes / 2**20:.1f} MiB)"

    def render(self, camera: Camera | dict[str, Any] | None = None, *, progress: bool | Listener | None = None) -> Image:
        """Renders the planned scene from its own camera or another.

        Steps, rules and their errors are those of the plan's own camera. `Scene.render` measures them for each camera.

        Raises
        ------
        PlanError
            If anything but camera, sky position and instrument of the scene has changed.
        """
        camera = self._tree.get("camera") if camera is None else camera
        moved = self._check(camera)
        scene, plan = self._scene, self._plan
        with told(progress) as listener:
            if moved:
                _, scene = self._owner._native(camera)
                plan = plan.look_from(scene, progress=listener)
            return self._render(scene, plan, listener)

    def _check(self, camera: Any) -> bool:
        """True if a camera is another than that of the plan; refuses a scene that has changed."""
        before, now = dict(self._tree), self._owner._tree(camera)
        own, other = [[tree.pop(part, None) for part in PASSED] for tree in (before, now)]
        changed = _changed(before, now)
        if changed is not None:
            error = PlanError(f"{changed}: the scene has changed since the plan was made; make a new one with scene.plan()")
            error.key = changed
            raise error
        return own != other

    def _render(self, scene: Any, plan: Any, listener: Listener | None) -> Image:
        image = Image(_barnard.render(scene, plan, self._backend, exactness(self._backend), self._owner._limit, progress=listener))
        if plan.misses_accuracy:
            error, rays = plan.spatial_error
            words = (
                f"the spatial error measured by {rays} pilot rays is {error:.1e}, the requested accuracy {plan.accuracy:.1e}; "
                "sample functions more finely (Method(bake=...)), use a finer grid, or request less (Method(accuracy=...))"
            )
            image._warnings.append(words)
            if not self._warned:
                self._warned = True
                warnings.warn(words, AccuracyWarning, stacklevel=4)
        return image


def exactness(
    backend: str,
    accuracy: float | None = None,
    samples: int | None = None,
    target_error: float | None = None,
    seed: int | None = None,
) -> dict[str, Any]:
    """What is asked of back ends that take more than a plan; each refuses what belongs to the other."""
    of = {"accuracy": ("reference", accuracy), "samples": ("path", samples), "target_error": ("path", target_error), "seed": ("path", seed)}
    for name, (own, value) in of.items():
        if value is not None and backend != own:
            instead = "; give Method(accuracy=...) to the scene" if name == "accuracy" else ""
            raise scene_error(name, f'{name} requires backend="{own}"{instead}')
    ranges = {"accuracy": (1e-12, 0.5), "samples": (1, 2**40), "target_error": (1e-6, 1.0), "seed": (0, 2**63 - 1)}
    for name, (low, high) in ranges.items():
        value = of[name][1]
        if value is not None and not low <= value <= high:
            raise scene_error(name, f"{value} is out of range; give a number from {low:g} to {high:g}")
    return {name: value for name, (_, value) in of.items()}


def _planned(owner: Scene, camera: dict[str, Any] | None, backend: str) -> Plan:
    return owner.plan(camera, backend=backend)


def _changed(before: Any, now: Any, place: str = "") -> str | None:
    """The first place in which two trees differ."""
    if isinstance(before, dict) and isinstance(now, dict):
        for key in [*before, *(key for key in now if key not in before)]:
            found = _changed(before.get(key), now.get(key), f"{place}.{key}" if place else key)
            if found is not None:
                return found
        return None
    if isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        for i, (a, b) in enumerate(zip(before, now)):
            found = _changed(a, b, f"{place}[{i}]")
            if found is not None:
                return found
        return None
    return None if before == now else place
