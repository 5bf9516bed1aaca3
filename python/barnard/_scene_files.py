"""Scenes as files: texts, packed scenes, and pages. These functions are methods of `Scene`."""

from __future__ import annotations

import functools
import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from . import _barnard
from ._bundle import packed, page_of, written
from ._files import replace
from ._progress import Listener
from ._rows import scene_error

if TYPE_CHECKING:
    from .scene import Scene


def to_toml(self: Scene) -> str:
    """The scene as the text of a scene file.

    Raises
    ------
    SceneError
        If a field is an array in memory; `save` writes such scenes.
    """
    self._refuse_bricks()
    arrays = self._arrays()
    if arrays:
        name = next(iter(arrays))
        raise scene_error(f"field.{name}", "the field is an array in memory; write the scene with save(path)")
    return _barnard.to_toml(self._tree())


def save(self: Scene, path: str | os.PathLike, *, limit: float = 4.0, progress: bool | Listener | None = None) -> None:
    """Writes a scene file, and each array in memory as NAME.npy next to it; or all of the scene as one .barnard file.

    Parameters
    ----------
    path : path
        The file, ending with .toml or .barnard. Files of the scene are copied into a .barnard file, and stay where they are
        with a .toml file.
    limit : number, default 4
        Largest size of a .barnard file [MB]: densities are stored on as many voxels as fit. The file states its errors.
    progress : bool or function, optional
        True for bars; a function of (stage, done, all).

    Raises
    ------
    SceneError
        If the name ends otherwise, or a built-in scene needs files.
    OSError
        If a file cannot be written.
    """
    path = Path(path)
    if path.suffix == ".barnard":
        bundle = self._packed(limit, progress)
        replace(path, lambda out: out.write(bundle))
        return
    if path.suffix != ".toml":
        raise scene_error("path", f"{path}: the name of a scene file must end with .toml or .barnard")
    self._refuse_bricks()
    tree = self._tree()
    for name, field in self._arrays().items():
        file, values = f"{path.stem}_{name}.npy", np.asarray(field.values)
        replace(path.with_name(file), functools.partial(np.save, arr=values))
        tree["field"][name]["file"] = file
    text = _barnard.to_toml(tree)
    replace(path, lambda out: out.write(text.encode()))


def to_html(
    self: Scene, path: str | os.PathLike | None = None, *, limit: float = 4.0, progress: bool | Listener | None = None
) -> str:
    """The scene and the explorer as one HTML page, which works without a server and without a network.

    Parameters
    ----------
    path : path, optional
        The file to write, ending with .html.
    limit : number, default 4
        Largest size of the scene in the page [MB]; the page takes 4/3 of it and 5.6 MB.
    progress : bool or function, optional
        True for bars; a function of (stage, done, all).

    Returns
    -------
    text
        The page.

    Raises
    ------
    BarnardError
        If this installation lacks the page of the explorer.
    SceneError
        If the scene cannot be rendered, or does not fit into the limit.
    """
    return written(page_of(self._packed(limit, progress)), path)


def packed_scene(self: Scene, limit: float, progress: bool | Listener | None) -> bytes:
    """Bytes of a bundle of the scene."""
    session = self._session()
    return packed(lambda size, listener: _barnard.bake(session.scene, size, True, listener), limit, progress)
