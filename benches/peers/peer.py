"""Arguments and clock of the peers' scripts."""

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scenes import METRES_PER_PARSEC, SCENES, Scene


@dataclass(frozen=True)
class Job:
    """One picture to render."""

    scene: Scene
    orders: str
    cloud: np.ndarray
    samples: int
    denoise: bool
    out: Path


def run(render: Callable[[Job], np.ndarray]) -> None:
    """Renders and writes `out` [row, column, band; W m-2 sr-1], then prints CPU seconds without the imports."""
    arguments = argparse.ArgumentParser()
    arguments.add_argument("scene")
    arguments.add_argument("orders", choices=("one", "all"))
    arguments.add_argument("samples", type=int)
    arguments.add_argument("--denoise", action="store_true")
    arguments.add_argument("--cloud", type=Path, required=True)
    arguments.add_argument("--out", type=Path, required=True)
    asked = vars(arguments.parse_args())
    cloud, scene = np.load(asked.pop("cloud")), SCENES[asked.pop("scene")]
    start = time.process_time()
    picture = render(Job(scene=scene, cloud=cloud, **asked))
    if scene.star is not None:
        picture = picture / METRES_PER_PARSEC**2
    np.save(asked["out"], picture)
    print(f"\nCPU seconds {time.process_time() - start:.3f}")
