"""Instruments and catalogues of stars: photometry, noise and files beside closed forms, photutils and astropy."""

import shutil
import subprocess
import warnings

import barnard as bn
import numpy as np
import pytest

pytest.importorskip("astropy")
pytest.importorskip("photutils")
import astropy.units as u
from astropy.coordinates import SkyCoord
from astropy.io import fits
from astropy.wcs import WCS
from photutils.aperture import ApertureStats, CircularAperture, CircularAnnulus, aperture_photometry

PLANCK, LIGHT = 6.62607015e-34, 2.99792458e8
#: Names, places [deg], V and B magnitudes (Vega).
STARS = [("Alpha", 274.700, -13.8167, 12.0, 12.5), ("Beta", 274.7180, -13.8050, 14.0, 15.2), ("", 274.6850, -13.8300, 15.0, 15.0)]


def catalogue(folder, columns="name,ra,dec,johnson-V,johnson-B"):
    path = folder / "sky.csv"
    path.write_text(columns + "\n" + "".join(",".join(str(v) for v in star) + "\n" for star in STARS))
    return path


def sky(path, size=400, field="0.1 deg", angle="0 deg", **more):
    """A scene of stars alone."""
    return bn.Scene(
        bands=["johnson-B", "johnson-V"],
        camera=bn.PerspectiveCamera("0 0 0 pc", field, target="0 0 -1 pc", size=size),
        background=bn.Background(catalogue=bn.StarCatalogue(str(path))),
        observation=bn.Observation("274.7 -13.8167", position_angle=angle),
        **more,
    )


def band_of(image, band="johnson-V"):
    """A band as plain numbers [W m-2 sr-1]."""
    return np.asarray(image[band], dtype=float)


def even(radiance="2e-8 W/m2/sr/um", size=16, field="0.01 deg", bands=("johnson-V",), **more):
    """A scene of even light."""
    background = bn.Background(kind="power_law", exponent=0, radiance=radiance)
    return bn.Scene(bands=list(bands), camera=bn.PerspectiveCamera("0 0 0 pc", field, target="0 0 -1 pc", size=size), background=background, **more)


@pytest.mark.parametrize("angle", ["0 deg", "35 deg", "200 deg"])
def test_stars_are_where_they_are_and_as_bright(tmp_path, angle):
    image = sky(catalogue(tmp_path), angle=angle).render()
    image.write(tmp_path / "sky.fits")
    with fits.open(tmp_path / "sky.fits") as file:
        for number, band in enumerate(["johnson-B", "johnson-V"]):
            header, data = file[band].header, file[band].data.astype(float)
            wcs = WCS(header)
            pixel = (0.1 * 3600 / 400) ** 2 * u.arcsec**2
            for name, ra, dec, v, b in STARS:
                x, y = wcs.world_to_pixel(SkyCoord(ra * u.deg, dec * u.deg))
                aperture = CircularAperture((float(x), float(y)), 6)
                # A centroid tells a place to the part of the light that the edge of the aperture cuts: none here.
                assert np.hypot(*(ApertureStats(data, aperture).centroid - (x, y))) < 2e-3, name
                flux = aperture_photometry(data, aperture)["aperture_sum"][0] * pixel.to_value(u.sr)
                magnitude = -2.5 * np.log10(flux) + header["ZPVEGA"]
                assert abs(magnitude - (b, v)[number]) < 0.002 / 1.0857, (name, band, magnitude)


def test_axes_of_the_scene_may_be_those_of_the_sky(tmp_path):
    path = tmp_path / "one.csv"
    path.write_text("glon glat mag teff\n30 10 8 6000\n")
    scene = sky(path)
    scene.observation = None
    # x, y and z are those of Galactic coordinates: the star is where the camera looks.
    lon, lat = np.radians([30, 10])
    ahead = np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)
    scene.camera = bn.PerspectiveCamera("0 0 0 pc", "1 deg", target=f"{ahead[0]:.15f} {ahead[1]:.15f} {ahead[2]:.15f} pc", up=[0, 0, 1], size=21)
    scene.background.catalogue.axes = "galactic"
    picture = band_of(scene.render())
    assert np.unravel_index(picture.argmax(), picture.shape) == (10, 10)
    scene.background.catalogue.axes = "icrs"
    assert band_of(scene.render()).max() == 0
    scene.background.catalogue.axes = None
    with pytest.raises(bn.SceneError, match=r"\[observation\]"):
        scene.check()


