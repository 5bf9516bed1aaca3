"""Fits of scenes to observed images, also as other programs drive them."""

from concurrent.futures import ThreadPoolExecutor

import barnard as bn
import numpy as np
import pytest
from conftest import cloud, lit

optimize = pytest.importorskip("scipy.optimize")

INSTRUMENT = bn.Instrument(aperture="0.5 m", read_noise="4 e", sky="21.5 mag", exposure="20 s", frames=3)
FREE = "star.0.luminosity, star.0.temperature=4000..40000"


@pytest.fixture
def observed(tmp_path):
    scene = lit(cloud())
    scene.camera = bn.perspective("0 0 1000 pc", "0.12 deg", size=32)
    scene.instrument = INSTRUMENT
    path = tmp_path / "master.fits"
    scene.render().observe().master().write(path)
    scene.stars[0].luminosity, scene.stars[0].temperature = "400 Lsun", "9000 K"
    return scene, path


def test_truth_is_found(observed):
    scene, path = observed
    fit = scene.fit(FREE, path)
    assert fit.converged and fit.linear == {"star.0.luminosity": True, "star.0.temperature": False}
    for key, truth in (("star.0.luminosity", 1000), ("star.0.temperature", 12000)):
        assert abs(fit.values[key] - truth) < 4 * fit.sigma[key]
    assert fit.units == {"star.0.luminosity": "Lsun", "star.0.temperature": "K"} and fit.covariance.shape == (2, 2)
    assert 0.9 < fit.chi2 / fit.freedom < 1.1 and "star.0.luminosity = " in repr(fit)
    left = fit.residuals[0]
    pull = np.asarray(left["johnson-V"]) / np.asarray(left["johnson-V_error"])
    pull = pull[np.isfinite(pull)]
    # Cosmic rays are masked; of a thousand normal numbers the deviation is 1 within 0.022, the mean 0 within 0.032.
    assert 950 < pull.size <= 1024 and abs(np.std(pull) - 1) < 0.09 and abs(np.mean(pull)) < 0.12


def test_places_on_the_sky_are_compared(observed, tmp_path):
    fits, wcs, coordinates = (pytest.importorskip(f"astropy.{name}") for name in ("io.fits", "wcs", "coordinates"))
    scene, path = observed
    scene.observation = bn.Observation("83.82 -5.39", position_angle="30 deg")
    scene.render().observe().master().write(path)

    def again(change):
        """The image with other coordinates in its headers."""
        other = tmp_path / "again.fits"
        with fits.open(path) as all:
            for hdu in all:
                if hdu.header["NAXIS"] == 2:
                    change(hdu.header)
            all.writeto(other, overwrite=True)
        return scene.fit("star.0.luminosity", other)

    def moved(header, pixels):
        # The same plane about another of its points, as astropy has it, by a CD matrix.
        own = wcs.WCS(header)
        place = (9.0, 20.0)
        at = own.pixel_to_world(*place)
        frame = at.skyoffset_frame()
        step = [own.pixel_to_world(place[0] + dx, place[1] + dy).transform_to(frame) for dx, dy in ((1, 0), (0, 1))]
        for keyword in [keyword for keyword in header if keyword.startswith(("PC1_", "PC2_", "CDELT"))]:
            del header[keyword]
        header["CRPIX1"], header["CRPIX2"] = place[0] + 1 + pixels, place[1] + 1
        header["CRVAL1"], header["CRVAL2"] = at.ra.deg, at.dec.deg
        for j in (0, 1):
            header[f"CD1_{j + 1}"], header[f"CD2_{j + 1}"] = step[j].lon.wrap_at("180d").deg, step[j].lat.deg

    plain = scene.fit("star.0.luminosity", path)
    assert again(lambda header: moved(header, 0.02)).values == plain.values
    with pytest.raises(bn.SceneError, match="0.20 pixels away"):
        again(lambda header: moved(header, 0.2))
    for words, change in (
        ("has the axes RA---SIN and DEC--SIN", {"CTYPE1": "RA---SIN", "CTYPE2": "DEC--SIN"}),
        ("says CTYPE1 = RA---TAN-SIP", {"CTYPE1": "RA---TAN-SIP", "CTYPE2": "DEC--TAN-SIP"}),
        ("says A_ORDER", {"A_ORDER": 2}),
        ("says LONPOLE = 90", {"LONPOLE": 90.0}),
        ("says RADESYS = FK4", {"RADESYS": "FK4"}),
        ("has the axes GLON-TAN", {"CTYPE1": "GLON-TAN", "CTYPE2": "GLAT-TAN"}),
    ):
        with pytest.raises(bn.SceneError, match=words):
            again(lambda header: header.update(change))


