"""Checks of what `barnard render` writes, as an astronomer makes them: scenes whose answer is a closed form, a published number or astropy's.

    python .ci/checks.py target/release/barnard docs/checks.md

renders each scene, compares, writes the page and ends with an error where a check fails. Nothing of Barnard is used but the program and its files.
"""

import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from astropy import constants, units as u
from astropy.io import fits
from astropy.modeling.models import BlackBody
from astropy.wcs import WCS

program, page = sys.argv[1], pathlib.Path(sys.argv[2])
PC = u.pc.to(u.m)
rows, failed = [], 0


def render(text):
    """The HDUs of a scene by name, its header of all, and what was printed."""
    with tempfile.TemporaryDirectory() as folder:
        scene, out = pathlib.Path(folder, "scene.toml"), pathlib.Path(folder, "out.fits")
        scene.write_text(text)
        done = subprocess.run([program, "render", scene, "-o", out], capture_output=True, text=True)
        assert done.returncode == 0, f"{done.stderr}\n{text}"
        with fits.open(out) as hdus:
            hdus.verify("exception")
            return {h.header["EXTNAME"].upper(): (h.data.astype(float), h.header.copy()) for h in hdus[1:]}, hdus[0].header.copy()


def check(what, source, found, expected, tolerance, unit=""):
    """One row: relative difference, or absolute where the unit is a magnitude or a pixel."""
    global failed
    off = found - expected if unit in ("mag", "pixel") else found / expected - 1
    good = abs(off) <= tolerance
    failed += not good
    rows.append(f"| {what} | {source} | {expected:.6g} {unit} | {found:.6g} {unit} | {off:+.1e} | {tolerance:.0e} | {'yes' if good else '**no**'} |")


def planck(temperature, low, high):
    """∫ B_λ dλ between two wavelengths [W m-2 sr-1], by astropy."""
    lam = np.linspace(low, high, 4001)
    black_body = BlackBody(temperature=temperature * u.K, scale=1 * u.W / (u.m**2 * u.um * u.sr))
    return np.trapezoid(black_body(lam * u.um).value, lam)


BAND = '[[band]]\nname = "green"\nkind = "top_hat"\ncentre = "550 nm"\nwidth = "100 nm"\n'
ORTHOGRAPHIC = '[camera]\nkind = "orthographic"\nposition = "0 0 5 pc"\nwidth = "2.2 pc"\nsize = [220, 220]\n'

# A star: all its light through a rectangular filter, at 4 pc.
R, T, D = 3.0, 9000.0, 4.0
text = f'''[camera]
kind = "perspective"
position = "0 0 {D} pc"
field_of_view = "2 deg"
size = [64, 64]
[[star]]
kind = "blackbody"
position = "0 0 0 pc"
temperature = "{T} K"
radius = "{R} Rsun"
{BAND}'''
hdus, _ = render(text)
image, header = hdus["GREEN"]
flux = image.sum() * WCS(header).proj_plane_pixel_area().to_value(u.sr)
expected = math.pi * planck(T, 0.5, 0.6) * (R * constants.R_sun.value / (D * PC)) ** 2
check("flux of a star of 9000 K and 3 R_sun at 4 pc, 500 to 600 nm [W m-2]", "astropy BlackBody, π B (R/d)²", flux, expected, 2e-3)

# Magnitudes: what is put in comes out, by the header's own zero points, through dust on the way as well.
for name, extinction in (("5 mag in B", ""), ("5 mag in B behind A_V = 2", 'extinction = "2 mag"\n')):
    text = f'''bands = "johnson"
[camera]
kind = "perspective"
position = "0 0 10 pc"
field_of_view = "1 deg"
size = [32, 32]
[[star]]
kind = "stellar"
type = "B3V"
position = "0 0 0 pc"
magnitude = "5 mag"
magnitude_band = "johnson-B"
distance = "10 pc"
{extinction}'''
    hdus, _ = render(text)
    magnitudes = {}
    for band, (image, header) in hdus.items():
        flux = image.sum() * WCS(header).proj_plane_pixel_area().to_value(u.sr)
        magnitudes[band] = header["ZPVEGA"] - 2.5 * math.log10(flux)
        ab = 2.5 * math.log10(3631e-26 * constants.c.value / (header["PHOTPLAM"] * 1e-10) ** 2 * header["BANDWID"] * 1e-9)
        if not extinction:
            check(f"AB zero point of {band.lower()} [mag for 1 W m-2]", "3631 Jy c/λ_p² ∫R dλ", header["ZPAB"], ab, 1e-4, "mag")
    if extinction:
        check("a B star seen at 5 mag in B behind A_V = 2, without that dust", "A_B of Gordon et al. 2023 at λ_p, 1.32 A_V", magnitudes["JOHNSON-B"], 5 - 2 * 1.32, 0.06, "mag")
    else:
        check("a B3 V star of 5 mag in B", "what the scene says", magnitudes["JOHNSON-B"], 5.0, 2e-3, "mag")
        check("its B − V", "Pecaut & Mamajek 2013, -0.178", magnitudes["JOHNSON-B"] - magnitudes["JOHNSON-V"], -0.178, 0.03, "mag")

# A thin sphere: chords, and all of its light.
text = f'''{ORTHOGRAPHIC}[field.ball]
kind = "sphere"
radius = "1 pc"
[[emission]]
kind = "lines"
density = "ball"
scale = "1e-25 W/m3/sr"
lines = [{{ wavelength = "550 nm", strength = 1 }}]
{BAND}'''
image = render(text)[0]["GREEN"][0]
check("thin sphere, middle: radiance [W m-2 sr-1]", "2 j R", image[109:111, 109:111].mean(), 2 * 1e-25 * PC, 2e-3)
check("thin sphere, all light [W m-2 sr-1 pc²]", "4/3 π R³ j", image.sum() * 1e-4, 4 / 3 * math.pi * 1e-25 * PC, 2e-3)

