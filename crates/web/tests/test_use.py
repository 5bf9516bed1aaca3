"""The page in use: flights, fingers, many edits, other files, small screens."""

import re
import tomllib

import numpy as np
import pytest
from pictured import await_picture, change, pictures, pixels

FLIGHT = """name = "Flight"
[camera]
kind = "perspective"
position = "0 0 5 pc"
target = "0 0 0 pc"
field_of_view = "32 deg"
size = [320, 180]
[camera.path]
key = [{ time = "0 s", position = "0 0 5 pc" }, { time = "1 s", position = "3 0.5 4 pc" }]
[sequence]
frames_per_second = 10
[field.cloud]
kind = "turbulence"
low = "-1 -1 -1 pc"
high = "1 1 1 pc"
voxels = 32
mach = 1
[dust]
density = "cloud"
scale = "2 mag/pc"
[method]
accuracy = 0.02
[[star]]
kind = "blackbody"
position = "0.3 1.2 0.4 pc"
temperature = "12000 K"
luminosity = "1000 Lsun"
visible = false
"""
BOOKMARK = """[bookmark.Afar]
kind = "perspective"
position = "0 0 9 pc"
field_of_view = "30 deg"
"""
STILL = FLIGHT[: FLIGHT.index("[camera.path]")] + BOOKMARK + FLIGHT[FLIGHT.index("[field.cloud]") :]


def opened(page, address, text, name="scene.toml"):
    page.goto(address)
    await_picture(page)
    count = pictures(page)
    page.set_input_files("#file", {"name": name, "mimeType": "text/plain", "buffer": text.encode()})
    await_picture(page, "final", count)
    assert page.is_hidden("#problem"), page.text_content("#problem")


def test_a_flight_is_played(page, address):
    opened(page, address, FLIGHT)
    assert page.is_visible("#timeline")
    first, last = change(page, lambda: page.click("#play"))
    page.wait_for_function("() => document.getElementById('play').textContent === 'Play' && document.getElementById('time').value === '1'", timeout=60_000)
    await_picture(page, "final")
    last = pixels(page)
    assert np.abs(first.astype(int) - last).mean() > 2
    # The first moment is as it was.
    _, again = change(page, lambda: page.locator("#time").fill("0"))
    assert np.array_equal(first, again)


def test_pans_looks_and_fingers_move_the_view(page, address):
    opened(page, address, STILL)
    box = page.locator("#canvas").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def drag(key=None):
        if key:
            page.keyboard.down(key)
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 60, y + 8, steps=3)
        page.mouse.up()
        if key:
            page.keyboard.up(key)

    def pinch():
        page.evaluate(
            """([x, y]) => {
                const canvas = document.getElementById('canvas');
                canvas.setPointerCapture = () => {};
                const send = (type, id, dx) => canvas.dispatchEvent(new PointerEvent(type, { pointerId: id, clientX: x + dx, clientY: y, pointerType: 'touch', bubbles: true }));
                send('pointerdown', 1, -10); send('pointerdown', 2, 10);
                send('pointermove', 1, -40); send('pointermove', 2, 40);
                send('pointerup', 1, -40); send('pointerup', 2, 40);
            }""",
            [x, y],
        )

    home = pixels(page)
    views = [home]
    for action in [lambda: drag("Shift"), lambda: drag("Control"), pinch, lambda: page.locator("#canvas").press("w"), lambda: page.click("text=Afar")]:
        _, view = change(page, action)
        assert all(np.abs(view.astype(int) - other).mean() > 0.5 for other in views), len(views)
        views.append(view)
    # Home is as it was, once its levels are measured there.
    change(page, lambda: page.click("#home"))
    _, again = change(page, lambda: page.click("#expose"))
    assert np.array_equal(home, again)


def test_memory_stays_over_many_edits(page, address):
    opened(page, address, FLIGHT)

    def size():
        return page.evaluate("async () => quick.call([['memory']])")

    def edit(number):
        page.evaluate("number => act(['set', 'star.0', 'temperature', `${9000 + number} K`], ['set', 'dust', 'scale', `${1 + number % 7} mag/pc`])", number)
        page.wait_for_function("() => !isRunning", timeout=60_000)

    for number in range(20):
        edit(number)
    before = size()
    for number in range(20, 220):
        edit(number)
    assert size() - before < 16e6, (before, size())


@pytest.mark.parametrize("format", ["exr", "toml"])
def test_pictures_and_scenes_are_saved(page, address, tmp_path, format):
    opened(page, address, FLIGHT)
    with page.expect_download() as download:
        page.click(f"[data-save={format}]")
    path = tmp_path / "saved"
    download.value.save_as(path)
    if format == "exr":
        # The magic number of OpenEXR.
        assert path.read_bytes()[:4] == b"\x76\x2f\x31\x01" and path.stat().st_size > 10_000
    else:
        scene = tomllib.loads(path.read_text())
        assert scene["dust"]["scale"] == "2 mag/pc" and re.match(r"\S+ \S+ \S+ pc", scene["camera"]["position"])


def test_files_are_dropped(page, address):
    page.goto(address)
    await_picture(page)
    count = pictures(page)
    page.evaluate(
        """text => {
            const data = new DataTransfer();
            data.items.add(new File([text], 'dropped.toml'));
            document.dispatchEvent(new DragEvent('drop', { dataTransfer: data, cancelable: true }));
        }""",
        FLIGHT,
    )
    await_picture(page, "final", count)
    assert "Flight" in page.title()


def test_phones_see_picture_and_settings(page, address):
    page.set_viewport_size({"width": 390, "height": 844})
    page.goto(address)
    await_picture(page)
    view, panel = page.locator("#canvas").bounding_box(), page.locator("#panel").bounding_box()
    assert view["width"] == 390 and panel["y"] >= view["y"] + view["height"] - 1 and panel["width"] == 390
    assert page.evaluate("() => document.documentElement.scrollWidth <= 390")
    small = page.evaluate("() => [...document.querySelectorAll('button')].filter(b => b.offsetParent && b.offsetHeight < 32).map(b => b.textContent)")
    assert small == []
