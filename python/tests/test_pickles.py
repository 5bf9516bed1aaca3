"""Pictures, plates, exposures and fits go through pickles and copies as they are."""

import copy
import pickle
import re
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import barnard as bn
import numpy as np
import pytest
from conftest import cloud, flight, lit


def through(thing):
    return pickle.loads(pickle.dumps(thing))


def undated(fits: bytes) -> bytes:
    """A FITS file without the time at which it was written."""
    undated, count = re.subn(rb"DATE    = '[-0-9T:]{19}'", b"", fits)
    assert count == 1
    return undated


def same(one: bn.Image, other: bn.Image) -> None:
    """Two pictures are the same in all that people see of them."""
    assert one.bands == other.bands and one.radiance.dtype == other.radiance.dtype
    assert np.array_equal(one.radiance, other.radiance, equal_nan=True)
    assert list(one.layers) == list(other.layers)
    assert all(np.array_equal(one.layers[name], other.layers[name]) for name in one.layers)
    assert (one.keywords, one.notes, one.certificates, one.warnings) == (other.keywords, other.notes, other.certificates, other.warnings)
    assert one.parameters == other.parameters and one.png() == other.png()
    assert undated(one._native.encode("fits")) == undated(other._native.encode("fits"))
    assert one._native.encode("exr") == other._native.encode("exr")


def scene_of_layers() -> bn.Scene:
    scene = lit(cloud())
    scene.camera = bn.PerspectiveCamera("0 0 4 pc", "32 deg", size=[24, 16], crop=[2, 3, 12, 9])
    scene.observation = bn.Observation("83.82 -5.39", unit="mag/arcsec2 AB")
    scene.output = bn.Output(layers="all")
    scene.display = bn.Display(palette="natural", stretch="log")
    return scene


def test_pictures_pickle_without_their_volumes():
    picture = scene_of_layers().render()
    for twin in (through(picture), copy.copy(picture), copy.deepcopy(picture), through(through(picture))):
        same(picture, twin)
        assert np.array_equal(picture["V"].value, twin["V"].value) and twin["V"].to("MJy/sr").unit == "MJy/sr"
        assert np.array_equal(picture.rgb(stretch="linear"), twin.rgb(stretch="linear"))
    # A grid of a megabyte is no part of them.
    big = lit(cloud(64))
    big.camera = bn.PerspectiveCamera("0 0 4 pc", "32 deg", size=8)
    assert len(pickle.dumps(big.render())) < 50_000


def test_pictures_of_all_kinds_pickle():
    scene = lit(cloud(12))
    scene.camera = bn.PerspectiveCamera("0 0 4 pc", "32 deg", size=8)
    same(*[each(scene.render(backend="reference")) for each in (lambda image: image, through)])
    paths = scene.render(backend="path", samples=4, seed=1)
    same(paths, through(paths))
    # Levels that hold for all frames of a film are kept.
    frames = flight().frames()
    frame = frames.render(frames.numbers[3])
    same(frame, through(frame))
    swept = next(iter(scene.sweep({"dust.scale": ["1 /pc", "2 /pc"]})))
    same(swept, through(swept))
    assert through(swept).parameters == swept.parameters != {}


def test_plates_exposures_and_fits_pickle():
    scene = lit(cloud(12))
    scene.camera = bn.PerspectiveCamera("0 0 1000 pc", "0.12 deg", size=12)
    plates = scene.plates()
    same(plates.expose(scene), through(plates).expose(scene))
    scene.instrument = bn.Instrument(aperture="0.5 m", read_noise="4 e", sky="21.5 mag", exposure="0.02 s", frames=3)
    for exposures in (scene.render().observe(), scene.render().observe(bn.Instrument(aperture="1 m", sky="21.5 mag", frames=2))):
        twin = through(exposures)
        assert len(twin) == len(exposures)
        assert all(np.array_equal(twin.frame(1)[band], frame) for band, frame in exposures.frame(1).items())
        same(exposures.master(), twin.master())
        same(exposures.master(), through(exposures.master()))
    fit = scene.fit(["star[0].luminosity"], scene.render().observe().master())
    twin = through(fit)
    assert 0.8 < fit.chi2 / fit.freedom < 1.2
    assert twin.values == fit.values and np.array_equal(twin.covariance, fit.covariance) and repr(twin) == repr(fit)
    same(fit.residuals[0], twin.residuals[0])


def luminous(model, value: float) -> float:
    return model.log_likelihood([value])


def test_models_work_in_processes():
    scene = lit(cloud(12))
    scene.camera = bn.PerspectiveCamera("0 0 4 pc", "32 deg", size=8)
    data = scene.render().radiance
    model = scene.fit_model(["star[0].luminosity"], data, sigma=1e-9)
    places = [900.0, 1000.0, 1100.0]
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        assert list(pool.map(luminous, [model] * 3, places)) == [luminous(model, place) for place in places]


def test_a_pickle_of_another_version_is_refused(monkeypatch):
    scene = lit(cloud(12))
    scene.camera = bn.PerspectiveCamera("0 0 4 pc", "32 deg", size=8)
    pickled = pickle.dumps(scene.render())
    monkeypatch.setattr("barnard._barnard.__version__", "99")
    with pytest.raises(bn.BarnardError, match="pickled by barnard"):
        pickle.loads(pickled)
