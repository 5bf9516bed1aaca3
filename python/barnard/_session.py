"""Scenes as the native module reads them."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import _barnard


class Session:
    """The tree of a scene, the reader with its arrays, and its memory limit [bytes]; made by a `Scene` for all work on it."""

    def __init__(self, tree: dict[str, Any], reader: _barnard.Reader, limit: int):
        self.tree, self.reader, self.limit = tree, reader, limit

    @cached_property
    def scene(self) -> _barnard.Scene:
        """The scene, read from its tree once."""
        return self.reader.read(self.tree, "scene")