def test_other_programs_drive_it(observed):
    scene, path = observed
    model = scene.fit_model(FREE, [path])
    assert model.start == [400, 9000] and model.bounds[1] == (4000, 40000)
    own = model.fit()
    values = np.array(list(own.values.values()))
    # Weights are held, as those of the fit are in the end.
    sigma = model.predict(values)[1]
    found = optimize.least_squares(lambda x: (model.data - model.predict(x * values)[0]) / sigma, [0.8, 0.9], diff_step=1e-3)
    assert np.all(np.abs(found.x * values - values) < 0.3 * np.array(list(own.sigma.values())))
    best = model.log_likelihood(values)
    steps = np.array(list(own.sigma.values()))
    assert all(model.log_likelihood(values + sign * 3 * steps * np.eye(2)[i]) < best for i in range(2) for sign in (-1, 1))
    assert model.log_likelihood([400, 50000]) == -np.inf


def test_likelihoods_hang_on_values_alone(observed):
    scene, path = observed
    free = "star.0.luminosity, dust.scale=0.5..12"
    places = [[900, 3], [1000, 3.1], [800, 9], [1000, 2.9]]
    own = [scene.fit_model(free, path).log_likelihood(place) for place in places]
    model = scene.fit_model(free, path)
    assert [model.log_likelihood(place) for place in reversed(places)] == own[::-1]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(model.log_likelihood, places * 3)) == own * 3
    model.fit([500, 1])
    assert [model.log_likelihood(place) for place in places] == own
    for wrong in ([900], [], [900, 3, 5]):
        with pytest.raises(ValueError, match="values for 2 keys"):
            model.predict(wrong)
        with pytest.raises(ValueError, match="values for 2 keys"):
            model.log_likelihood(wrong)
    with pytest.raises(TypeError, match="FITS file"):
        scene.fit(free, scene.render())


def test_walkers_find_the_same(observed):
    emcee = pytest.importorskip("emcee")
    scene, path = observed
    model = scene.fit_model(FREE, path)
    own = model.fit()
    values, sigma = (np.array(list(of.values())) for of in (own.values, own.sigma))
    random = np.random.default_rng(3)
    sampler = emcee.EnsembleSampler(12, 2, model.log_likelihood)
    np.random.seed(3)
    state = sampler.run_mcmc(values + sigma * random.standard_normal((12, 2)), 30)
    sampler.reset()
    sampler.run_mcmc(state, 120)
    chain = sampler.get_chain(flat=True)
    # Some 70 independent samples: the mean is right to an eighth of a deviation, the deviation to a tenth of it.
    assert np.all(np.abs(chain.mean(axis=0) - values) < 0.5 * sigma)
    assert np.all(np.abs(chain.std(axis=0) / sigma - 1) < 0.35)
    correlation = own.covariance[0, 1] / (sigma[0] * sigma[1])
    assert abs(np.corrcoef(chain.T)[0, 1] - correlation) < 0.2


def test_images_with_tables_of_their_own(observed, tmp_path):
    scene, path = observed
    other = lit(cloud())
    other.camera = bn.perspective("0 0 1000 pc", "0.12 deg", size=32)
    other.bands = ["sdss2010-g"]
    deep = bn.Instrument(aperture="1 m", read_noise="5 e", sky="21 mag", exposure="4 s", frames=3)
    second = tmp_path / "second.fits"
    other.render().observe(deep).master().write(second)
    together = scene.fit(FREE, [path, (second, {"bands": ["sdss2010-g"], "instrument": deep})])
    alone = scene.fit(FREE, path)
    assert together.pixels > alone.pixels and together.sigma["star.0.luminosity"] < alone.sigma["star.0.luminosity"]
    assert len(together.residuals) == 2


def test_what_cannot_be_fitted_is_said(observed):
    scene, path = observed
    with pytest.raises(bn.SceneError, match="KEY=LOW"):
        scene.fit("star.0.luminosity=3..1", path)
    with pytest.raises(bn.SceneError, match="write it there"):
        scene.fit("star.0.radius", path)
    with pytest.raises(ValueError, match="2 keys"):
        scene.fit_model(FREE, path).fit([1.0])
    scene.camera = bn.perspective("0 0 1000 pc", "0.12 deg", size=24)
    with pytest.raises(bn.SceneError, match="32 x 32 pixels"):
        scene.fit(FREE, path)
