"""Sequences: frame after frame of a scene that changes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import _barnard
from ._progress import Listener, told
from .image import Image
from .plan import PlanError, exactness

if TYPE_CHECKING:
    from .scene import Scene


class FrameSequence:
    """The frames of a scene whose camera follows a path or whose keys change; `Scene.frames` makes one.

    What would flicker if each frame chose it, a few pilot frames choose for all: steps, star depths, spectral rules,
    the white of pictures and the balance of bands. A frame has the same bits whether others were rendered before it or
    not, so that workers of a cluster may share them: `bn.map(frames.render, frames.numbers, client)`.

    They are those of the scene as it was when the sequence was made: where the scene has changed since, they are refused.
    """

    def __init__(self, scene: Scene):
        self._owner = scene
        self._tree, self._limit = scene._tree(), scene._limit
        self._native: Any = None

    def _sequence(self) -> Any:
        if self._native is None:
            self._native = _barnard.sequence(self._owner._reading(), self._tree, "scene")
        return self._native

    def _check(self) -> None:
        if self._owner._tree() != self._tree:
            error = PlanError("the scene has changed since its frames were made; make others by scene.frames()")
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
        """Renders a frame: the same bits as `barnard render --frames` writes.

        The first one that is rendered renders the pilot frames as well.

        Parameters
        ----------
        number : integer
            One of `numbers`.
        backend, progress, accuracy, samples, target_error, seed
            As for `Scene.render`.

        Raises
        ------
        PlanError
            Where the scene has changed since.
        SceneError, MemoryLimitError, DeviceError
        KeyboardInterrupt
            Where Ctrl-C stopped it.
        """
        self._check()
        exact = exactness(backend, accuracy, samples, target_error, seed)
        sequence = self._sequence()
        with told(progress) as listener:
            return Image(sequence.render(int(number), backend, exact, self._limit, progress=listener))

    def __reduce__(self):
        """Its scene; whoever reads the pickle chooses anew what holds for all frames, with the same bits."""
        self._check()
        return FrameSequence, (self._owner,)

    def __repr__(self) -> str:
        numbers = self.numbers
        return f"FrameSequence( {numbers[0]} to {numbers[-1]})"