@pytest.mark.parametrize(
    "text",
    [
        "RAJ2000;DEJ2000;Vmag\n\"h:m:s\";\"d:m:s\";mag\n-----;-----;----\n18 18 48.0;-13 49 00;9.5\n18 18 50.0;-13 49 00;\n",
        "source_id,ra,dec,phot_g_mean_mag,phot_bp_mean_mag,teff_gspphot\n1,274.7,-13.816666,9.5,null,null\n2,274.7,-13.9,null,9,5000\n",
    ],
)
def test_catalogues_of_archives_are_read(tmp_path, text):
    path = tmp_path / "archive.csv"
    path.write_text(text)
    scene = sky(path, size=21)
    picture = band_of(scene.render())
    # One star with a magnitude, where the camera looks; beside it nothing.
    assert np.unravel_index(picture.argmax(), picture.shape) == (10, 10) and (picture > 0).sum() <= 81


def test_stars_stay_with_the_coordinates_of_every_picture(tmp_path):
    scene = sky(catalogue(tmp_path), angle="20 deg", size=200)
    plan = scene.plan()
    turned = bn.PerspectiveCamera("0 0 0 pc", "0.1 deg", target="1 0.3 -1 pc", up=[0.2, 1, 0.1], size=200)
    pictures = [scene.render(), scene.render(turned), plan.render(turned), scene.render(bn.PerspectiveCamera("0 0 0 pc", "0.1 deg", target="0 0 -1 pc", size=200, crop=[40, 30, 120, 140]))]
    for image in pictures:
        wcs = image.wcs
        for name, ra, dec, *_ in STARS:
            x, y = (float(c) for c in wcs.world_to_pixel(SkyCoord(ra * u.deg, dec * u.deg)))
            aperture = CircularAperture((x, y), 6)
            assert np.hypot(*(ApertureStats(band_of(image), aperture).centroid - (x, y))) < 2e-3, name
    # Another place on the sky needs no other plan, and pictures without a camera are those of the plan's own.
    scene.observation = bn.Observation("274.7 -13.8267")
    assert band_of(plan.render()).argmax() != band_of(pictures[0]).argmax()
    planned = scene.plan(turned)
    assert (band_of(planned.render()) == band_of(scene.render(turned))).all()


@pytest.mark.parametrize(
    "text, words",
    [
        ("ra,decc,mag\n1,2,3\n", 'did you mean "dec" by "decc"'),
        ("ra,dec,colour\n1,2,3\n", "no magnitude column"),
        ("ra,dec,mag\n101,95,3\n", "place on the sky.*bad.csv:2"),
        ("ra,dec,mag\n101,2,bright\n", "not a magnitude.*bad.csv:2"),
        ("ra,dec,mag,type\n101,2,3,Q7\n", "bad.csv:2"),
        ("ra,dec,mag,teff\n101,2,3,-7\n", "out of range.*bad.csv:2"),
    ],
)
def test_what_is_no_catalogue_is_refused(tmp_path, text, words):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(bn.SceneError, match=words):
        sky(path).check()


def test_a_thin_nebula_has_the_flux_of_its_volume():
    # A ball of gas j in size at 1 kpc: F = 4 pi j V / (4 pi d^2) [W m-2], a line at the pivot of a top hat.
    parsec = 3.0856775814913673e16
    scene = bn.Scene(
        camera=bn.PerspectiveCamera("0 0 1000 pc", "0.15 deg", size=96, supersampling=3),
        fields={"ball": bn.Sphere("1 pc")},
        emission=[bn.Emission("lines", density="ball", scale="1e-25 W/m3/sr", lines=[{"wavelength": "656.3 nm", "strength": 1.0}])],
        passbands=[bn.Band("top_hat", name="Ha", centre="656.3 nm", width="4 nm")],
        bands=[],
    )
    scene.method = bn.Method(accuracy=1e-4)
    image = scene.render()
    pixel = 2 * np.tan(np.radians(0.075)) / 96
    flux = band_of(image, "Ha").sum() * pixel**2
    wanted = 4 * np.pi * 1e-25 * (4 / 3 * np.pi * parsec) / (4 * np.pi * 1000**2)
    assert abs(flux / wanted - 1) < 3e-3, flux / wanted
    # What an instrument gathers of it is the same: electrons of photons.
    exposures = image.observe({"aperture": "1 m", "exposure": "100 s", "psf": [{"kind": "gaussian", "fwhm": "20 arcsec"}]})
    electrons = wanted * np.pi / 4 * 100 * 656.3e-9 / (PLANCK * LIGHT)
    assert abs(exposures.mean("Ha").sum() / electrons - 1) < 3e-3


