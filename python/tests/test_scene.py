"""Scenes in Python are the scenes of files: the same keys, the same bits, errors that name the key."""

import copy
import inspect
import pickle
import re
import subprocess
import sys

import astropy.units as u
import numpy as np
import pytest

import barnard as bn
from barnard import tables
from barnard._rows import ROWS
from conftest import cloud, lit


def command(*arguments: str, **options):
    return subprocess.run([sys.executable, "-m", "barnard", *arguments], capture_output=True, text=True, **options)


@pytest.mark.parametrize("name", bn.catalogue("scenes"))
def test_builtin_scenes_round_trip(name):
    scene = bn.Scene.builtin(name)
    again = bn.Scene.from_toml(scene.to_toml())
    assert again == scene
    assert again.to_toml() == scene.to_toml()
    again.camera.supersampling = 2
    assert again != scene


def test_the_command_makes_the_same_bits(tmp_path, scene):
    scene.save(tmp_path / "scene.toml")
    done = command("render", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "out.npy"))
    assert done.returncode == 0, done.stderr
    theirs = np.load(tmp_path / "out.npy")
    ours = scene.render().radiance
    assert ours.dtype == theirs.dtype == np.float32 and ours.max() > 0
    assert np.array_equal(ours, theirs)
    # A scene that differs is told.
    scene.dust.albedo = 0.61
    assert not np.array_equal(scene.render().radiance, theirs)


def test_saved_scenes_are_read_as_they_were(tmp_path, scene):
    scene.save(tmp_path / "scene.toml")
    again = bn.Scene.from_toml(tmp_path / "scene.toml")
    assert np.array_equal(again.render().radiance, scene.render().radiance)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["scene.toml", "scene_cloud.npy"]
    with pytest.raises(bn.SceneError, match="save"):
        scene.to_toml()


def test_pickles_are_the_same_scene(scene):
    again = pickle.loads(pickle.dumps(scene))
    assert again == scene
    assert np.array_equal(again.render().radiance, scene.render().radiance)


def test_pickles_of_another_version_are_refused(scene):
    state = scene.__getstate__()
    with pytest.raises(bn.BarnardError, match="0.0.1"):
        bn.Scene.__new__(bn.Scene).__setstate__({**state, "version": "0.0.1"})


WRONG = [
    (lambda s: setattr(s.stars[0], "temperature", "-3 K"), "star[0].temperature"),
    (lambda s: setattr(s.dust, "law", "ccm98"), "dust.law"),
    (lambda s: setattr(s.dust, "density", "clod"), "dust.density"),
    (lambda s: setattr(s, "bands", "jonson"), "bands"),
    (lambda s: setattr(s.camera, "field_of_view", "190 deg"), "camera.field_of_view"),
    (lambda s: setattr(s.camera, "size", [0, 10]), "camera.size"),
    (lambda s: setattr(s, "camera", None), "camera"),
    (lambda s: s.stars.append({"kind": "blackbody"}), "star[1]"),
    (lambda s: s.stars.append(bn.Star("0 0 0 pc", kind="blackbody", luminosity="1 Lsun")), "star[1].temperature"),
    (lambda s: setattr(s, "method", {"accuracy": 7.0}), "method.accuracy"),
    (lambda s: setattr(s, "method", {"name": "magic"}), "method.name"),
    (lambda s: s.fields.update(other=np.ones((3, 3, 3))), "field.other"),
    (lambda s: s.passbands.append(bn.Band("top_hat", name="x", centre="500 nm", width="-1 nm")), "band[0].width"),
]


@pytest.mark.parametrize("change, key", WRONG, ids=[key for _, key in WRONG])
def test_errors_name_the_key(scene, change, key):
    with pytest.raises(bn.SceneError) as caught:
        change(scene)
        scene.check()
    assert caught.value.key.startswith(key), caught.value


