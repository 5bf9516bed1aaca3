"""Plans: precomputed data of a scene for many pictures."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import _barnard
from ._progress import Listener, told
from ._rows import ROWS, scene_error
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


#: Parts of a scene that a plan is made of.
FIXED = {"space", "stars", "spectra", "amount", "method"}


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
            If densities, lights, passbands, dust or method of the scene have changed.
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
        tree, native = self._owner._native(camera)
        differing = self._scene.differing(native)
        if FIXED & set(differing):
            changed = next((place for place in _changes(self._tree, tree) if FIXED & set(_parts(place))), "scene")
            error = PlanError(f"{changed}: the scene has changed since the plan was made; make a new one with scene.plan()")
            error.key = changed
            raise error
        return bool(differing)

    def _render(self, scene: Any, plan: Any, listener: Listener | None) -> Image:
        image = Image(_barnard.render(scene, plan, self._backend, {}, self._owner._limit, progress=listener))
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


def backend_options(
    backend: str,
    accuracy: float | None = None,
    samples: int | None = None,
    target_error: float | None = None,
    seed: int | None = None,
) -> dict[str, dict[str, Any]]:
    """Options of a render as tables of `[method]`; each back end refuses those of others."""
    given = {
        "reference": {"accuracy": accuracy},
        "path": {"samples": samples, "target_error": target_error, "seed": seed},
    }
    options = {name: {key: value for key, value in keys.items() if value is not None} for name, keys in given.items()}
    for name, keys in options.items():
        if keys and backend != name:
            key = next(iter(keys))
            remedy = "; give Method(accuracy=...) to the scene" if key == "accuracy" else ""
            raise scene_error(key, f'{key} requires backend="{name}"{remedy}')
    return {name: keys for name, keys in options.items() if keys}


def _planned(owner: Scene, camera: dict[str, Any] | None, backend: str) -> Plan:
    return owner.plan(camera, backend=backend)


def _changes(before: Any, now: Any, place: str = "") -> Iterator[str]:
    """The places in which two trees differ."""
    if isinstance(before, dict) and isinstance(now, dict):
        for key in [*before, *(key for key in now if key not in before)]:
            yield from _changes(before.get(key), now.get(key), f"{place}.{key}" if place else key)
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        for i, (a, b) in enumerate(zip(before, now)):
            yield from _changes(a, b, f"{place}[{i}]")
    elif before != now:
        yield place


def _parts(place: str) -> list[str]:
    """The parts of a scene that a place changes; those of a plan for tables as a whole."""
    path, _, key = re.sub(r"\[\d+\]", "", place).rpartition(".")
    row = ROWS.get(path) or ROWS.get(f"{path.partition('.')[0]}.*")
    known = row.all_keys().get(key) if row else None
    return known.parts if known else sorted(FIXED)
