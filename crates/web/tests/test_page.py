"""The page in a real browser."""

import io
import tomllib
from pathlib import Path

import numpy as np
import pytest
from pictured import await_picture, change, pictures, pixels

fits = pytest.importorskip("astropy.io.fits")
#: Texts of built-in scenes.
SCENES = Path(__file__).parents[2] / "files" / "scenes"


def test_a_scene_is_painted_dragged_and_recoloured(page, address):
    page.goto(address + "?builtin=barres_neyret")
    await_picture(page)
    assert pixels(page)[..., :3].std() > 5

    def drag():
        box = page.locator("#canvas").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + box["width"] / 4, y + 10, steps=4)
        page.mouse.up()

    before, after = change(page, drag)
    assert np.abs(before.astype(int) - after).mean() > 1
    # Home is where it was, by the levels of the first picture.
    _, again = change(page, lambda: page.click("#home"))
    assert np.array_equal(before, again)
    home, other = change(page, lambda: page.select_option("#filters", "sdss"))
    assert np.abs(home.astype(int) - other).mean() > 0.3
    assert page.input_value("#filters") == "sdss"
    change(page, lambda: page.click("#undo"))
    assert page.input_value("#filters") != "sdss"


def test_texts_are_checked_as_by_the_program(page, address):
    page.goto(address + "?builtin=six_stars")
    await_picture(page)
    page.click("#text-button")
    page.wait_for_function("() => document.getElementById('text').value.includes('[camera]')")
    text = page.input_value("#text")
    page.fill("#text", text.replace("temperature =", "temprature =", 1))
    page.click("#apply")
    page.wait_for_function("() => document.getElementById('text-problem').textContent !== ''")
    assert "temperature" in page.text_content("#text-problem")
    page.fill("#text", text.replace('"35000 K"', '"3500 K"', 1))
    page.click("#apply")
    page.wait_for_function("() => document.getElementById('text-problem').textContent === ''")
    page.click("#close-editor")
    page.wait_for_function("() => document.getElementById('temperature').value === '3500 K'")


def test_pictures_are_saved_and_read_by_astropy(page, address, tmp_path):
    page.goto(address + "?builtin=barres_neyret")
    await_picture(page, "final")
    with page.expect_download() as download:
        page.click("[data-save=fits]")
    path = tmp_path / "picture.fits"
    download.value.save_as(path)
    with fits.open(io.BytesIO(path.read_bytes())) as hdus:
        hdus.verify("exception")
        data = next(hdu.data for hdu in hdus if hdu.data is not None)
        assert data.shape[-1] == pixels(page).shape[1] and np.isfinite(data).all() and data.max() > 0
    page.hover("#canvas")
    page.wait_for_function("() => document.getElementById('probe').textContent.includes('W m')")


def test_all_built_in_scenes_are_shown(page, address):
    page.goto(address)
    await_picture(page)
    names = page.eval_on_selector_all("#scenes button", "buttons => buttons.map(b => b.childNodes[1].textContent)")
    for name in names:
        count = pictures(page)
        page.click("#gallery-button")
        page.click(f"#scenes button:has-text('{name}')")
        await_picture(page, after=count)
        page.wait_for_function("name => new URLSearchParams(location.search).get('builtin') === name", arg=name)
        # The title is the name that the scene's own text states.
        title = tomllib.loads((SCENES / f"{name}.toml").read_text())["name"]
        page.wait_for_function("title => document.title.startsWith(title)", arg=title)
        assert page.is_hidden("#problem"), page.text_content("#problem")
        assert pixels(page)[..., :3].max() > 40, name


def test_volumes_are_dropped(page, address, tmp_path):
    page.goto(address)
    await_picture(page)
    z, y, x = np.mgrid[-1:1:24j, -1:1:24j, -1:1:24j]
    np.save(tmp_path / "ball.npy", np.exp(-4 * (x**2 + y**2 + z**2)).astype(np.float32))
    count = pictures(page)
    page.set_input_files("#file", tmp_path / "ball.npy")
    await_picture(page, "final", count)
    assert page.is_hidden("#problem"), page.text_content("#problem")
    assert "ball" in page.title()


def test_controls_have_names(page, address):
    page.goto(address)
    await_picture(page)
    nameless = page.evaluate(
        """() => [...document.querySelectorAll('button, input, select, textarea, canvas')].filter(e => !(
            e.ariaLabel || e.labels?.length || e.textContent.trim() || e.title)).map(e => e.outerHTML)"""
    )
    assert nameless == []


def test_a_page_without_an_engine_says_so(browser, address):
    page = browser.new_page()
    page.route("**/barnard_bg.wasm", lambda route: route.fulfill(status=200, body=b"no engine"))
    page.goto(address)
    page.wait_for_selector("#problem:not([hidden])")
    assert "cannot start" in page.text_content("#problem")
    page.close()
