"""Fits of scenes to observed images, also as other programs drive them."""

from concurrent.futures import ThreadPoolExecutor

import astropy.units as u
import barnard as bn
import numpy as np
import pytest
from conftest import cloud, lit

optimize = pytest.importorskip("scipy.optimize")

INSTRUMENT = bn.Instrument(aperture="0.5 m", read_noise="4 e", sky="21.5 mag", exposure="20 s", frames=3)
FREE = {"star[0].luminosity": None, "star[0].temperature": bn.Free(4e3 * u.K, "40 kK")}


@pytest.fixture
def observed(tmp_path):
    scene = lit(cloud())
    scene.camera = bn.PerspectiveCamera("0 0 1000 pc", "0.12 deg", size=32)
    scene.instrument = INSTRUMENT
    path = tmp_path / "master.fits"
    scene.render().observe().master().write(path)
    scene.stars[0].luminosity, scene.stars[0].temperature = "400 Lsun", "9000 K"
    return scene, path


def test_truth_is_found(observed):
    scene, path = observed
    fit = scene.fit(FREE, path)
    assert fit.converged and fit.linear == {"star[0].luminosity": True, "star[0].temperature": False}
    for key, truth in (("star[0].luminosity", 1000), ("star[0].temperature", 12000)):
        assert abs(fit.values[key] - truth) < 4 * fit.sigma[key]
    assert fit.units == {"star[0].luminosity": "Lsun", "star[0].temperature": "K"} and fit.covariance.shape == (2, 2)
    assert 0.9 < fit.chi2 / fit.freedom < 1.1 and "star[0].luminosity = " in repr(fit)
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
        return scene.fit(["star[0].luminosity"], other)

    def moved(header, pixels):
        # The same plane about another of its points, as astropy has it, by a CD matrix.
        world = wcs.WCS(header)
        place = (9.0, 20.0)
        at = world.pixel_to_world(*place)
        frame = at.skyoffset_frame()
        step = [world.pixel_to_world(place[0] + dx, place[1] + dy).transform_to(frame) for dx, dy in ((1, 0), (0, 1))]
        for keyword in [keyword for keyword in header if keyword.startswith(("PC1_", "PC2_", "CDELT"))]:
            del header[keyword]
        header["CRPIX1"], header["CRPIX2"] = place[0] + 1 + pixels, place[1] + 1
        header["CRVAL1"], header["CRVAL2"] = at.ra.deg, at.dec.deg
        for j in (0, 1):
            header[f"CD1_{j + 1}"], header[f"CD2_{j + 1}"] = step[j].lon.wrap_at("180d").deg, step[j].lat.deg

    plain = scene.fit(["star[0].luminosity"], path)
    assert again(lambda header: moved(header, 0.02)).values == plain.values
    with pytest.raises(bn.SceneError, match="0.20 pixels from"):
        again(lambda header: moved(header, 0.2))
    for words, change in (
        ("has the axes RA---SIN and DEC--SIN", {"CTYPE1": "RA---SIN", "CTYPE2": "DEC--SIN"}),
        ("has CTYPE1 = RA---TAN-SIP", {"CTYPE1": "RA---TAN-SIP", "CTYPE2": "DEC--TAN-SIP"}),
        ("has A_ORDER", {"A_ORDER": 2}),
        ("has LONPOLE = 90", {"LONPOLE": 90.0}),
        ("has RADESYS = FK4", {"RADESYS": "FK4"}),
        ("has the axes GLON-TAN", {"CTYPE1": "GLON-TAN", "CTYPE2": "GLAT-TAN"}),
    ):
        with pytest.raises(bn.SceneError, match=words):
            again(lambda header: header.update(change))


def test_other_programs_drive_it(observed):
    scene, path = observed
    model = scene.fit_model(FREE, [path])
    assert model.start == [400, 9000] and model.bounds[1] == (4000, 40000)
    fit = model.fit()
    values = np.array(list(fit.values.values()))
    # Weights are held, as those of the fit are in the end.
    sigma = model.predict(values)[1]
    found = optimize.least_squares(lambda x: (model.data - model.predict(x * values)[0]) / sigma, [0.8, 0.9], diff_step=1e-3)
    assert np.all(np.abs(found.x * values - values) < 0.3 * np.array(list(fit.sigma.values())))
    best = model.log_likelihood(values)
    steps = np.array(list(fit.sigma.values()))
    assert all(model.log_likelihood(values + sign * 3 * steps * np.eye(2)[i]) < best for i in range(2) for sign in (-1, 1))
    assert model.log_likelihood([400, 50000]) == -np.inf


