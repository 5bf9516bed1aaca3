"""Plans that are kept, sweeps, progress, interruption and images."""

import _thread
import json
import pickle
import signal
import threading
import time

import astropy.units as u
import numpy as np
import pytest

import barnard as bn
from conftest import cloud, lit


def test_a_kept_plan_gives_the_same_bits(scene):
    scene.render()
    for change in [
        lambda s: setattr(s.stars[0], "temperature", "5000 K"),
        lambda s: setattr(s, "bands", "bessell-V"),
        lambda s: setattr(s.camera, "position", "3 1 2 pc"),
        lambda s: setattr(s.dust, "scale", "5 /pc"),
        lambda s: setattr(s.stars[0], "position", "0 0.5 0 pc"),
    ]:
        change(scene)
        fresh = lit(cloud())
        for name in ("bands", "camera", "dust", "stars"):
            setattr(fresh, name, getattr(scene, name))
        assert np.array_equal(scene.render().radiance, fresh.render().radiance)


def test_a_plan_renders_what_it_was_made_of(scene):
    plan = scene.plan()
    assert np.array_equal(plan.render().radiance, scene.render().radiance)
    other = bn.PerspectiveCamera("1 1 4 pc", "32 deg", size=[40, 30])
    assert plan.render(other).shape == (3, 30, 40)
    assert plan.terms > 0 and plan.bytes > 1000 and plan.certificates["johnson-V"][0].absolute < plan.accuracy
    scene.stars[0].temperature = "5000 K"
    with pytest.raises(bn.PlanError) as caught:
        plan.render()
    assert caught.value.key == "star[0].temperature"


def test_sweeps(scene):
    temperatures = [4000, 8000, 16000] * u.K
    images = list(scene.sweep({"star[0].temperature": temperatures}))
    assert scene.stars[0].temperature == "12000 K"
    assert [image.parameters["star[0].temperature"] for image in images] == list(temperatures)
    scene.stars[0].temperature = 8000 * u.K
    assert np.array_equal(images[1].radiance, scene.render().radiance)
    blue = [image["B"].sum() / image["R"].sum() for image in images]
    assert blue == sorted(blue)
    cameras = [bn.PerspectiveCamera([0, 0, d] * u.pc, "32 deg", size=16) for d in (3, 4)]
    near, far = scene.sweep(camera=cameras)
    assert near["V"].sum() > far["V"].sum()


@pytest.mark.parametrize(
    "parameters, words",
    [
        ({}, "one parameter is required"),
        ({"star[0].temperature": ["1 K"], "dust.albedo": [0.1, 0.2]}, "same number of values"),
        ({"star[3].temperature": ["1 K"]}, "no .star.3"),
        ({"star[0].temprature": ["1 K"]}, "did you mean"),
        ({"star[0]": [1]}, "not a key"),
    ],
)
def test_sweeps_of_no_parameter_are_refused(scene, parameters, words):
    with pytest.raises(bn.SceneError, match=words):
        scene.sweep(parameters)


def test_layers_add_up(scene):
    assert scene.render().layers == {}
    scene.output = bn.Output(layers=["all"])
    scene.emission = [bn.Emission("lines", "cloud", name="Ha", lines=[{"wavelength": "656.3 nm", "strength": 1}], scale="1e-24 W/m3/sr")]
    image = scene.render()
    layers = image.layers
    assert list(layers) == ["scattered", "emission.Ha", "depth", "tau"]
    assert np.allclose(layers["scattered"] + layers["emission.Ha"], image.radiance, rtol=1e-5)
    assert all(layers[name].max() > 0 for name in layers)
    assert layers["depth"].shape == layers["tau"].shape == image.shape[1:]
    lit_up = np.isfinite(layers["depth"])
    # The box is from 3 to 5 pc away.
    assert lit_up.any() and 3 < layers["depth"][lit_up].min() and layers["depth"][lit_up].max() < 5.2


def test_detail_is_seen_from_near_by(scene):
    scene.camera.size = 16
    far = scene.render()
    scene.detail = bn.Detail(strength=0.2)
    assert scene.detail.octaves is None and np.array_equal(scene.render().radiance, far.radiance)
    scene.camera.field_of_view = 0.5 * u.deg
    near = scene.render()
    scene.detail = None
    plain = scene.render()
    assert not np.allclose(near.radiance, plain.radiance, rtol=5e-3, atol=0)
    with pytest.raises(bn.SceneError, match="octves.*octaves"):
        scene.detail = {"octves": 3}


def test_fields_are_made_of_fields(scene):
    inline = scene.render()
    scene.fields["twice"] = bn.Expression("2 * cloud")
    scene.dust.density = "0.5 * twice"
    assert np.allclose(scene.render().radiance, inline.radiance, rtol=1e-6)


