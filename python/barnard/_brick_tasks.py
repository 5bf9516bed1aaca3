"""Worker tasks for pictures of distributed volumes; `bricks` gives them the tasks.

Parts of a volume come as how many voxels they have along each axis, and pieces: a brick, or what was cut from one, where the
piece is in it, and where in the part.
"""

from __future__ import annotations

import hashlib
import itertools
import math
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np

from . import _barnard

if TYPE_CHECKING:
    from .scene import Scene

Made = TypeVar("Made")
#: For each axis a start and an end.
Voxels = Sequence[tuple[int, int]]
Place = tuple[int, int, int]
Box = tuple[list[float], list[float]]
Part = tuple[tuple[int, ...], list[Any]]
Rays = dict[int, tuple[np.ndarray, np.ndarray]]

#: Native work takes turns: each has all threads of the worker.
_lock = threading.RLock()
_limited: list[int] = []
#: No entries.
_NONE = np.empty(0, np.float32)


def _limit(threads: int) -> None:
    with _lock:
        if _limited != [threads]:
            _barnard.set_threads(threads)
            _limited[:] = [threads]


def unchanged(value: Any) -> Any:
    """The value itself, as a task whose result other tasks share."""
    return value


class Volume:
    """Voxels along x, y and z of a box [pc], and where bricks begin along each axis, the end of the last behind them."""

    def __init__(self, dims: tuple[int, ...], cuts: tuple[tuple[int, ...], ...], box: Box):
        self.dims = tuple(int(n) for n in dims)
        self.cuts = cuts
        self.box = box

    def places(self) -> Iterator[Place]:
        x, y, z = (range(len(cuts) - 1) for cuts in self.cuts)
        return itertools.product(x, y, z)

    def voxels(self, place: Place) -> Voxels:
        return tuple((cuts[i], cuts[i + 1]) for cuts, i in zip(self.cuts, place))

    def shape(self, place: Place) -> tuple[int, ...]:
        return tuple(end - start for start, end in self.voxels(place))

    def box_of(self, place: Place) -> Box:
        low, high = map(np.array, self.box)
        edge = (high - low) / self.dims
        corners = [low + edge * [ends[i] for ends in self.voxels(place)] for i in (0, 1)]
        return tuple([float(x) for x in corner] for corner in corners)  # type: ignore[return-value]


class Shared:
    """A scene and a volume, which a worker turns into what all bricks share, once."""

    _cache: dict[str, Any] = {}

    def __init__(self, scene: Scene, volume: Volume, threads: int):
        import cloudpickle

        self.volume, self.threads = volume, threads
        # Fields in bricks stay where they are: their keys alone are told.
        self._pickled = cloudpickle.dumps(_without_bricks(scene))
        self._digest = hashlib.sha256(self._pickled).hexdigest()

    @property
    def scene(self) -> Scene:
        return self._of("scene", self._loaded)

    @property
    def whole(self) -> _barnard.Whole:
        """The plan of a scene of coarse densities, for all bricks."""
        return self._of("whole", self.planned)

    def _of(self, what: str, make: Callable[[], Made]) -> Made:
        with _lock:
            key = f"{what} {self._digest}"
            if key not in self._cache:
                _limit(self.threads)
                for other in [other for other in self._cache if other.startswith(what)]:
                    del self._cache[other]
                self._cache[key] = make()
            return cast("Made", self._cache[key])

    def _loaded(self) -> Scene:
        import cloudpickle

        return cast("Scene", cloudpickle.loads(self._pickled))

    def planned(self) -> _barnard.Whole:
        """Variant that recomputes."""
        session = self._loaded()._session()
        cuts = [list(cuts) for cuts in self.volume.cuts]
        return _barnard.Whole(session.scene, list(self.volume.dims), cuts, session.limit)


class _Placeholder:
    """Stands for a Dask array in a scene that goes to workers."""

    ndim, dtype, shape, chunks, dask = 3, np.dtype(np.float32), (1, 1, 1), (), None


def _rebuilt(scene: Scene, fields: dict[str, Any], **parts: Any) -> Scene:
    """Copy of the scene with other fields, and other parts where they are given."""
    from ._tree import PARTS
    from .scene import Scene

    stated = {part: getattr(scene, part) for part in PARTS if part != "fields"}
    return Scene(**{**stated, **parts}, fields=fields, folder=scene._folder, memory=scene._limit / 2**30)