def test_likelihoods_hang_on_values_alone(observed):
    scene, path = observed
    free = {"star[0].luminosity": None, "dust.scale": (0.5, 12)}
    places = [[900, 3], [1000, 3.1], [800, 9], [1000, 2.9]]
    likelihoods = [scene.fit_model(free, path).log_likelihood(place) for place in places]
    model = scene.fit_model(free, path)
    assert [model.log_likelihood(place) for place in reversed(places)] == likelihoods[::-1]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(model.log_likelihood, places * 3)) == likelihoods * 3
    model.fit([500, 1])
    assert [model.log_likelihood(place) for place in places] == likelihoods
    for wrong in ([900], [], [900, 3, 5]):
        with pytest.raises(ValueError, match="values for 2 keys"):
            model.predict(wrong)
        with pytest.raises(ValueError, match="values for 2 keys"):
            model.log_likelihood(wrong)


def noisy(scene, seed=3):
    """The picture of a scene with noise of a fiftieth of its brightest pixel, and that."""
    picture = scene.render().radiance.astype(float)
    sigma = 0.02 * picture.max(axis=(1, 2), keepdims=True)
    return picture + sigma * np.random.default_rng(seed).normal(size=picture.shape), np.broadcast_to(sigma, picture.shape)


def test_defaults_of_scipy_and_emcee_find_the_truth():
    scene = lit(cloud())
    scene.bands, scene.camera = ["johnson-B", "cousins-R"], bn.PerspectiveCamera("0 0 4 pc", "32 deg", size=24)
    data, sigma = noisy(scene)
    scene.dust.scale, scene.stars[0].temperature = "1.5 /pc", "7000 K"
    model = scene.fit_model({"dust.scale": (0.2, 10), "star[0].temperature": bn.Free(3000, 40000)}, data, sigma=sigma)
    # A step as scipy takes by itself changes what is predicted, and not by rounding.
    start = np.array(model.start)
    small, large = ((model.residuals(start + [step, 0]) - model.residuals(start)) / step for step in (2e-8, 2e-3))
    assert np.linalg.norm(small - large) < 2e-3 * np.linalg.norm(large)
    truth, steps = np.array([3, 12000]), np.array([0.02, 100])
    plain = optimize.least_squares(model.residuals, model.start)
    bounded = optimize.least_squares(model.residuals, model.start, bounds=np.transpose(model.bounds))
    analytic = optimize.least_squares(model.residuals, model.start, jac=model.jacobian, x_scale=model.x_scale)
    fit = model.fit()
    errors = np.array(list(fit.sigma.values()))
    for found in (plain, bounded, analytic):
        assert found.success and np.all(np.abs(found.x - list(fit.values.values())) < 0.1 * errors), found
        assert np.all(np.abs(found.x - truth) < 4 * errors)
    # The covariance of the fit is that of these derivatives.
    jacobian = model.jacobian(found.x)
    assert np.allclose(np.linalg.inv(jacobian.T @ jacobian), fit.covariance, rtol=0.02)
    differences = [(model.residuals(found.x + h) - model.residuals(found.x - h)) / (2 * h.sum()) for h in np.diag(steps * 1e-3)]
    assert np.allclose(jacobian, np.transpose(differences), atol=1e-4 * np.abs(jacobian).max(axis=0))
    with pytest.warns(UserWarning, match="no model at"):
        assert np.all(np.isinf(model.residuals([3, -5])))


def test_derivatives_by_linear_keys_are_exact():
    scene = lit(cloud())
    scene.camera = bn.PerspectiveCamera("0 0 4 pc", "32 deg", size=16)
    data, sigma = noisy(scene)
    model = scene.fit_model({"star[0].luminosity": bn.Free(100, 1000)}, data, sigma=sigma)
    # At the bound differences are of one side.
    for at in (400.0, 1000.0):
        column = model.jacobian([at])[:, 0]
        assert np.allclose(column, (model.residuals([at]) - model.data / sigma.ravel()) / at, rtol=1e-6, atol=1e-9 * np.abs(column).max())


