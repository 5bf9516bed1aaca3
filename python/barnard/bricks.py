"""Volumes larger than memory: pictures of Dask arrays, brick by brick.

Extinction is k(λ) σ(x), so a brick adds one optical depth and one light per term to a ray, and bricks are composited in
order. Star depths are computed outwards from brick to brick. Rules and steps are chosen on a coarse volume. The picture
does not depend on the number of bricks.
"""

from __future__ import annotations

import itertools
import math
import operator
import weakref
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _barnard, _brick_tasks as tasks
from ._brick_tasks import Box, Place, Voxels
from ._field import Sampled
from ._rows import scene_error
from .cluster import _check_installed, _counted, _threads, _wait_for_workers
from .image import Image
from .tables import Camera, Dust, Grid, PerspectiveCamera

if TYPE_CHECKING:
    from .scene import Scene

#: Keys of a field that may be said of bricks; all others are of arrays that are read as a whole.
KEYS = ("file", "low", "high", "axes", "unit", "factor", "clip")
#: A piece that is no more of a brick than this goes alone to the task that needs it, another with all of its brick.
SMALL = 0.25


def render_bricks(
    scene: Scene,
    client: Any = None,
    *,
    camera: Camera | dict[str, Any] | None = None,
    coarse: int = 128,
    timeout: float = 60.0,
    progress: bool | Callable[[int, int], None] = True,
) -> Image:
    """Renders a scene whose fields are Dask arrays, without gathering them.

    Each chunk is a brick. Workers store four bytes per voxel for dust, for each star and for each emitting species, in memory
    or on disk as Dask decides. The picture is that of back end "cpu". Spectral rules and steps are chosen, and the spatial
    error is measured, on a volume of means with at most `coarse` voxels per edge.

    Parameters
    ----------
    scene : Scene
        With at least one field `Grid(dask_array, low=..., high=...)`, single scattering (`bounces=1`) and individual depths
        of all stars (`exact_stars`).
    client : dask.distributed.Client, optional
        Default: the current client.
    camera : Camera, optional
        Camera instead of the scene's.
    coarse : int, default 128
        Largest number of voxels per edge of the coarse volume.
    timeout : number, default 60
        Time to wait for the first worker [s].
    progress : bool or callable (done, all), default True
        Progress over bricks.

    Returns
    -------
    Image

    Raises
    ------
    SceneError
        If no field is bricked, bricked fields have different boxes or voxels, the scene uses an unsupported feature, or
        values are not densities.
    BarnardError
        If Dask is not installed, or there is no client or worker.
    """
    client = _client(client, timeout)
    if not 8 <= coarse <= 1024:
        raise scene_error("coarse", f"{coarse} is out of range; give a number from 8 to 1024")
    if scene.gas is not None:
        raise scene_error("gas", "bricks do not support [gas]; give the emission instead")
    fields = _fields(scene)
    first = next(iter(fields.values()))
    box = _box(scene, next(iter(fields)))
    _check_densities(scene, fields, box)
    nothing = [np.zeros((2, 2, 2), np.float32)] * len(tasks.named_densities(scene))
    tasks.of_densities(scene, nothing, box, camera).check()
    cuts = tuple(tuple(int(cut) for cut in np.cumsum([0, *chunks])) for chunks in first.chunks)
    with _Work(scene, camera, tasks.Volume(first.shape, cuts, box), client, progress) as work:
        densities = work.densities(fields)
        native = work.plan(densities, coarse)
        dust = densities.pop(0) if scene.dust is not None else None
        depths = [] if dust is None else [work.star_depths(star, dust, 1 / len(native.stars)) for star in native.stars]
        return Image(native.picture(tasks.aligned(work.light(native, dust, depths, densities))))


def _client(client: Any, timeout: float) -> Any:
    """A client that has workers."""
    _check_installed()
    import distributed

    if client is None:
        try:
            client = distributed.get_client()
        except ValueError:
            raise _barnard.BarnardError("no Dask client; create one, such as distributed.Client()") from None
    _wait_for_workers(client, timeout)
    return client


# What the scene says.


def _fields(scene: Scene) -> dict[str, Any]:
    """The fields that lie in bricks, with axes x, y and z."""
    arrays: dict[str, Any] = {}
    for name, field in scene.fields.items():
        bricks = field.bricks if isinstance(field, Sampled) else None
        if bricks is None:
            continue
        for key in field.tree():
            if key not in (*KEYS, "kind"):
                raise scene_error(f"field.{name}.{key}", f"bricks do not support {key}; supported: {', '.join(KEYS[1:])}")
        if field.low is None or field.high is None:
            raise scene_error(f"field.{name}.low", "a bricked field requires a box; give low and high")
        axes = field.axes or "xyz"
        if sorted(axes) != ["x", "y", "z"]:
            raise scene_error(f"field.{name}.axes", f"{axes!r} must contain x, y and z once each")
        arrays[name] = bricks.transpose([axes.index(axis) for axis in "xyz"])
    if not arrays:
        raise scene_error("fields", "no field is bricked; give a Dask array, as in Grid(array, low=..., high=...), or use Scene.render")
    name, first = next(iter(arrays.items()))
    # A chunk without voxels is no brick.
    chunks = tuple(tuple(chunk for chunk in axis if chunk > 0) for axis in first.chunks)
    for other, array in arrays.items():
        if array.shape != first.shape:
            raise scene_error(f"field.{other}", f"it has {array.shape} voxels, field {name} {first.shape}; all bricked fields must have the same")
        if _box(scene, other) != _box(scene, name):
            raise scene_error(f"field.{other}", f"its box differs from that of field {name}; all bricked fields must have the same")
        arrays[other] = array.rechunk(chunks)
    return arrays


