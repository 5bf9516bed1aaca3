"""Forty frames by one worker of one thread, and by two: python python/benchmarks/cluster.py"""

from __future__ import annotations

import tempfile
import time

import numpy as np
from distributed import Client, LocalCluster

import barnard as bn
from sweeps import camera, scene

FRAMES = 40


def seconds(workers: int, nebula: bn.Scene) -> float:
    """Seconds that so many workers take, once they have rendered a frame each."""
    cameras = [camera(2 * np.pi * i / FRAMES) for i in range(FRAMES)]
    with (
        LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
        tempfile.TemporaryDirectory() as folder,
    ):
        bn.map(nebula.render, cameras[:workers], client, files=f"{folder}/warm_{{}}.npy", threads=1, progress=False)
        begun = time.perf_counter()
        results = bn.map(nebula.render, cameras, client, files=f"{folder}/{{}}.npy", threads=1, progress=False)
        assert all(result.state == "rendered" for result in results)
        return time.perf_counter() - begun


if __name__ == "__main__":
    nebula = scene(128)
    one, two = seconds(1, nebula), seconds(2, nebula)
    print(f"{FRAMES} frames of 256 x 256: one worker {one:.1f} s, two {two:.1f} s, ratio {two / one:.2f}")
