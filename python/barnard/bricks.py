"""Volumes that no machine holds: pictures of Dask arrays, brick by brick.

Extinction is k(λ) σ(x), so all that a brick does to a ray is to add one optical depth, and one light for each term; of two
bricks one stands before the other, and together they do the same kind of thing. Star depths go outward from brick to
brick. Rules and steps are chosen on a coarse volume. Any number of bricks makes the picture of one.
"""

from __future__ import annotations

import hashlib
import itertools
import math
from collections import defaultdict
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _barnard
from ._field import Sampled
from ._rows import scene_error
from .cluster import _counted, _lock
from .image import Image
from .tables import Camera

if TYPE_CHECKING:
    from .scene import Scene

#: Keys of a field that may be said of bricks; all others are of arrays that are read as a whole.
KEYS = ("file", "low", "high", "axes", "unit", "factor", "clip")

Voxels = tuple[tuple[int, int], tuple[int, int], tuple[int, int]]
Place = tuple[int, int, int]
Corners = tuple[list[float], list[float]]


def render_bricks(
    scene: Scene,
    client: Any = None,
    *,
    camera: Camera | dict[str, Any] | None = None,
    coarse: int = 128,
    progress: bool | Callable[[int, int], None] = True,
) -> Image:
    """Renders a scene whose fields are Dask arrays, without any machine holding them as a whole.

    Each chunk is a brick; those of several fields must be the same. A worker holds a brick, its halo, and as much again
    for each star and each glowing species. The picture is that of the fast back end, whatever the bricks are: the spectral
    rules and the steps a voxel are chosen, and the spatial error is measured, on a volume of no more than `coarse` voxels
    along an edge, each the mean of those in it.

    Parameters
    ----------
    scene : Scene
        With one field or more that is `Grid(dask_array, low=..., high=...)`. Light scatters once (`bounces=1`), and every
        star has depths of its own (see `exact_stars`).
    client : dask.distributed.Client, optional
        The current one where none is given.
    camera : Camera, optional
        Another camera than the scene's own.
    coarse : int, default 128
        Most voxels along an edge of the volume on which rules and steps are chosen.
    progress : bool or callable (done, all), default True

    Returns
    -------
    Image

    Raises
    ------
    SceneError
        Where no field lies in bricks, bricks of several differ, or bricks cannot do what the scene asks for; where
        densities are none, with their place.
    BarnardError
        Where Dask is not installed, or there is no client.
    """
    try:
        import dask
        import distributed
    except ImportError:
        raise _barnard.BarnardError("Dask is not installed; pip install barnard[cluster]") from None
    if client is None:
        try:
            client = distributed.get_client()
        except ValueError:
            raise _barnard.BarnardError("there is no client; make one, such as distributed.Client(), and give it") from None
    if not 8 <= coarse <= 1024:
        raise scene_error("coarse", f"{coarse} lies outside of 8 to 1024")
    fields = _fields(scene)
    first = next(iter(fields.values()))
    cuts = tuple(tuple(int(cut) for cut in np.cumsum([0, *chunks])) for chunks in first.chunks)
    volume = _Volume(first.shape, cuts)

    # What rules and steps are chosen on.
    means = dask.compute(*(_coarse(array, volume, coarse, scene.fields[name].clip) for name, array in fields.items()), scheduler=client)
    small = _with_arrays(scene, dict(zip(fields, means)))
    if camera is not None:
        small.camera = camera
    _filling(small, _box(scene, next(iter(fields))), means[0].shape)
    native = _whole(small, volume)
    shared = dask.delayed(_Shared(small, volume), traverse=False)

    # Densities and star depths at all voxels.
    count = (scene.dust is not None) + len(scene.emission)
    of_bricks = {
        place: dask.delayed(_densities, nout=count)(shared, {name: array.blocks[place] for name, array in fields.items()}, place)
        for place in volume.places()
    }
    densities = [_Bricks(volume, {place: of[number] for place, of in of_bricks.items()}, client) for number in range(count)]
    dust = densities.pop(0) if scene.dust is not None else None
    depths = [] if dust is None else [_Bricks(volume, _star_depths(native, volume, star, dust), client) for star in native.stars]

    # What each brick does to the rays.
    order = [tuple(place) for place in native.front_to_back()]
    held = {place: native.held(list(place)) for place in order}
    of_held = lambda arrays, place: [array.part(held[place]) for array in arrays]  # noqa: E731
    partials = [
        dask.delayed(_march)(shared, place, None if dust is None else dust.part(held[place]), of_held(depths, place), of_held(densities, place))
        for place in order
    ]
    futures = client.compute(partials)
    with _counted(progress, len(futures), "bricks") as told:
        for number, future in enumerate(distributed.as_completed(futures), 1):
            if future.status == "error":
                client.cancel(futures)
                future.result()
            told(number)
    shared = client.scatter(_Shared(small, volume), hash=False)
    while len(futures) > 1:
        pairs = [futures[i : i + 2] for i in range(0, len(futures), 2)]
        futures = [client.submit(_over, shared, *pair, pure=False) if len(pair) == 2 else pair[0] for pair in pairs]
    return Image(native.picture(_aligned(futures[0].result())))


