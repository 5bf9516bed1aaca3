"""Sequences: frame after frame of a scene that changes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import _barnard
from ._progress import Listener, listening
from .image import Image
from .plan import PlanError, backend_options

if TYPE_CHECKING:
    from .scene import Scene


class FrameSequence:
    """The frames of an animated scene, made by `Scene.frames`.

    A few pilot frames choose the settings of all frames, so that nothing flickers: steps, star depths, spectral rules,
    white level and balance of bands. Frames have the same bits in any order, so workers of a cluster can share them:
    `bn.map(frames.render, frames.numbers, client)`.

    A sequence belongs to the scene at its creation; frames of a changed scene raise `PlanError`.
    """

    def __init__(self, scene: Scene):
        self._owner = scene
        self._session = scene._session()
        self._native: _barnard.Sequence | None = None

    def _sequence(self) -> _barnard.Sequence:
        if self._native is None:
            self._native = _barnard.sequence(self._session.reader, self._session.tree, "scene")
        return self._native

    def _check(self) -> None:
        if self._owner._session().tree != self._session.tree:
            error = PlanError("the scene has changed since its frames were made; make new ones with scene.frames()")
            error.key = "scene"
            raise error

    @property
    def numbers(self) -> range:
        """Numbers of the frames."""
        first, last = self._sequence().range
        return range(first, last + 1)

    def __len__(self) -> int:
        return len(self.numbers)

    def time(self, number: int) -> float:
        """The moment of a frame [s]."""
        return self._sequence().time(number)

    def render(
        self,
        number: int,
        *,
        backend: str = "cpu",
        progress: bool | Listener | None = None,
        accuracy: float | None = None,
        samples: int | None = None,
        target_error: float | None = None,
        seed: int | None = None,
    ) -> Image:
        """Renders a frame, with the bits of `barnard render --frames`.

        The first frame also renders the pilot frames.

        Parameters
        ----------
        number : integer
            One of `numbers`.
        backend, progress, accuracy, samples, target_error, seed
            As for `Scene.render`.

        Raises
        ------
        PlanError
            If the scene has changed.
        SceneError, MemoryLimitError, DeviceError
        KeyboardInterrupt
            After Ctrl-C.
        """
        self._check()
        options = backend_options(backend, accuracy, samples, target_error, seed)
        sequence = self._sequence()
        with listening(progress) as listener:
            return Image(sequence.render(int(number), backend, options, self._session.limit, progress=listener))

    def __reduce__(self):
        """Its scene; whoever reads the pickle chooses anew what holds for all frames, with the same bits."""
        self._check()
        return FrameSequence, (self._owner,)

    def __repr__(self) -> str:
        numbers = self.numbers
        return f"FrameSequence( {numbers[0]} to {numbers[-1]})"
