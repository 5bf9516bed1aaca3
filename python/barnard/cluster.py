"""Many pictures on many machines with Dask.

Use one worker process per machine with one Dask thread (`nthreads=1`): Barnard's own threads fill the cores.
"""

from __future__ import annotations

import collections
import contextlib
import contextvars
import hashlib
import os
import socket
import threading
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from . import _barnard
from ._files import replace
from ._rows import scene_error
from ._table import table_of
from .tables import Camera

#: The folder in which arrays are laid down while something is pickled for workers.
_shared: contextvars.ContextVar[Path | None] = contextvars.ContextVar("shared", default=None)


@dataclass(frozen=True)
class Result:
    """Outcome of one picture."""

    #: The key of the picture: its number, or that of the dictionary.
    key: Any
    #: The file.
    path: Path
    #: "rendered", "skipped" where the file was there, or "failed".
    state: str
    #: What went wrong, in words; none where nothing did.
    error: str | None = None
    #: Where it went wrong, for a person who looks for a fault.
    traceback: str | None = None


@contextlib.contextmanager
def sharing(folder: Path) -> Iterator[None]:
    """Pickles of scenes hold no arrays meanwhile, but the names of files in `folder` that they are laid down in."""
    token = _shared.set(folder)
    try:
        yield
    finally:
        _shared.reset(token)


def laid_down(array: np.ndarray) -> str | None:
    """The file in which an array lies for workers, written where it is not there; none where nothing is shared.

    The first axis runs fastest in it: as it lies there a field can use it.
    """
    folder = _shared.get()
    if folder is None:
        return None
    array = np.asfortranarray(array)
    digest = hashlib.sha256(repr((array.shape, array.dtype.str)).encode())
    digest.update(array.T.data.cast("B"))
    path = folder / f"{digest.hexdigest()[:32]}.npy"
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        replace(path, lambda out: np.save(out, array))
    return str(path.resolve())


def tiles(camera: Camera | dict[str, Any], edge: int = 1024) -> dict[tuple[int, int], Camera]:
    """Cameras of the tiles of a large image, of at most edge × edge pixels, by their first row and column.

    Rendered with one plan, as in `bn.map(plan.render, bn.tiles(plan.camera), client)`, tiles have no seams.

    Parameters
    ----------
    camera : Camera
        Camera of the whole image.
    edge : int, default 1024
        Largest edge of a tile in pixels.

    Raises
    ------
    SceneError
        If the camera is cropped, or the edge is out of range.
    """
    tree = table_of(Camera, camera, "camera")._nodes()
    if "crop" in tree:
        raise scene_error("camera.crop", "the camera is already cropped; give the camera of the whole image")
    if not edge >= 1:
        raise scene_error("edge", f"{edge} is out of range; give 1 pixel or more")
    width, height = tree.get("size", (512, 512))
    parts = ((row, column) for row in range(0, height, int(edge)) for column in range(0, width, int(edge)))
    crop = lambda row, column: [column, row, min(edge, width - column), min(edge, height - row)]  # noqa: E731
    return {place: Camera.of({**tree, "crop": crop(*place)}) for place in parts}


# On a worker.

_lock = threading.Lock()
_unpickled: dict[str, Callable[[Any], Any]] = {}


def _one(pickled: bytes, digest: str, key: Any, item: bytes, path: str, threads: int, overwrite: bool) -> Result:
    """Renders one picture and writes it; what is pickled stays on the worker, with the plans that it keeps."""
    import cloudpickle

    target = Path(path)
    if target.exists() and not overwrite:
        return Result(key, target, "skipped")
    # Pictures of one process take turns: each has all of its threads.
    with _lock:
        try:
            if digest not in _unpickled:
                _unpickled.clear()
                _barnard.set_threads(threads)
                _unpickled[digest] = cloudpickle.loads(pickled)
            image = _unpickled[digest](cloudpickle.loads(item))
            image.write(path)
        except Exception as error:
            return Result(key, target, "failed", f"{type(error).__name__}: {error}", traceback.format_exc())
    return Result(key, target, "rendered")


# On the client.