def test_a_point_in_the_middle_keeps_all_of_its_light(tmp_path):
    path = tmp_path / "one.csv"
    path.write_text("ra,dec,mag\n274.7,-13.8167,10\n")
    scene = sky(path, size=801, field="0.2 deg")
    scene.bands = ["johnson-V"]
    image = scene.render()
    spreads = [
        [{"kind": "gaussian", "fwhm": "0.01 arcsec"}],
        [{"kind": "gaussian", "fwhm": "8 arcsec"}],
        [{"kind": "moffat", "fwhm": "3 arcsec"}],
        [{"kind": "airy", "vanes": 4}],
        [{"kind": "airy", "optics": "webb"}, {"kind": "moffat", "fwhm": "2 arcsec"}, {"kind": "gaussian", "fwhm": "1 arcsec"}],
    ]
    sums = []
    for psf in spreads:
        # Pixels of the picture's own size, and wider ones of which a whole number fills it.
        for scale in [{}, {"pixel_scale": "2.7 arcsec"}]:
            exposures = image.observe({"aperture": "0.3 m", "obstruction": 0.3, "exposure": "1 s", "psf": psf, **scale})
            sums.append(exposures.mean("johnson-V").sum())
    assert np.ptp(sums) < 1e-6 * sums[0], sums


def test_photometry_of_a_deep_master_gives_magnitudes_back(tmp_path):
    scene = sky(catalogue(tmp_path), size=500, field="0.08 deg")
    scene.instrument = bn.Instrument(
        aperture="1 m",
        psf=[bn.PointSpread("moffat", fwhm="1.2 arcsec")],
        sky="21 mag",
        pixel_scale="0.6 arcsec",
        dark_current="0.1 e/s",
        read_noise="5 e",
        gain="20 e/ADU",
        bias="100 ADU",
        exposure="20 s",
        frames=50,
    )
    image = scene.render().observe().master()
    image.write(tmp_path / "master.fits")
    with fits.open(tmp_path / "master.fits") as file:
        file.verify("exception")
        for number, band in enumerate(["johnson-B", "johnson-V"]):
            header, data = file[band].header, file[band].data.astype(float)
            assert file[band + "_error"].header["HDUCLAS2"] == "ERROR"
            # One reading in 1.7e6 lies 5 sigma apart by chance, of 1.2e7.
            mask = file["mask." + band].data
            assert mask.dtype == ">i2" and (mask != 0).mean() < 2e-4 and np.isin(mask, (0, 2)).all()
            wcs = WCS(header)
            for name, ra, dec, v, b in STARS[:2]:
                place = tuple(float(c) for c in wcs.world_to_pixel(SkyCoord(ra * u.deg, dec * u.deg)))
                aperture, ring = CircularAperture(place, 15), CircularAnnulus(place, 20, 30)
                level = ApertureStats(data, ring).median
                # Photons of the brighter stars: 1e7 electrons and more, 3e-4; wings of the profile beyond the aperture: 3e-4.
                flux = (aperture_photometry(data, aperture)["aperture_sum"][0] - level * aperture.area) * np.radians(0.6 / 3600) ** 2
                magnitude = -2.5 * np.log10(flux) + header["ZPVEGA"]
                assert abs(magnitude - (b, v)[number]) < 0.002 * 1.0857, (name, band, magnitude)


