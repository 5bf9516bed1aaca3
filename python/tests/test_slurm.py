"""Pictures on workers that Slurm started; `.ci/slurm` starts one of a single machine."""

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import barnard as bn
from barnard import cluster
from conftest import cameras, cloud, flight, lit

if "SLURM_CONF" not in os.environ:
    pytest.skip("NOT CHECKED: no Slurm is at hand; `.ci/slurm start FOLDER` starts one, SLURM_CONF names its configuration", allow_module_level=True)

distributed = pytest.importorskip("distributed")
jobqueue = pytest.importorskip("dask_jobqueue")


@pytest.fixture
def client(tmp_path):
    logs = str(tmp_path / "logs")
    jobs = jobqueue.SLURMCluster(
        cores=1,
        processes=1,
        memory="1GB",
        walltime="00:10:00",
        log_directory=logs,
        local_directory=logs,
        scheduler_options={"dashboard_address": None},
    )
    with jobs, distributed.Client(jobs) as client:
        jobs.scale(jobs=2)
        client.wait_for_workers(2, timeout=60)
        yield client


def running() -> list[str]:
    return subprocess.run(["squeue", "--noheader", "--states=running", "--format=%i"], capture_output=True, text=True, check=True).stdout.split()


def test_jobs_of_slurm_render_frames(client, tmp_path):
    assert len(running()) == 2 and cluster._threads(client) == 1
    scene, files = lit(cloud()), str(tmp_path / "frame_{:03}.npy")
    results = bn.map(scene.render, cameras(6), client, files=files, progress=False)
    assert [result.state for result in results] == ["rendered"] * 6, results
    for i, camera in enumerate(cameras(6)):
        assert np.array_equal(np.load(tmp_path / f"frame_{i:03}.npy"), scene.render(camera).radiance)


def test_a_job_that_is_cancelled_costs_no_picture(client, tmp_path):
    scene, cancelled = lit(cloud()), []

    def render(camera):
        time.sleep(0.3)
        return scene.render(camera)

    def cancel(done, whole):
        if done == 2 and not cancelled:
            cancelled.append(running()[0])
            subprocess.run(["scancel", "--full", "--signal=KILL", cancelled[0]], check=True)

    results = bn.map(render, cameras(12), client, files=str(tmp_path / "{:03}.npy"), threads=1, progress=cancel)
    assert cancelled and cancelled[0] not in running()
    assert [result.state for result in results] == ["rendered"] * 12, results


def test_an_array_of_jobs_renders_bookmarks(tmp_path):
    scene = lit(cloud())
    scene.bookmarks = {f"view{i}": camera for i, camera in enumerate(cameras(3))}
    scene.save(tmp_path / "scene.toml")
    script = tmp_path / "frames.sh"
    script.write_text(
        "#!/bin/bash\n#SBATCH --array=0-2\n#SBATCH --output=/dev/null\n"
        f"{sys.executable} -m barnard render scene.toml --bookmark view$SLURM_ARRAY_TASK_ID -o frame_$SLURM_ARRAY_TASK_ID.npy\n"
    )
    subprocess.run(["sbatch", "--wait", script], cwd=tmp_path, check=True, timeout=120)
    for i, camera in enumerate(cameras(3)):
        assert np.array_equal(np.load(tmp_path / f"frame_{i}.npy"), scene.render(camera).radiance)


def test_the_recipe_for_a_flight(tmp_path):
    """The script of docs/shows.md, for three jobs of this machine in place of forty of a farm."""
    text = (Path(__file__).parents[2] / "docs" / "shows.md").read_text()
    script = re.search(r"```\n(#!/bin/sh\n#SBATCH.*?)```", text, re.S)[1]
    changes = {"1-40": "1-3", "/40": "/3", "--cpus-per-task=8": "--cpus-per-task=1", "--mem=8G": "--output=/dev/null"}
    for before, after in {**changes, "barnard render": f"{sys.executable} -m barnard render"}.items():
        assert before in script
        script = script.replace(before, after)
    scene = flight()
    scene.save(tmp_path / "flight.toml")
    (tmp_path / "frames").mkdir()
    (tmp_path / "flight.sh").write_text(script.replace(".exr", ".npy"))
    subprocess.run(["sbatch", "--wait", "flight.sh"], cwd=tmp_path, check=True, timeout=180)
    frames = scene.frames()
    assert sorted(path.name for path in (tmp_path / "frames").glob("*.npy")) == [f"flight_{number:06}.npy" for number in frames.numbers]
    for number in (frames.numbers[0], frames.numbers[4]):
        assert np.array_equal(np.load(tmp_path / "frames" / f"flight_{number:06}.npy"), frames.render(number).radiance)
