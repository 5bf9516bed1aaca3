"""Cubes: channels beside wide bands and the reference, lines that move, files as astropy reads them."""

import barnard as bn
import numpy as np
import pytest
from conftest import cloud, lit

pytest.importorskip("astropy")
import astropy.units as u
from astropy.io import fits
from astropy.wcs import WCS

LIGHT = 299792.458


def band_of(image, band=None):
    return np.asarray(image.radiance if band is None else image[band], dtype=float)


def shell(velocity=None, count=40, **keys):
    """A thin ball of gas with one line, in channels of 0.1 nm."""
    moves = {} if velocity is None else {"velocity": velocity, **keys}
    return bn.Scene(
        camera=bn.PerspectiveCamera("0 0 1000 pc", "0.15 deg", size=24, supersampling=2),
        fields={"ball": bn.Sphere("1 pc")},
        emission=[bn.Emission("lines", density="ball", scale="1e-25 W/m3/sr", lines=[{"wavelength": "500 nm", "strength": 1.0}], doppler_fwhm="30 km/s", **moves)],
        spectrograph=bn.Spectrograph("498 nm", "502 nm", count),
        # Each velocity is a function that is sampled.
        method=bn.Method(bake=32, accuracy=0.02),
    )


def test_channels_sum_to_the_wide_band_and_are_those_of_the_reference():
    scene = lit(cloud())
    scene.camera.size = 12
    scene.bands = None
    scene.spectrograph = bn.Spectrograph("400 nm", "700 nm", 60)
    channels = scene.render()
    assert len(channels.bands) == 60 and channels.bands[0] == "402.5 nm"
    exact = scene.render(backend="reference")
    worst = max(np.sqrt(((band_of(channels)[b] - band_of(exact)[b]) ** 2).sum() / (band_of(exact)[b] ** 2).sum()) for b in range(60))
    assert worst < 3e-3, worst
    scene.spectrograph = None
    scene.passbands = [bn.Band("top_hat", name="wide", centre="550 nm", width="300 nm")]
    wide = band_of(scene.render(), "wide")
    total = band_of(channels).sum(0)
    assert np.sqrt(((total - wide) ** 2).sum() / (wide**2).sum()) < 3e-3


def test_a_line_spread_keeps_the_line():
    scene = shell(count=400)
    sharp = band_of(scene.render()).sum((1, 2))
    scene.spectrograph.resolving_power = 2000
    spread = band_of(scene.render()).sum((1, 2))
    assert abs(spread.sum() / sharp.sum() - 1) < 1e-5
    middle = 498 + 0.01 * (np.arange(400) + 0.5)
    mean = (middle * spread).sum() / spread.sum()
    width = np.sqrt(((middle - mean) ** 2 * spread).sum() / spread.sum()) * np.sqrt(8 * np.log(2))
    # lambda/R, the line's own 30 km/s and a channel's width together.
    wanted = np.sqrt((500 / 2000) ** 2 + (500 * 30 / LIGHT) ** 2 + (0.01 * np.sqrt(8 * np.log(2) / 12)) ** 2)
    assert abs(mean - 500) < 1e-4 and abs(width / wanted - 1) < 5e-3, (mean, width, wanted)


def test_gas_that_moves_is_seen_where_it_is():
    # Both sampled on 64 voxels: no light is lost on the way to several velocities.
    at_rest, receding = shell(), shell(["0", "0", "-300"])
    at_rest.method = receding.method = bn.Method(bake=64)
    still = band_of(at_rest.render())
    # All of it recedes with 300 km/s from a camera that looks down z: 0.5003 nm.
    away = band_of(receding.render())
    middle = 498 + 0.1 * (np.arange(40) + 0.5)
    mean = lambda cube: (middle * cube.sum((1, 2))).sum() / cube.sum()
    assert abs(away.sum() / still.sum() - 1) < 1e-5
    assert abs(mean(away) - mean(still) - 500 * 300 / LIGHT) < 1e-3
    # A ball that turns around y: what is to the right recedes, in proportion to its distance from the axis.
    # Channels as narrow as the line is wide: in wider ones a mean of their middles is not that of the line.
    turning = shell(["200*z", "0", "-200*x"], count=200, velocity_step="10 km/s")
    image = turning.render()
    cube = band_of(image)
    column = cube.sum(0)
    fine = 498 + 0.02 * (np.arange(200) + 0.5)
    seen = (fine[:, None, None] * cube).sum(0) / np.maximum(column, 1e-300)
    scale = 1000 * 2 * np.tan(np.radians(0.075)) / 24
    x = (np.arange(24) + 0.5 - 12) * scale
    # At the rim half a pixel is gas.
    inside = np.hypot(x[None, :], x[:, None]) < 0.8
    wanted = 500 * (1 + 200 * np.broadcast_to(x, column.shape) / LIGHT)
    assert np.abs(seen - wanted)[inside].max() < 2e-3
    # A ball that grows is seen near and far side: the line of its middle is as wide as its gas is fast.
    growing = band_of(shell(["250*x", "250*y", "250*z"], velocity_step="10 km/s").render())[:, 12, 12]
    rms = np.sqrt(((middle - 500) ** 2 * growing).sum() / growing.sum())
    # Even from -250 to 250 km/s, with the line's own width, a channel's, and half a step's.
    width = np.sqrt(250**2 / 3 + (30 / np.sqrt(8 * np.log(2))) ** 2 + (0.1 / 500 * LIGHT) ** 2 / 12 + 10**2 / 6)
    assert abs(rms / (500 * width / LIGHT) - 1) < 0.02, (rms, 500 * width / LIGHT)


