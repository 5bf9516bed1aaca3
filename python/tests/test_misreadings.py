"""Inputs that were once misread without a word: each is right now, or refused with its place and a remedy."""

import pickle
import warnings
from concurrent.futures import ThreadPoolExecutor

import astropy.units as u
import numpy as np
import pytest
from astropy.utils.masked import Masked

import barnard as bn
from conftest import cloud, lit

BOX = {"low": "-1 -1 -1 pc", "high": "1 1 1 pc"}


def labelled(values=None, **attributes):
    xarray = pytest.importorskip("xarray")
    values = cloud() if values is None else values
    places = {axis: (np.arange(n) + 0.5) * 2 / n - 1 for axis, n in zip("xyz", values.shape)}
    return xarray.DataArray(values, dims=("x", "y", "z"), coords=places, attrs=attributes)


def test_labels_of_xarray_are_followed():
    values = cloud() * np.linspace(1, 2, 24, dtype=np.float32)[:, None, None]
    expected = lit(values).render().radiance
    array = labelled(values)
    for same in (array, array.isel(y=slice(None, None, -1)), array.transpose("z", "y", "x"), array.transpose("y", "z", "x").isel(x=slice(None, None, -1))):
        assert np.array_equal(lit(same).render().radiance, expected)
    # What was read without labels is another cloud.
    assert not np.array_equal(lit(array.transpose("z", "y", "x").values).render().radiance, expected)


def test_units_and_boxes_of_xarray_are_followed():
    array = labelled(units="m-3")
    for axis in "xyz":
        array[axis].attrs["units"] = "pc"
    grid = bn.Grid(array)
    assert grid.unit == "m-3"
    assert [float(v) for v in f"{grid.low} {grid.high}".replace("pc", "").split()] == pytest.approx([-1] * 3 + [1] * 3)
    for change, words in (
        (lambda a: a.rename(x="u"), "rename them to x, y and z"),
        (lambda a: a.assign_attrs(units="furlong"), "furlong"),
        (lambda a: a.assign_coords(x=np.arange(24.0) ** 2), "not uniform"),
    ):
        with pytest.raises(bn.SceneError, match=words):
            bn.Grid(change(array))


@pytest.mark.parametrize("mask", [np.ma.masked_less, lambda a, least: Masked(a, a < least)], ids=["numpy", "astropy"])
def test_masked_values_are_clipped_on_request(mask):
    values = mask(cloud(), 0.5)
    with pytest.raises(bn.SceneError, match="clip=True"):
        bn.Grid(values, **BOX)
    assert np.array_equal(bn.Grid(values, **BOX, clip=True).values, np.where(cloud() < 0.5, 0, cloud()))


def test_failures_leave_arrays_as_they_were():
    values = np.ones((4, 4, 4), np.float32)
    with pytest.raises(bn.SceneError):
        bn.Grid(values, low=[1, 2, 3], high="1 1 1 pc")
    assert values.flags.writeable


def test_radiances_of_two_bands_have_no_passband():
    image = lit(cloud()).render()
    b, v = image["B"], image["V"]
    assert (v + v).to("MJy/sr").max() == 2 * v.to("MJy/sr").max()
    for mixed in (b + v, v + b, np.concatenate([v, b]), np.maximum(b, v)):
        with pytest.raises(u.UnitConversionError):
            mixed.to("MJy/sr")
    again = pickle.loads(pickle.dumps(v))
    assert np.array_equal(again.to_value("MJy/sr"), v.to_value("MJy/sr")) and type(again) is type(v)
    assert "V" in image and "johnson-V" in image and "K" not in image
    with pytest.raises(ValueError, match="read-only"):
        image.radiance[:] = 0


def test_coordinates_index_the_arrays():
    """A star at (1, 0.7) pc before an eye at 10 pc: to the right of the middle and above it."""
    star = bn.Star("1 0.7 0 pc", temperature="9000 K", luminosity="10 Lsun")
    camera = bn.PerspectiveCamera("0 0 10 pc", "20 deg", size=(60, 40))
    image = bn.Scene(bands=["johnson-V"], camera=camera, stars=[star], observation=bn.Observation(target="83.8 -5.4")).render()
    row, column = np.unravel_index(image["V"].value.argmax(), image.shape[1:])
    assert row < 20 and column > 30
    place = image.wcs.pixel_to_world(column, row)
    # East is to the left: 0.1 rad to the right and 0.07 rad upwards in the plane of the sky.
    east, north = -np.tan(np.radians((place.ra.deg - 83.8) * np.cos(np.radians(-5.4)))), place.dec.deg + 5.4
    assert abs(east - 0.1) < 0.008 and abs(north - np.degrees(0.07)) < 0.4


def means(images):
    return [float(image["V"].mean().value) for image in images]


def test_sweeps_leave_the_scene_alone():
    temperatures, scales = [5e3, 9e3] * u.K, [1, 9] * u.mag / u.pc
    scene = lit(cloud())
    before, alone = scene._tree(), means(scene.sweep({"dust.scale": scales}))
    zipped = means(b for _, b in zip(scene.sweep({"star[0].temperature": temperatures}), scene.sweep({"dust.scale": scales})))
    assert zipped == alone and scene._tree() == before
    half = scene.sweep({"star[0].temperature": temperatures})
    next(half)
    assert scene._tree() == before
    ways = (temperatures, temperatures[::-1])
    with ThreadPoolExecutor(2) as pool:
        first, second = pool.map(lambda values: means(scene.sweep({"star[0].temperature": values})), ways)
    assert first == second[::-1] and first[0] != first[1] and scene._tree() == before


def test_missed_accuracies_are_told_once():
    scene = lit(cloud())
    scene.method = bn.Method(accuracy=1e-6, steps=4)
    with pytest.warns(bn.AccuracyWarning, match="requested accuracy 1.0e-06") as told:
        image = scene.render()
    assert [warning.filename for warning in told] == [__file__]
    assert any("spatial error" in words for words in image.warnings)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene.render()


def test_nothing_is_planned_twice():
    scene = lit(cloud())
    plan = scene.plan()
    assert scene.plan() is plan
    scene.stars[0].temperature = "9000 K"
    assert scene.plan() is not plan


@pytest.mark.parametrize(
    "wrong, words",
    [
        (lambda: bn.Scene(stars=bn.Star("0 0 0 pc", temperature="5000 K", luminosity="1 Lsun")), "list of tables"),
        (lambda: setattr(lit(cloud()), "stars", bn.Star("0 0 0 pc", temperature="5000 K", luminosity="1 Lsun")), "list of tables"),
        (lambda: bn.Scene(star=[]), "stars"),
        (lambda: list(lit(cloud()).sweep({"dust.albedo": 0.5})), "single value"),
        (lambda: bn.Scene(bands="V", camera=lit(cloud()).camera).check(), "johnson-V"),
    ],
)
def test_mistakes_are_told_with_a_remedy(wrong, words):
    with pytest.raises(bn.SceneError, match=words):
        wrong()


def test_plain_numbers_may_be_quantities():
    assert bn.Dust("n", scale="1 /pc", albedo=0.5 * u.dimensionless_unscaled).tree()["albedo"] == 0.5
    with pytest.raises(ValueError, match="4096"):
        bn.set_threads(-1)