def map(
    render: Callable[[Any], Any],
    items: Iterable[Any] | Mapping[Any, Any],
    client: Any,
    *,
    files: str = "frame_{:05}.fits",
    overwrite: bool = False,
    threads: int | None = None,
    timeout: float = 60.0,
    progress: bool | Callable[[int, int], None] = True,
) -> list[Result]:
    """Renders a picture per item on the workers of a Dask client and writes files.

    Scenes are sent as text; their arrays are stored once next to the files, in a folder `.barnard`, and memory-mapped.
    Existing pictures are skipped, so an interrupted job resumes. A failure does not stop other items; Dask replaces
    a worker that dies, and repeats its picture.

    Parameters
    ----------
    render : callable
        From an item to an `Image`, such as `scene.render` for cameras, or `lambda scene: scene.render()` for scenes.
    items : iterable, or dictionary by key
        Items to render. Items without keys are numbered from 0.
    client : dask.distributed.Client
    files : text
        Path of each file, formatted with the key of the item (tuples as several values); the extension selects the
        format. All workers must see the folder.
    overwrite : bool, default False
        Render existing files again.
    threads : int, optional
        Threads per worker. Default: the cores of its machine divided by the workers on it.
    timeout : number, default 60
        Time to wait for the first worker [s].
    progress : bool or callable (done, all), default True

    Returns
    -------
    list of Result
        In the order of the items.

    Raises
    ------
    BarnardError
        If Dask is not installed, no worker starts in time, or two items have the same file.
    """
    _check_installed()
    import cloudpickle
    from distributed import as_completed

    keyed = dict(items) if isinstance(items, Mapping) else dict(enumerate(items))
    paths = {key: Path(files.format(*key) if isinstance(key, tuple) else files.format(key)).resolve() for key in keyed}
    if len(set(paths.values())) != len(paths):
        raise _barnard.BarnardError(f'several items have the same file; use the key in `files`, as in "frame_{{:05}}.fits", not "{files}"')
    _wait_for_workers(client, timeout)
    if threads is None:
        threads = _threads(client)
    folders = {path.parent for path in paths.values()}
    for folder in folders:
        folder.mkdir(parents=True, exist_ok=True)
    for path in list(paths.values())[:1]:
        _barnard.check_writable(str(path))
    with sharing(min(folders) / ".barnard" if folders else Path(".barnard")):
        pickled = cloudpickle.dumps(render)
        pickles = {key: cloudpickle.dumps(item) for key, item in keyed.items()}
    digest = hashlib.sha256(pickled).hexdigest()
    futures = {
        client.submit(_one, pickled, digest, key, pickles[key], str(paths[key]), threads, overwrite, pure=False, retries=3): key
        for key in keyed
    }
    results: dict[Any, Result] = {}
    with _counted(progress, len(futures)) as count:
        for future in as_completed(futures):
            key = futures[future]
            try:
                results[key] = future.result()
            except Exception as error:  # Whatever ended the worker.
                results[key] = Result(key, paths[key], "failed", f"{type(error).__name__}: {error}")
            count(len(results))
    return [results[key] for key in keyed]


def _check_installed() -> None:
    try:
        import cloudpickle  # noqa: F401
        import distributed  # noqa: F401
    except ImportError:
        raise _barnard.BarnardError("Dask is not installed; pip install barnard[cluster]") from None


def _wait_for_workers(client: Any, timeout: float) -> None:
    try:
        client.wait_for_workers(1, timeout=timeout)
    except TimeoutError:
        raise _barnard.BarnardError(f"the client has no workers after {timeout:g} s; start some, or increase `timeout`") from None


def _threads(client: Any) -> int:
    """Threads of a worker, where workers that may run on the same cores share them."""
    workers = client.run(_cores).values()
    sharing = collections.Counter((host, cores) for host, cores, stated in workers if stated is None)
    return max(1, min(stated if stated is not None else len(cores) // sharing[host, cores] for host, cores, stated in workers))


def _cores() -> tuple[str, tuple[int, ...], int | None]:
    """The machine, the cores that this process may run on, and how many of them Slurm gave it alone, where it did."""
    cores = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else range(os.cpu_count() or 1)
    stated = os.environ.get("SLURM_CPUS_PER_TASK", "")
    return socket.gethostname(), tuple(cores), min(int(stated), len(cores)) if stated.isdecimal() and int(stated) > 0 else None


@contextlib.contextmanager
def _counted(progress: bool | Callable[[int, int], None], whole: int, what: str = "pictures") -> Iterator[Callable[[int], None]]:
    if callable(progress):
        listener = progress
        yield lambda done: listener(done, whole)
        return
    if not progress:
        yield lambda done: None
        return
    from ._progress import listening

    with listening(True) as show:
        bars = show or (lambda *_: None)
        yield lambda done: bars(what, done, whole)
