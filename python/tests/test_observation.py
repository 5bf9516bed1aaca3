"""Pictures placed on the sky: world coordinates and units beside closed forms and astropy."""

import warnings

import barnard as bn
import numpy as np
import pytest
from conftest import cloud, lit

pytest.importorskip("astropy")
import astropy.units as u
from astropy.coordinates import SkyCoord

TARGETS = [
    ("18h18m48s -13d49m", "icrs", 0.0),
    ("83.63 22.01", "icrs", 37.0),
    ("0:00:01 -89:59:00", "icrs", 200.0),
    ("16.95 deg 0.79 deg", "galactic", -62.0),
    ("10 0", "icrs", 30.0),
    ("10 0", "icrs", 90.0),
    ("200 0.000001", "icrs", -90.0),
    ("33 90", "icrs", 20.0),
    ("33 -90", "galactic", 20.0),
]
#: Cameras, where the axis of view meets the image from its upper left corner [pixels], and the size of a pixel [rad].
CAMERAS = [
    (bn.PerspectiveCamera("0 0 4 pc", "32 deg", size=[20, 12]), (10, 6), 2 * np.tan(np.radians(16)) / 20),
    (bn.PerspectiveCamera("0 0 4 pc", "32 deg", size=[20, 12], crop=[11, 3, 8, 7]), (-1, 3), 2 * np.tan(np.radians(16)) / 20),
    (bn.FisheyeCamera("0 0 0 pc", target="0 0 -1 pc", size=16), (8, 8), np.pi / 16),
    (bn.EquirectangularCamera("0 0 0 pc", target="0 0 -1 pc", size=[24, 12]), (12, 6), 2 * np.pi / 24),
]


def directions(kind, shape, axis, step):
    """Directions of all pixels in a frame of ahead, right and up, the uppermost row first, and which pixels have one."""
    height, width = shape
    column, row = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    x, y = (column - axis[0]) * step, (axis[1] - row) * step
    if kind == "TAN":
        along = np.stack([np.ones_like(x), x, y])
        return along / np.linalg.norm(along, axis=0), np.ones_like(x, bool)
    if kind == "ARC":
        r = np.maximum(np.hypot(x, y), 1e-300)
        return np.stack([np.cos(r), np.sin(r) / r * x, np.sin(r) / r * y]), r < np.pi / 2
    return np.stack([np.cos(y) * np.cos(x), np.cos(y) * np.sin(x), np.sin(y)]), np.abs(x) < np.pi - 1e-9


@pytest.mark.parametrize("camera, axis, step", CAMERAS)
@pytest.mark.parametrize("target, frame, angle", TARGETS)
def test_pixels_are_places_of_the_sky(camera, axis, step, target, frame, angle):
    scene = lit(cloud())
    scene.camera = camera
    scene.observation = bn.Observation(target, frame=frame, position_angle=angle * u.deg)
    image = scene.render()
    wcs, shape = image.wcs, image.shape[1:]
    seen, has = directions(wcs.wcs.ctype[0][-3:], shape, axis, step)
    # The target, north and east there; the picture's up is turned from north through east, its right is where west is then.
    units = (u.hourangle, u.deg) if ":" in target or "h" in target else u.deg
    place = SkyCoord(target.replace(" deg", ""), unit=units, frame=frame)
    lon, lat = place.spherical.lon.rad, place.spherical.lat.rad
    ahead = np.array([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)])
    north = np.array([-np.sin(lat) * np.cos(lon), -np.sin(lat) * np.sin(lon), np.cos(lat)])
    east = np.array([-np.sin(lon), np.cos(lon), 0.0])
    a = np.radians(angle)
    up, right = np.cos(a) * north + np.sin(a) * east, np.sin(a) * north - np.cos(a) * east
    x, y, z = np.tensordot(np.stack([ahead, right, up], axis=1), seen, axes=1)
    column, row = wcs.wcs_world2pix(np.degrees(np.arctan2(y, x)).ravel(), np.degrees(np.arctan2(z, np.hypot(x, y))).ravel(), 0)
    wanted = np.meshgrid(np.arange(shape[1]), np.arange(shape[0]))
    off = np.hypot(column.reshape(shape) - wanted[0], row.reshape(shape) - wanted[1])
    assert has.any() and off[has].max() < 1e-6, (wcs.wcs.ctype[0], off[has].max())
    # Read the other way round, east is to the left where north is up.
    if angle == 0.0 and wcs.wcs.ctype[0].endswith("TAN"):
        there = wcs.pixel_to_world(0, shape[0] / 2), wcs.pixel_to_world(shape[1] - 1, shape[0] / 2)
        assert there[0].ra > there[1].ra


