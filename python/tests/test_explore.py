"""The live view without a browser: what it hears, and the frames that it sends."""

import time

import numpy as np
import pytest

import barnard as bn
from conftest import cloud, lit

pytest.importorskip("anywidget")


class Sent(list):
    def frames(self, quality):
        return [message for message, buffers in self if message["type"] == "frame" and message["quality"] == quality]


@pytest.fixture
def seen():
    scene = lit(cloud())
    explorer = scene.explore({"star[0].temperature": ("3000 K", "48000 K"), "dust.albedo": (0.1, 0.9)}, size=(64, 48), in_browser=False)
    sent = Sent()
    explorer.send = lambda message, buffers=None: sent.append((message, buffers))
    yield scene, explorer, sent
    explorer.close()


def settled(explorer, order):
    begun = time.perf_counter()
    while time.perf_counter() - begun < 60:
        if explorer.state[0] >= order and explorer.state[1] in ("settled", "failed"):
            return explorer.state
        time.sleep(0.01)
    raise AssertionError(f"no settled frame of order {order}: {explorer.state}")


def test_a_view_settles_to_the_picture_of_the_scene(seen):
    scene, explorer, sent = seen
    settled(explorer, 1)
    explorer._hear(explorer, {"type": "move", "orbit": [40, 10], "zoom": 0.3}, [])
    settled(explorer, 2)
    assert sent.frames("coarse") and sent.frames("settled")
    message, buffers = sent[-1]
    assert buffers[0].startswith(b"\x89PNG")
    scene.camera.size = [64, 48]
    assert buffers[0] == scene.render().png()
    assert scene.camera.position != "0 0 4 pc"
    explorer._hear(explorer, {"type": "home"}, [])
    settled(explorer, 3)
    assert np.allclose([float(n) for n in scene.camera.position.split()[:3]], [0, 0, 4])


def test_orbits_keep_their_distance():
    from barnard.explore import _Eye

    eye = _Eye({"position": "0 0 4 pc"})
    for step in [(0.3, 0.2), (-2.0, 4.0), (0.1, -9.0)]:
        eye.orbit(*step)
        assert np.isclose(np.linalg.norm(eye.place), 4)
    eye.near(np.log(2))
    assert np.isclose(np.linalg.norm(eye.place), 8)
    turned = _Eye({"position": "0 0 4 pc"})
    turned.orbit(np.pi / 2, 0)
    assert np.allclose(turned.place, [-4, 0, 0]), turned.place


def test_sliders_move_keys(seen):
    scene, explorer, sent = seen
    explorer._hear(explorer, {"type": "slide", "place": "star[0].temperature", "at": 0.5}, [])
    assert scene.stars[0].temperature == "12000.0 K"
    explorer._hear(explorer, {"type": "slide", "place": "dust.albedo", "at": 2}, [])
    assert scene.dust.albedo == 0.9
    settled(explorer, 3)
    assert any(message["type"] == "slid" and message["text"] == "1.2e+04 K" for message, _ in sent)


def test_what_cannot_be_shown_is_said(seen):
    scene, explorer, sent = seen
    settled(explorer, 1)
    scene.dust.law = "nothing"
    explorer._hear(explorer, {"type": "move", "orbit": [1, 0], "zoom": 0}, [])
    assert settled(explorer, 2)[1] == "failed"
    assert any(message["type"] == "words" and "dust.law" in message["text"] for message, _ in sent)
    scene.dust.law = "ccm89"
    explorer._hear(explorer, {"type": "move", "orbit": [1, 0], "zoom": 0}, [])
    assert settled(explorer, 3)[1] == "settled"
    for sliders in [{"star[0].temperature": ("9 K", "1 K")}, {"star[0].temperature": ("1 K", "9 kK")}, {"star[9].temperature": (1, 2)}]:
        with pytest.raises(bn.SceneError):
            scene.explore(sliders)


def test_what_is_done_in_the_browser_is_done_to_the_scene():
    scene = lit(cloud())
    page = Sent()
    explorer = scene.explore({"star[0].temperature": ("3000 K", "48000 K")}, size=(64, 48), in_browser=False)
    explorer.send = lambda message, buffers=None: page.append((message, buffers))
    text = bn.Scene.from_toml(scene_text()).to_toml()
    explorer._take(text)
    explorer._take(text.replace('"0 0 4 pc"', '"1 0 4 pc"').replace('"12000 K"', '"9000 K"').replace('"3 /pc"', '"2 /pc"') + '\n[display]\nstretch = "linear"\n')
    assert scene.camera.position == "1 0 4 pc"
    assert (scene.stars[0].temperature, scene.dust.scale, scene.display.stretch) == ("9000 K", "2 /pc", "linear")
    explorer.close()


def scene_text():
    """The scene with a field that a text can state."""
    scene = lit(cloud())
    scene.fields["cloud"] = bn.Sphere("1 pc")
    return scene.to_toml()


def test_scenes_are_packed_for_the_browser(monkeypatch, tmp_path):
    page = tmp_path / "barnard.html"
    page.write_text("<title>Barnard</title><!-- preview --><!-- scene -->")
    monkeypatch.setenv("BARNARD_PAGE", str(page))
    scene = lit(cloud())
    explorer = scene.explore(size=(64, 48), palette="natural")
    explorer.send = lambda message, buffers=None: None
    assert (explorer.mode, explorer.steps) == ("browser", [["set", "display", "palette", "natural"]])
    assert b'id="barnard-bundle"' in explorer.page
    # A frame that shows nothing leaves the work to the kernel.
    explorer._hear(explorer, {"type": "blocked"}, [])
    assert explorer.mode == "kernel" and settled(explorer, explorer._order)[1] == "settled"
    explorer.close()
    monkeypatch.setenv("BARNARD_PAGE", str(tmp_path / "none.html"))
    assert scene.explore(size=(64, 48)).mode == "kernel"
    with pytest.raises(bn.BarnardError, match="lacks the page"):
        scene.to_html()