def _without_bricks(scene: Scene) -> Scene:
    from ._field import Sampled
    from .tables import Grid

    def plain(field: Any) -> Any:
        if not isinstance(field, Sampled) or field.bricks is None:
            return field
        placeholder: Any = _Placeholder()
        return Grid(placeholder, low=field.low, high=field.high, unit=field.unit, factor=field.factor, clip=field.clip)

    return _rebuilt(scene, {name: plain(field) for name, field in scene.fields.items()})


def _corners(box: Box) -> tuple[str, str]:
    low, high = (" ".join(map(repr, corner)) + " pc" for corner in box)
    return low, high


def named_densities(scene: Scene) -> list[tuple[str, str]]:
    """The densities of a scene, each with its place: of dust where there is some, then of gas."""
    dust = [("dust.density", scene.dust.density)] if scene.dust is not None else []
    return dust + [(f"emission[{i}].density", gas.density) for i, gas in enumerate(scene.emission)]


def of_densities(scene: Scene, means: list[np.ndarray], box: Box, camera: Any) -> Scene:
    """The scene of coarse densities, by another camera than its own where one is given."""
    from .tables import Dust, Emission, Grid

    low, high = _corners(box)
    fields = {f"density_{number}": Grid(mean, low=low, high=high) for number, mean in enumerate(means)}
    names = iter(fields)
    parts: dict[str, Any] = {} if camera is None else {"camera": camera}
    if scene.dust is not None:
        parts["dust"] = Dust.of({**scene.dust.tree(), "density": next(names), "scale": "1 /pc"})
    parts["emission"] = [Emission.of({**gas.tree(), "density": next(names)}) for gas in scene.emission]
    return _rebuilt(scene, fields, **parts)


# Densities.


def densities(shared: Shared, values: dict[str, np.ndarray], place: Place) -> list[np.ndarray]:
    """The densities at the voxels of a brick, x × y × z: extinction of dust [pc-1], then gas."""
    from .tables import Grid, PerspectiveCamera

    volume, scene = shared.volume, shared.scene
    box, shape = volume.box_of(place), volume.shape(place)
    fields = dict(scene.fields)
    for name, array in values.items():
        field = fields[name]
        low, high = _corners(box)
        fields[name] = Grid(array, low=low, high=high, unit=field.unit, factor=field.factor, clip=field.clip)
    with _lock:
        # Nobody looks yet.
        session = _rebuilt(scene, fields, camera=PerspectiveCamera("0 0 9 pc", "30 deg"))._session()
        found = _barnard.densities(session.scene, list(shape), box, session.limit)
    return [flat.reshape(shape, order="F") for flat in found]


def cut(brick: np.ndarray, voxels: Voxels) -> np.ndarray:
    """Some voxels of a brick, in memory of their own."""
    return np.array(brick[tuple(slice(*ends) for ends in voxels)], order="F")


def _blocks(voxels: tuple[int, int], whole: int, coarse: int) -> np.ndarray:
    """The coarse voxel in which the centre of each voxel of a range lies, along an axis."""
    return (np.arange(*voxels) * 2 + 1) * coarse // (2 * whole)


def sums(values: np.ndarray, place: Place, volume: Volume, coarse: tuple[int, ...]) -> tuple[list[int], np.ndarray]:
    """The sums of a brick's values over coarse voxels, and the first of these along each axis."""
    sums = np.asarray(values, np.float64)
    first = []
    for axis, voxels in enumerate(volume.voxels(place)):
        blocks = _blocks(voxels, volume.dims[axis], coarse[axis])
        sums = np.add.reduceat(sums, np.flatnonzero(np.diff(blocks, prepend=-1)), axis=axis)
        first.append(int(blocks[0]))
    return first, sums


def means(sums: list[tuple[list[int], np.ndarray]], volume: Volume, coarse: tuple[int, ...]) -> np.ndarray:
    """The means over coarse voxels."""
    means = np.zeros(coarse)
    for first, part in sums:
        means[tuple(slice(a, a + n) for a, n in zip(first, part.shape))] += part
    for axis, whole in enumerate(volume.dims):
        count = np.bincount(_blocks((0, whole), whole, coarse[axis]), minlength=coarse[axis])
        means /= np.expand_dims(count, tuple(other for other in range(3) if other != axis))
    return means.astype(np.float32)


# Light.