SAID_WRONG = [
    (lambda: bn.Star([0, 0, 0]), "star.position", "unit"),
    (lambda: bn.Star("0 0 0 pc", temperature=39e3), "star.temperature", "39000"),
    (lambda: bn.Star("0 0 0 pc", temperatur="39000 K"), "star.temperatur", "did you mean"),
    (lambda: bn.Star("0 0 0 pc", kind="blackbod"), "star.kind", "blackbody"),
    (lambda: bn.PerspectiveCamera("0 0 4 pc", "30 deg", sise=3), "camera.sise", "size"),
    (lambda: bn.Scene(dust=3), "dust", "dictionary"),
    (lambda: setattr(bn.Scene(), "dst", None), "dst", "dust"),
    (lambda: bn.Scene(memory=-1), "memory", "GiB"),
]


@pytest.mark.parametrize("make, key, words", SAID_WRONG, ids=[key for _, key, _ in SAID_WRONG])
def test_errors_come_when_a_key_is_said(make, key, words):
    with pytest.raises(bn.SceneError, match=words) as caught:
        make()
    assert caught.value.key == key


def test_what_a_file_says_wrong_has_its_line():
    with pytest.raises(bn.SceneError, match="scene:2"):
        bn.Scene.from_toml("bands = 'johnson'\n= 3\n")
    with pytest.raises(bn.SceneError, match="cannot be read"):
        bn.Scene.from_toml("/no/such/scene.toml")
    with pytest.raises(bn.SceneError, match="cameras.*camera"):
        bn.Scene.from_toml("bands = 'johnson'\n[cameras]\n")


def test_the_command_comes_along(tmp_path):
    done = command("list", "passband-sets")
    assert done.returncode == 0 and "johnson" in done.stdout
    done = command("render", "--builtin", "nothing", "-o", str(tmp_path / "x.png"))
    assert done.returncode == 1 and "pleiades" in done.stderr
    assert command("rendr").returncode == 2


def test_fields_may_be_formulas_and_files(tmp_path, scene):
    np.save(tmp_path / "cloud.npy", cloud())
    of_file = bn.Scene(bands="johnson", camera=scene.camera, dust=scene.dust, stars=scene.stars, folder=tmp_path)
    of_file.fields["cloud"] = bn.Grid("cloud.npy", low="-1 -1 -1 pc", high="1 1 1 pc")
    assert np.array_equal(of_file.render().radiance, scene.render().radiance)
    scene.fields["ball"] = bn.Sphere("0.5 pc")
    scene.dust.density = "cloud * ball"
    assert 0 < scene.render()["V"].max()


def test_a_tables_keys_are_its_attributes(scene):
    star = scene.stars[0]
    assert star.temperature == "12000 K" and star.kind == "blackbody" and star.radius is None
    star.temperature = None
    assert "temperature" not in star.tree()
    with pytest.raises(AttributeError):
        star.temperatur
    assert "temperature" in dir(star) and "Star(" in repr(star)


def test_tables_within_tables_may_be_changed(scene):
    scene.dust.phase = bn.Phase("henyey_greenstein", g=0.5)
    before = scene.render().radiance
    scene.dust.phase.g = 0.9
    assert scene._tree()["dust"]["phase"] == {"kind": "henyey_greenstein", "g": 0.9}
    assert not np.array_equal(scene.render().radiance, before)
    # A dictionary becomes the same table, and a file's table too.
    scene.dust.phase = {"kind": "henyey_greenstein", "g": 0.5}
    assert scene.dust.phase == bn.Phase("henyey_greenstein", g=0.5)
    assert np.array_equal(scene.render().radiance, before)
    again = bn.Scene.from_toml(bn.Scene(bands="johnson", dust=scene.dust).to_toml())
    again.dust.phase.g = 0.1
    assert "0.1" in again.to_toml()
    with pytest.raises(bn.SceneError, match="dust.phase.gg"):
        scene.dust.phase = {"kind": "henyey_greenstein", "gg": 0.5}


