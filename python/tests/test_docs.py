"""Code blocks of README and docs: TOML is a scene or a part of one, and Python blocks and shell blocks marked `run` run."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import barnard as bn
from conftest import cameras, cloud, lit

h5py = pytest.importorskip("h5py")
fits = pytest.importorskip("astropy.io.fits")
units = pytest.importorskip("astropy.units")
yt = pytest.importorskip("yt")
distributed = pytest.importorskip("distributed")
emcee = pytest.importorskip("emcee")

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(r"^```([^\n]*)\n(.*?)^```", re.M | re.S)
#: Files that the text before a block names.
SAVED = re.compile(r"Save this as `([^`]+)`")

#: Parts of a scene that a block may lack, each with the key that replaces it.
BARE = {"bands": 'bands = "johnson"'}
TABLES = {
    ("camera", "kind"): '[camera]\nkind = "perspective"\nposition = "0 0 6 pc"\nfield_of_view = "30 deg"\nsize = [16, 16]',
    ("dust", "density"): '[dust]\ndensity = "cloud"\nscale = "4 mag/pc"',
    ("field", "cloud"): '[field.cloud]\nkind = "fbm"',
    ("field", "n_H"): '[field.n_H]\nkind = "sphere"\nradius = "1 pc"\n',
    ("star", 0): '[[star]]\nkind = "blackbody"\nposition = "0 0 0 pc"\ntemperature = "40000 K"\nluminosity = "1000 Lsun"',
}


def page_name(path: Path) -> str:
    return str(path.relative_to(ROOT))


def blocks(path: Path) -> list[tuple[str, str, str]]:
    """Code blocks of a page: info string, text, and the paragraph before it."""
    page = path.read_text(encoding="utf-8")
    return [(m[1], m[2], page[: m.start()].rstrip().rsplit("\n\n", 1)[-1]) for m in BLOCK.finditer(page)]


def texts(path: Path, info: str) -> list[str]:
    """Texts of the code blocks with an info string."""
    return [text for found, text, _ in blocks(path) if found == info]


def whole(part: str) -> str:
    """A scene around a part of one."""
    tree = tomllib.loads(part)
    bare = [text for key, text in BARE.items() if key not in tree and "band" not in tree and "spectrograph" not in tree]

    def lacks(table, key):
        value = tree.get(table)
        return value is None or (key not in value if isinstance(value, dict) else len(value) <= key)

    return "\n".join([*bare, part, *(text for (table, key), text in TABLES.items() if lacks(table, key))])


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working folder with the files that scenes name, and the command on the path."""
    monkeypatch.chdir(tmp_path)
    density = cloud(16)
    np.save("cloud.npy", density)
    np.save("cube.npy", density)
    Path("filter.csv").write_text("wavelength_nm,throughput\n600,0\n650,0.9\n700,0\n")
    Path("stars.csv").write_text("name,ra,dec,johnson-V,johnson-B\nA,274.70,-13.82,9.1,9.3\n")
    Path("cluster.csv").write_text("x [pc],y [pc],z [pc],temperature [K],luminosity [Lsun]\n0.1,0.2,0.3,22000,5000\n")
    with h5py.File("snapshot.h5", "w") as file:
        file["gas/density"] = density
    header = fits.Header({f"{key}{axis}": value for axis in (1, 2, 3) for key, value in {"CRPIX": 13, "CRVAL": 0, "CDELT": 100, "CUNIT": "pc"}.items()})
    fits.HDUList([fits.PrimaryHDU(), fits.ImageHDU(np.ones((25, 25, 25), np.float32), header, name="MEAN")]).writeto("mean_and_std_xyz.fits")
    command = tmp_path / "bin" / "barnard"
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m barnard "$@"\n')
    command.chmod(0o755)
    monkeypatch.setenv("PATH", f"{command.parent}{os.pathsep}{os.environ['PATH']}")
    subprocess.run([command, "convert", "cloud.npy", "smoke.vdb", "--voxel", "0.1 pc"], check=True, capture_output=True)
    [scene] = texts(ROOT / "docs" / "tutorials" / "first-nebula.md", "toml")
    Path("scene.toml").write_text(scene.replace("[512, 512]", "[64, 64]"))
    return tmp_path


def pages(info: str):
    """Parameters of a test: pages with such blocks."""
    return [pytest.param(path, id=page_name(path)) for path in PAGES if texts(path, info)]