def test_arrays_and_pictures_are_fitted():
    scene = lit(cloud())
    scene.camera = bn.PerspectiveCamera("0 0 4 pc", "32 deg", size=16)
    picture = scene.render()
    data, sigma = noisy(scene)
    scene.stars[0].luminosity = "600 Lsun"
    of_array = scene.fit(["star[0].luminosity"], data, sigma=sigma)
    assert abs(of_array.values["star[0].luminosity"] - 1000) < 4 * of_array.sigma["star[0].luminosity"]
    # A picture without noise is found to what single precision leaves.
    with pytest.warns(UserWarning, match="chi2"):
        of_picture = scene.fit(["star[0].luminosity"], picture, sigma=sigma)
    assert of_picture.values["star[0].luminosity"] == pytest.approx(1000, rel=1e-5)
    # Pixels of a mask do not count, whatever they hold.
    mask = np.zeros(data.shape, dtype=bool)
    mask[:, :4] = True
    broken = np.where(mask, 1e9, data)
    masked = scene.fit(["star[0].luminosity"], broken, sigma=sigma, mask=mask)
    assert masked.pixels == data.size * 3 // 4
    assert scene.fit(["star[0].luminosity"], [(data, {"sigma": sigma}), (data, {"sigma": sigma})]).pixels == 2 * data.size
    for image, words in ((data, "no standard errors"), (data[:2], "2 bands"), (data[:, :8], "16 x 8 pixels")):
        with pytest.raises(bn.SceneError, match=words):
            scene.fit(["star[0].luminosity"], image, sigma=None if image is data else 1e-9)
    with pytest.raises(ValueError, match="shape"):
        scene.fit(["star[0].luminosity"], data, sigma=sigma[:, :3])
    with pytest.raises(TypeError, match="sigma requires an array"):
        scene.fit(["star[0].luminosity"], "file.fits", sigma=1)


def test_models_are_pickled(observed, monkeypatch, tmp_path):
    import copy
    import pickle

    scene, path = observed
    monkeypatch.chdir(path.parent)
    model = scene.fit_model(FREE, path.name)
    monkeypatch.chdir(tmp_path.parent)
    before = model.log_likelihood(model.start)
    # What becomes of the scene later is nothing to the model.
    scene.stars[0].luminosity = "1 Lsun"
    for twin in (pickle.loads(pickle.dumps(model)), copy.deepcopy(model)):
        assert twin.log_likelihood(model.start) == before


def test_units_and_places_are_said_or_assumed(tmp_path):
    fits = pytest.importorskip("astropy.io.fits")
    scene = lit(cloud())
    scene.bands, scene.camera = "johnson-V", bn.PerspectiveCamera("0 0 1000 pc", "0.12 deg", size=16)
    scene.observation = bn.Observation("83.82 -5.39", unit="MJy/sr")
    picture = scene.render().hdus
    plane = next(hdu for hdu in picture if hdu.header["NAXIS"] == 2)
    path = tmp_path / "image.fits"

    def written(name, unit="MJy/sr", sky=True, more=()):
        header = plane.header.copy()
        header["EXTNAME"], header["BUNIT"] = name, unit
        for keyword in [*(() if unit else ["BUNIT"]), *([] if sky else [key for key in header if key.startswith(("CTYPE", "CRVAL", "CRPIX"))])]:
            del header[keyword]
        image, error = fits.ImageHDU(plane.data, header), fits.ImageHDU(0.01 * plane.data + 1e-9, name="ERR")
        fits.HDUList([fits.PrimaryHDU(), image, error, *more]).writeto(path, overwrite=True)
        return path

    def found(source, **options):
        fit = scene.fit(["star[0].luminosity"], source, **options)
        return fit.values["star[0].luminosity"]

    with pytest.warns(UserWarning, match="chi2"):
        for name in ("johnson-V", "JOHNSON-V", "SCI", "PRIMARY"):
            assert found(written(name)) == pytest.approx(1000, rel=1e-3)
            with pytest.raises(bn.SceneError, match="is in W m-2 sr-1"):
                found(written(name, "W m-2 sr-1"))
            with pytest.raises(bn.SceneError, match="has no unit"):
                found(written(name, ""))
        assert found(written("SCI", ""), assume="unit") == pytest.approx(1000, rel=1e-3)
        with pytest.raises(bn.SceneError, match="no sky coordinates"):
            found(written("SCI", sky=False))
        assert found(written("SCI", "", sky=False), assume=["unit", "place"]) == pytest.approx(1000, rel=1e-3)
        # Weights are no images; one of several images is chosen.
        more = [fits.ImageHDU(np.ones_like(plane.data), name="WHT"), fits.ImageHDU(2 * plane.data, plane.header, name="SCI", ver=2), fits.ImageHDU(0.01 * plane.data + 1e-9, name="ERR", ver=2)]
        with pytest.raises(bn.SceneError, match=r"2 images named SCI; select one with FILE\[SCI,1\]"):
            found(written("SCI", more=more))
        more[1].header["EXTVER"] = 2
        assert found(f"{written('SCI', more=more)}[SCI,2]") == pytest.approx(2000, rel=1e-3)
        assert found(f"{path}[1]") == pytest.approx(1000, rel=1e-3)
    with pytest.raises(bn.SceneError, match="no images DATA"):
        found(f"{path}[DATA]")


