"""Volumes in bricks: any number of them makes the picture of one, and nothing is ever gathered."""

import gc
import os
import signal
import time

import numpy as np
import pytest

import barnard as bn
from conftest import cloud, lit

da = pytest.importorskip("dask.array")


def scene(density) -> bn.Scene:
    """Dust and gas, a star on a corner between bricks, one beside the box and one far away."""
    scene = lit(density)
    scene.stars[0].position = "0 0 0.25 pc"
    scene.stars[0].visible = True
    scene.stars.append(bn.Star("-1.05 0.3 0.2 pc", temperature="6000 K", luminosity="300 Lsun", visible=False))
    scene.stars.append(bn.Star("2 -3 4 pc", temperature="4000 K", luminosity="5000 Lsun", visible=False))
    lines = {"kind": "lines", "scale": "1e-9 W/m2/sr/pc", "lines": [{"wavelength": f"{nm} nm", "strength": 1} for nm in (440, 550, 650)]}
    scene.emission.append(bn.Emission.of({"density": "cloud * (1 + x)", **lines}))
    return scene


def difference(a: bn.Image, b: bn.Image) -> float:
    """The largest difference in a band, in parts of the band's largest value."""
    peaks = b.radiance.max(axis=(1, 2))
    assert (peaks > 0).all()
    return float((np.abs(a.radiance - b.radiance).max(axis=(1, 2)) / peaks).max())


CAMERAS = [
    bn.PerspectiveCamera("0.4 0.3 4 pc", "32 deg", size=40),
    # From inside, towards a corner between bricks.
    bn.PerspectiveCamera("0.1 -0.4 -0.3 pc", "80 deg", target="0 0 0.25 pc", size=40),
    bn.OrthographicCamera("0 0 4 pc", "2.2 pc", size=32, supersampling=2),
]


@pytest.mark.parametrize("camera", CAMERAS, ids=["outside", "inside", "along an axis"])
def test_bricks_make_the_picture_of_one(client, camera):
    density = cloud(32)
    heard = []
    one = bn.render_bricks(scene(da.from_array(density, chunks=32)), client, camera=camera, progress=lambda *now: heard.append(now))
    assert heard[-1] == (3, 3)
    for chunks in [16, ((12, 12, 8), (32,), (16, 16))]:
        many = bn.render_bricks(scene(da.from_array(density, chunks=chunks)), client, camera=camera, progress=False)
        assert difference(many, one) < 1e-6
        assert many.keywords["TAUMAX"] == pytest.approx(one.keywords["TAUMAX"], rel=1e-5)
    # The whole in one piece, planned on itself.
    whole = scene(density).render(camera)
    assert difference(one, whole) < 1e-3
    assert one.certificates and one.keywords["SPATERR"] < 1e-2


def test_coarse_volumes_choose_and_axes_are_turned(client):
    density = cloud(36)

    def scene(density) -> bn.Scene:
        # Pictures of what is diffuse.
        nebula = globals()["scene"](density)
        nebula.stars[0].visible = False
        return nebula

    whole = scene(density).render()
    turned = scene(da.from_array(density.transpose(2, 0, 1), chunks=(18, 12, 20)))
    turned.fields["cloud"].axes = "zxy"
    # A coarse volume of 9 voxels an edge of 4 voxels each says which steps and rules are taken, and no more.
    image = bn.render_bricks(turned, client, coarse=9, progress=False)
    assert difference(image, whole) < 5e-3
    # It is not the picture of the coarse volume.
    blocks = density.reshape(9, 4, 9, 4, 9, 4).mean(axis=(1, 3, 5))
    assert difference(scene(blocks).render(), whole) > 5e-2


@pytest.mark.parametrize("star", [[0.0, 0.0, 0.25], [-1.05, 0.3, 0.2], [20.0, -30.0, 40.0]])
def test_no_sweep_asks_for_much(star):
    """What the sweep of a brick reads is the brick and what stands beside it, wherever the star is."""
    cuts = list(range(0, 129, 16))
    sweep = bn._barnard.StarSweep([128] * 3, ([-1.0] * 3, [1.0] * 3), [cuts] * 3, star)
    cells = lambda voxels: 0 if voxels is None else np.prod([end - start for start, end in voxels])  # noqa: E731
    bricks = [(layer, place) for layer, (_, places) in enumerate(sweep.layers) for place in places]
    assert len(bricks) >= 100 and max(cells(sweep.needs(*brick)) for brick in bricks) < 16 * 16**3
    # Beside a side a strip of four voxels is read as far as rays come; rays come in through one where a star is outside.
    strips = [sweep.border(*brick, side) for brick in bricks for side in (0, 1)]
    assert any(strips) == (max(map(abs, star)) > 1)
    assert all(min(end - start for start, end in strip) == 4 for strip in strips if strip)


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda s: setattr(s, "method", bn.Method(bounces=2)), "multiple scattering"),
        (lambda s: setattr(s, "method", bn.Method(name="lookup")), "spectral method"),
        (lambda s: setattr(s.fields["cloud"], "every", 2), "do not support every"),
        (lambda s: setattr(s.fields["cloud"], "low", None), "requires a box"),
        (lambda s: s.fields.update(ball=bn.Sphere(radius="1.5 pc")) or setattr(s.dust, "density", "cloud + ball"), "beyond the box"),
        (lambda s: s.fields.update(other=bn.Grid(da.zeros((8, 8, 8)), low="-1 -1 -1 pc", high="1 1 1 pc")), "must have the same"),
        (lambda s: s.fields.update(other=bn.Grid(da.zeros((16, 16, 16)), low="-1 -1 -1 pc", high="1 1 2 pc")), "its box differs"),
        (lambda s: s.fields.update(cloud=bn.Grid(cloud(8), low="-1 -1 -1 pc", high="1 1 1 pc")), "no field is bricked"),
    ],
)
def test_what_bricks_cannot_do_is_said(client, change, words):
    wrong = scene(da.from_array(cloud(16), chunks=8))
    change(wrong)
    with pytest.raises(bn.SceneError, match=words):
        bn.render_bricks(wrong, client, progress=False)


