"""Pictures on the workers of a Dask client: files, skipped where they are there, whatever dies."""

import os
import pickle
import signal
import time

import numpy as np
import pytest

import barnard as bn
from barnard import cluster
from conftest import cloud, lit

distributed = pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def client():
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as local:
        with distributed.Client(local) as client:
            yield client


def cameras(count):
    return [bn.perspective(f"{i / 10} 0 4 pc", "32 deg", size=24) for i in range(count)]


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
        return scene.render(bn.perspective(f"{i / 10} 0 4 pc", "32 deg", size=24))

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
        bn.map(scene.render, cameras(2), client, files=str(tmp_path / "frame_{}.jpeg"))
    with distributed.LocalCluster(n_workers=0, dashboard_address=None) as nobody, distributed.Client(nobody) as idle:
        begun = time.perf_counter()
        with pytest.raises(bn.BarnardError, match="no workers"):
            bn.map(scene.render, cameras(2), idle, files=str(tmp_path / "frame_{}.npy"), timeout=0.5)
        assert time.perf_counter() - begun < 30