def test_glare_is_for_pictures_alone(scene):
    scene.stars[0].visible = True
    plain = scene.render()
    scene.display = bn.Display(glare={"optics": "webb", "size": 4, "rotation": 10 * u.deg})
    glaring = scene.render()
    assert np.array_equal(plain.radiance, glaring.radiance)
    assert not np.array_equal(plain.rgb(), glaring.rgb()) and np.array_equal(glaring.rgb(glare=None), plain.rgb())
    with pytest.raises(bn.SceneError, match="weeb.*webb"):
        bn.Display(glare=bn.Glare(optics="weeb"))
        scene.display.glare.optics = "weeb"
        scene.render()


def test_progress_is_told(scene):
    heard = []
    scene.camera.size = 400
    scene.render(progress=lambda stage, done, whole: heard.append((stage, done, whole)))
    assert heard and {stage for stage, _, _ in heard} <= {"star depths", "light", "rays"}
    assert all(0 <= done <= whole for _, done, whole in heard)
    with pytest.raises(ZeroDivisionError):
        lit(cloud()).render(progress=lambda stage, done, whole: 1 / 0, backend="reference")


@pytest.fixture
def ctrl_c():
    """Python's own answer to Ctrl-C: workers of pytest-xdist ignore it, and dask_jobqueue exits."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_ctrl_c_stops_soon_and_keeps_the_process(scene, ctrl_c):
    scene.camera.size = 512
    for backend, options in [("reference", {"accuracy": 1e-8}), ("path", {"samples": 100_000})]:
        threading.Timer(0.5, _thread.interrupt_main).start()
        begun = time.perf_counter()
        with pytest.raises(KeyboardInterrupt):
            scene.render(backend=backend, **options)
        assert time.perf_counter() - begun < 2
    scene.camera.size = 16
    assert scene.render()["V"].max() > 0


def test_threads_render_at_once():
    scenes = [lit((i + 1) * cloud()) for i in range(4)]
    alone = [lit((i + 1) * cloud()).render().radiance for i in range(4)]
    images = [None] * 4

    def work(i):
        images[i] = scenes[i].render().radiance

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(a, b) for a, b in zip(images, alone))


def test_numbers_of_threads_give_the_same_bits(scene):
    expected = scene.render().radiance
    try:
        for count in (1, 3):
            bn.set_threads(count)
            assert np.array_equal(lit(cloud()).render().radiance, expected)
        with pytest.raises(ValueError):
            bn.set_threads(10**9)
    finally:
        bn.set_threads(0)


def test_a_forked_process_renders(scene):
    import multiprocessing

    expected = scene.render().radiance
    with multiprocessing.get_context("fork").Pool(1) as pool:
        assert np.array_equal(pool.apply_async(_rendered, (scene,)).get(timeout=60), expected)


def _rendered(scene):
    return scene.render().radiance


def test_back_ends_agree(scene):
    scene.camera.size = 12
    scene.method = {"accuracy": 1e-3}
    truth = scene.render(backend="reference", accuracy=1e-6)
    assert truth.radiance.dtype == np.float64
    image = scene.render()
    off = np.sqrt(((image.radiance - truth.radiance) ** 2).sum() / (truth.radiance**2).sum())
    assert 0 < off < 5e-3
    paths = scene.render(backend="path", samples=64)
    assert paths.bands[3:] == ["johnson-B_error", "johnson-V_error", "cousins-R_error"]
    sigma = paths["V_error"].value.ravel()
    residuals = (paths["V"].value.ravel() - truth["V"].value.ravel())[sigma > 0] / sigma[sigma > 0]
    assert 0.5 < residuals.std() < 2
    for wrong in [{"accuracy": 1e-3}, {"samples": 3}, {"backend": "path", "target_error": 2.0}, {"backend": "cup"}]:
        with pytest.raises(bn.SceneError):
            scene.render(**wrong)


def test_images(tmp_path, scene):
    scene.camera.size = [40, 30]
    image = scene.render()
    assert image.bands == ["johnson-B", "johnson-V", "cousins-R"] and image.shape == image.radiance.shape == np.asarray(image).shape == (3, 30, 40)
    assert image["V"].unit.is_equivalent(u.MJy * u.Hz / u.sr)
    with pytest.raises(KeyError, match="not a band.*johnson-B, johnson-V, cousins-R"):
        image["U"]
    image.write(tmp_path / "a.fits")
    from astropy.io import fits

    with fits.open(tmp_path / "a.fits") as hdus:
        planes = [hdu for hdu in hdus if hdu.data is not None]
        # Rows of FITS begin at the bottom.
        assert any(np.array_equal(np.squeeze(hdu.data)[::-1], image.radiance[1]) for hdu in planes)
        assert hdus[0].header["SPATERR"] == image.keywords["SPATERR"]
    with pytest.raises(bn.BarnardError, match="known"):
        image.write(tmp_path / "a.gif")
    with pytest.raises(bn.BarnardError):
        image.write(tmp_path / "nowhere" / "a.fits")
    scale = abs(image.wcs.wcs.cdelt[0])
    array = image.to_xarray()
    assert array.dims == ("band", "y", "x") and array.sel(band="johnson-V").shape == (30, 40)
    assert np.isclose(float(array.x[1] - array.x[0]), scale, rtol=1e-6)
    assert abs(image.certificates["johnson-B"][0].absolute) < 1e-3 and "method" in image.notes


def test_pictures(scene):
    image = scene.render()
    picture = image.rgb()
    assert picture.shape == (48, 48, 3) and picture.dtype == np.uint8 and picture.max() > 200
    assert not np.array_equal(image.rgb(stretch="linear"), picture)
    assert "data:image/png;base64," in image._repr_html_() and "F(0)" in image._repr_html_()
    # A notebook keeps every representation: the picture is in one of them alone.
    assert not hasattr(image, "_repr_png_")
    with pytest.raises(bn.SceneError, match="stretch"):
        image.rgb(stretch="nothing")
    with pytest.raises(bn.SceneError, match="did you mean"):
        image.rgb(strech="log")


def test_infrared_to_the_unit_of_maps(scene):
    scene.bands = "hst-wfc3"
    image = scene.render()
    band = image.bands[0]
    assert image[band].to(u.W / u.m**2 / u.arcsec**2).value.max() > 0


@pytest.mark.skipif("gpu" not in bn.catalogue("backends"), reason="the package was built without devices")
def test_devices_stay_open(scene):
    try:
        first = scene.render(backend="gpu").radiance
    except bn.DeviceError:
        pytest.skip("NOT CHECKED: there is no graphics adapter")
    assert np.allclose(first, scene.render().radiance, rtol=2e-3, atol=1e-5 * first.max())
    scene.stars[0].temperature = "30000 K"
    hotter = scene.render(backend="gpu").radiance
    assert not np.array_equal(hotter, first)
    # The plan that lies on the device is renewed, and another scene takes its place.
    scene.stars[0].temperature = "12000 K"
    assert np.array_equal(scene.render(backend="gpu").radiance, first)
    other = lit(2 * cloud())
    assert np.allclose(other.render(backend="gpu").radiance, other.render().radiance, rtol=2e-3, atol=1e-5 * first.max())


def test_images_of_all_around_have_their_coordinates():
    # ARC and CAR by astropy beside closed forms: x to the right, y upwards, both from the axis of view.
    pytest.importorskip("astropy")
    scene = lit(cloud())
    for camera, half in [
        (bn.FisheyeCamera("0 0 0 pc", target="0 0 -1 pc", size=24), np.pi / 2),
        (bn.FisheyeCamera("0 0 0 pc", target="0 0 -1 pc", aperture="360 deg", tilt="90 deg", size=24), np.pi),
        (bn.EquirectangularCamera("0 0 0 pc", target="0 0 -1 pc", size=[24, 12]), np.pi),
    ]:
        scene.camera = camera
        image = scene.render()
        wcs, (_, height, width) = image.wcs, image.shape
        column, row = np.meshgrid(np.arange(width), np.arange(height))
        x, y = (column + 0.5 - width / 2) * 2 * half / width, (height / 2 - row - 0.5) * 2 * half / width
        lon, lat = np.radians(wcs.wcs_pix2world(column.ravel(), row.ravel(), 0)).reshape(2, height, width)
        found = np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)])
        if "ARC" in wcs.wcs.ctype[0]:
            r = np.hypot(x, y)
            truth = np.stack([np.cos(r), np.sin(r) / r * x, np.sin(r) / r * y])
            seen = r < half
        else:
            truth = np.stack([np.cos(y) * np.cos(x), np.cos(y) * np.sin(x), np.sin(y)])
            seen = np.abs(y) < np.pi / 2
        assert np.abs(found - truth)[:, seen].max() < 1e-9, wcs.wcs.ctype[0]


def test_reports_have_the_numbers_of_headers():
    """The report of an image is that of its keywords and of JSON, also for plates and after pickling; exact back ends certify nothing."""
    scene = lit(cloud())
    image = scene.render()
    report = image.report
    assert report.backend == "cpu" and report.method == scene.plan().method and report.steps == scene.plan().steps
    assert report.spatial_error.error == image.keywords["SPATERR"] and report.accuracy == image.keywords["ACCURACY"]
    worst = max(certificate.absolute for lights in report.certificates.values() for certificate in lights)
    assert report.spectral_error == worst and report.misses_accuracy == (report.spatial_error.error > report.accuracy)
    assert json.loads(report.to_json())["spatial_error"]["pilot_rays"] == image.keywords["SPATRAYS"]
    assert pickle.loads(pickle.dumps(image)).report == report
    plates = scene.plates()
    assert plates.expose(scene).certificates.keys() == image.certificates.keys() and plates.expose(scene).report.backend == "plates"
    path = scene.render(backend="path", samples=4, seed=3)
    assert path.report.paths == {"per_pixel": 4, "seed": 3, "skipped": 0} and path.report.certificates == {}
    assert path.report.spectral_error is None and "johnson-V_error" in path.bands
