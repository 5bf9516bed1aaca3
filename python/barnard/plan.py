"""Plans: precomputed data of a scene for many pictures."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from . import _barnard
from ._progress import Listener, listening
from ._report import Certificate, Report, report_of
from ._rows import ROWS, scene_error
from ._session import Session
from ._table import table_of
from ._warn import warn
from .image import Image
from .tables import Camera

if TYPE_CHECKING:
    from .scene import Scene


class AccuracyWarning(UserWarning):
    """A picture is less exact than its scene requests; raised once per plan."""


class PlanError(_barnard.BarnardError):
    """Use of a plan after its scene changed; `key` is the changed key."""

    key: str


#: Parts of a scene that a plan is made of.
FIXED = {"space", "stars", "spectra", "amount", "method"}


class Plan:
    """Precomputed data of a scene, made by `Scene.plan`.

    It renders the scene at its creation from any camera.
    """

    def __init__(self, owner: Scene, session: Session, plan: _barnard.Plan, backend: str):
        self._owner, self._session, self._plan, self._backend = owner, session, plan, backend
        self._warned = False
        self._report: Report | None = None

    @property
    def report(self) -> Report:
        """The report that its images are expected to have; optical depths and spectral errors are those of their worst case."""
        if self._report is None:
            self._report = report_of(self._plan.report)
        return self._report

    @property
    def method(self) -> str:
        """Spectral method."""
        return self.report.method or ""

    @property
    def terms(self) -> int:
        """Exponentials per sample and star."""
        return self._plan.terms

    @property
    def steps(self) -> str:
        """Spacing of the samples along a ray, as text."""
        return self.report.steps or ""

    @property
    def bytes(self) -> int:
        """Size of tables and volumes."""
        return self._plan.bytes

    @property
    def accuracy(self) -> float:
        """Requested accuracy."""
        return self.report.accuracy or 0.0

    @property
    def misses_accuracy(self) -> bool:
        """True if pilot rays found a larger error than requested."""
        return self.report.misses_accuracy

    @property
    def spatial_error(self) -> tuple[float, int] | None:
        """Relative rms error of the worst band, and the number of pilot rays."""
        spatial = self.report.spatial_error
        return None if spatial is None else (spatial.error, spatial.pilot_rays)

    @property
    def certificates(self) -> dict[str, list[Certificate]]:
        """Spectral errors by passband."""
        return self.report.certificates

    @property
    def camera(self) -> Camera:
        """Camera of the plan."""
        return table_of(Camera, self._session.tree["camera"], "camera")

    @property
    def notes(self) -> dict[str, str]:
        """Statements about volumes and multiple scattering, by topic."""
        return self.report.notes

    def __reduce__(self):
        """The scene; unpickling plans it again, with the same bits."""
        self._now(self._session.tree.get("camera"))
        return _planned, (self._owner, self._session.tree.get("camera"), self._backend)

    def __repr__(self) -> str:
        return f"Plan({self.method}, {self.terms} terms per sample, {self.steps}, {self.bytes / 2**20:.1f} MiB)"

    def render(self, camera: Camera | dict[str, Any] | None = None, *, progress: bool | Listener | None = None) -> Image:
        """Renders the planned scene from its own camera or another.

        Steps, rules and their errors are those of the plan's own camera, and so are the wavelengths of moving gas. `Scene.render`
        finds them for each camera.

        Raises
        ------
        PlanError
            If densities, lights, passbands, dust or method of the scene have changed.
        """
        camera = self._session.tree.get("camera") if camera is None else camera
        scene, plan = self._now(camera), self._plan
        with listening(progress) as listener:
            if self._session.scene.differing(scene):
                plan = plan.look_from(scene, progress=listener)
            return self._render(scene, plan, listener)

    def _now(self, camera: Camera | dict[str, Any] | None) -> _barnard.Scene:
        """The scene as it is now, by a camera; refuses one that has changed."""
        planned, seen = self._session, self._owner._session(camera)
        if FIXED.isdisjoint(planned.scene.differing(seen.scene)):
            return seen.scene
        # Lines of moving gas are shifted by the camera, and the plan has those of its own.
        now = self._owner._session(planned.tree.get("camera"))
        if FIXED.isdisjoint(planned.scene.differing(now.scene)):
            return now.scene.seen_as(seen.scene)
        changed = next((place for place in _changes(planned.tree, now.tree) if FIXED & set(_parts(place))), "scene")
        error = PlanError(f"{changed}: the scene has changed since the plan was made; make a new one with scene.plan()")
        error.key = changed
        raise error

    def _render(self, scene: _barnard.Scene, plan: _barnard.Plan, listener: Listener | None) -> Image:
        image = Image(_barnard.render(scene, plan, self._backend, {}, self._session.limit, progress=listener))
        spatial = image.report.spatial_error
        if image.report.misses_accuracy and spatial is not None:
            words = (
                f"the spatial error measured by {spatial.pilot_rays} pilot rays is {spatial.error:.1e}, "
                f"the requested accuracy {image.report.accuracy:.1e}; "
                "sample functions more finely (Method(bake=...)), use a finer grid, or request less (Method(accuracy=...))"
            )
            image._warnings.append(words)
            if not self._warned:
                self._warned = True
                warn(words, AccuracyWarning)
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