class _Volume:
    """Voxels along x, y and z, and where bricks begin along each axis, the end of the last behind them."""

    def __init__(self, dims: tuple[int, ...], cuts: tuple[tuple[int, ...], ...]):
        self.dims = tuple(int(n) for n in dims)
        self.cuts = cuts

    def places(self) -> Iterator[Place]:
        return np.ndindex(*(len(cuts) - 1 for cuts in self.cuts))

    def voxels(self, place: Place) -> Voxels:
        return tuple((cuts[i], cuts[i + 1]) for cuts, i in zip(self.cuts, place))

    def shape(self, place: Place) -> tuple[int, ...]:
        return tuple(end - start for start, end in self.voxels(place))


class _Bricks:
    """What stands at the voxels of a volume, brick by brick, kept by the workers.

    Parts are put together by the task that needs them, so that there is no other copy of a brick before.
    """

    def __init__(self, volume: _Volume, bricks: dict[Place, Any], client: Any):
        self.volume = volume
        self.bricks = dict(zip(bricks, client.persist(list(bricks.values()))))

    def part(self, voxels: Voxels) -> tuple[tuple[int, ...], list[Any]]:
        """Some voxels: how many along each axis, and for each brick that has some of them, where they are in it and in the
        part."""
        pieces = []
        along = [[i for i in range(len(cuts) - 1) if cuts[i] < end and cuts[i + 1] > start] for cuts, (start, end) in zip(self.volume.cuts, voxels)]
        for place in itertools.product(*along):
            own = self.volume.voxels(place)
            both = [(max(a, start), min(b, end)) for (a, b), (start, end) in zip(own, voxels)]
            within = [[(a - first, b - first) for (a, b), (first, _) in zip(both, frame)] for frame in (own, voxels)]
            pieces.append((self.bricks[place], *within))
        return tuple(end - start for start, end in voxels), pieces


def _fields(scene: Scene) -> dict[str, Any]:
    """The fields that lie in bricks, with axes x, y and z."""
    arrays: dict[str, Any] = {}
    for name, field in scene.fields.items():
        bricks = field.bricks if isinstance(field, Sampled) else None
        if bricks is None:
            continue
        for key in field.tree():
            if key not in (*KEYS, "kind"):
                raise scene_error(f"field.{name}.{key}", f"{key} is for arrays that are read as a whole; bricks know {', '.join(KEYS[1:])}")
        if field.low is None or field.high is None:
            raise scene_error(f"field.{name}.low", "a field in bricks needs its box: give low and high")
        axes = field.axes or "xyz"
        if sorted(axes) != ["x", "y", "z"]:
            raise scene_error(f"field.{name}.axes", f"{axes!r} does not name x, y and z, each once")
        arrays[name] = bricks.transpose([axes.index(axis) for axis in "xyz"])
    if not arrays:
        raise scene_error("fields", "no field lies in bricks: give one a Dask array, as in Grid(array, low=..., high=...); Scene.render does others")
    name, first = next(iter(arrays.items()))
    for other, array in arrays.items():
        if array.shape != first.shape:
            raise scene_error(f"field.{other}", f"it has {array.shape} voxels, field {name} {first.shape}; bricks of all fields must be the same")
        if _box(scene, other) != _box(scene, name):
            raise scene_error(f"field.{other}", f"its box is another than that of field {name}; bricks of all fields must be the same")
        arrays[other] = array.rechunk(first.chunks)
    return arrays


def _box(scene: Scene, name: str) -> Corners:
    """The box of a field in bricks."""
    from .scene import Scene
    from .tables import Dust, Grid

    own = scene.fields[name]
    fields = {name: Grid(np.zeros((2, 2, 2), np.float32), low=own.low, high=own.high)}
    _, native = Scene(fields=fields, dust=Dust(name, "1 /pc", albedo=0), camera=scene.camera)._native()
    [(_, corners, _)] = _barnard.densities(native, 2**20)
    return corners


def _filling(scene: Scene, box: Corners, dims: tuple[int, ...]) -> list[np.ndarray]:
    """The densities of a scene, extinction of dust first, at voxels that must be those of a box."""
    names = ["dust.density"] * (scene.dust is not None) + [f"emission[{i}].density" for i in range(len(scene.emission))]
    densities = _barnard.densities(scene._native()[1], scene._limit)
    for name, (own, corners, _) in zip(names, densities):
        if tuple(own) != tuple(dims) or not np.allclose(corners, box, rtol=0, atol=1e-9 * np.ptp(box)):
            raise scene_error(name, "it does not fill the box of the bricks; let it be made of the fields in bricks, and of others where they are")
    return [flat.reshape(dims, order="F") for _, _, flat in densities]