def _flat(part: Part) -> np.ndarray:
    """The values of a part of a volume in one row, x fastest."""
    shape, pieces = part
    values = np.empty(shape, np.float32, order="F")
    for brick, within, place in pieces:
        values[tuple(slice(*along) for along in place)] = brick[tuple(slice(*along) for along in within)]
    return values.ravel(order="F")


def aligned(received: Any) -> Any:
    """Received message with aligned arrays."""
    if isinstance(received, np.ndarray):
        return np.require(received, requirements=["C", "A"])
    return tuple(map(aligned, received)) if isinstance(received, tuple) else received


def march(shared: Shared, place: Place, dust: Part | None, depths: list[Part], gas: list[Part]) -> _barnard.Partial:
    """Effect of a brick on the rays."""
    whole = shared.whole
    with _lock:
        return whole.march(list(place), None if dust is None else _flat(dust), [_flat(part) for part in depths], [_flat(part) for part in gas])


def over(shared: Shared, front: _barnard.Partial, back: _barnard.Partial) -> _barnard.Partial:
    """Combined effect of two bricks, the nearer one first."""
    return shared.whole.over(aligned(front), aligned(back))


# Star depths.


class Sweeps:
    """The sweeps of a star's depths through a volume, which a worker makes anew."""

    def __init__(self, volume: Volume, star: list[float], threads: int):
        self.volume, self.star, self.threads = volume, star, threads
        self._native: _barnard.StarSweep | None = None

    @property
    def native(self) -> _barnard.StarSweep:
        with _lock:
            if self._native is None:
                _limit(self.threads)
                self._native = self.made()
            return self._native

    def made(self) -> _barnard.StarSweep:
        """Variant that recomputes."""
        return _barnard.StarSweep(list(self.volume.dims), self.volume.box, [list(cuts) for cuts in self.volume.cuts], list(self.star))

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_native": None}


def swept(sweeps: Sweeps, layer: int, finds_entries: bool, place: Place, dust: Part, borders: list[Part | None], carried: Rays) -> tuple[np.ndarray | None, list[_barnard.Handed]]:
    """The depths of a brick's voxels in a layer, and the rays that it hands on."""
    native = sweeps.native
    carried = {tier: aligned(rays) for tier, rays in carried.items()}
    with _lock:
        return native.sweep(layer, finds_entries, list(place), _flat(dust), [None if border is None else _flat(border) for border in borders], carried)


def joined(sweeps: Sweeps, frustum: int, before: Rays, handed: list[list[_barnard.Handed]]) -> Rays:
    """All rays behind a layer: depths and entries by tier, those of tiers that ended before it as they were."""
    carried = dict(before)
    rays = sweeps.native.rays(frustum)
    for tier in {tier for of_brick in handed for tier, *_ in of_brick}:
        columns, rows = rays[tier]
        depths, entries = np.full((2, rows, columns), np.nan, np.float32)
        has_entries = False
        for of_tier, u, v, own_depths, own_entries in (part for of_brick in handed for part in of_brick):
            if of_tier == tier:
                shape = v[1] - v[0], u[1] - u[0]
                depths[slice(*v), slice(*u)] = own_depths.reshape(shape)
                if own_entries.size:
                    has_entries = True
                    entries[slice(*v), slice(*u)] = own_entries.reshape(shape)
        carried[tier] = depths.ravel(), entries.ravel() if has_entries else _NONE
    return carried


def begun(carried: Rays) -> Rays:
    """Rays at the star, which have none of the depth at which they come into the box."""
    return {tier: (-entries, _NONE) for tier, (_, entries) in carried.items()}


def merged(sweeps: Sweeps, place: Place, swept: list[np.ndarray | None]) -> np.ndarray:
    """The depths of a brick's voxels, x × y × z, from all frustums; where two share one the later counts, as in one sweep."""
    shape = sweeps.volume.shape(place)
    depths = np.full(shape, np.nan, np.float32, order="F")
    own_voxel = sweeps.native.own_voxel
    if own_voxel is not None:
        within = tuple(i - start for i, (start, _) in zip(own_voxel, sweeps.volume.voxels(place)))
        if all(0 <= i < n for i, n in zip(within, shape)):
            depths[within] = 0.0
    flat = depths.ravel(order="F")
    for each in swept:
        if each is not None:
            np.copyto(flat, each, where=~np.isnan(each))
    if np.isnan(flat).any():
        raise _barnard.BarnardError(f"{int(np.isnan(flat).sum())} voxels of a brick have no star depth; please report it with the scene")
    return flat.reshape(shape, order="F")
