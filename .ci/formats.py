"""Reads what `barnard render` and `barnard convert` wrote with other programs: standard-conforming, in the right units and the right way up."""

import subprocess
import sys

import h5py
import numpy as np
import tinyvdb
from astropy import units
from astropy.io import fits
from astropy.wcs import WCS

stem = sys.argv[1]
cube = np.load(f"{stem}.npy")
assert cube.shape == (3, 24, 32) and cube.dtype == np.float32, (cube.shape, cube.dtype)
assert np.isfinite(cube).all() and cube.max() > 0
with fits.open(f"{stem}.fits") as hdus:
    hdus.verify("exception")
    assert len(hdus) == 4
    for band, hdu in zip(cube, hdus[1:]):
        assert units.Unit(hdu.header["BUNIT"]) == units.Unit("W m-2 sr-1")
        assert hdu.header["PIVOT"] > 300 and hdu.header["EXTNAME"]
        assert any("certificate" in str(line) for line in hdu.header["HISTORY"])
        # The first row of FITS is the lowest.
        assert np.array_equal(hdu.data[::-1], band)
        wcs = WCS(hdu.header)
        assert np.allclose(np.abs(wcs.proj_plane_pixel_scales()[0].to_value("deg")), 2 * np.degrees(np.tan(np.radians(15)) / 32))
print("3 passed, 0 failed")

# Layers as HDUs behind the bands: those of light add up to the bands.
barnard = sys.argv[2]
subprocess.run([barnard, "render", "--builtin", "barres_neyret", "--size", "32x24", "--layers", "all", "-o", f"{stem}_layers.fits"], check=True, stdout=subprocess.DEVNULL)
with fits.open(f"{stem}_layers.fits") as hdus:
    hdus.verify("exception")
    bands = [hdu for hdu in hdus[1:] if "LAYER" not in hdu.header]
    layers = {hdu.header["EXTNAME"]: hdu for hdu in hdus[1:] if "LAYER" in hdu.header}
    assert len(bands) == 3 and {"depth", "tau", "opacity"} < set(layers), list(layers)
    for band in bands:
        parts = [hdu.data for name, hdu in layers.items() if name.endswith("." + band.header["EXTNAME"])]
        assert len(parts) >= 1 and np.allclose(sum(parts), band.data, rtol=1e-4, atol=1e-7 * band.data.max())
    assert units.Unit(layers["depth"].header["BUNIT"]) == units.pc and layers["depth"].data.min() > 0
    assert np.allclose(layers["opacity"].data, 1 - np.exp(-layers["tau"].data), atol=0.02)
print(f"{len(layers)} layers passed, 0 failed")

# Grids as other programs read what `barnard convert` makes of them: 1e6 a cubic metre are one a cubic centimetre.
x, y, z = np.mgrid[0:40, 0:23, 0:31]
cloud = (1e6 * (np.maximum(0, 50 - (x - 9) ** 2 - (y - 8) ** 2 - (z - 11) ** 2) + (x + y > 58))).astype(np.float32)
np.save(f"{stem}_cloud.npy", cloud)
for ending in ("fits", "npy", "h5", "vdb"):
    place = ["--voxel", "0.5 pc", "--centre", "1 2 -3 pc", "--unit", "m-3", "--name", "n_H"]
    subprocess.run([barnard, "convert", f"{stem}_cloud.npy", f"{stem}_grid.{ending}", *place], check=True, stdout=subprocess.DEVNULL)
expected = (cloud.astype(float) * 1e-6).astype(np.float32)
first = [middle - 0.25 * (count - 1) for middle, count in zip((1, 2, -3), cloud.shape)]
assert np.array_equal(np.load(f"{stem}_grid.npy"), expected)
with fits.open(f"{stem}_grid.fits") as hdus:
    hdus.verify("exception")
    header = hdus[0].header
    assert np.array_equal(hdus[0].data.T, expected)
    assert units.Unit(header["BUNIT"]) == units.cm**-3 and header["EXTNAME"] == "n_H"
    wcs = WCS(header)
    assert [units.Unit(unit) for unit in wcs.wcs.cunit] == 3 * [units.pc]
    assert np.allclose(units.Quantity(wcs.pixel_to_world_values(0, 0, 0), wcs.wcs.cunit[0]).to_value("pc"), first)
    assert np.allclose(wcs.wcs.cdelt, 0.5)
with h5py.File(f"{stem}_grid.h5") as file:
    dataset = file["n_H"]
    assert np.array_equal(dataset[...], expected) and dataset.attrs["units"] in ("cm-3", b"cm-3")
    low, high = dataset.attrs["left_edge"], dataset.attrs["right_edge"]
    assert np.allclose(low + 0.25, first) and np.allclose(high - low, 0.5 * np.array(cloud.shape))
with tinyvdb.open(f"{stem}_grid.vdb") as file:
    file.read_grids()
    grid = file.grid(0)
    sparse = grid.to_sparse()
    places = np.frombuffer(sparse["coords"], np.int32).reshape(-1, 3)
    read = np.zeros_like(expected)
    read[tuple(places.T)] = np.frombuffer(sparse["values"], np.float32)
    assert grid.name == "n_H" and sparse["count"] == np.count_nonzero(expected) and np.array_equal(read, expected)
print("4 grids passed, 0 failed")