def _box(scene: Scene, name: str) -> Box:
    """The box of a field in bricks [pc]."""
    field = scene.fields[name]
    return _bounds(scene, {name: Grid(np.zeros((2, 2, 2), np.float32), low=field.low, high=field.high)}, name)


def _bounds(scene: Scene, fields: dict[str, Any], density: str) -> Box:
    """The box of a density that is made of some fields [pc]."""
    from .scene import Scene

    probe = Scene(fields=fields, dust=Dust(density, "1 /pc", albedo=0), camera=PerspectiveCamera("0 0 9 pc", "30 deg"), folder=scene._folder)
    return _barnard.dust_bounds(probe._session().scene)


def _check_densities(scene: Scene, fields: dict[str, Any], box: Box) -> None:
    """Refuses densities that reach out of the box of the bricks, where they would be cut off."""
    probes = {name: Grid(np.zeros((2, 2, 2), np.float32), low=scene.fields[name].low, high=scene.fields[name].high) for name in fields}
    margin = 1e-9 * np.ptp(box)
    for place, density in tasks.named_densities(scene):
        low, high = _bounds(scene, {**scene.fields, **probes}, density)
        if (np.array(low) < np.array(box[0]) - margin).any() or (np.array(high) > np.array(box[1]) + margin).any():
            words = " ".join(f"{x:g}" for x in low), " ".join(f"{x:g}" for x in high)
            raise scene_error(place, f"it extends from {words[0]} to {words[1]} pc, beyond the box of the bricks; enlarge the box, or crop the other fields")


# The work that is given to the client.


class _Bricks:
    """Voxel values per brick, kept by the workers."""

    def __init__(self, work: _Work, futures: dict[Place, Any]):
        self.volume = work.volume
        self.futures = futures
        self._submit = work.submit

    def part(self, voxels: Voxels) -> tuple[tuple[int, ...], list[Any]]:
        """Some voxels: how many along each axis, and for each brick that has some of them, where they are in what comes of it
        and in the part.
        """
        pieces = []
        along = [[i for i in range(len(cuts) - 1) if cuts[i] < end and cuts[i + 1] > start] for cuts, (start, end) in zip(self.volume.cuts, voxels)]
        x, y, z = along
        for place in itertools.product(x, y, z):
            brick = self.volume.voxels(place)
            both = [(max(a, start), min(b, end)) for (a, b), (start, end) in zip(brick, voxels)]
            within = [[(a - first, b - first) for (a, b), (first, _) in zip(both, frame)] for frame in (brick, voxels)]
            brick, (from_brick, to_part) = self.futures[place], within
            size = math.prod(b - a for a, b in both)
            if size <= SMALL * math.prod(self.volume.shape(place)):
                brick = self._submit(tasks.cut, brick, from_brick)
                from_brick = [(0, b - a) for a, b in both]
            pieces.append((brick, from_brick, to_part))
        return tuple(end - start for start, end in voxels), pieces


