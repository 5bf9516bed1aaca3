"""Scenes in one HTML file, opened from a disk, and packed scenes."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import PAGE
from pictured import await_picture, change, pictures, pixels

Image = pytest.importorskip("PIL.Image")
PROGRAM = Path(os.environ.get("BARNARD_PROGRAM", Path(__file__).parents[3] / "target" / "release" / "barnard"))

if not PROGRAM.exists():
    pytest.skip("NOT CHECKED: no program barnard (BARNARD_PROGRAM)", allow_module_level=True)

#: A turbulent cloud that a star ionises.
GAS = """name = "Ionised cloud"
bands = "hst-wfc3-sho"
[camera]
kind = "perspective"
position = "0 0 8 pc"
target = "0 0 0 pc"
field_of_view = "24 deg"
size = [320, 180]
[field.t]
kind = "turbulence"
low = "-1.5 -1 -1 pc"
high = "1.5 1 1 pc"
voxels = 48
mach = 1
outer_scale = "1 pc"
slope = 5
[dust]
density = "200 * t"
scale = "5e-22 mag cm2"
[gas]
density = "200 * t"
[[star]]
kind = "blackbody"
position = "0.2 0 0 pc"
temperature = "38000 K"
luminosity = "2e4 Lsun"
"""
SMALL = ["--set", "camera.size=[320, 180]", "--limit", "1"]
SCENES = {"six_stars": ["--builtin", "six_stars", *SMALL], "pleiades": ["--builtin", "pleiades", *SMALL], "gas": ["gas.toml"]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with each scene as NAME.barnard and NAME.html."""
    folder = tmp_path_factory.mktemp("html")
    (folder / "gas.toml").write_text(GAS)
    for name, scene in SCENES.items():
        run(folder, "bake", *scene, "-o", f"{name}.barnard")
        run(folder, "html", f"{name}.barnard", "-o", f"{name}.html", "--page", PAGE / "barnard.html")
    return folder


def run(folder, *arguments):
    subprocess.run([PROGRAM, *arguments], cwd=folder, check=True, capture_output=True)


@pytest.mark.parametrize("name", SCENES)
def test_pages_open_from_a_disk_and_show_what_the_program_renders(page, folder, name):
    path = folder / f"{name}.html"
    assert path.stat().st_size < 12e6
    page.add_init_script("window.stages = new Set(); window.noted = () => stages.add(document.getElementById('status').textContent.split(' ')[0])")
    page.goto(path.as_uri())
    assert page.is_visible("#preview")
    page.evaluate("() => new MutationObserver(noted).observe(document.getElementById('status'), { childList: true, characterData: true, subtree: true })")
    await_picture(page, "final")
    assert page.locator("#preview").count() == 0
    # The gas came with the file.
    assert "ionised" not in page.evaluate("() => [...stages]")
    shown = pixels(page)[..., :3].astype(int)
    height, width, _ = shown.shape
    run(folder, "render", f"{name}.barnard", "--size", f"{width}x{height}", "-o", f"{name}.png")
    rendered = np.asarray(Image.open(folder / f"{name}.png").convert("RGB")).astype(int)
    near = (np.abs(shown - rendered) <= 1).all(axis=2).mean()
    assert rendered.std() > 5 and near > 0.999, near
    # Another scene would fail.
    assert (np.abs(shown - rendered[:, ::-1]) <= 1).all(axis=2).mean() < 0.9


def test_changed_gas_is_solved_in_the_page(page, folder):
    page.goto((folder / "gas.html").as_uri())

    def cool():
        page.fill("#temperature", "30000 K")
        page.press("#temperature", "Enter")
        page.dispatch_event("#temperature", "change")

    before, after = change(page, cool)
    assert page.is_hidden("#problem"), page.text_content("#problem")
    assert np.abs(before.astype(int) - after).mean() > 1


def test_other_gas_is_solved_in_the_page(page, folder):
    page.goto((folder / "gas.html").as_uri())

    def denser():
        page.fill("#gas-density", f"3 * {page.input_value('#gas-density')}")
        page.dispatch_event("#gas-density", "change")

    await_picture(page, "final")
    before, after = change(page, denser)
    assert page.is_hidden("#problem"), page.text_content("#problem")
    assert np.abs(before.astype(int) - after).mean() > 1

    def wrong():
        page.fill("#gas-density", "3 * nothing")
        page.dispatch_event("#gas-density", "change")

    wrong()
    page.wait_for_selector("#problem:not([hidden])")
    assert "nothing" in page.text_content("#problem")


def test_packed_scenes_are_opened(page, address, folder):
    page.goto(address)
    await_picture(page)
    count = pictures(page)
    page.set_input_files("#file", folder / "gas.barnard")
    await_picture(page, "final", count)
    assert page.is_hidden("#problem"), page.text_content("#problem")
    assert "Ionised cloud" in page.title()
    damaged = bytearray((folder / "gas.barnard").read_bytes())
    damaged[len(damaged) // 2] ^= 255
    page.set_input_files("#file", {"name": "bad.barnard", "mimeType": "application/zip", "buffer": bytes(damaged)})
    page.wait_for_selector("#problem:not([hidden])")
    assert "bad.barnard" in page.text_content("#problem")


def test_addresses_of_scenes_are_opened(page, address, folder):
    page.route("**/there.barnard", lambda route: route.fulfill(path=folder / "six_stars.barnard"))
    page.goto(address + "?scene=there.barnard")
    await_picture(page)
    assert "Six stars" in page.title() or "six_stars" in page.title().lower(), page.title()
    page.route("**/there.toml", lambda route: route.fulfill(body=GAS))
    page.goto(address + "?scene=there.toml")
    await_picture(page)
    assert "Ionised cloud" in page.title()