@pytest.mark.parametrize("path", pages("toml"))
def test_toml_blocks_are_scenes(path, folder):
    for text in texts(path, "toml"):
        bn.Scene.from_toml(whole(text))
        with pytest.raises(bn.SceneError):
            bn.Scene.from_toml(whole(text) + "\n[surely_unknown]\n")


@pytest.mark.parametrize("path", pages("sh run"))
def test_shell_blocks_run(path, folder):
    known = {}
    for info, text, before in blocks(path):
        if name := SAVED.search(before):
            Path(name[1]).write_text(text)
        elif info == "sh run":
            done = subprocess.run(["bash", "-e", "-c", text], capture_output=True, text=True)
            assert done.returncode == 0, f"{text}\n{done.stdout}\n{done.stderr}"
        elif info == "python" and "tutorials" in path.parts:
            exec(compile(text, page_name(path), "exec"), known)


class Cluster(distributed.LocalCluster):
    """A cluster of this machine in place of one of Slurm."""

    def __init__(self, **options):
        super().__init__(n_workers=1, threads_per_worker=1, dashboard_address=None)

    def scale(self, **options):
        pass


def observed() -> bn.Scene:
    """A small scene that an instrument sees."""
    scene = lit(cloud(16))
    scene.bands = ["johnson-B", "johnson-V", "cousins-R"]
    scene.camera = bn.PerspectiveCamera("0 0 400 pc", "40 arcsec", size=110)
    scene.observation = bn.Observation("5h35m17s -5d23m")
    scene.instrument = bn.Instrument(preset="lco-1m-sinistro", exposure="60 s")
    return scene


def names(path: Path) -> dict:
    """Names that the blocks of a page use and do not make."""
    base = {"bn": bn, "u": units, "np": np, "numpy": np, "density": cloud(16), "scene": lit(cloud(16)), "camera": bn.PerspectiveCamera("0 0 5 pc", "30 deg", size=16)}
    base |= {"cameras": cameras(2), "height": 112, "width": 112}
    if path.name == "observing.md":
        scipy = pytest.importorskip("scipy.optimize")
        base |= {"scene": observed(), "scipy": SimpleNamespace(optimize=scipy), "emcee": emcee}
    if path.name in ("simulations.md", "data.md"):
        from yt.testing import fake_amr_ds

        base["ds"] = fake_amr_ds(fields=[("gas", "H_nuclei_density"), ("gas", "number_density")], units=["cm**-3"] * 2, length_unit=3.0857e18)
    return base


@pytest.mark.parametrize("path", [page for page in pages("python") if page.id != "docs/tutorials/own-data.md"])
def test_python_blocks_run(path, folder, monkeypatch):
    jobqueue = pytest.importorskip("dask_jobqueue")
    dask_array = pytest.importorskip("dask.array")
    monkeypatch.setattr(jobqueue, "SLURMCluster", Cluster)
    monkeypatch.setattr(dask_array, "from_zarr", lambda name: dask_array.from_array(cloud(16), chunks=8))
    box = [[-3.0, 3.0]] * 3
    monkeypatch.setattr(yt, "load", lambda name: yt.load_uniform_grid({("gas", "H_nuclei_density"): (cloud(16), "cm**-3")}, [16] * 3, "pc", np.array(box)))
    # Sizes and numbers of a page are those of real work.
    monkeypatch.setattr(bn, "PerspectiveCamera", lambda *args, _own=bn.PerspectiveCamera, size=112, **keys: _own(*args, size=min(112, np.max(size)), **keys))
    builtin = bn.Scene.builtin

    def small(name):
        scene = builtin(name)
        scene.camera.size = [64, 36]
        return scene

    monkeypatch.setattr(bn.Scene, "builtin", small)
    run_mcmc = emcee.EnsembleSampler.run_mcmc
    monkeypatch.setattr(emcee.EnsembleSampler, "run_mcmc", lambda self, start, steps: run_mcmc(self, start, 2))
    known = names(path)
    if path.name == "observing.md":
        known["scene"].render().observe().master().write("master.fits")
    for text in texts(path, "python"):
        text = text.replace("2**7", "1").replace(", 2048)", ", 48)")
        exec(compile(text, page_name(path), "exec"), known)


def test_blocks_have_a_language_that_is_checked():
    languages = {"", "toml", "sh", "bash", "python", "rust", "text", "yaml", "csv"}
    infos = {(page_name(path), info) for path in PAGES for info, _, _ in blocks(path)}
    assert not {(page, info) for page, info in infos if info.split(" ")[0] not in languages and not info.startswith("{")}
