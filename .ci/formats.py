"""Reads what `barnard render` wrote with astropy and numpy: standard-conforming, in the right units and the right way up."""

import sys

import numpy as np
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
