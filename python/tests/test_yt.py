"""From a simulation through yt to FITS in a few lines, as docs/python.md has them."""

import astropy.units as u
import numpy as np
import pytest

import barnard as bn

yt = pytest.importorskip("yt")


def test_a_covering_grid_becomes_a_picture(tmp_path):
    from yt.testing import fake_amr_ds

    ds = fake_amr_ds(fields=[("gas", "H_nuclei_density")], units=["cm**-3"], length_unit=3.0857e18)
    cg = ds.covering_grid(2, ds.domain_left_edge, ds.domain_dimensions * 2**2)
    density = cg["gas", "H_nuclei_density"]
    scene = bn.Scene(bands="hst-wfc3-sho", fields={"n_H": bn.Grid(density, low=cg.left_edge, high=cg.right_edge)})
    scene.dust = bn.Dust("n_H", scale=5.32e-22 * u.mag * u.cm**2, law="gordon23", albedo=0.6)
    scene.stars.append(bn.Star(position=[0.2, 0.1, 0.3] * u.pc, temperature=39e3 * u.K, luminosity=2e5 * u.Lsun))
    image = scene.render(bn.perspective(position=[0, 0, 5] * u.pc, field_of_view=25 * u.deg, size=32))
    assert image["F656N"].to(u.MJy / u.sr).value.max() > 0
    image.write(tmp_path / "gmc.fits")
    assert scene.fields["n_H"].unit == "cm-3"
    # The same by hand: the box in pc, the values as plain numbers.
    box = [edge.to_value("pc") for edge in (cg.left_edge, cg.right_edge)]
    scene.fields["n_H"] = bn.Grid(np.array(density.to_value("cm**-3")), low=box[0] * u.pc, high=box[1] * u.pc)
    again = scene.render(bn.perspective(position=[0, 0, 5] * u.pc, field_of_view=25 * u.deg, size=32))
    assert np.array_equal(again.radiance, image.radiance)


def test_mean_radiances_are_those_of_the_band():
    scene = bn.Scene(bands="johnson", camera=bn.perspective("0 0 4 pc", "20 deg", size=4))
    scene.background = bn.Background(kind="power_law", exponent=0.0, radiance="2e-7 W/m2/sr/um", wavelength="550 nm")
    image = scene.render()
    for band in image:
        # A spectrum that is flat in wavelength has its mean everywhere; for each frequency it is that times λ²/c at the pivot.
        assert np.allclose(image[band].to_value("W / (m2 sr um)"), 2e-7, rtol=1e-3)
    pivot = image.to_xarray().pivot.sel(band="johnson-V").item() * u.um
    per_frequency = (2e-7 * u.W / u.m**2 / u.sr / u.um * pivot**2 / (299792458 * u.m / u.s)).to_value(u.MJy / u.sr)
    assert np.allclose(image["V"].to_value(u.MJy / u.sr), per_frequency, rtol=1e-3)
    assert np.allclose((2 * image["V"]).to_value(u.MJy / u.sr), 2 * per_frequency, rtol=1e-3)
    with pytest.raises(u.UnitConversionError):
        image["V"].to(u.K)
