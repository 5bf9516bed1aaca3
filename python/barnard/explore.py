"""A live view of a scene in a notebook."""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _barnard
from ._rows import QUANTITIES, scene_error
from ._tree import place_of
from ._values import number, parsed

if TYPE_CHECKING:
    from .scene import Scene

try:
    import anywidget
    import traitlets
except ImportError:
    raise _barnard.BarnardError("a live view requires anywidget; pip install barnard[notebook]") from None

_HERE = Path(__file__).parent
#: Pixels of a first look along the longer side.
_COARSE = 256
#: How long nothing moves before a picture is settled [s], and how long a frame may stay unseen before the next is made.
_REST = 0.15
_UNSEEN = 1.0


class Explorer(anywidget.AnyWidget):
    """A view that is dragged, with sliders; `Scene.explore` makes one.

    The browser renders where it can: the kernel packs the scene once, and is not asked again. Otherwise the kernel renders: coarse
    while something moves, then the picture that `Scene.render` makes. In both modes, what is done here is done to the scene: its
    camera and the keys that sliders move.
    """

    _esm = _HERE / "explore.js"
    _css = _HERE / "explore.css"
    width = traitlets.Int(640).tag(sync=True)
    height = traitlets.Int(360).tag(sync=True)
    sliders: Any = traitlets.List().tag(sync=True)
    #: The renderer: "browser" or "kernel".
    mode = traitlets.Unicode("kernel").tag(sync=True)
    #: The page with the packed scene, and steps after it was opened. Both go with the first message, which servers of notebooks do not
    #: limit.
    page = traitlets.Bytes().tag(sync=True)
    steps: Any = traitlets.List().tag(sync=True)

    def __init__(
        self, scene: Scene, sliders: Mapping[str, tuple[Any, Any]], size: tuple[int, int], display: dict[str, Any], page: bytes | None
    ):
        self._scene, self._display = scene, display
        self._ranges = {place: _Range(scene, place, *ends) for place, ends in sliders.items()}
        self._home = scene.camera.tree()
        self._eye = _Eye(self._home)
        self._wake = threading.Condition()
        self._order = 0
        self._seen = self._sent = 0
        self._closed = False
        #: The plan of the last coarse frame.
        self._coarse: _barnard.Plan | None = None
        #: The newest frame: its number, its quality, and why there is none.
        self.state: tuple[int, str, str | None] = (0, "none", None)
        #: The scene as the browser told it last.
        self._text: dict[str, Any] | None = None
        rows = [slider.shown for slider in self._ranges.values()]
        steps = [["set", "display", key, value] for key, value in display.items()]
        mode = "kernel" if page is None else "browser"
        super().__init__(width=size[0], height=size[1], sliders=rows, mode=mode, page=page or b"", steps=steps)
        self.on_msg(self._hear)
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()
        self._changed()

    def _changed(self) -> None:
        with self._wake:
            self._order += 1
            self._wake.notify_all()

    def _hear(self, _: Any, message: dict[str, Any], buffers: Any) -> None:
        kind = message.get("type")
        if kind == "seen":
            with self._wake:
                self._seen = max(self._seen, int(message.get("number", 0)))
                self._wake.notify_all()
            return
        if kind == "view":
            self._take(message["text"])
            return
        with self._wake:
            if kind == "blocked":
                self.mode = "kernel"
            if kind == "move":
                x, y = message.get("orbit", (0, 0))
                self._eye.orbit(float(x) * 0.01, float(y) * 0.01)
                self._eye.near(float(message.get("zoom", 0)))
            elif kind == "home":
                self._eye = _Eye(self._home)
            elif kind == "slide":
                slider = self._ranges[message["place"]]
                slider.move(float(message["at"]))
                self.send({"type": "slid", "place": slider.place, "text": slider.text})
        self._changed()

    def close(self) -> None:
        """Ends the view; the scene stays as it is."""
        # Whoever was never made is closed as well.
        if "_wake" in self.__dict__:
            with self._wake:
                self._closed = True
                self._order += 1
                self._wake.notify_all()
        super().close()

    def _work(self) -> None:
        done = 0
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._order != done)
                # A browser that is slower than the kernel is sent no more than it shows.
                self._wake.wait_for(lambda: self._closed or self._seen >= self._sent, timeout=_UNSEEN)
                if self._closed:
                    return
                done = self._order
            try:
                if self.mode == "kernel":
                    self._frames(done)
            except _barnard.BarnardError as error:
                self.send({"type": "words", "text": str(error)})
                self.state = (done, "failed", str(error))
            except _Moved:
                continue

    def _take(self, text: str) -> None:
        """Does to the scene what was done in the browser: camera and keys that differ from the text before."""
        tree = _barnard.from_toml("explorer", text)
        if self._text is not None:
            for place, value in _changes(self._text, tree):
                owner, key = place_of(self._scene, place)
                setattr(owner, key, value)
            if tree["camera"] != self._text["camera"]:
                self._scene.camera = {**tree["camera"], "size": self._scene.camera.size}
        self._text = tree

    def _stop_if_moved(self, order: int) -> None:
        if self._order != order:
            raise _Moved

    def _frames(self, order: int) -> None:
        """A coarse frame at once, then the settled one, unless something moves."""
        with self._wake:
            self._scene.camera = {**self._home, **self._eye.keys()}
            width, height = self.width, self.height
        scale = min(1.0, _COARSE / max(width, height))
        coarse = self._scene._resized([max(1, round(width * scale)), max(1, round(height * scale))])
        session = self._scene._session(coarse)
        self._coarse = _barnard.plan(session.scene, self._coarse, "cpu", session.limit, preview=True)
        self._show(order, "coarse", _barnard.render(session.scene, self._coarse, "cpu", {}, session.limit))
        with self._wake:
            self._wake.wait_for(lambda: self._order != order, timeout=_REST)
        self._stop_if_moved(order)
        stop = lambda *_: self._stop_if_moved(order)  # noqa: E731
        image = self._scene.render(self._scene._resized([width, height]), progress=stop)
        self._show(order, "settled", image._native)

    def _show(self, order: int, quality: str, native: _barnard.Image) -> None:
        height, width = native.shape
        message = {"type": "frame", "number": order, "quality": quality, "text": f"{quality}, {width} x {height}"}
        self.send(message, buffers=[native.png(self._display or None)])
        self._sent, self.state = order, (order, quality, None)


