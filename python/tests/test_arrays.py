"""Arrays of any float type, order and stride are the same field; those that no density can be are refused."""

import astropy.units as u
import numpy as np
import pytest

import barnard as bn
from conftest import cloud, lit

SAME = {
    "float64": lambda a: a.astype(np.float64),
    "longdouble": lambda a: a.astype(np.longdouble),
    "big-endian": lambda a: a.astype(">f4"),
    "Fortran order": np.asfortranarray,
    "strided": lambda a: np.repeat(a, 2, axis=1)[:, ::2],
    "backwards": lambda a: a[::-1, :, ::-1].copy()[::-1, :, ::-1],
    "read-only": lambda a: np.frombuffer(a.tobytes(), np.float32).reshape(a.shape),
    "dimensionless": lambda a: u.Quantity(a, ""),
    "cm-3": lambda a: a / u.cm**3,
    "unmasked": np.ma.masked_array,
}


@pytest.mark.parametrize("make", SAME.values(), ids=SAME)
def test_arrays_are_the_same_field(make):
    expected = lit(cloud()).render().radiance
    assert np.array_equal(lit(make(cloud())).render().radiance, expected)


def test_float16_and_integers_are_taken():
    half = cloud().astype(np.float16)
    assert np.array_equal(lit(half).render().radiance, lit(half.astype(np.float32)).render().radiance)
    whole = (100 * cloud()).astype(np.int64)
    assert np.array_equal(lit(whole).render().radiance, lit(whole.astype(np.float64)).render().radiance)


def test_axes_say_which_is_which():
    turned = lit(cloud().transpose(2, 1, 0), axes="zyx").render().radiance
    assert np.array_equal(turned, lit(cloud()).render().radiance)
    assert not np.array_equal(lit(cloud().transpose(2, 1, 0)).render().radiance, turned)


def test_number_densities_are_in_their_unit():
    cubic_metres = lit(cloud() / u.m**3, factor=1e6).render().radiance
    assert np.allclose(cubic_metres, lit(cloud()).render().radiance, rtol=1e-5)


def not_finite(value):
    values = cloud()
    values[3, 4, 5] = value
    return values


REFUSED = [
    (lambda: np.ones((4, 4), np.float32), "2 axes"),
    (lambda: np.ones((4, 0, 4), np.float32), "empty"),
    (lambda: np.ones((4, 4, 4), np.complex64), "real"),
    (lambda: np.full((4, 4, 4), None), "object"),
    (lambda: np.full((4, 4, 4), "x"), "float32"),
    (lambda: np.ma.masked_less(cloud(), 0.5), "masked"),
    (lambda: cloud() * u.K, "not a .*density"),
    (lambda: cloud() * u.g / u.cm**3, "mass_per_h = 1.4"),
    (lambda: cloud() / u.km**3, r"cm\*\*-3"),
]


@pytest.mark.parametrize("make, words", REFUSED, ids=[words for _, words in REFUSED])
def test_what_is_no_density_is_refused(make, words):
    with pytest.raises(bn.SceneError, match=words):
        lit(make()).check()


@pytest.mark.parametrize("value, words", [(np.nan, "NaN"), (np.inf, "infinite"), (-1, "negative")])
def test_bad_values_are_told_with_their_place(value, words):
    with pytest.raises(bn.SceneError, match=rf"{words}.*\[3, 4, 5\]"):
        lit(not_finite(value)).check()


def test_arrays_are_shared_on_request_alone():
    values = np.asfortranarray(cloud())
    grid = bn.Grid(values, low="-1 -1 -1 pc", high="1 1 1 pc", copy=False)
    assert np.shares_memory(grid.values, values)
    # What is shared cannot be changed behind the back of a render.
    with pytest.raises(ValueError, match="read-only"):
        values[0, 0, 0] = 1
    values = cloud()
    older = values.reshape(-1)
    grid = bn.Grid(values, low="-1 -1 -1 pc", high="1 1 1 pc")
    older[0] = values[0, 0, 0] = 1
    assert not np.shares_memory(grid.values, values) and grid.values[0, 0, 0] != 1


def test_views_of_what_can_be_changed_are_copied():
    values = np.zeros((48, 24, 24), np.float32)
    values[:24] = cloud()
    scene = lit(values[:24])
    before = scene.render().radiance
    values[:] = 7
    assert np.array_equal(lit(cloud()).render().radiance, before)
    assert np.array_equal(scene.render().radiance, before)


def test_a_limit_of_memory_is_kept():
    scene = lit(np.ones((64, 64, 64), np.float32))
    small = bn.Scene(bands="johnson", camera=scene.camera, dust=scene.dust, stars=scene.stars, fields=scene.fields, memory=1e-4)
    with pytest.raises(bn.MemoryLimitError, match="MiB"):
        small.check()


def test_units_of_quantities():
    star = bn.Star([0.2, 0.1, 0.3] * u.pc, temperature=39 * u.kK, luminosity=2e5 * u.Lsun)
    assert star.tree()["temperature"] == "39000.0 K"
    assert star.tree()["position"] == "0.2 0.1 0.3 pc"
    assert bn.Star([1 * u.pc, 1 * u.lyr, 0 * u.m], temperature="1 K").tree()["position"].startswith("1.0 0.306")
    assert bn.Dust("n", 5.32e-22 * u.mag * u.cm**2).tree()["scale"] == "5.32e-22 mag cm2"
    assert bn.Dust("n", 2 * u.mag / u.pc).tree()["scale"] == "2.0 mag/pc"
    assert bn.Background(kind="blackbody", radiance=1e-7 * u.W / u.m**2 / u.sr / u.um).tree()["radiance"] == "1e-07 W/m2/sr/um"
    with pytest.raises(bn.SceneError, match="not a length"):
        bn.Star([1, 2, 3] * u.K)
    with pytest.raises(bn.SceneError, match="shape"):
        bn.Star([1, 2] * u.pc)
    with pytest.raises(bn.SceneError, match="2 numbers"):
        bn.Star("0 0 0 pc", temperature=[1, 2] * u.K)


def test_units_of_every_quantity_are_read_by_astropy():
    from barnard._rows import QUANTITIES
    from barnard._values import spelled, units_of

    for quantity, (sizes, _) in QUANTITIES.items():
        parsed = {}
        for unit in units_of(quantity):
            try:
                parsed[unit] = u.Unit(spelled(unit))
            except ValueError:
                pass  # Names such as Rsun that astropy spells otherwise.
        assert parsed, quantity
        first = next(iter(parsed))
        for unit, value in parsed.items():
            if "mag" not in unit and "mag" not in first:
                ratio = dict(sizes)[unit] / dict(sizes)[first]
                assert np.isclose((1 * value).to_value(parsed[first]), ratio, rtol=1e-4), (quantity, unit)
    with pytest.raises(bn.SceneError, match="not a wavelength"):
        bn.Band("top_hat", name="x", centre=5 * u.A, width="3 nm")