def _with_arrays(scene: Scene, arrays: dict[str, np.ndarray], box: Corners | None = None) -> Scene:
    """The same scene with arrays in place of fields in bricks, in a box [pc] where one is given."""
    from .scene import Scene
    from .tables import Grid
    from ._tree import PARTS

    fields = dict(scene.fields)
    for name, array in arrays.items():
        own = scene.fields[name]
        low, high = (own.low, own.high) if box is None else (" ".join(map(repr, corner)) + " pc" for corner in box)
        fields[name] = Grid(array, low=low, high=high, unit=own.unit, factor=own.factor, clip=own.clip)
    parts = {part: getattr(scene, part) for part in PARTS if part != "fields"}
    return Scene(**parts, fields=fields, folder=scene._folder, memory=scene._limit / 2**30)


def _whole(small: Scene, volume: _Volume) -> Any:
    """What all bricks share, from the scene of coarse fields."""
    plan = small.plan()
    cuts = [list(cuts) for cuts in volume.cuts]
    return _barnard.Whole(plan._scene, plan._plan, list(volume.dims), cuts, small._limit)


# The coarse volume.


def _coarse(array: Any, volume: _Volume, most: int, clip: bool | None) -> Any:
    """The means of an array's voxels over blocks, at most so many along an edge."""
    import dask

    factor = max(1, math.ceil(max(volume.dims) / most))
    # Blocks of a box that the coarse voxels fill evenly: where a voxel's centre lies.
    dims = tuple(math.ceil(n / factor) for n in volume.dims)
    sums = [dask.delayed(_sums)(array.blocks[place], volume.voxels(place), volume.dims, dims, bool(clip)) for place in volume.places()]
    return dask.delayed(_means)(sums, volume.dims, dims)


def _blocks(voxels: tuple[int, int], whole: int, coarse: int) -> np.ndarray:
    """The coarse voxel of each voxel of a range along an axis."""
    return (np.arange(*voxels) * 2 + 1) * coarse // (2 * whole)


def _sums(values: np.ndarray, voxels: Voxels, whole: tuple[int, ...], coarse: tuple[int, ...], clip: bool) -> tuple[list[int], np.ndarray]:
    """The sums of a brick's values over coarse voxels, and the first of these along each axis."""
    sums = np.asarray(values, np.float64)
    if clip:
        sums = np.where(sums > 0, sums, 0.0)
    first = []
    for axis in range(3):
        blocks = _blocks(voxels[axis], whole[axis], coarse[axis])
        starts = np.flatnonzero(np.diff(blocks, prepend=-1))
        sums = np.add.reduceat(sums, starts, axis=axis)
        first.append(int(blocks[0]))
    return first, sums


def _means(sums: list[tuple[list[int], np.ndarray]], whole: tuple[int, ...], coarse: tuple[int, ...]) -> np.ndarray:
    means = np.zeros(coarse)
    for first, own in sums:
        means[tuple(slice(a, a + n) for a, n in zip(first, own.shape))] += own
    for axis in range(3):
        count = np.bincount(_blocks((0, whole[axis]), whole[axis], coarse[axis]), minlength=coarse[axis])
        means /= np.expand_dims(count, tuple(other for other in range(3) if other != axis))
    return means.astype(np.float32)


# On a worker.


class _Shared:
    """A scene of coarse fields and a volume, which a worker turns into what all bricks share, once."""

    def __init__(self, small: Scene, volume: _Volume):
        import cloudpickle

        self.pickled = cloudpickle.dumps((small, volume))
        self.digest = hashlib.sha256(self.pickled).hexdigest()

    @property
    def kept(self) -> tuple[Scene, _Volume, Any]:
        import cloudpickle

        with _lock:
            if self.digest not in _kept:
                _kept.clear()
                small, volume = cloudpickle.loads(self.pickled)
                _kept[self.digest] = small, volume, _whole(small, volume)
            return _kept[self.digest]


_kept: dict[str, tuple[Any, _Volume, Any]] = {}


def _flat(part: tuple[tuple[int, ...], list[Any]] | None) -> np.ndarray | None:
    """The values of a part of a volume in one row, x fastest."""
    if part is None:
        return None
    shape, pieces = part
    values = np.empty(shape, np.float32, order="F")
    for brick, own, place in pieces:
        values[tuple(slice(*range_) for range_ in place)] = brick[tuple(slice(*range_) for range_ in own)]
    return values.ravel(order="F")