class _Work:
    """The tasks of one picture; all that the workers keep of it goes when it ends."""

    def __init__(self, scene: Scene, camera: Any, volume: tasks.Volume, client: Any, progress: Any):
        self.scene, self.camera, self.volume, self.client = scene, camera, volume, client
        self.threads = _threads(client)
        # Densities, star depths where there is dust, and light.
        stages = 3 if scene.dust is not None else 2
        self._counted = _counted(progress, stages * len(list(volume.places())), "bricks")
        self._done = 0.0
        # What is not needed any more goes by itself.
        self._futures: Any = weakref.WeakSet()

    def __enter__(self) -> _Work:
        self._tell = self._counted.__enter__()
        return self

    def __exit__(self, *error: Any) -> None:
        self.client.cancel(list(self._futures), force=True)
        self._counted.__exit__(*error)

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Any:
        """The future of a task."""
        future = self.client.submit(task, *arguments, pure=False)
        self._futures.add(future)
        return future

    def shared_value(self, value: Any) -> Any:
        """The future of a value for many tasks. It is the result of a task, so that it is made anew where its worker is lost."""
        return self.submit(tasks.unchanged, value)

    def _finished(self, futures: list[Any], share: float = 1.0) -> list[Any]:
        """The futures, when all are done; each is so much of a brick's work."""
        import distributed

        for future in distributed.as_completed(futures):
            if future.status != "finished":
                error = future.exception() if future.status == "error" else None
                raise error or _barnard.BarnardError(f"a task of a worker was {future.status}")
            self._done += share
            self._tell(round(self._done))
        return futures

    def densities(self, fields: dict[str, Any]) -> list[_Bricks]:
        """Extinction of dust where there is some, then gas, at all voxels."""
        import dask

        shared = self.shared_value(tasks.Shared(self.scene, self.volume, self.threads))
        places = list(self.volume.places())
        blocks = ({name: array.blocks[place] for name, array in fields.items()} for place in places)
        delayed = [dask.delayed(tasks.densities)(shared, values, place) for values, place in zip(blocks, places)]
        futures = self.client.compute(delayed)
        self._futures.update(futures)
        of_bricks = dict(zip(places, self._finished(futures)))
        count = (self.scene.dust is not None) + len(self.scene.emission)
        part = lambda number: {place: self.submit(operator.getitem, pair, number) for place, pair in of_bricks.items()}  # noqa: E731
        return [_Bricks(self, part(number)) for number in range(count)]

    def plan(self, densities: list[_Bricks], coarse: int) -> _barnard.Whole:
        """Data shared by all bricks, from means of the densities over no more than so many voxels along an edge."""
        factor = max(1, math.ceil(max(self.volume.dims) / coarse))
        dims = tuple(math.ceil(n / factor) for n in self.volume.dims)
        sums = [[self.submit(tasks.sums, brick, place, self.volume, dims) for place, brick in bricks.futures.items()] for bricks in densities]
        means = [tasks.means(self.client.gather(parts), self.volume, dims) for parts in sums]
        small = tasks.of_densities(self.scene, means, self.volume.box, self.camera)
        # The client's own threads are left as they are.
        native = tasks.Shared(small, self.volume, 0).planned()
        self.shared = self.shared_value(tasks.Shared(small, self.volume, self.threads))
        return native

    def star_depths(self, star: list[float], dust: _Bricks, share: float) -> _Bricks:
        """The depths from a star at all voxels, a share of those of all stars."""
        sweeps = self.shared_value(tasks.Sweeps(self.volume, star, self.threads))
        native = tasks.Sweeps(self.volume, star, 0).made()
        layers: dict[int, list[tuple[int, list[Any]]]] = {}
        for number, (frustum, places) in enumerate(native.layers):
            layers.setdefault(frustum, []).append((number, places))
        swept: dict[Place, list[Any]] = {place: [] for place in self.volume.places()}
        for frustum, of_frustum in layers.items():
            carried: Any = {}
            if native.has_entries(frustum):
                for number, places in of_frustum:
                    carried = self._layer(sweeps, native, number, frustum, places, True, dust, carried)[0]
                carried = self.submit(tasks.begun, carried)
            for number, places in of_frustum:
                carried, depths = self._layer(sweeps, native, number, frustum, places, False, dust, carried)
                for place, part in depths.items():
                    swept[place].append(part)
        merged = {place: self.submit(tasks.merged, sweeps, place, part) for place, part in swept.items()}
        self._finished(list(merged.values()), share)
        return _Bricks(self, merged)

    def _layer(
        self, sweeps: Any, native: _barnard.StarSweep, number: int, frustum: int, places: list[Any], finds_entries: bool, dust: _Bricks, carried: Any
    ) -> tuple[Any, dict[Place, Any]]:
        """One layer of a frustum: all rays behind it, and the depths of its bricks."""
        handed, depths = [], {}
        for place in places:
            borders = [native.border(number, place, side) for side in (0, 1)]
            parts = [None if voxels is None else dust.part(voxels) for voxels in borders]
            needs = dust.part(native.needs(number, place))
            result = self.submit(tasks.swept, sweeps, number, finds_entries, place, needs, parts, carried)
            handed.append(self.submit(operator.getitem, result, 1))
            if not finds_entries:
                depths[tuple(place)] = self.submit(operator.getitem, result, 0)
        before = carried if finds_entries else {}
        return self.submit(tasks.joined, sweeps, frustum, before, handed), depths

    def light(self, native: _barnard.Whole, dust: _Bricks | None, depths: list[_Bricks], gas: list[_Bricks]) -> _barnard.Partial:
        """Effect of all bricks on the rays."""
        marched = []
        for place in native.front_to_back():
            voxels = native.stored(place)
            parts_of = lambda bricks: [bricks_of_one.part(voxels) for bricks_of_one in bricks]  # noqa: B023, E731
            dust_part = None if dust is None else dust.part(voxels)
            marched.append(self.submit(tasks.march, self.shared, place, dust_part, parts_of(depths), parts_of(gas)))
        rest = self._finished(marched)
        while len(rest) > 1:
            pairs = [rest[i : i + 2] for i in range(0, len(rest), 2)]
            rest = [self.submit(tasks.over, self.shared, *pair) if len(pair) == 2 else pair[0] for pair in pairs]
        return rest[0].result()