def test_kinds_are_classes():
    phase = bn.HenyeyGreensteinPhase(g=0.5)
    assert isinstance(phase, bn.Phase) and phase == bn.Phase("henyey_greenstein", g=0.5) != bn.Phase("draine")
    assert phase.kind == "henyey_greenstein" and repr(phase) == "HenyeyGreensteinPhase(g=0.5)"
    with pytest.raises(bn.SceneError, match="dust.phase.alpha"):
        bn.HenyeyGreensteinPhase(alpha=1.0)
    with pytest.raises(TypeError, match="field_of_view"):
        bn.PerspectiveCamera("0 0 5 pc")
    camera = bn.PerspectiveCamera("0 0 5 pc", "30 deg")
    star = bn.BlackbodyStar("0 0 1 pc", "9000 K", luminosity="10 Lsun")
    scene = bn.Scene(camera=camera, stars=[star], dust=bn.Dust("n", "1 /pc", albedo=0.5, phase=phase), fields={"n": bn.Sphere("1 pc")})
    again = bn.Scene.from_toml(scene.to_toml())
    assert again == scene == copy.copy(scene) == pickle.loads(pickle.dumps(scene)) and again.stars[0] == star
    with pytest.deprecated_call(match="use PerspectiveCamera"):
        assert bn.perspective("0 0 5 pc", "30 deg") == camera
    assert pickle.loads(pickle.dumps(bn.perspective)) is bn.perspective and "field_of_view" in inspect.signature(bn.perspective).parameters
    camera.kind = "perspective"
    with pytest.raises(bn.SceneError, match="PerspectiveCamera is of the kind 'perspective'"):
        camera.kind = "fisheye"
    assert bn.HenyeyGreensteinPhase.of({"g": 0.5}) == phase and bn.BlackbodyStar.of({"kind": "blackbody"}) == bn.BlackbodyStar.of({})
    # Every kind of every table has a class, whose keys are those of the kind. Bookmarks are cameras.
    classes = [cls for name in tables.__all__ if isinstance(cls := getattr(bn, name), type)]
    for row in [row for row in ROWS.values() if row.path != "bookmark.*"]:
        for kind in row.kinds:
            (cls,) = (cls for cls in classes if (cls._path, cls._kind) == (row.path, kind))
            assert set(inspect.signature(cls).parameters) - {"copy"} == set(row.all_keys(kind)), cls


def test_values_changed_in_place_are_heard():
    position = np.array([1.0, 0.0, 0.0]) * u.pc
    star = bn.Star(position, temperature="12000 K")
    star.position[0] = 2 * u.pc
    assert star.tree()["position"] == "2.0 0.0 0.0 pc"
    star.position += 1 * u.pc
    assert star.tree()["position"] == "3.0 1.0 1.0 pc"
    emission = bn.Emission("lines", density="gas", lines=[{"wavelength": "656.3 nm", "strength": 1.0}])
    emission.lines[0]["strength"] = 2.0
    assert emission.tree()["lines"][0]["strength"] == 2.0
    star.position[0] = np.nan * u.pc
    assert star.tree()["position"].startswith("nan")


def test_lit_scenes_differ_by_their_density():
    assert not np.array_equal(lit(cloud()).render().radiance, lit(2 * cloud()).render().radiance)


def test_scenes_pass_type_checkers(tmp_path):
    """Keys of parts are set without a check for None; a wrong keyword or type is an error."""
    pytest.importorskip("mypy")
    script = tmp_path / "use.py"
    script.write_text(
        "import barnard as bn\n"
        'scene = bn.Scene(dust={"density": "1", "scale": "1 /pc"})\n'
        'scene.dust.scale = "3 mag/pc"\n'
        'scene.background = {"stars": {"density": "2500 /deg2"}}\n'
        "scene.camera.size = (8, 8)\n"
        "wrong: int = scene.render().shape\n"
        'bn.Star(positon="0 0 0 pc")\n'
    )
    command = [sys.executable, "-m", "mypy", "--ignore-missing-imports", "--cache-dir", str(tmp_path / "cache"), str(script)]
    found = subprocess.run(command, capture_output=True, text=True).stdout
    assert [line for line in found.splitlines() if "error:" in line and "use.py:" not in line] == []
    assert sorted(int(line) for line in re.findall(r"use\.py:(\d+): error", found)) == [6, 7], found
