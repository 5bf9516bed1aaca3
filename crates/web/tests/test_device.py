"""Pictures of a graphics device: WebGPU in software, beside the program's own device."""

import subprocess

import numpy as np
import pytest
from conftest import CHROMIUM, browsers
from pictured import await_picture, pixels
from test_html import PROGRAM, Image

#: WebGPU by SwiftShader, which needs no graphics processor.
FLAGS = ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--enable-features=Vulkan", "--use-vulkan=swiftshader"]


@pytest.fixture(scope="module")
def device_page(address):
    with browsers.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", *FLAGS])
        page = chromium.new_page(viewport={"width": 460, "height": 200})
        page.goto(address)
        if not page.evaluate("async () => Boolean(await navigator.gpu?.requestAdapter())"):
            pytest.skip("NOT CHECKED: this Chromium has no WebGPU in software")
        yield page
        chromium.close()


@pytest.mark.parametrize("scene", ["barres_neyret", "six_stars"])
def test_pictures_are_those_of_the_programs_device(device_page, address, tmp_path, scene):
    device_page.goto(f"{address}?builtin={scene}&device=webgpu")
    await_picture(device_page, "final")
    assert "gpu" in device_page.text_content("#status")
    shown = pixels(device_page)[..., :3].astype(int)
    height, width, _ = shown.shape
    path = tmp_path / "device.png"
    arguments = ["render", "--builtin", scene, "--size", f"{width}x{height}", "--backend", "gpu", "-o", path]
    made = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True)
    if "no graphics adapter" in made.stderr or "-F gpu" in made.stderr:
        pytest.skip("NOT CHECKED: the program has no device (Mesa's mesa-vulkan-drivers renders in software)")
    assert made.returncode == 0, made.stderr
    rendered = np.asarray(Image.open(path).convert("RGB")).astype(int)
    near = (np.abs(shown - rendered) <= 1).all(axis=2).mean()
    assert rendered.std() > 5 and near > 0.999, near
    assert (np.abs(shown - rendered[:, ::-1]) <= 1).all(axis=2).mean() < 0.9