def _aligned(received: Any) -> Any:
    """What came through a network, with arrays that begin where numbers may."""
    if isinstance(received, np.ndarray):
        return np.require(received, requirements=["C", "A"])
    return tuple(map(_aligned, received)) if isinstance(received, tuple) else received


def _densities(shared: _Shared, values: dict[str, np.ndarray], place: Place) -> list[np.ndarray]:
    """The densities of a brick: extinction of dust, then gas."""
    small, volume, whole = shared.kept
    low, high = map(np.array, whole.bounds)
    edge = (high - low) / volume.dims
    box = tuple([float(x) for x in low + edge * [ends[i] for ends in volume.voxels(place)]] for i in (0, 1))
    return _filling(_with_arrays(small, values, box), box, volume.shape(place))


def _march(shared: _Shared, place: Place, dust: Any, depths: list[Any], gas: list[Any]) -> Any:
    """What a brick does to the rays."""
    whole = shared.kept[2]
    with _lock:
        return whole.march(list(place), _flat(dust), [_flat(part) for part in depths], [_flat(part) for part in gas])


def _over(shared: _Shared, front: Any, back: Any) -> Any:
    return shared.kept[2].over(_aligned(front), _aligned(back))


# Star depths.


def _star_depths(native: Any, volume: _Volume, star: list[float], dust: _Bricks) -> dict[Place, Any]:
    """The depths from a star at the voxels of each brick."""
    import dask

    sweeps = _Sweeps(volume, native.bounds, star)
    star_sweep = sweeps.native
    delayed = dask.delayed(sweeps, traverse=False)
    of_frustums: dict[int, list[int]] = defaultdict(list)
    for layer, (frustum, _) in enumerate(star_sweep.layers):
        of_frustums[frustum].append(layer)
    swept: dict[Place, list[Any]] = defaultdict(list)
    for frustum, layers in of_frustums.items():
        carried: Any = {}
        for finds_entries in [True, False] if star_sweep.has_entries(frustum) else [False]:
            for layer in layers:
                results = []
                for place in star_sweep.layers[layer][1]:
                    borders = [star_sweep.border(layer, place, side) for side in (0, 1)]
                    borders = [None if voxels is None else dust.part(voxels) for voxels in borders]
                    needs = dust.part(star_sweep.needs(layer, place))
                    results.append(dask.delayed(_swept, nout=2)(delayed, layer, finds_entries, place, needs, borders, carried))
                    if not finds_entries:
                        swept[tuple(place)].append(results[-1][0])
                carried = dask.delayed(_joined)(delayed, frustum, carried, [handed for _, handed in results])
            if finds_entries:
                carried = dask.delayed(_begun)(carried)
    return {place: dask.delayed(_merged)(swept[place], volume.shape(place)) for place in volume.places()}


class _Sweeps:
    """The sweeps of a star's depths through a volume, which a worker makes anew."""

    def __init__(self, volume: _Volume, bounds: Any, star: list[float]):
        self.arguments = list(volume.dims), bounds, [list(cuts) for cuts in volume.cuts], list(star)
        self._native: Any = None

    @property
    def native(self) -> Any:
        if self._native is None:
            self._native = _barnard.StarSweep(*self.arguments)
        return self._native

    def __getstate__(self) -> dict[str, Any]:
        return {"arguments": self.arguments, "_native": None}

    def __dask_tokenize__(self) -> Any:
        return self.arguments


def _swept(sweeps: _Sweeps, layer: int, finds_entries: bool, place: Place, dust: Any, borders: list[Any], carried: dict) -> Any:
    """The depths of a brick's voxels in a layer, and the rays that it hands on."""
    carried = {tier: _aligned(rays) for tier, rays in carried.items()}
    with _lock:
        return sweeps.native.sweep(layer, finds_entries, list(place), _flat(dust), [_flat(border) for border in borders], carried)


#: No entries.
_NONE = np.empty(0, np.float32)


def _joined(sweeps: _Sweeps, frustum: int, before: dict, handed: list[Any]) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """All rays behind a layer: depths and entries by tier; those of tiers that ended before stay."""
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


def _begun(carried: dict[int, tuple[np.ndarray, np.ndarray]]) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """Rays at the star, which have none of the depth at which they come into the box."""
    return {tier: (-entries, _NONE) for tier, (_, entries) in carried.items()}


def _merged(swept: list[np.ndarray | None], shape: tuple[int, ...]) -> np.ndarray:
    """The depths of a brick's voxels from all frustums; where two share one the later counts, as in one sweep."""
    depths = np.full(math.prod(shape), np.nan, np.float32)
    for own in swept:
        if own is not None:
            np.copyto(depths, own, where=~np.isnan(own))
    if np.isnan(depths).any():
        raise _barnard.BarnardError(f"{int(np.isnan(depths).sum())} voxels of a brick have no star depth; please report it with the scene")
    return depths.reshape(shape, order="F")