# Case B: emissivities of hydrogen as tables have them.
text = f'''{ORTHOGRAPHIC}[field.ball]
kind = "sphere"
radius = "1 pc"
[[emission]]
kind = "ion"
ion = "H1"
temperature = "10000 K"
electron_density = "100 cm-3"
density = "1e4 * ball"
[[band]]
name = "Ha"
kind = "top_hat"
centre = "656.3 nm"
width = "2 nm"
[[band]]
name = "Hb"
kind = "top_hat"
centre = "486.1 nm"
width = "2 nm"
'''
hdus, _ = render(text)
alpha, beta = (hdus[name][0].sum() * 1e-4 * PC**2 for name in ("HA", "HB"))
# 4π j/(n_e n_p) of H β = 1.24e-25 erg cm3 s-1 at 10⁴ K (Osterbrock & Ferland 2006, table 4.4); luminosity of a sphere of 1 pc with n_e n_p = 10⁴ cm-6.
luminosity = 1.24e-25 * 1e-7 * 1e4 * 4 / 3 * math.pi * (PC * 100) ** 3
check("Case B sphere, n_e = 100 cm-3, 10⁴ K: Hα/Hβ", "Osterbrock & Ferland 2006, 2.86", alpha / beta, 2.86, 1e-2)
check("its luminosity in Hβ [W]", "4πj = 1.24e-25 erg cm3 s-1", 4 * math.pi * beta, luminosity, 1e-2)

# Dust mixed with gas.
tau = 2.0
text = f'''{ORTHOGRAPHIC}[field.box]
kind = "box"
low = "-1 -1 -0.5 pc"
high = "1 1 0.5 pc"
[dust]
density = "box"
scale = "{tau} /pc"
law = "inverse_wavelength"
albedo = 0.0
[[emission]]
kind = "lines"
density = "box"
scale = "1e-25 W/m3/sr"
lines = [{{ wavelength = "550 nm", strength = 1 }}]
{BAND}'''
image = render(text)[0]["GREEN"][0]
check("gas mixed with dust of depth 2 [W m-2 sr-1]", "j L (1 − e^−τ)/τ", image[100:120, 100:120].mean(), 1e-25 * PC * (1 - math.exp(-tau)) / tau, 1e-4)

# Dust before a background: five magnitudes.
text = f'''{ORTHOGRAPHIC}[field.box]
kind = "box"
low = "-0.5 -1 -0.5 pc"
high = "0.5 1 0.5 pc"
[dust]
density = "box"
scale = "5 mag/pc"
law = "inverse_wavelength"
albedo = 0.0
[background]
kind = "power_law"
exponent = 0
radiance = "1e-7 W/m2/sr/um"
[[band]]
name = "green"
kind = "top_hat"
centre = "550 nm"
width = "0.2 nm"
'''
image = render(text)[0]["GREEN"][0]
check("a background behind A_V = 5", "definition of the magnitude", -2.5 * math.log10(image[110, 110] / image[110, 5]), 5.0, 1e-3, "mag")

# Where things are: a star off the axis, by the header's WCS.
x, y = 0.31, -0.17
text = f'''[camera]
kind = "perspective"
position = "0 0 8 pc"
field_of_view = "6 deg"
size = [301, 201]
[[star]]
kind = "blackbody"
position = "{x} {y} 0 pc"
temperature = "9000 K"
radius = "3 Rsun"
{BAND}'''
image, header = render(text)[0]["GREEN"]
row, column = np.unravel_index(image.argmax(), image.shape)
window = image[row - 4 : row + 5, column - 4 : column + 5]
grid_y, grid_x = np.mgrid[row - 4 : row + 5, column - 4 : column + 5]
found = [(window * g).sum() / window.sum() for g in (grid_x, grid_y)]
expected = WCS(header).wcs_world2pix([[math.degrees(math.atan2(x, 8)), math.degrees(math.atan2(y, math.hypot(8, x)))]], 0)[0]
check("a star off the axis: column", "astropy WCS of its direction", found[0], expected[0], 0.05, "pixel")
check("and row", "astropy WCS of its direction", found[1], expected[1], 0.05, "pixel")

# What the header says of itself.
for key in ("BACKEND", "METHOD", "ACCURACY", "BOUNCES", "SPATERR", "CAMX", "DISTANCE", "SCENESHA", "DATE"):
    hdus, primary = render(f'{ORTHOGRAPHIC}[field.ball]\nkind = "sphere"\nradius = "1 pc"\n[dust]\ndensity = "ball"\nscale = "1 /pc"\n[[star]]\nkind = "blackbody"\nposition = "0 0 2 pc"\ntemperature = "9000 K"\nluminosity = "1 Lsun"\n') if key == "BACKEND" else (hdus, primary)
    assert key in primary, f"{key} is missing in the header"
for key in ("PHOTPLAM", "PHOTFLAM", "ZPVEGA", "ZPAB", "SPECERR", "FILTER"):
    assert all(key in header for _, header in hdus.values()), f"{key} is missing in a band's header"

page.write_text(
    "# Checks\n\nWritten by `python .ci/checks.py target/release/barnard docs/checks.md`, with numpy and astropy: each scene is rendered to FITS by `barnard render` with its "
    "defaults, read by astropy and compared with a closed form, a published number or astropy's own. Differences are relative, those of magnitudes and pixels absolute.\n\n"
    "| what | by | expected | found | difference | allowed | holds |\n|---|---|---|---|---|---|---|\n" + "\n".join(rows) + "\n"
)
print(f"{len(rows) - failed} passed, {failed} failed")
sys.exit(failed > 0)