def test_noise_is_as_predicted(tmp_path):
    scene = even()
    scene.instrument = bn.Instrument(
        aperture="0.5 m", obstruction=0.3, throughput=0.6, sky="20.5 mag", sky_system="vega", dark_current="0.05 e/s", read_noise="4 e",
        gain="1.3 e/ADU", bias="200 ADU", exposure="120 s", frames=1000, pixel_scale="2.25 arcsec",
    )
    exposures = scene.render().observe()
    # By hand: photons at the pivot, of the picture and of the sky.
    pivot = 548.74e-9
    image = scene.render()
    area = np.pi / 4 * 0.25 * (1 - 0.09) * 0.6
    omega = np.radians(2.25 / 3600) ** 2
    mean = exposures.mean("johnson-V")
    band = band_of(image)
    image.write(tmp_path / "even.fits")
    # A Vega magnitude of an irradiance of 1 W m-2 is minus 2.5 lg of that of magnitude zero.
    zero = 10 ** (0.4 * fits.getheader(tmp_path / "even.fits", "johnson-V")["ZPVEGA"])
    vega = zero * 10 ** (-0.4 * 20.5) / np.radians(1 / 3600) ** 2
    wanted = 120 * (area * pivot / (PLANCK * LIGHT) * omega * (band[8, 8] + vega) + 0.05)
    assert abs(mean[8, 8] / wanted - 1) < 1e-4, (mean[8, 8], wanted)
    counts = np.stack([exposures.frame(number)["johnson-V"] for number in range(len(exposures))])
    assert counts.dtype == np.uint16
    electrons = (counts.astype(float) - 200) * 1.3
    variance = mean + 16 + 1.3**2 / 12
    # Chi square of all frames and pixels, and of the means of pixels: N and sqrt(2 N), 5 sigma.
    n = electrons.size
    chi = ((electrons - mean) ** 2 / variance).sum()
    assert abs(chi - n) < 5 * np.sqrt(2 * n), chi / n
    means = ((electrons.mean(0) - mean) ** 2 / (variance / len(counts))).sum()
    assert abs(means - mean.size) < 5 * np.sqrt(2 * mean.size), means / mean.size
    # A tenth more noise would be seen.
    assert abs(((electrons - mean) ** 2 / (1.1 * variance)).sum() - n) > 20 * np.sqrt(2 * n)
    # Frames and pixels know nothing of each other.
    noise = (electrons - mean) / np.sqrt(variance)
    for pair in [(noise[1:], noise[:-1]), (noise[:, 1:], noise[:, :-1]), (noise[:, :, 1:], noise[:, :, :-1])]:
        assert abs((pair[0] * pair[1]).mean()) < 5 / np.sqrt(pair[0].size)
    # The master's errors are those of its pixels.
    master = exposures.master()
    sky = mean / 120 - 0.05 - area * pivot / (PLANCK * LIGHT) * omega * band
    truth = (mean / 120 - 0.05 - sky) / (area * pivot / (PLANCK * LIGHT) * omega)
    pulls = (band_of(master) - truth) / band_of(master, "johnson-V_error")
    assert abs((pulls**2).sum() - mean.size) < 5 * np.sqrt(2 * mean.size)


def test_a_dark_master_is_dark():
    # Six readings above zero nothing is cut off, wherever the bias is not said.
    scene = even("1e-14 W/m2/sr/um", size=32, field="0.02 deg")
    image = scene.render()
    for frames in (1, 2, 24):
        master = image.observe(bn.Instrument(aperture="0.2 m", read_noise="5 e", gain="0.8 e/ADU", frames=frames, seed=3)).master()
        pulls = band_of(master) / band_of(master, "johnson-V_error")
        assert abs(pulls.mean()) < 5 / 32 and abs(pulls.std() - 1) < 0.1, frames
        assert (master.layers["mask"] != 0).mean() < 2e-3
    # The sky's mean is there where it is not taken away.
    keys = dict(aperture="0.2 m", sky="20 mag", frames=50)
    without, with_sky = (image.observe({**keys, "subtract_sky": subtract}).master() for subtract in (True, False))
    # 20 mag AB in a square arcsecond at V: 3631 Jy c/pivot^2 [W m-2 um-1] over the width, 3 % of colour of the passband aside.
    wanted = 3631e-26 * 2.99792458e8 / (548.74e-9) ** 2 * 1e-6 * 0.0877 * 1e-8 / np.radians(1 / 3600) ** 2
    assert abs(band_of(with_sky).mean() / wanted - 1) < 0.05 and abs(band_of(without).mean()) < 0.01 * wanted