def _changes(before: Any, after: Any, place: str = "") -> list[tuple[str, Any]]:
    """Places of values that differ, with the new value; fields of a packed scene and its camera are left out."""
    if isinstance(before, dict) and isinstance(after, dict):
        keys = [key for key in {**before, **after} if place or key not in ("field", "camera")]
        within = [_changes(before.get(key), after.get(key), f"{place}.{key}" if place else key) for key in keys]
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after) and all(isinstance(row, dict) for row in after):
        within = [_changes(*pair, f"{place}[{number}]") for number, pair in enumerate(zip(before, after, strict=True))]
    else:
        return [] if before == after else [(place, after)]
    return [change for changes in within for change in changes]


class _Moved(Exception):
    """Something moved: a finer picture is given up."""


class _Eye:
    """Position and target of a camera [pc]."""

    def __init__(self, camera: dict[str, Any]):
        self.target = _place(camera.get("target", "0 0 0 pc"))
        self.place = _place(camera["position"])
        self.up = np.array(camera.get("up", [0.0, 1.0, 0.0]), float)

    def orbit(self, right: float, down: float) -> None:
        """Turns the view about its target [rad]."""
        out = self.place - self.target
        distance = np.linalg.norm(out)
        up = self.up / np.linalg.norm(self.up)
        side = np.cross(up, out)
        side /= max(np.linalg.norm(side), 1e-12)
        height = math.asin(np.clip(out @ up / distance, -1, 1)) + down
        height = min(max(height, -1.55), 1.55)
        front = np.cross(side, up)
        around = math.cos(right) * front - math.sin(right) * side
        self.place = self.target + distance * (math.cos(height) * around + math.sin(height) * up)

    def near(self, steps: float) -> None:
        """Goes away from the target by a factor of e for each step."""
        self.place = self.target + (self.place - self.target) * math.exp(min(max(steps, -2.0), 2.0))

    def keys(self) -> dict[str, Any]:
        return {"position": " ".join(map(number, self.place)) + " pc"}


def _place(text: str) -> np.ndarray:
    *numbers, unit = text.replace(",", " ").split()
    return np.array([float(n) for n in numbers]) * dict(QUANTITIES["length"][0])[unit]


class _Range:
    """A key that a slider moves between two values: by ratio where both are above zero and far apart."""

    def __init__(self, scene: Scene, place: str, low: Any, high: Any):
        self.place = place
        self._owner, self._key = place_of(scene, place)
        row = self._owner._row().all_keys(self._owner._chosen)[self._key]
        speak = lambda value: self._owner._spoken(self._key, row, value)  # noqa: E731
        (self._low, self._unit), (high_number, unit) = parsed(speak(low)), parsed(speak(high))
        self._high = high_number
        if unit != self._unit or not self._low < self._high:
            raise scene_error(place, f"a slider must range from a smaller to a larger value of the same unit, not from {low} to {high}")
        self._by_ratio = self._low > 0 and self._high / self._low >= 4
        setting = self._owner._nodes().get(self._key)
        value, own_unit = parsed(setting) if setting is not None else (self._low, self._unit)
        self._value = value if own_unit == self._unit else self._low

    @property
    def shown(self) -> dict[str, Any]:
        """The slider as the view shows and moves it."""
        ends = {"low": self._low, "high": self._high, "byRatio": self._by_ratio, "unit": self._unit or ""}
        return {"place": self.place, "at": self.at, "text": self.text, **ends}

    @property
    def at(self) -> float:
        """Position of the value, from 0 to 1."""
        value, low, high = self._value, self._low, self._high
        share = math.log(max(value, low) / low) / math.log(high / low) if self._by_ratio else (value - low) / (high - low)
        return min(max(share, 0.0), 1.0)

    @property
    def text(self) -> str:
        return f"{self._value:.4g} {self._unit}".strip()

    def move(self, at: float) -> None:
        at = min(max(at, 0.0), 1.0)
        low, high = self._low, self._high
        self._value = low * (high / low) ** at if self._by_ratio else low + (high - low) * at
        setattr(self._owner, self._key, f"{number(self._value)} {self._unit}" if self._unit else self._value)
