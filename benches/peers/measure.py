"""Error and CPU time of Barnard and its peers: `python measure.py FOLDER [PROGRAM ...]` appends to FOLDER/measured.csv.

The folder keeps the cloud, the truths and the measurements; what is there is not made again.
"""

import csv
import os
import resource
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy.ndimage import map_coordinates, uniform_filter
from scenes import DISTANCE, FIELD_OF_VIEW, GLOW, SCENES, SIZE, STRIDE, WAVELENGTHS, Scene, cloud, toml

HERE = Path(__file__).parent
PATHS = 4096
"""Paths per pixel and band of each of the two truths with all scatterings."""
SETTINGS = {
    "barnard": (0.3, 0.1, 0.05, 0.02, 0.01, 0.003, 0.001),
    "mitsuba": (1, 4, 16, 64),
    "cycles": (1, 4, 16, 64),
    "vtk": (1, 4),
}
"""Allowed errors, samples per pixel (denoised), and samples per voxel."""


def timed(command: list[str]) -> tuple[str, float]:
    """Output of a command and its CPU seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: {done.stderr[-2000:]}")
    return done.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def barnard(*arguments: str) -> tuple[str, float]:
    """Runs Barnard without its cache."""
    os.environ["BARNARD_CACHE"] = "off"
    return timed([os.environ.get("BARNARD", "barnard"), *arguments])


def truths(scene: Scene, orders: str, folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Two unbiased pictures [row, column, band] of every STRIDE-th pixel, with independent noise."""
    if scene.star is None:
        exact = glow(scene, np.load(folder / "cloud.npy"))
        return exact, exact
    file, size = toml(scene, orders, folder), f"{SIZE // STRIDE}x{SIZE // STRIDE}"

    def made(name: str, *how: str) -> np.ndarray:
        out = folder / f"truth_{scene.name}_{orders}_{name}.npy"
        if not out.exists():
            barnard("render", str(file), "--size", size, "-o", str(out), *how)
        # Standard errors follow the bands of paths.
        return np.load(out)[: len(WAVELENGTHS)].transpose(1, 2, 0)

    if orders == "one":
        exact = made("reference", "--backend", "reference", "--accuracy", "1e-4")
        return exact, exact
    first, second = (made(f"seed{seed}", "--backend", "path", "--samples", str(PATHS), "--seed", str(seed)) for seed in (1, 2))
    return first, second


def glow(scene: Scene, density: np.ndarray) -> np.ndarray:
    """Closed form of the glowing cloud, whose source function is constant: GLOW (1 - exp(-depth))."""
    pixels = SIZE // STRIDE
    tangent = np.tan(np.radians(FIELD_OF_VIEW) / 2) * (2 * (np.arange(pixels) + 0.5) / pixels - 1)
    steps = np.linspace(DISTANCE - 1.8, DISTANCE + 1.8, 4096)
    column = np.empty((pixels, pixels))
    for row, y in enumerate(-tangent):
        length = np.sqrt(1 + tangent**2 + y**2)
        places = np.stack([tangent[:, None] * steps, np.broadcast_to(y * steps, (pixels, steps.size)), np.broadcast_to(DISTANCE - steps, (pixels, steps.size))])
        voxels = (places + 1) * density.shape[0] / 2 - 0.5
        column[row] = map_coordinates(density, voxels, order=1, mode="constant").sum(1) * (steps[1] - steps[0]) * length
    return GLOW * (1 - np.exp(-column[..., None] * scene.extinction()))


def errors(picture: np.ndarray, first: np.ndarray, second: np.ndarray) -> tuple[float, float]:
    """Root mean square errors of the worst band: relative to the picture's, and of the relative errors of pixels.

    The product of the differences from two truths has the expectation of the squared error, without the truths' noise.
    Relative errors are of pixels above 1 % of the mean, by means of 5 x 5 pixels of the truth, which have little noise.
    """
    seen = picture[STRIDE // 2 :: STRIDE, STRIDE // 2 :: STRIDE]
    square = (seen - first) * (seen - second)
    truth = uniform_filter((first + second) / 2, size=(5, 5, 1))
    whole = np.sqrt(np.maximum(square.mean((0, 1)), 0) / (first * second).mean((0, 1)))
    lit = truth > 0.01 * truth.mean((0, 1))
    relative = [np.sqrt(max((square[lit[..., b], b] / truth[lit[..., b], b] ** 2).mean(), 0)) for b in range(truth.shape[-1])]
    return float(whole.max()), float(max(relative))


def measure(program: str, scene: Scene, orders: str, setting: float, folder: Path) -> tuple[np.ndarray, float]:
    """Picture [row, column, band; W m-2 sr-1] and CPU seconds: of Barnard's whole command, of a peer without its imports."""
    out = folder / f"{program}_{scene.name}_{orders}_{setting}.npy"
    if program == "barnard":
        _, seconds = barnard("render", str(toml(scene, orders, folder)), "--accuracy", str(setting), "-o", str(out))
        return np.load(out).transpose(1, 2, 0), seconds
    denoise = [] if program == "vtk" else ["--denoise"]
    script = [sys.executable, str(HERE / f"peer_{program}.py"), scene.name, orders, str(setting)]
    words, _ = timed([*script, *denoise, "--cloud", str(folder / "cloud.npy"), "--out", str(out)])
    return np.load(out), float(words.split()[-1])


def pictures(programs: list[str]) -> Iterator[tuple[str, Scene, str, float]]:
    """Program, scene, orders and setting of each picture. VTK has no scattering; path tracers render no glow here."""
    for scene in SCENES.values():
        able = ("barnard", "mitsuba", "cycles") if scene.star else ("barnard", "vtk")
        for orders in ("one", "all") if scene.star else ("one",):
            for program in (program for program in programs if program in able):
                yield from ((program, scene, orders, setting) for setting in SETTINGS[program])


def main() -> None:
    folder, programs = Path(sys.argv[1]), sys.argv[2:] or list(SETTINGS)
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "cloud.npy").exists():
        np.save(folder / "cloud.npy", cloud())
    table = folder / "measured.csv"
    done = {tuple(row[:4]) for row in csv.reader(table.open(newline=""))} if table.exists() else set()
    with table.open("a", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        if file.tell() == 0:
            rows.writerow(["program", "scene", "orders", "setting", "CPU seconds", "rms error", "rms relative error"])
        for program, scene, orders, setting in pictures(programs):
            if (program, scene.name, orders, str(setting)) in done:
                continue
            known = truths(scene, orders, folder)
            picture, seconds = measure(program, scene, orders, setting, folder)
            whole, relative = errors(picture, *known)
            row = [program, scene.name, orders, setting, f"{seconds:.2f}", f"{whole:.2e}", f"{relative:.2e}"]
            rows.writerow(row)
            file.flush()
            print(*row, flush=True)


main()