@pytest.mark.parametrize("unit, bunit", [(None, "W m-2 sr-1 um-1"), ("erg s-1 cm-2 arcsec-2", "erg s-1 cm-2 arcsec-2 Angstrom-1"), ("MJy/sr", "MJy/sr")])
def test_cubes_are_files(tmp_path, unit, bunit):
    scene = shell(["0", "0", "-300"])
    scene.observation = bn.Observation("10 20", position_angle="30 deg", unit=unit)
    image = scene.render()
    image.write(tmp_path / "cube.fits")
    with fits.open(tmp_path / "cube.fits") as file:
        file.verify("exception")
        assert len(file) == 2 and file["CUBE"].data.shape == (40, 24, 24)
        header, data = file["CUBE"].header, file["CUBE"].data.astype(float)
        assert header["BUNIT"] == bunit
        wcs = WCS(header)
        sky, wavelength = wcs.pixel_to_world(11.5, 11.5, 7)
        assert abs(sky.ra.deg - 10) < 1e-9 and abs(sky.dec.deg - 20) < 1e-9
        assert abs(wavelength.to_value(u.nm) - (498 + 0.75)) < 1e-9
        assert wcs.celestial.naxis == 2 and wcs.spectral.naxis == 1
        stated = band_of(image)[:, ::-1]
        if unit is None:
            np.testing.assert_allclose(data * 1e-4, stated, rtol=1e-5, atol=1e-30)
        elif unit.startswith("erg"):
            factor = (1 * u.W / u.m**2 / u.sr / u.um).to_value(u.erg / u.s / u.cm**2 / u.arcsec**2 / u.AA)
            np.testing.assert_allclose(data, stated / 1e-4 * factor, rtol=1e-5, atol=1e-40)
        else:
            middle = (498 + 0.1 * (np.arange(40) + 0.5))[:, None, None] * u.nm
            wanted = (stated / 1e-4 * u.W / u.m**2 / u.um / u.sr).to_value(u.MJy / u.sr, u.spectral_density(middle))
            np.testing.assert_allclose(data, wanted, rtol=1e-5, atol=1e-30)


@pytest.mark.parametrize(
    "keys, words",
    [
        (dict(low="700 nm", high="400 nm", count=3), "must exceed"),
        (dict(low="400 nm", high="700 nm", count=0), "out of range"),
        (dict(low="400 nm", high="700 nm", count=100000), "4096"),
        (dict(low="400 nm", high="700 nm", count=3, resolving_power=0.1), "out of range"),
    ],
)
def test_what_is_no_spectrograph_is_refused(keys, words):
    scene = shell()
    low, high = keys.pop("low"), keys.pop("high")
    with pytest.raises(bn.SceneError, match=words):
        scene.spectrograph = bn.Spectrograph(low, high, **keys)
        scene.check()


def test_what_is_no_velocity_is_refused():
    for velocity, keys, words in [
        (["0", "0"], {}, "three components"),
        (["0", "0", "wind"], {}, "wind"),
        (["0", "0", "1e6*z"], {}, "velocity_step"),
        (["0", "0", "1/(x-x)"], {}, "finite wherever"),
        (None, {"velocity_step": "3 km/s"}, "velocity"),
    ]:
        scene = shell()
        with pytest.raises(bn.SceneError, match=words):
            scene.emission[0].velocity = velocity
            for name, value in keys.items():
                setattr(scene.emission[0], name, value)
            scene.check()
    scene = shell()
    scene.bands = "johnson"
    with pytest.raises(bn.SceneError, match="spectrograph"):
        scene.check()


def test_a_plan_keeps_the_wavelengths_of_its_camera():
    """Seen from behind, a turning ball turns the other way; a plan shows the wavelengths of its own camera, mirrored."""
    scene = shell(["200*z", "0", "-200*x"], velocity_step="20 km/s")
    plan, behind = scene.plan(), bn.PerspectiveCamera("0 0 -1000 pc", "0.15 deg", size=24, supersampling=2)
    front, mirrored, behind_now = (band_of(image) for image in (plan.render(), plan.render(behind), scene.render(behind)))
    off = lambda a, b: np.sqrt(((a - b) ** 2).sum() / (b**2).sum())  # noqa: E731
    assert off(mirrored[:, :, ::-1], front) < 0.02 and off(behind_now, front) < 0.02
    assert off(mirrored, front) > 0.5
    scene.emission[0].scale = "2e-25 W/m3/sr"
    with pytest.raises(bn.PlanError, match=r"emission"):
        plan.render(behind)