def test_saturation_and_cosmic_rays_are_masked():
    scene = even("3e-6 W/m2/sr/um", size=64)
    keys = dict(aperture="0.5 m", exposure="60 s", read_noise="3 e", pixel_size="15 um", cosmic_rays="10 /cm2/s", frames=5)
    image = scene.render()
    exposures = image.observe(bn.Instrument(**keys))
    master = exposures.master()
    mean, rays = exposures.mean("johnson-V"), master.layers["mask"][0]
    hit = np.zeros(mean.shape, bool)
    for number in range(5):
        hit |= exposures.frame(number)["johnson-V"] > mean + 7 * np.sqrt(mean + 10)
    # Whatever was hit hard in a frame is marked, and left out of the mean.
    assert 50 < hit.sum() < mean.size / 2 and (rays[hit] == 2).all()
    pulls = (band_of(master) - band_of(image)) / band_of(master, "johnson-V_error")
    assert np.abs(pulls[hit]).max() < 6 and abs(pulls.mean()) < 0.1
    # One frame alone has no other to be told apart from.
    alone = image.observe(bn.Instrument(**{**keys, "frames": 1})).master()
    assert (alone.layers["mask"] == 0).all()
    full = image.observe(bn.Instrument(**{**keys, "cosmic_rays": "0 /cm2/s", "full_well": f"{0.5 * mean.mean()} e"})).master()
    # A pixel that gathers less than its well by chance is one in thirty thousand.
    assert (full.layers["mask"][0] == 5).mean() > 0.999


def test_a_mosaic_has_a_band_in_each_pixel(tmp_path):
    bands = ["johnson-B", "johnson-V", "cousins-R"]
    scene = even(size=12, bands=bands)
    mosaic = [bands[2], bands[1], bands[1], bands[0]]
    scene.instrument = bn.Instrument(aperture="1 m", exposure="100 s", frames=3, mosaic=mosaic)
    image = scene.render()
    exposures = image.observe()
    frame = exposures.frame(0)
    assert list(frame) == ["mosaic"]
    means = {band: exposures.mean(band) for band in bands}
    for row, column in np.ndindex(12, 12):
        mean = means[mosaic[2 * (row % 2) + column % 2]][row, column]
        assert abs(frame["mosaic"][row, column] - mean) < 6 * np.sqrt(mean) + 1
    for square, pattern in [([2, 1, 1, 0], "RGGB"), ([0, 1, 1, 2], "BGGR"), ([1, 2, 0, 1], "GRBG"), ([1, 0, 2, 1], "GBRG"), ([0, 0, 1, 2], None)]:
        seen = image.observe({"aperture": "1 m", "mosaic": [bands[i] for i in square]})
        seen.write_frame(0, tmp_path / "raw.fits")
        assert fits.getheader(tmp_path / "raw.fits", "mosaic").get("BAYERPAT") == pattern
    master = exposures.master()
    for band in bands:
        pulls = (band_of(master, band) - band_of(image, band)) / band_of(master, band + "_error")
        assert np.abs(pulls).max() < 5
    with pytest.raises(bn.BarnardError, match="johnson-U"):
        image.observe({"aperture": "1 m", "mosaic": ["johnson-U"] * 4})
    with pytest.raises(bn.BarnardError, match="does not name passband cousins-R"):
        image.observe({"aperture": "1 m", "mosaic": bands[:2] * 2})


