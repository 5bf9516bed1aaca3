"""Plates: pictures of other spectra without a march."""

import barnard as bn
import numpy as np
import pytest

u = pytest.importorskip("astropy.units")


def test_spectra_change_without_a_march(tmp_path, scene):
    nebula = scene
    plates = nebula.plates(range=(380 * u.nm, "1 um"))
    assert plates.shape == (48, 48) and plates.lights == 1 and "1 lights, 48 x 48 pixels" in repr(plates)
    low, high = plates.range
    assert low <= 0.3801 and high >= 0.9999
    nebula.stars[0].temperature = "25000 K"
    nebula.bands = "sdss"
    nebula.dust.albedo = 0.3
    with pytest.raises(bn.SceneError, match="outside of the range"):
        plates.expose(nebula)
    nebula.bands = ["sdss2010-g", "sdss2010-r"]
    image, fresh = plates.expose(nebula), nebula.render()
    for band in ("sdss2010-g", "sdss2010-r"):
        a, b = np.asarray(image[band], float), np.asarray(fresh[band], float)
        assert np.abs(a - b).max() < 2e-3 * b.max()
    path = tmp_path / "nebula.plates"
    plates.write(path)
    again = bn.Plates.read(path).expose(nebula)
    assert np.array_equal(again["sdss2010-g"], image["sdss2010-g"])
    with np.load(path) as arrays:
        assert arrays["plate_0_level"].shape == (48, 48) and arrays["plate_0_coordinates"].dtype == np.uint16
    nebula.dust.scale = "4 /pc"
    with pytest.raises(bn.SceneError, match="amount of dust"):
        plates.expose(nebula)


def test_dust_changes_without_a_march(scene):
    plates = scene.plates(dust=(0.5, 2))
    scale = float(scene.dust.scale.split()[0])
    for factor in (0.55, 1.9):
        scene.dust.scale = f"{factor * scale} /pc"
        image, fresh = plates.expose(scene), scene.render()
        for band in fresh.bands:
            a, b = np.asarray(image[band], float), np.asarray(fresh[band], float)
            assert np.abs(a - b).max() < 2e-3 * b.max()
    with pytest.raises(bn.SceneError, match="dust range of plates"):
        scene.plates(dust=(2, 3))


def test_what_is_no_range_is_refused(scene):
    with pytest.raises(bn.SceneError, match="unit"):
        scene.plates(range=(380, 900))
    with pytest.raises(bn.SceneError, match="range of plates"):
        scene.plates(range=("900 nm", "400 nm"))
    with pytest.raises(bn.SceneError, match="is not an .npz archive"):
        bn.Plates.read(__file__)
