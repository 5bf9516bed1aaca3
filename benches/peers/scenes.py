"""Scenes that every program renders: one cloud of dust, three narrow bands, one star or a glow."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

VOXELS = 128
SIZE = 255
STRIDE = 3
"""Errors are of every third pixel: those have the centres of a picture with a third of the pixels."""
FIELD_OF_VIEW = 24.0
"""Of the image [deg]; the camera is at z = DISTANCE, looks at the origin, and y is up."""
DISTANCE = 6.0
"""Of the camera [pc]. The cloud fills the cube from -1 to 1 pc."""
WAVELENGTHS = (440.0, 550.0, 660.0)
"""Middles of the bands [nm], each 1 nm wide."""
ALBEDO = 0.8
TEMPERATURE = 15000.0
"""Of the star [K], which is a black body of 1000 solar luminosities."""
GLOW = 1e-8
"""Source function of the glow [W m-2 sr-1]."""

METRES_PER_PARSEC = 3.0856775814913673e16


@dataclass(frozen=True)
class Scene:
    """A cloud and its light."""

    name: str
    depth: float
    """Mean optical depth through the middle of the cloud, at 550 nm."""
    star: tuple[float, float, float] | None
    """Position of the star [pc]; without one the cloud glows itself and does not scatter."""
    g: float
    """Mean cosine of Henyey & Greenstein's phase function."""

    def extinction(self) -> np.ndarray:
        """Extinction at density 1, per band [1/pc]: proportional to 1 / wavelength."""
        return self.depth * 550.0 / np.array(WAVELENGTHS)


SCENES = {
    scene.name: scene
    for scene in (
        Scene("inside", 2.6, (0.25, 0.15, 0.35), 0.7),
        Scene("outside", 10.0, (1.2, 0.9, 1.4), 0.0),
        Scene("glow", 2.6, None, 0.0),
    )
}


def cloud() -> np.ndarray:
    """Density [x, y, z]: log-normal, its logarithm of spectral slope -3.6 and deviation 1.0, that ends before the cube's faces."""
    frequency = np.fft.fftfreq(VOXELS) * VOXELS
    square = sum(axis**2 for axis in np.meshgrid(frequency, frequency, frequency, indexing="ij", sparse=True))
    square[0, 0, 0] = np.inf
    noise = np.random.default_rng(1).standard_normal((VOXELS,) * 3)
    waves = np.fft.ifftn(np.fft.fftn(noise) * square**-0.9).real
    x = (np.arange(VOXELS) + 0.5) * 2.0 / VOXELS - 1.0
    radius = np.sqrt(sum(axis**2 for axis in np.meshgrid(x, x, x, indexing="ij", sparse=True)))
    density = np.exp(waves / waves.std()) * np.clip((0.95 - radius) / 0.4, 0.0, 1.0) ** 2
    middle = np.abs(x) < 0.3
    return np.ascontiguousarray(density / (density[middle][:, middle].mean() * 2.0), np.float32)


def intensity() -> np.ndarray:
    """Radiant intensity of the star in each band [W/sr]."""
    h, c, k, sigma, sun = 6.62607015e-34, 2.99792458e8, 1.380649e-23, 5.670374419e-8, 3.828e26
    wavelength = np.array(WAVELENGTHS) * 1e-9
    planck = 2.0 * h * c**2 / wavelength**5 / np.expm1(h * c / (wavelength * k * TEMPERATURE))
    return 1000.0 * sun / (4.0 * np.pi) * np.pi * planck / (sigma * TEMPERATURE**4) * 1e-9


def toml(scene: Scene, orders: str, folder: Path) -> Path:
    """Barnard's file of a scene."""
    bands = "".join(f'[[band]]\nname = "{w:.0f}"\nkind = "top_hat"\ncentre = "{w} nm"\nwidth = "1 nm"\n' for w in WAVELENGTHS)
    if scene.star is None:
        # The glow has the extinction's profile, so its source function is the same everywhere.
        strength = GLOW * scene.depth / METRES_PER_PARSEC
        lines = ", ".join(f'{{ wavelength = "{w} nm", strength = {550.0 / w} }}' for w in WAVELENGTHS)
        light = f'[[emission]]\nkind = "lines"\ndensity = "cloud"\nscale = "{strength} W/m3/sr"\nlines = [{lines}]\n'
    else:
        x, y, z = scene.star
        light = f'[[star]]\nkind = "blackbody"\nposition = "{x} {y} {z} pc"\ntemperature = "{TEMPERATURE} K"\nluminosity = "1000 Lsun"\nvisible = false\n'
    text = f"""[camera]
kind = "perspective"
position = "0 0 {DISTANCE} pc"
field_of_view = "{FIELD_OF_VIEW} deg"
size = [{SIZE}, {SIZE}]
[field.cloud]
kind = "grid"
file = "cloud.npy"
low = "-1 -1 -1 pc"
high = "1 1 1 pc"
[dust]
density = "cloud"
scale = "{scene.depth} /pc"
law = "inverse_wavelength"
albedo = {ALBEDO if scene.star else 0.0}
phase = {{ kind = "henyey_greenstein", g = {scene.g} }}
{light}{bands}[method]
bounces = {1000 if orders == "all" else 1}
"""
    file = folder / f"{scene.name}_{orders}.toml"
    file.write_text(text)
    return file