def test_frames_are_files_of_counts(tmp_path):
    scene = sky(catalogue(tmp_path), size=60, instrument=bn.Instrument(preset="lco-1m-sinistro", pixel_scale="6 arcsec"))
    exposures = scene.render().observe()
    exposures.write_frame(2, tmp_path / "raw.fits")
    with warnings.catch_warnings(), fits.open(tmp_path / "raw.fits") as file:
        warnings.simplefilter("error")
        file.verify("exception")
        assert file[0].header["IMAGETYP"] == "Light Frame" and file[0].header["FRAME"] == 3
        for band, counts in exposures.frame(2).items():
            header, data = file[band].header, file[band].data
            assert data.dtype == np.uint16 and (data[::-1] == counts).all()
            assert header["BUNIT"] == "adu" and header["EXPTIME"] == 300 and header["GAIN"] == 2
            x, y = WCS(header).world_to_pixel(SkyCoord(274.7 * u.deg, -13.8167 * u.deg))
            assert abs(x - 29.5) < 1e-6 and abs(y - 29.5) < 1e-6
    with pytest.raises(bn.BarnardError, match="FITS"):
        exposures.write_frame(0, tmp_path / "raw.png")
    with pytest.raises(IndexError, match="there are 6"):
        exposures.frame(6)


@pytest.mark.skipif(shutil.which("fitsverify") is None, reason="needs fitsverify, a package of Debian")
def test_files_are_as_the_standard_has_them(tmp_path):
    scene = sky(catalogue(tmp_path), size=60, instrument=bn.Instrument(preset="lco-1m-sinistro", pixel_scale="6 arcsec"))
    image = scene.render()
    exposures = image.observe()
    files = [tmp_path / name for name in ("picture.fits", "master.fits", "raw.fits")]
    image.write(files[0])
    exposures.master().write(files[1])
    exposures.write_frame(0, files[2])
    for file in files:
        words = subprocess.run(["fitsverify", file], capture_output=True, text=True).stdout
        assert "Verification found 0 warning(s) and 0 error(s)" in words, words


def test_the_same_seed_records_the_same(tmp_path):
    scene = even(bands=["lsst2023-g"], instrument=bn.Instrument(preset="rubin-lsstcam", pixel_scale="2.25 arcsec"))
    frames = []
    try:
        for threads in (1, 3):
            bn.set_threads(threads)
            exposures = scene.render().observe()
            frames.append((exposures.frame(4)["lsst2023-g"], exposures.master().radiance))
    finally:
        bn.set_threads(0)
    assert all((a == b).all() for a, b in zip(*frames))
    other = scene.render().observe(bn.Instrument(preset="rubin-lsstcam", pixel_scale="2.25 arcsec", seed=2))
    assert (other.frame(4)["lsst2023-g"] != frames[0][0]).mean() > 0.5


def test_kernels_of_files(tmp_path):
    image = sky(catalogue(tmp_path), size=200).render()
    y, x = np.mgrid[-20:21, -20:21]
    # A point, and half as much light to the right and above it: rows of FITS run upwards.
    kernel = np.exp(-0.5 * (x**2 + y**2)) + 0.5 * np.exp(-0.5 * ((x - 12) ** 2 + (y - 6) ** 2))
    fits.writeto(tmp_path / "psf.fits", kernel.astype("f4"))
    seen = image.observe({"aperture": "1 m", "exposure": "1 s", "psf": [{"kind": "kernel", "file": str(tmp_path / "psf.fits"), "pixel_scale": "1.8 arcsec"}]})
    mean = seen.mean("johnson-V")
    # Its own scale is that of the picture, whose first row is on top: two wide pixels around each.
    place = np.unravel_index(mean.argmax(), mean.shape)
    other = mean[place[0] - 6, place[1] + 12]
    assert abs(other / mean[place] - 0.5) < 0.02
    assert all(mean[place[0] + dy, place[1] + dx] < 0.01 * other for dy, dx in [(6, 12), (-6, -12), (6, -12)])
    for bad, words in [(np.zeros((3, 3)), "above zero"), (np.full((3, 3), np.nan), "finite"), (np.array([[1, -1.0], [0, 1]]), "at least zero")]:
        np.save(tmp_path / "bad.npy", bad[None])
        with pytest.raises(bn.SceneError, match=words):
            image.observe({"aperture": "1 m", "psf": [{"kind": "kernel", "file": str(tmp_path / "bad.npy"), "pixel_scale": "1 arcsec"}]})


