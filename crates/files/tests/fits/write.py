"""Writes the FITS files of fits.zip: python write.py FOLDER (astropy 7, CFITSIO's fpack 1.7).

Each holds the same cube, which the tests know as a formula, in tiles that are packed in another way. What dithered and
quantised numbers unpack to is what astropy makes of them, as .npy beside them.
"""

import gzip
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
from astropy.io import fits

SHAPE = (12, 10, 14)
i, j, k = np.meshgrid(*(np.arange(n) for n in SHAPE), indexing="ij")
whole = (3 * i + 5 * j + 7 * k) % 61 + 1
smooth = 100 * np.sin(i / 3.0) * np.cos(j / 4.0) + k + np.random.default_rng(2).normal(0.0, 0.5, SHAPE)


def packed(folder, name, data, **how):
    how = {"tile_shape": (3, 4, 5)} | how
    hdu = fits.CompImageHDU(data, name="CUBE", **how)
    hdu.header["CDELT1"], hdu.header["CUNIT1"], hdu.header["CRPIX1"] = 2.0, "pc", 1.0
    hdu.header["CDELT2"], hdu.header["CUNIT2"], hdu.header["CRPIX2"] = 2.0, "pc", 1.0
    hdu.header["CDELT3"], hdu.header["CUNIT3"], hdu.header["CRPIX3"] = 2.0, "pc", 1.0
    hdu.header["BUNIT"] = "cm-3"
    path = folder / f"{name}.fits"
    fits.HDUList([fits.PrimaryHDU(), hdu]).writeto(path, overwrite=True)
    return path


def unpacked(path):
    with fits.open(path) as file:
        np.save(path.with_suffix(".npy"), file[1].data.astype("f4" if file[1].data.dtype == ">f4" else "f8"))


def main(folder):
    for kind in ("u1", "i2", "i4"):
        for packing in ("RICE_1", "GZIP_1", "GZIP_2", "NOCOMPRESS"):
            packed(folder, f"{kind}_{packing.lower()}", whole.astype(kind), compression_type=packing)
        packed(folder, f"{kind}_rows", whole.astype(kind), compression_type="RICE_1", tile_shape=(1, 1, 14))
        packed(folder, f"{kind}_planes", whole.astype(kind), compression_type="RICE_1", tile_shape=(1, 10, 14))
    steep = np.where(whole % 2, 2**31 - 1 - whole, whole - 2**31).astype("i4")
    unpacked(packed(folder, "steep_rice", steep, compression_type="RICE_1"))
    for kind in ("f4", "f8"):
        for packing in ("GZIP_1", "GZIP_2", "NOCOMPRESS"):
            packed(folder, f"{kind}_{packing.lower()}", (whole / 8).astype(kind), compression_type=packing, quantize_level=0.0)
        for packing in ("RICE_1", "GZIP_1", "GZIP_2"):
            for dither in (-1, 1, 2):
                data = smooth.astype(kind)
                data[3, 4, 5], data[0, 0, :3], data[6:9, 4:8, 5:10] = np.nan, 0.0, 7.0
                path = packed(
                    folder,
                    f"quantised_{kind}_{packing.lower()}_{dither + 1}",
                    data,
                    compression_type=packing,
                    quantize_level=8.0,
                    quantize_method=dither,
                    dither_seed=9997,
                )
                unpacked(path)
    packed(folder, "hcompress", whole[0].astype("i4"), compression_type="HCOMPRESS_1", tile_shape=(10, 14))
    packed(folder, "plane", whole[0].astype("i4"), compression_type="RICE_1", tile_shape=(4, 5))
    scaled = fits.PrimaryHDU(whole.astype("i2"))
    scaled.header["BSCALE"], scaled.header["BZERO"] = 0.25, 3.0
    scaled.writeto(folder / "scaled.fits", overwrite=True)
    plain = fits.PrimaryHDU((whole / 8).astype("f4"))
    plain.header["BUNIT"] = "cm-3"
    plain.writeto(folder / "plain.fits", overwrite=True)
    # CFITSIO's own packer, for one of whole numbers and one of others.
    for name, options in (("fpack_i2", ["-r", "-t", "5,4,3"]), ("fpack_gzip", ["-g2", "-q", "0"])):
        source = folder / f"{name}.fits"
        source.write_bytes((folder / ("scaled.fits" if name == "fpack_i2" else "plain.fits")).read_bytes())
        subprocess.run(["fpack", "-D", "-Y", *options, str(source)], check=True)
    (folder / "plain.fits.gz").write_bytes(gzip.compress((folder / "plain.fits").read_bytes(), mtime=0))
    with zipfile.ZipFile(folder / "fits.zip", "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for path in sorted([*folder.glob("*.f*"), *folder.glob("*.npy")]):
            archive.write(path, path.name)


main(Path(sys.argv[1]))
