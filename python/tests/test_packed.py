"""Packed scenes, and pages with them."""

import base64
import io
import re
import subprocess
import sys
import zipfile

import numpy as np
import pytest

import barnard as bn

MARKS = "<title>Barnard</title><!-- preview --><!-- scene -->"


@pytest.fixture
def page(tmp_path, monkeypatch):
    """A page with the marks of the explorer's."""
    path = tmp_path / "barnard.html"
    path.write_text(MARKS)
    monkeypatch.setenv("BARNARD_PAGE", str(path))


def text_of(html):
    """The text of the scene in a page."""
    packed = base64.b64decode(re.search(r'id="barnard-bundle"[^>]*>([^<]*)<', html)[1])
    return zipfile.ZipFile(io.BytesIO(packed)).read("scene.toml").decode()


def test_packed_scenes_show_their_scene(scene, tmp_path):
    heard = []
    scene.save(tmp_path / "cloud.barnard", progress=lambda *step: heard.append(step))
    assert heard and (tmp_path / "cloud.barnard").stat().st_size < 4e6
    subprocess.run([sys.executable, "-m", "barnard", "render", "cloud.barnard", "-o", "cloud.npy"], cwd=tmp_path, check=True, capture_output=True)
    packed, whole = np.load(tmp_path / "cloud.npy"), scene.render().radiance
    error = np.sqrt(np.mean((packed - whole) ** 2) / np.mean(whole**2))
    assert 1e-5 < error < 0.01, error
    with pytest.raises(bn.SceneError, match="packed scene"):
        bn.Scene.from_toml(tmp_path / "cloud.barnard")
    with pytest.raises(bn.SceneError, match="limit"):
        scene.save(tmp_path / "other.barnard", limit=0)
    with pytest.raises(bn.BarnardError, match="MB"):
        scene.save(tmp_path / "other.barnard", limit=0.001)
    assert not (tmp_path / "other.barnard").exists()


def test_pages_have_the_scene_and_the_view(scene, page, tmp_path):
    scene.name = 'A <cloud> & "more"'
    html = scene.to_html(tmp_path / "cloud.html")
    assert (tmp_path / "cloud.html").read_text(encoding="utf-8") == html
    assert "<title>A &lt;cloud&gt; &amp; &quot;more&quot;</title>" in html and "data:image/jpeg" in html
    assert 'position = "0 0 4 pc"' in text_of(html)
    image = scene.render(bn.PerspectiveCamera("1 0 4 pc", "32 deg", size=24))
    assert 'position = "1 0 4 pc"' in text_of(image.to_html())
    with pytest.raises(bn.SceneError, match="must end with .html"):
        scene.to_html(tmp_path / "cloud.txt")


def test_other_pages_are_refused(scene, page, tmp_path, monkeypatch):
    (tmp_path / "barnard.html").write_text("<title>Another</title>")
    with pytest.raises(bn.BarnardError, match="no mark"):
        scene.to_html()
