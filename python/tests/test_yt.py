"""From a simulation through yt to FITS in a few lines, as docs/python.md has them."""

import re
from pathlib import Path

import astropy.units as u
import numpy as np
import pytest

import barnard as bn

yt = pytest.importorskip("yt")

ROOT = Path(__file__).parents[2]
SPECTRA = ROOT / "crates" / "spectra" / "data"


def test_a_covering_grid_becomes_a_picture(tmp_path):
    from yt.testing import fake_amr_ds

    ds = fake_amr_ds(fields=[("gas", "H_nuclei_density")], units=["cm**-3"], length_unit=3.0857e18)
    cg = ds.covering_grid(2, ds.domain_left_edge, ds.domain_dimensions * 2**2)
    density = cg["gas", "H_nuclei_density"]
    scene = bn.Scene(bands="hst-wfc3-sho", fields={"n_H": bn.Grid(density, low=cg.left_edge, high=cg.right_edge)})
    scene.dust = bn.Dust("n_H", scale=5.32e-22 * u.mag * u.cm**2, law="gordon23", albedo=0.6)
    scene.stars.append(bn.Star(position=[0.2, 0.1, 0.3] * u.pc, temperature=39e3 * u.K, luminosity=2e5 * u.Lsun))
    image = scene.render(bn.PerspectiveCamera(position=[0, 0, 5] * u.pc, field_of_view=25 * u.deg, size=32))
    assert image["F656N"].to(u.MJy / u.sr).value.max() > 0
    image.write(tmp_path / "gmc.fits")
    assert scene.fields["n_H"].unit == "cm-3"
    # The same by hand: the box in pc, the values as plain numbers.
    box = [edge.to_value("pc") for edge in (cg.left_edge, cg.right_edge)]
    scene.fields["n_H"] = bn.Grid(np.array(density.to_value("cm**-3")), low=box[0] * u.pc, high=box[1] * u.pc)
    again = scene.render(bn.PerspectiveCamera(position=[0, 0, 5] * u.pc, field_of_view=25 * u.deg, size=32))
    assert np.array_equal(again.radiance, image.radiance)


def test_the_lines_of_the_page_run_as_they_stand(tmp_path, monkeypatch):
    page = ROOT / "docs" / "python.md"
    [lines] = [code for code in re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.S) if "yt.load(" in code]
    # yt refines no axis of a single cell, so the root has two.
    values = np.random.default_rng(3).random((256, 256, 256))
    coarse = {"left_edge": [-3.0] * 3, "right_edge": [3.0] * 3, "level": 0, "dimensions": [2] * 3}
    fine = {**coarse, "level": 7, "dimensions": [256] * 3}
    grids = [{**grid, ("gas", "H_nuclei_density"): (v, "cm**-3")} for grid, v in ((coarse, np.ones((2, 2, 2))), (fine, 1e3 * values))]
    box = np.array([[-3.0, 3.0]] * 3)
    ds = yt.load_amr_grids(grids, [2, 2, 2], length_unit="pc", bbox=box, refine_by=2)
    monkeypatch.setattr(yt, "load", lambda name: ds)
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    exec(compile(lines.replace("size=1024", "size=96"), str(page), "exec"), names)
    assert names["image"]["F656N"].max() > 0 and (tmp_path / "gmc.fits").exists()
    assert "draine03_rv31" in names["image"].notes["albedo"]
    # The albedo that nobody said is the one that the note names.
    rows = [row.split(",")[:2] for row in (SPECTRA / "dust" / "draine03_rv31.csv").read_text().splitlines() if row[:1].isdigit()]
    (tmp_path / "albedo.csv").write_text("# wavelength_um, albedo\n" + "".join(f"{row[0]}, {row[1]}\n" for row in rows))
    scene, camera = names["scene"], bn.PerspectiveCamera(position=[0, 0, 20] * u.pc, field_of_view=25 * u.deg, size=96)
    scene.dust.albedo = {"kind": "file", "file": str(tmp_path / "albedo.csv")}
    again = scene.render(camera)
    assert "albedo" not in again.notes and np.allclose(again.radiance, names["image"].radiance, rtol=1e-6, atol=0)
    scene.dust.albedo = 0.6
    assert not np.allclose(scene.render(camera).radiance, again.radiance, rtol=1e-3, atol=0)


def test_mean_radiances_are_those_of_the_band():
    scene = bn.Scene(bands="johnson", camera=bn.PerspectiveCamera("0 0 4 pc", "20 deg", size=4))
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
