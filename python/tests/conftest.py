"""Shared parts of tests."""

import os
import sys
from pathlib import Path

import astropy.units as u
import numpy as np
import pytest

import barnard as bn

# Results of earlier runs would hide what is computed now.
os.environ["BARNARD_CACHE"] = "off"
# The writer of the tables stands beside the package.
sys.path.append(str(Path(__file__).parents[1]))


def cloud(n: int = 24) -> np.ndarray:
    """A lopsided cloud, n × n × n of float32, other along every axis."""
    x, y, z = np.meshgrid(*[(np.arange(n) + 0.5) / n * 2 - 1] * 3, indexing="ij")
    return (np.exp(-3 * (x**2 + 2 * y**2 + z**2)) * (1.2 + np.sin(3 * x + y) * np.cos(4 * z))).astype(np.float32)


def lit(density, **grid) -> bn.Scene:
    """A small scene of dust of this density, lit by one star."""
    scene = bn.Scene(bands="johnson", camera=bn.PerspectiveCamera("0 0 4 pc", "32 deg", size=48))
    scene.fields["cloud"] = bn.Grid(density, low="-1 -1 -1 pc", high="1 1 1 pc", **grid)
    scene.dust = bn.Dust("cloud", "3 /pc", albedo=0.6)
    scene.stars.append(bn.Star("0.3 0.2 0.4 pc", temperature="12000 K", luminosity="1000 Lsun", visible=False))
    return scene


def flight() -> bn.Scene:
    """A camera that goes round a lit cloud while its star grows hot."""
    scene = lit(cloud())
    keys = [
        bn.Keyframe(0 * u.s, position=[0, 0, 5] * u.pc, target="0 0 0 pc"),
        bn.Keyframe("1 s", position=[3, 0.5, 4] * u.pc, field_of_view=40 * u.deg),
    ]
    scene.camera = bn.PerspectiveCamera("0 0 5 pc", "32 deg", size=[24, 16], path=bn.CameraPath(key=keys, ease="0.2 s"))
    scene.animation = [bn.Animation("star[0].temperature", [0, 1] * u.s, [5000, 20000] * u.K)]
    scene.sequence = bn.Frames(frames_per_second=10, first_frame=100)
    return scene


def cameras(count: int) -> list[bn.Camera]:
    """So many cameras of small pictures, each from elsewhere."""
    return [bn.PerspectiveCamera(f"{i / 10} 0 4 pc", "32 deg", size=24) for i in range(count)]


@pytest.fixture
def scene() -> bn.Scene:
    return lit(cloud())


@pytest.fixture(scope="module")
def client():
    """A client of Dask with two workers, each a process."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as local:
        with distributed.Client(local) as client:
            yield client