@pytest.mark.parametrize(
    "keys, words",
    [
        ({"aperture": "1 m", "exposure": "-3 s"}, "must be above zero"),
        ({"aperture": "1 m", "read_noise": "-3 e"}, "at least zero"),
        ({"aperture": "1 m", "gain": "0 e/ADU"}, "must be above zero"),
        ({"aperture": "1 m", "obstruction": 1.5}, "out of range"),
        ({"aperture": "1 m", "sky": ["21 mag", "20 mag", "19 mag"]}, "found 3"),
        ({"aperture": "1 m", "mosaic": ["johnson-V"]}, "four pixels"),
        ({"aperture": "1 m", "pixel_scale": "0.01 arcsec"}, "finer than the picture"),
        ({"aperture": "1 m", "pixel_scale": "3 deg"}, "wider than the picture"),
        ({"preset": "hubble"}, "hst-wfc3-uvis"),
        ({"exposure": "3 s"}, "aperture"),
        ({"aperture": "1 m", "psf": [{"kind": "moffat"}]}, "fwhm"),
    ],
)
def test_what_is_no_instrument_is_refused(keys, words):
    image = even().render()
    with pytest.raises(bn.BarnardError, match=words):
        image.observe(keys)


def test_pictures_that_no_detector_sees():
    scene = even()
    with pytest.raises(bn.BarnardError, match="instrument"):
        scene.render().observe()
    scene.camera = bn.FisheyeCamera("0 0 0 pc", target="0 0 -1 pc", size=16)
    with pytest.raises(bn.BarnardError, match="perspective"):
        scene.render().observe({"aperture": "1 m"})


def test_electrons_are_a_unit(tmp_path):
    scene = even(observation=bn.Observation("10 20", unit="electron s-1"))
    with pytest.raises(bn.SceneError, match="instrument"):
        scene.check()
    scene.instrument = bn.Instrument(aperture="2 m", frames=4, exposure="1000 s")
    image = scene.render()
    exposures = image.observe()
    image.write(tmp_path / "e.fits")
    exposures.master().write(tmp_path / "m.fits")
    rate = exposures.mean("johnson-V") / 1000
    with fits.open(tmp_path / "e.fits") as plain, fits.open(tmp_path / "m.fits") as master:
        assert plain["johnson-V"].header["BUNIT"] == "electron s-1"
        np.testing.assert_allclose(plain["johnson-V"].data, rate, rtol=1e-5)
        pulls = (master["johnson-V"].data - rate) / master["johnson-V_error"].data
        assert np.abs(pulls).max() < 5
    assert u.Unit("electron s-1") == u.electron / u.s


def test_a_frame_of_one_band_is_the_first_image(tmp_path):
    scene = even(bands=["lsst2023-g"], instrument=bn.Instrument(preset="rubin-lsstcam", pixel_scale="2.25 arcsec"))
    exposures = scene.render().observe()
    starts = []
    for number in (0, 2):
        exposures.write_frame(number, tmp_path / "raw.fits")
        with warnings.catch_warnings(), fits.open(tmp_path / "raw.fits") as file:
            warnings.simplefilter("error")
            file.verify("exception")
            assert len(file) == 1
            header, data = file[0].header, file[0].data
            assert data.dtype == np.uint16 and (data[::-1] == exposures.frame(number)["lsst2023-g"]).all()
            assert (header["TELESCOP"], header["INSTRUME"], header["EGAIN"], header["XPIXSZ"]) == ("rubin-lsstcam", "rubin-lsstcam", 1.6, 10)
            # 10 um in 2.25 arcsec.
            assert header["FOCALLEN"] == pytest.approx(1e-2 / np.radians(2.25 / 3600), rel=1e-6)
            starts.append(header["DATE-OBS"])
    assert starts == ["2000-01-01T12:00:00.000", "2000-01-01T12:01:00.000"]


def test_instruments_have_filters_of_their_own():
    scene = even(bands=["jwst-miri-f770w"], instrument=bn.Instrument(preset="hst-wfc3-uvis", pixel_scale="2.25 arcsec"))
    with pytest.raises(bn.BarnardError, match="jwst-miri-f770w is not a filter of hst-wfc3-uvis"):
        scene.render().observe()
    scene.instrument = bn.Instrument(preset="hst-wfc3-uvis", pixel_scale="2.25 arcsec", allow_foreign_filters=True)
    assert len(scene.render().observe()) == 4
