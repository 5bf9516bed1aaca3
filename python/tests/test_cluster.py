"""Pictures on the workers of a Dask client: files, skipped where they are there, whatever dies."""

import os
import pickle
import signal
import time

import numpy as np
import pytest

import barnard as bn
from barnard import cluster
from conftest import cameras, cloud, lit

distributed = pytest.importorskip("distributed")


def test_frames_land_as_files(client, tmp_path):
    scene = lit(cloud())
    files = str(tmp_path / "frame_{:03}.npy")
    heard = []
    results = bn.map(scene.render, cameras(6), client, files=files, progress=lambda done, whole: heard.append((done, whole)))
    assert [result.state for result in results] == ["rendered"] * 6 and heard[-1] == (6, 6)
    for i, camera in enumerate(cameras(6)):
        assert np.array_equal(np.load(tmp_path / f"frame_{i:03}.npy"), scene.render(camera).radiance)
    # The arrays were laid down once; what is there is not made again.
    assert len(list((tmp_path / ".barnard").glob("*.npy"))) == 1
    (tmp_path / "frame_002.npy").unlink()
    again = bn.map(scene.render, cameras(6), client, files=files, progress=False)
    assert [result.state for result in again] == ["skipped"] * 2 + ["rendered"] + ["skipped"] * 3


def test_tiles_make_the_whole(client, tmp_path):
    scene = lit(cloud())
    scene.camera.size = [60, 44]
    scene.background = bn.Background(stars={"density": "100 /deg2"})
    plan = scene.plan()
    tiles = bn.tiles(plan.camera, 32)
    assert list(tiles) == [(0, 0), (0, 32), (32, 0), (32, 32)]
    results = bn.map(plan.render, tiles, client, files=str(tmp_path / "tile_{:02}_{:02}.npy"), progress=False)
    assert [result.state for result in results] == ["rendered"] * 4, results
    whole = plan.render().radiance
    assembled = np.full_like(whole, np.nan)
    for result in results:
        tile, (row, column) = np.load(result.path), result.key
        assembled[:, row : row + tile.shape[1], column : column + tile.shape[2]] = tile
    # Where rounding decides, a ray of a tile takes a step more or less: far below the accuracy of a step.
    assert np.allclose(assembled, whole, rtol=1e-4, atol=1e-9 * whole.max())
    # Pixels of a tile are where they are in the whole.
    image = plan.render(tiles[32, 32])
    there = plan.render().wcs.pixel_to_world_values(40, 32 + 5), image.wcs.pixel_to_world_values(40 - 32, 5)
    assert np.allclose(*there, atol=1e-12)
    ours, theirs = image.to_xarray(), plan.render().to_xarray()
    assert np.allclose(ours.x, theirs.x[32:]) and np.allclose(ours.y, theirs.y[32:])


def test_an_image_may_be_larger_than_memory():
    scene = lit(cloud())
    scene.camera.size = [40_000, 40_000]
    plan = scene.plan()
    with pytest.raises(bn.MemoryLimitError, match="image"):
        plan.render()
    tile = plan.render({**plan.camera.tree(), "crop": [19968, 19968, 64, 64]})
    assert tile.shape[1:] == (64, 64) and tile.radiance.max() > 0
    with pytest.raises(bn.SceneError, match="whole"):
        bn.tiles(bn.tiles(plan.camera, 20_000)[0, 0])
    with pytest.raises(bn.SceneError, match="out of range"):
        bn.tiles(plan.camera, 0)
    scene.camera.crop = [39_999, 0, 2, 2]
    with pytest.raises(bn.SceneError, match="40000 x 40000") as caught:
        scene.check()
    assert caught.value.key == "camera.crop"


def test_failures_carry_their_key_and_end_no_others(client, tmp_path):
    scenes = {"thin": lit(cloud()), "wrong": lit(cloud()), "thick": lit(3 * cloud())}
    scenes["wrong"].stars[0].temperature = "-5 K"
    results = bn.map(lambda scene: scene.render(), scenes, client, files=str(tmp_path / "{}.npy"), progress=False)
    assert [result.state for result in results] == ["rendered", "failed", "rendered"]
    assert results[1].key == "wrong" and "star[0].temperature" in results[1].error
    assert not (tmp_path / "wrong.npy").exists() and len(list(tmp_path.glob("*.npy"))) == 2


def test_a_killed_worker_costs_its_frame_once(client, tmp_path):
    scene = lit(cloud())

    def render(i):
        if i == 3 and not (tmp_path / "died").exists():
            (tmp_path / "died").touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return scene.render(bn.PerspectiveCamera(f"{i / 10} 0 4 pc", "32 deg", size=24))

    results = bn.map(render, range(8), client, files=str(tmp_path / "{}.npy"), progress=False)
    assert (tmp_path / "died").exists()
    assert [result.state for result in results if result.key == 3] == ["rendered"]
    assert all(result.state in ("rendered", "skipped") for result in results)
    assert len(list(tmp_path.glob("*.npy"))) == 8


def test_arrays_are_mapped_by_all_who_read_a_pickle(tmp_path):
    scene = lit(np.asfortranarray(cloud(32)))
    with cluster.sharing(tmp_path):
        text = pickle.dumps(scene)
    assert len(text) < 4000
    again = pickle.loads(text)
    assert isinstance(again.fields["cloud"].values, np.memmap)
    assert np.array_equal(again.render().radiance, scene.render().radiance)


def test_plans_are_pickled_as_their_scenes():
    scene = lit(cloud())
    plan = scene.plan()
    again = pickle.loads(pickle.dumps(plan))
    assert np.array_equal(again.render().radiance, plan.render().radiance)
    scene.dust.albedo = 0.1
    with pytest.raises(bn.PlanError, match="albedo"):
        pickle.dumps(plan)


def test_what_cannot_be_is_said_before_anything_is_done(client, tmp_path):
    scene = lit(cloud())
    with pytest.raises(bn.BarnardError, match="same file"):
        bn.map(scene.render, cameras(2), client, files=str(tmp_path / "frame.npy"))
    with pytest.raises(bn.BarnardError, match="known"):
        bn.map(scene.render, cameras(2), client, files=str(tmp_path / "frame_{}.gif"))
    with distributed.LocalCluster(n_workers=0, dashboard_address=None) as nobody, distributed.Client(nobody) as idle:
        begun = time.perf_counter()
        with pytest.raises(bn.BarnardError, match="no workers"):
            bn.map(scene.render, cameras(2), idle, files=str(tmp_path / "frame_{}.npy"), timeout=0.5)
        assert time.perf_counter() - begun < 30