def test_bad_values_are_told(client):
    density = cloud(16)
    density[3, 12, 9] = -1e-3
    with pytest.raises(bn.SceneError, match="negative"):
        bn.render_bricks(scene(da.from_array(density, chunks=8)), client, coarse=8, progress=False)
    clipped = scene(da.from_array(density, chunks=8))
    clipped.fields["cloud"].clip = True
    assert np.isfinite(bn.render_bricks(clipped, client, progress=False).radiance).all()


def test_densities_are_made_brick_by_brick(client):
    """Thresholds that means would not pass, and fields that end within the box, are those of the whole."""
    density = cloud(24)
    density[density < np.quantile(density, 0.98)] *= 0.1

    def made(density):
        nebula = scene(density)
        nebula.stars[0].visible = False
        nebula.fields["ball"] = bn.Sphere(radius="0.2 pc", centre="0.45 0.4 0.1 pc")
        nebula.dust.density = f"max(cloud - {0.5 * float(np.max(cloud(24)))}, 0) * 4 + 0.3 * ball"
        return nebula

    bricks = bn.render_bricks(made(da.from_array(density, chunks=12)), client, coarse=8, progress=False)
    assert difference(bricks, made(density).render()) < 5e-3


@pytest.mark.parametrize("what", ["gas alone", "no stars", "a star on a voxel", "half", "flat voxels", "no camera"])
def test_scenes_of_all_kinds(client, what):
    def made(density):
        nebula = scene(density)
        nebula.stars[0].visible = False
        if what == "gas alone":
            nebula.dust = None
        elif what == "no stars":
            nebula.stars.clear()
        elif what == "a star on a voxel":
            nebula.stars[0].position = "0 0 0 pc"
        elif what == "half":
            nebula.method = bn.Method(volumes="half")
        elif what == "flat voxels":
            nebula.fields["cloud"].high = "1 1.5 0.4 pc"
        elif what == "no camera":
            nebula.camera = None
        return nebula

    density = cloud(17)
    camera = CAMERAS[0] if what == "no camera" else None
    bricks = [da.from_array(density, chunks=chunks) for chunks in (17, (9, 4, 17))]
    one, many = (bn.render_bricks(made(density), client, camera=camera, progress=False) for density in bricks)
    assert difference(many, one) < 1e-6
    assert difference(one, made(density).render(camera)) < 3e-3


def test_nothing_is_left_behind(client):
    def stop(done, whole):
        if done > 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        bn.render_bricks(scene(da.from_array(cloud(24), chunks=8)), client, progress=stop)
    gc.collect()
    for _ in range(100):
        if not any(client.has_what().values()):
            break
        time.sleep(0.1)
    assert not any(client.has_what().values())


def test_a_wrong_camera_is_told_at_once(client):
    def never(block):
        raise AssertionError("it was read")

    density = da.from_array(cloud(16), chunks=8).map_blocks(never, dtype=np.float32, meta=np.empty((0, 0, 0), np.float32))
    with pytest.raises(bn.SceneError, match="camera"):
        bn.render_bricks(scene(density), client, camera={"kind": "perspective", "position": "0 0 4 pc", "field_of_view": "200 deg"}, progress=False)


def test_a_field_in_bricks_is_no_array():
    nebula = scene(da.from_array(cloud(16), chunks=8))
    for use in (nebula.render, nebula.check, nebula.to_toml, lambda: nebula.save("bricks.toml")):
        with pytest.raises(bn.SceneError, match="render_bricks"):
            use()
    with pytest.raises(bn.SceneError, match="three axes"):
        bn.Grid(da.zeros((8, 8)))


def test_killed_workers_are_made_up_for():
    """What they had is computed anew by the others: the same bits, early and late."""
    distributed = pytest.importorskip("distributed")
    nebula = scene(da.from_array(cloud(16), chunks=8))
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as local:
        with distributed.Client(local) as client:
            whole = bn.render_bricks(nebula, client, camera=CAMERAS[0], progress=False)
            for share in (0.5, 0.8):
                client.wait_for_workers(2, timeout=60)
                victims = [min(client.run(os.getpid).values())]

                def kill(done, all, share=share, victims=victims):
                    if victims and done >= share * all:
                        os.kill(victims.pop(), signal.SIGKILL)

                again = bn.render_bricks(nebula, client, camera=CAMERAS[0], progress=kill)
                assert not victims and np.array_equal(again.radiance, whole.radiance)
