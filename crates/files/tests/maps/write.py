"""Writes the files of maps.zip: python write.py FOLDER (astropy 7, h5py 3.16).

Each has the layout of a published map of the Galaxy's dust (headers, HDUs, datasets, axes, units, blank values), with few
voxels. One cloud stands at x = 20, y = -10, z = 10 pc (for Lallement: 20, -10, 10; for Leike: -360.5, -365.5, -263.5).
"""

import gzip
import sys
import zipfile
from pathlib import Path

import h5py
import numpy as np
from astropy.io import fits


def edenhofer(folder):
    """As mean_and_std_xyz.fits of doi 10.5281/zenodo.10658339, whose cubes have 1251 voxels along an edge, from -1250 pc."""
    edge, low = 25, -24
    mean = np.full((edge, edge, edge), 0.001, ">f4")
    place = (np.arange(edge) * 2.0 + low).tolist()
    mean[place.index(10), place.index(-10), place.index(20)] = 0.05
    mean[0, 0, 0] = np.nan
    hdus = [fits.PrimaryHDU()]
    for name, data in (("MEAN", mean), ("STD.", 0.1 * mean)):
        hdu = fits.ImageHDU(data, name=name)
        for i, axis in enumerate("XYZ", 1):
            hdu.header[f"CTYPE{i}"], hdu.header[f"CUNIT{i}"] = axis, "pc"
            hdu.header[f"CDELT{i}"], hdu.header[f"CRVAL{i}"], hdu.header[f"CRPIX{i}"] = 2, low, 1
        hdu.header["CUNIT"] = "E of Zhang, Green, and Rix (2023)"
        hdus.append(hdu)
    fits.HDUList(hdus).writeto(folder / "mean_and_std_xyz.fits", overwrite=True)


def leike(folder):
    """As mean_std.h5 of doi 10.5281/zenodo.3993082: 740 x 740 x 540 voxels of 1 pc, x, y, z, from (-370, -370, -270) pc."""
    mean = np.full((16, 8, 12), 1.0, "<f8")
    mean[9, 4, 6] = 50.0
    with h5py.File(folder / "mean_std.h5", "w") as file:
        file["mean"], file["std"] = mean, 0.1 * mean


def lallement(folder):
    """As cube_ext.fits.gz of VizieR J/A+A/661/A147: 601 x 601 x 81 voxels, the Sun in the middle of the middle one."""
    shape = (5, 7, 9)
    cube = np.full(shape, 0.0002, "f4")
    cube[2 + 1, 3 - 1, 4 + 2] = 0.01
    hdu = fits.PrimaryHDU(cube)
    hdu.header["STEP"], hdu.header["RESOL"], hdu.header["UNIT"] = 10, 25, "A0(550nm)/parsec"
    hdu.header["SUN_POSX"], hdu.header["SUN_POSY"], hdu.header["SUN_POSZ"] = 4.5, 3.5, 2.5
    path = folder / "cube_ext.fits"
    hdu.writeto(path, overwrite=True)
    (folder / "cube_ext.fits.gz").write_bytes(gzip.compress(path.read_bytes(), mtime=0))
    path.unlink()


def main(folder):
    edenhofer(folder)
    leike(folder)
    lallement(folder)
    with zipfile.ZipFile(folder / "maps.zip", "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in ("mean_and_std_xyz.fits", "mean_std.h5", "cube_ext.fits.gz"):
            archive.write(folder / name, name)


main(Path(sys.argv[1]))
