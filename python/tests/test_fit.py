"""Fits of scenes to observed images, also as other programs drive them."""

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
    assert 0.8 < np.nanstd(pull) < 1.2


def test_other_programs_drive_it(observed):
    scene, path = observed
    model = scene.fit_model(FREE, [path])
    assert model.start == [400, 9000] and model.bounds[1] == (4000, 40000)
    own = model.fit()
    values = np.array(list(own.values.values()))
    # Weights are held, as those of the fit are in the end.
    sigma = model.predict(values)[1]
    found = optimize.least_squares(lambda x: (model.data - model.predict(x * values)[0]) / sigma, [0.8, 0.9], diff_step=1e-3)
    assert np.abs(found.x * values - values).max() < 0.2 * min(own.sigma.values()) or np.all(
        np.abs(found.x * values - values) < 0.3 * np.array(list(own.sigma.values()))
    )
    best = model.log_likelihood(values)
    steps = np.array(list(own.sigma.values()))
    assert all(model.log_likelihood(values + sign * 3 * steps * np.eye(2)[i]) < best for i in range(2) for sign in (-1, 1))
    assert model.log_likelihood([400, 50000]) == -np.inf


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
