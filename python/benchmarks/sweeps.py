"""Sweeps beside as many runs of the command: python python/benchmarks/sweeps.py [COMMAND]

COMMAND is the program `barnard`, `python -m barnard` where it is not given. 256 × 256 pixels, a cloud of 128³ voxels, one star.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import barnard as bn
from barnard._tree import place_of

COUNT = 20


def scene(edge: int) -> bn.Scene:
    """A cloud of edge³ voxels from memory, lit by one star."""
    x = (np.arange(edge, dtype=np.float32) + 0.5) / edge * 2 - 1
    x, y, z = np.meshgrid(x, x, x, indexing="ij")
    cloud = np.exp(-3 * (x**2 + y**2 + z**2)) * (1.2 + np.sin(9 * x + 2 * y) * np.cos(11 * z - 3 * y))
    scene = bn.Scene(bands="johnson", camera=camera(0.0))
    scene.fields["cloud"] = bn.Grid(np.asfortranarray(cloud.astype(np.float32)), low="-1 -1 -1 pc", high="1 1 1 pc")
    scene.dust = bn.Dust("cloud", "3 /pc", albedo=0.6)
    scene.stars.append(bn.Star("0.3 0.2 0.4 pc", temperature="12000 K", luminosity="1000 Lsun"))
    return scene


def camera(angle: float) -> bn.Camera:
    """A camera that looks at the cloud from around it."""
    return bn.PerspectiveCamera(f"{4 * np.sin(angle)} 0 {4 * np.cos(angle)} pc", "32 deg", size=256)


def timed(work) -> float:
    """Seconds of some work."""
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun


def by_command(command: list[str], scenes: list[bn.Scene]) -> float:
    """Seconds that the command takes for some scenes, one run each."""
    with tempfile.TemporaryDirectory() as folder:
        for i, each in enumerate(scenes):
            each.save(Path(folder) / f"{i}.toml")
        run = lambda i: subprocess.run([*command, "render", f"{folder}/{i}.toml", "-o", f"{folder}/{i}.npy"], check=True, stdout=-3)  # noqa: E731
        return timed(lambda: [run(i) for i in range(len(scenes))])


def table(command: list[str]) -> None:
    """Prints the table."""
    temperatures = [f"{4000 + 1500 * i} K" for i in range(COUNT)]
    cameras = [camera(2 * np.pi * i / COUNT) for i in range(COUNT)]
    print(f"| {COUNT} pictures | first [s] | each further [s] | `barnard render`, each [s] | ratio |\n|---|---|---|---|---|")
    for name, place, values in [("star temperatures", "star[0].temperature", temperatures), ("cameras", "camera", cameras)]:
        nebula, times = scene(128), []
        images = nebula.sweep({place: values})
        while True:
            begun = time.perf_counter()
            if next(images, None) is None:
                break
            times.append(time.perf_counter() - begun)
        scenes = []
        for value in values[:5]:
            other = scene(128)
            owner, key = place_of(other, place)
            setattr(owner, key, value)
            scenes.append(other)
        alone = by_command(command, scenes) / len(scenes)
        further = float(np.median(times[1:]))
        print(f"| {name} | {times[0]:.3f} | {further:.3f} | {alone:.3f} | {further / alone:.2f} |")
    nebula = scene(128)
    plan = nebula.plan()
    from_plan = [timed(lambda c=c: plan.render(c)) for c in cameras]
    print(f"| cameras, `plan.render` | | {np.median(from_plan):.3f} | | |")
    tiny = scene(16)
    tiny.camera = bn.PerspectiveCamera("0 0 4 pc", "32 deg", size=8)
    plan = tiny.plan()
    plan.render()
    print(f"\nA picture of 8 x 8 pixels by a kept plan: {1e3 * np.median([timed(plan.render) for _ in range(50)]):.2f} ms")


def peak() -> None:
    """Prints what a grid of 256³ in single precision costs beside the array itself."""
    # Filled in place: the most memory so far is that of the array itself.
    array = np.empty((256, 256, 256), np.float32, order="F")
    array[...] = 0.5
    nebula = bn.Scene(bands="johnson", camera=camera(0.0), dust=bn.Dust("n", "3 /pc", albedo=0.6))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    nebula.fields["n"] = bn.Grid(array, low="-1 -1 -1 pc", high="1 1 1 pc")
    nebula.check()
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(f"A grid of 256³ (64 MiB): {(after - before) / 1024:.1f} MiB more at most when its scene is read")


if __name__ == "__main__":
    print(f"{os.cpu_count()} cores")
    peak()
    table(sys.argv[1:] or [sys.executable, "-m", "barnard"])