def test_lengths_become_angles_at_a_distance():
    scene = lit(cloud())
    scene.camera = bn.OrthographicCamera("0 0 4 pc", "3 pc", size=[30, 30])
    scene.observation = bn.Observation("10 20", distance="400 pc")
    wcs = scene.render().wcs
    assert wcs.wcs.ctype[0] == "RA---TAN"
    assert wcs.proj_plane_pixel_scales()[0].to_value(u.rad) == pytest.approx(0.1 / 400, rel=1e-12)
    scene.observation = bn.Observation("10 20")
    with pytest.raises(bn.SceneError, match="400 pc"):
        scene.render()


ARCSEC2 = u.arcsec**2


def wanted(unit, band, width, pivot):
    """Radiances in a unit, by astropy alone."""
    surface = band * u.W / u.m**2 / u.sr
    mean = surface / width
    photons = (surface / (pivot.to(u.J, u.spectral()) / u.photon)).to(u.photon / u.s / u.m**2 / u.sr)
    per_frequency = (mean * pivot**2 / u.Quantity(299_792_458, "m/s")).to(u.MJy / u.sr)
    return {
        "erg s-1 cm-2 arcsec-2": lambda: surface.to_value(u.erg / u.s / u.cm**2 / ARCSEC2),
        "MJy/sr": lambda: per_frequency.to_value(u.MJy / u.sr),
        "R": lambda: photons.to_value(u.Unit("R")),
        "photon s-1 m-2 sr-1": lambda: photons.value,
        "mag/arcsec2 AB": lambda: (per_frequency * ARCSEC2).to(u.ABmag).value,
        "mag/arcsec2 ST": lambda: (mean * ARCSEC2).to(u.STmag).value,
    }[unit]()


@pytest.mark.parametrize("unit", ["erg s-1 cm-2 arcsec-2", "MJy/sr", "R", "photon s-1 m-2 sr-1", "mag/arcsec2 AB", "mag/arcsec2 ST"])
def test_units_are_those_of_astropy(unit):
    # The reference back end holds doubles.
    scene = lit(cloud())
    scene.camera = bn.PerspectiveCamera("0 0 4 pc", "20 deg", size=4)
    plain = scene.render(backend="reference")
    scene.observation = bn.Observation("10 20", unit=unit)
    hdus = scene.render(backend="reference").hdus
    for number, (hdu, band) in enumerate(zip(hdus[1:], plain.radiance, strict=True)):
        width, pivot = hdu.header["BANDWID"] * u.nm, hdu.header["PIVOT"] * u.nm
        # Files hold the lowest row first.
        truth = wanted(unit, band, width, pivot)
        assert band.dtype == float and band.min() > 0
        # AB magnitudes here are those of 3631 Jy, of astropy those of 3630.78 Jy: 6.5e-5 mag apart.
        bound = 1e-5 if unit.endswith("AB") else 1e-10
        assert np.abs(hdu.data[::-1] / truth - 1).max() < bound, (unit, number)
        assert u.Unit(hdu.header["BUNIT"], format="fits").is_equivalent(u.mag / ARCSEC2) == unit.startswith("mag")


def test_headers_pass_the_standard():
    scene = lit(cloud())
    for unit in ["W m-2 sr-1", "MJy/sr", "mag/arcsec2 Vega", "mag/arcsec2 AB", "R"]:
        scene.observation = bn.Observation("18h18m48s -13d49m", position_angle="30 deg", unit=unit)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            hdus = scene.render().hdus
            hdus.verify("exception")
        header = hdus[1].header
        assert header["RADESYS"] == "ICRS" and ("MAGSYS" in header) == unit.startswith("mag")


def test_what_is_no_observation_is_refused():
    scene = lit(cloud())
    for wrong, key in [
        (bn.Observation("somewhere"), "observation.target"),
        (bn.Observation("10 95"), "observation.target"),
        (bn.Observation("10 20", distance="-4 pc"), "observation.distance"),
    ]:
        scene.observation = wrong
        with pytest.raises(bn.SceneError) as error:
            scene.render()
        assert error.value.key == key


def test_pictures_for_eyes_say_where_they_are(tmp_path):
    # AVM tags by PyAVM: the same coordinates as the FITS file has.
    pyavm = pytest.importorskip("pyavm")
    scene = lit(cloud())
    for target, frame in [("18h18m48s -13d49m", "icrs"), ("16.95 0.79", "galactic")]:
        scene.observation = bn.Observation(target, frame=frame, position_angle="30 deg")
        image = scene.render()
        image.write(tmp_path / "sky.png")
        tags = pyavm.AVM.from_image(str(tmp_path / "sky.png"))
        assert tags.Spatial.Quality == "Full" and tags.Spatial.CoordsystemProjection == "TAN"
        column, row = np.meshgrid(np.arange(48.0), np.arange(48.0))
        there = np.array(tags.to_wcs().wcs_pix2world(column.ravel(), row.ravel(), 0))
        # Rows of AVM tags count from below, as those of FITS do.
        assert np.abs(there - np.array(image.wcs.wcs_pix2world(column.ravel(), 47 - row.ravel(), 0))).max() < 1e-9
