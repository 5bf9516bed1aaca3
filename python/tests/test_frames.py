"""Frames of scenes that change."""

import pickle
import re
from pathlib import Path

import astropy.units as u
import numpy as np
import pytest

import barnard as bn
from conftest import cloud, flight, lit


def test_frames_are_those_of_the_command(tmp_path):
    scene = flight()
    frames = scene.frames()
    assert frames.numbers == range(100, 111) and len(frames) == 11 and frames.time(105) == 0.5
    images = {number: frames.render(number) for number in (100, 107)}
    scene.save(tmp_path / "flight.toml")
    from barnard import _barnard

    command = ["barnard", "render", str(tmp_path / "flight.toml"), "-o", str(tmp_path / "f_%d.npy"), "--frames", "100,107"]
    assert _barnard.run(command) == 0
    for number, image in images.items():
        assert np.array_equal(np.load(tmp_path / f"f_{number}.npy"), np.asarray(image.radiance))
    assert not np.array_equal(images[100].radiance, images[107].radiance)


def test_frames_travel():
    frames = flight().frames()
    there = pickle.loads(pickle.dumps(frames))
    assert np.array_equal(there.render(103).radiance, frames.render(103).radiance)
    # The reference goes by the same scene.
    exact = frames.render(103, backend="reference", accuracy=1e-3)
    assert np.allclose(exact.radiance, frames.render(103).radiance, rtol=0.05, atol=float(exact.radiance.max()) * 0.01)


def test_frames_are_refused_where_their_scene_has_changed():
    scene = flight()
    frames = scene.frames()
    scene.stars[0].luminosity = "1 Lsun"
    with pytest.raises(bn.PlanError, match="changed since"):
        frames.render(103)
    with pytest.raises(bn.PlanError):
        pickle.dumps(frames)


def test_threads_may_share_frames():
    from concurrent.futures import ThreadPoolExecutor

    frames = flight().frames()
    with ThreadPoolExecutor(4) as pool:
        images = list(pool.map(frames.render, [100, 104, 102, 104, 106]))
    assert np.array_equal(images[1].radiance, images[3].radiance)
    assert np.array_equal(images[2].radiance, flight().frames().render(102).radiance)


def test_a_scene_file_says_the_same(tmp_path):
    scene = flight()
    scene.save(tmp_path / "flight.toml")
    again = bn.Scene.from_toml(tmp_path / "flight.toml")
    assert np.array_equal(again.frames().render(104).radiance, scene.frames().render(104).radiance)
    # A still is the first moment.
    assert np.array_equal(scene.render().radiance.shape, (3, 16, 24))


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda s: setattr(s, "animation", [bn.Animation("star[4].temperature", [0, 1] * u.s, [1, 2] * u.K)]), "star[4]"),
        (lambda s: setattr(s, "animation", [bn.Animation("star[0].temperature", [1, 0] * u.s, [1, 2] * u.K)]), "ascend"),
        (lambda s: setattr(s.camera, "path", bn.CameraPath(key=[bn.Keyframe("0 s", position="0 0 5 pc")])), "one key"),
    ],
)
def test_wrong_changes_are_told(change, words):
    scene = flight()
    change(scene)
    with pytest.raises(bn.SceneError) as caught:
        scene.frames()
    assert words in str(caught.value)


def test_what_stands_still_has_no_frames():
    with pytest.raises(bn.BarnardError, match="timeline"):
        lit(cloud()).frames()
    frames = flight().frames()
    with pytest.raises(bn.BarnardError, match="between 100 and 110"):
        frames.render(7)
    with pytest.raises(bn.SceneError, match="not a time"):
        bn.Animation("star[0].temperature", [0, 1] * u.m, [1, 2] * u.K)


def test_two_eyes_are_one_picture():
    scene = flight()
    scene.camera.stereo = bn.Stereo("0.2 pc")
    assert scene.render().radiance.shape == (3, 32, 24)
    assert scene.frames().render(101).radiance.shape == (3, 32, 24)


def test_the_template_of_open_job_description_is_one():
    """The template of docs/shows.md, by the schema of the specification."""
    model = pytest.importorskip("openjd.model", reason="NOT CHECKED: openjd-model is not installed")
    text = (Path(__file__).parents[2] / "docs" / "shows.md").read_text()
    template = model.document_string_to_object(document=re.search(r"```yaml\n(.*?)```", text, re.S)[1], document_type=model.DocumentType.YAML)
    job = model.decode_job_template(template=template)
    assert job.name == "barnard-flight" and len(job.steps) == 1
    template["steps"][0]["parameterSpace"]["taskParameterDefinitions"][0]["type"] = "NUMBER"
    with pytest.raises(model.DecodeValidationError):
        model.decode_job_template(template=template)