def test_walkers_find_the_same(observed):
    emcee = pytest.importorskip("emcee")
    scene, path = observed
    model = scene.fit_model(FREE, path)
    fit = model.fit()
    values, sigma = (np.array(list(each.values())) for each in (fit.values, fit.sigma))
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
    correlation = fit.covariance[0, 1] / (sigma[0] * sigma[1])
    assert abs(np.corrcoef(chain.T)[0, 1] - correlation) < 0.2


def test_images_with_tables_of_their_own(observed, tmp_path):
    scene, path = observed
    other = lit(cloud())
    other.camera = bn.PerspectiveCamera("0 0 1000 pc", "0.12 deg", size=32)
    other.bands = ["sdss2010-g"]
    deep = bn.Instrument(aperture="1 m", read_noise="5 e", sky="21 mag", exposure="4 s", frames=3)
    second = tmp_path / "second.fits"
    other.render().observe(deep).master().write(second)
    together = scene.fit(FREE, [path, (second, {"bands": ["sdss2010-g"], "instrument": deep})])
    alone = scene.fit(FREE, path)
    assert together.pixels > alone.pixels and together.sigma["star[0].luminosity"] < alone.sigma["star[0].luminosity"]
    assert len(together.residuals) == 2


def test_free_keys_are_values_with_units(observed):
    """Quantities, texts in another unit and numbers in the scene's unit are the same bounds; a text of keys is deprecated."""
    scene, path = observed
    forms = [(4e3 * u.K, 40 * u.kK), ("4 kK", "40000 K"), (4000, 40000)]
    models = [scene.fit_model({"star[0].temperature": bn.Free(*form, prior=(9e3 * u.K, "500 K"))}, path) for form in forms]
    assert all(model.bounds == [(4000.0, 40000.0)] and model.units == ["K"] for model in models)
    with pytest.warns(DeprecationWarning, match="give a dictionary") as told:
        assert scene.fit_model("star[0].temperature=4000..40000", path).bounds == models[0].bounds
        scene.fit("star[0].temperature=4000..40000", path)
    assert {warning.filename for warning in told if warning.category is DeprecationWarning} == {__file__}
    for wrong in (3 * u.m, "3 m", "hot", (1, 2)):
        with pytest.raises(bn.SceneError, match=r"star\[0\].temperature"):
            scene.fit_model({"star[0].temperature": bn.Free(wrong)}, path)
    with pytest.raises(bn.SceneError, match="positive standard deviation"):
        scene.fit_model({"star[0].temperature": bn.Free(prior=(9000, 0))}, path)


def test_what_cannot_be_fitted_is_said(observed):
    scene, path = observed
    with pytest.raises(bn.SceneError, match="no value within its bounds"):
        scene.fit({"star[0].luminosity": bn.Free(3, 1)}, path)
    with pytest.raises(bn.SceneError, match="write the key in the scene"):
        scene.fit(["star[0].radius"], path)
    with pytest.raises(ValueError, match="2 keys"):
        scene.fit_model(FREE, path).fit([1.0])
    scene.camera = bn.PerspectiveCamera("0 0 1000 pc", "0.12 deg", size=24)
    with pytest.raises(bn.SceneError, match="32 x 32 pixels"):
        scene.fit(FREE, path)
