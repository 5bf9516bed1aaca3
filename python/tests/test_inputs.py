"""Arrays in many forms, written by the libraries of others: each is read right, or refused with file, reason and remedy.

Every table feeds one reader; an expected value is an array by x, y and z, or words of the refusal.
"""

import re
from functools import partial

import astropy.units as u
import numpy as np
import pytest
from astropy.io import fits
from astropy.utils.masked import Masked

import barnard as bn
from barnard import _barnard
from test_instrument import catalogue, sky

#: The cloud by x, y and z: other along every axis, without a value twice. Its voxels are cubes of 1 pc around the origin.
X, Y, Z = (np.arange(n) - (n - 1) / 2 for n in (4, 6, 8))
A = 1.0 + np.arange(4 * 6 * 8).reshape(4, 6, 8) / 64
BOX = ["--low", "-2 -3 -4 pc", "--high", "2 3 4 pc"]
CM3 = ["--unit", "cm-3"]


def without(values=A, *cells):
    """The cloud with nothing in some cells."""
    values = values.copy()
    for cell in cells:
        values[cell] = 0
    return values


def converted(file, options, folder, capfd):
    """Array that `barnard convert` reads from a file, by x, y and z, and the box that it prints; or its message."""
    out = folder / "out.npy"
    capfd.readouterr()
    code = _barnard.run(["barnard", "convert", str(file), str(out), *options])
    printed = capfd.readouterr()
    if code != 0:
        assert not out.exists()
        return None, printed.err
    return np.load(out), printed.out


def hold(file, options, expected, folder, capfd):
    found, printed = converted(file, options, folder, capfd)
    if isinstance(expected, str):
        assert found is None, f"was read: {printed}"
        assert re.search(expected, printed) and file.name in printed and len(printed) > 50, printed
        return
    assert found is not None, printed
    assert found.shape == expected.shape
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    low, high = (np.array([float(v) for v in re.search(rf"{name} +(.*) pc", printed)[1].split()]) for name in ("low", "high"))
    np.testing.assert_allclose([low, high], [[-2, -3, -4], [2, 3, 4]], rtol=1e-5)


def params(table):
    assert len(table) >= 30
    return pytest.mark.parametrize("case", [pytest.param(row, id=row[0]) for row in table])


# NumPy files.


def saved(values):
    return lambda path: np.save(path, values)


def header(values, change):
    """A .npy whose header, of the same length, is changed."""

    def write(path):
        np.save(path, values)
        data = path.read_bytes()
        end = 10 + int.from_bytes(data[8:10], "little")
        text = change(data[10:end].decode()).rstrip()
        path.write_bytes(data[:10] + text.ljust(end - 11).encode() + b"\n" + data[end:])

    return write


def version(major):
    def write(path):
        with open(path, "wb") as file:
            np.lib.format.write_array(file, A, version=(major, 0))

    return write


def archive(compressed=False, **arrays):
    return lambda path: (np.savez_compressed if compressed else np.savez)(path, **arrays)


def cut(path):
    np.save(path, A)
    path.write_bytes(path.read_bytes()[:-8])


NUMPY = [
    ("float64.npy", saved(A), BOX, A),
    ("float32.npy", saved(A.astype("f4")), BOX, A),
    ("float16.npy", saved((A * 64).astype("f2")), [*BOX, "--factor", "0.015625"], A),
    ("big-endian.npy", saved(A.astype(">f8")), BOX, A),
    ("big-endian-integers.npy", saved((A * 64).astype(">i4")), [*BOX, "--factor", "0.015625"], A),
    ("int16.npy", saved((A * 64).astype("i2")), [*BOX, "--factor", "0.015625"], A),
    ("uint8.npy", saved((A * 32).astype("u1")), [*BOX, "--factor", "0.03125"], np.floor(A * 32) / 32),
    ("uint64.npy", saved((A * 64).astype("u8")), [*BOX, "--factor", "0.015625"], A),
    ("fortran.npy", saved(np.asfortranarray(A)), BOX, A),
    ("version2.npy", version(2), BOX, A),
    ("version3.npy", version(3), BOX, A),
    ("long.npy", header(A, lambda text: text.replace("(4, 6, 8)", "(4L, 6L, 8L)")), BOX, A),
    ("axes.npy", saved(A.transpose(2, 1, 0)), [*BOX, "--axes", "zyx"], A),
    ("axes2.npy", saved(A.transpose(1, 2, 0)), [*BOX, "--axes", "yzx"], A),
    ("voxel.npy", saved(A), ["--voxel", "1 pc", "--centre", "0 0 0 pc"], A),
    ("metres.npy", saved(A * 1e6), [*BOX, "--unit", "m-3"], A),
    ("kilograms.npy", saved(A * 1.4 * 1.6735328e-21), [*BOX, "--unit", "kg/m3", "--mass-per-h", "1.4"], A),
    ("grams.npy", saved(A), [*BOX, "--unit", "g/cm**3"], "mass_per_h = 1.4"),
    ("no-mass.npy", saved(A), [*BOX, "--unit", "cm-3", "--mass-per-h", "1.4"], "requires a unit of mass"),
    ("furlongs.npy", saved(A), [*BOX, "--unit", "furlong-3"], "furlong"),
    ("nan.npy", saved(np.where(A == A[1, 2, 3], np.nan, A)), BOX, "clip"),
    ("clipped.npy", saved(np.where(A == A[1, 2, 3], np.nan, A)), [*BOX, "--clip"], without(A, (1, 2, 3))),
    ("negative.npy", saved(-A), BOX, "negative|below zero"),
    ("complex.npy", saved(A.astype(complex)), BOX, "real numbers"),
    ("bool.npy", saved(A > 1), BOX, "real numbers|type"),
    ("objects.npy", saved(A.astype(object)), BOX, "real numbers|type"),
    ("records.npy", saved(np.zeros((4, 6, 8), [("a", "f8"), ("b", "f4")])), BOX, "records"),
    ("flat.npy", saved(A[0]), BOX, "2 axes"),
    ("four.npy", saved(A[None, None]), BOX, "5 axes"),
    ("empty.npy", saved(A[:0]), BOX, "empty"),
    ("cut.npy", cut, BOX, "truncated"),
    ("shape.npy", header(A, lambda text: text.replace("(4, 6, 8)", "(4, 6, 9)")), BOX, "truncated"),
    ("unplaced.npy", saved(A), [], "voxel"),
    ("one.npz", archive(a=A), BOX, A),
    ("packed.npz", archive(True, a=A), BOX, A),
    ("named.npz", archive(a=A, b=2 * A), [*BOX, "--array", "a"], A),
    ("two.npz", archive(a=A, b=2 * A), BOX, "array"),
    ("missing.npz", archive(a=A), [*BOX, "--array", "density"], "density"),
]


@params(NUMPY)
def test_arrays_of_numpy_files(case, tmp_path, capfd):
    name, write, options, expected = case
    write(tmp_path / name)
    hold(tmp_path / name, options, expected, tmp_path, capfd)


# HDF5.


def h5(values=A, dtype=None, dimensions=None, groups=None, write=None, **attributes):
    """A file with the dataset /gas/density, attributes of it, and of groups by their names."""

    def made(path):
        h5py = pytest.importorskip("h5py")
        with h5py.File(path, "w") as file:
            dataset = file.create_dataset("gas/density", data=np.asarray(values, dtype))
            for name, value in attributes.items():
                dataset.attrs[name] = value
            for group, variables in (groups or {}).items():
                for name, value in variables.items():
                    file.require_group(group).attrs[name] = value
            for axis, label in enumerate(dimensions or ()):
                dataset.dims[axis].label = label
            if write:
                write(h5py, file, dataset)

    return made


def edges(unit, factor=1.0, other=None, other_factor=None):
    low, high = np.array([-2, -3, -4.0]) * factor, np.array([2, 3, 4.0]) * (factor if other_factor is None else other_factor)
    return {"left_edge": low, "right_edge": high, "left_edge_units": unit, "right_edge_units": other or unit}


def matlab(path):
    h5(A.T, MATLAB_class=np.bytes_("double"))(path)


def mesh(labels=("z", "y", "x"), order="C", unit=3.0856775814913673e16, dimension=(-3, 0, 0, 0, 0, 0, 0), unit_si=1e6):
    """A mesh of openPMD, written by z, y and x."""
    return h5(
        A.T,
        axisLabels=np.array([name.encode() for name in labels]),
        dataOrder=np.bytes_(order),
        gridSpacing=np.ones(3),
        gridGlobalOffset=np.array([-4.0, -3.0, -2.0][:: 1 if order == "C" else -1]),
        gridUnitSI=unit,
        position=np.full(3, 0.5),
        unitSI=unit_si,
        unitDimension=np.array(dimension, float),
    )


def scales(h5py, file, dataset, names=("x", "y", "z"), places=(X, Y, Z), unit="pc"):
    for axis, (name, values) in enumerate(zip(names, places)):
        scale = file["gas"].create_dataset(name, data=values)
        scale.make_scale(name)
        if unit:
            scale.attrs["units"] = unit
        dataset.dims[axis].attach_scale(scale)


def other_dataset(h5py, file, dataset):
    file["gas/other"] = 2 * A


def virtual(h5py, file, dataset):
    layout = h5py.VirtualLayout((4, 6, 8), "f8")
    layout[...] = h5py.VirtualSource(dataset)
    file.create_virtual_dataset("virtual", layout)


TWO_BYTES = np.where(A == A[1, 2, 3], -999, A * 64).astype("i2")
HDF5 = [
    ("plain", h5(), BOX, A),
    ("single", h5(dtype="f4"), BOX, A),
    ("big-endian", h5(dtype=">f8"), BOX, A),
    ("integers", h5(A * 64, "i4"), [*BOX, "--factor", "0.015625"], A),
    ("units-text", h5(units="cm**-3"), BOX, A),
    ("units-bytes", h5(units=np.bytes_("cm**-3")), BOX, A),
    ("units-array", h5(units=np.array([b"cm**-3"])), BOX, A),
    ("units-metres", h5(A * 1e6, units="m**-3"), BOX, A),
    ("units-grams", h5(units="g/cm**3"), BOX, "mass_per_h = 1.4"),
    ("units-grams-per-h", h5(A * 1.4 * 1.6735328e-24, units="g/cm**3"), [*BOX, "--mass-per-h", "1.4"], A),
    ("units-unknown", h5(units="furlong"), BOX, "furlong"),
    ("units-against", h5(units="m**-3"), [*BOX, *CM3], "correct or remove one"),
    ("edges-parsecs", h5(groups={"gas": edges("pc")}), [], A),
    ("edges-kiloparsecs", h5(groups={"gas": edges("kpc", 1e-3)}), [], A),
    ("edges-centimetres", h5(groups={"/": edges("cm", 3.0856775814913673e18)}), [], A),
    ("edges-two-units", h5(groups={"gas": edges("pc", 1, "kpc", 1e-3)}), [], A),
    ("edges-code-length", h5(groups={"gas": edges("code_length", 0.5), "/": {"length_unit": 2.0, "length_unit_units": "pc"}}), [], A),
    ("edges-unknown-length", h5(groups={"gas": edges("code_length")}), [], "code_length"),
    ("edges-furlongs", h5(groups={"gas": edges("pc", 1, "furlong")}), [], "furlong"),
    ("edges-missing", h5(), [], "voxel"),
    ("labels", h5(A.transpose(1, 2, 0), dimensions="yzx"), BOX, A),
    ("labels-long", h5(A.T, dimensions=("pos_z", "pos_y", "pos_x")), BOX, A),
    ("labels-unknown", h5(dimensions=("lon", "lat", "depth")), BOX, "lon, lat, depth"),
    ("labels-ordered", h5(dimensions=("lon", "lat", "depth")), [*BOX, "--axes", "xyz"], A),
    ("scales", h5(write=scales), [], A),
    ("scales-turned", h5(A.T, write=partial(scales, names="zyx", places=(Z, Y, X))), [], A),
    ("scales-backwards", h5(A[::-1], write=partial(scales, places=(X[::-1], Y, Z))), [], A),
    ("scales-uneven", h5(write=partial(scales, places=(X**3, Y, Z))), [], "unequal steps"),
    ("scales-furlongs", h5(write=partial(scales, unit="furlong")), [], "furlong"),
    ("fill-value", h5(TWO_BYTES, _FillValue=np.int16(-999), scale_factor=1 / 64), [*BOX, "--clip"], without(A, (1, 2, 3))),
    ("fill-value-not-clipped", h5(TWO_BYTES, _FillValue=np.int16(-999), scale_factor=1 / 64), BOX, "clip"),
    ("missing-value-text", h5(np.where(A == A[1, 2, 3], 99.5, A), missing_value="99.5"), [*BOX, "--clip"], without(A, (1, 2, 3))),
    ("several", h5(write=other_dataset), BOX, "array = "),
    ("several-named", h5(write=other_dataset), [*BOX, "--array", "/gas/density"], A),
    ("misnamed", h5(), [*BOX, "--array", "/gas/densty"], "/gas/density"),
    ("virtual", h5(write=virtual), [*BOX, "--array", "virtual"], "virtual dataset"),
    ("complex", h5(dtype=complex), BOX, "unsupported"),
    ("bool", h5(A > 1), BOX, "unsupported"),
    ("texts", h5(np.full((2, 2, 2), b"a")), BOX, "texts"),
    ("flat", h5(A[0]), BOX, "three"),
    ("matlab.mat", matlab, BOX, A),
    ("matlab5.mat", lambda path: path.write_bytes(b"MATLAB 5.0 MAT-file, Platform: GLNXA64".ljust(512)), BOX, "-v7.3"),
    ("openpmd", mesh(), [], A),
    ("openpmd-fortran", mesh(labels=("x", "y", "z"), order="F"), [], A),
    ("openpmd-mass", mesh(dimension=(-3, 1, 0, 0, 0, 0, 0), unit_si=1.4 * 1.6735328e-21), ["--mass-per-h", "1.4"], A),
    ("openpmd-energy", mesh(dimension=(-1, 1, -2, 0, 0, 0, 0)), [], "unitDimension"),
    ("damaged", lambda path: path.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(100)), BOX, "HDF5"),
    ("text", lambda path: path.write_text("x,y,z\n1,2,3\n"), BOX, "HDF5"),
]


@params(HDF5)
def test_datasets_of_hdf5(case, tmp_path, capfd):
    name, write, options, expected = case
    path = tmp_path / (name if "." in name else f"{name}.h5")
    write(path)
    hold(path, options, expected, tmp_path, capfd)


# netCDF.


def nc(values=A, dtype="f8", names=("x", "y", "z"), places=(X, Y, Z), unit="pc", fill=None, kind="NETCDF4", only=None, **attributes):
    """A file with the variable density over dimensions and their coordinates."""

    def made(path):
        netcdf = pytest.importorskip("netCDF4")
        with netcdf.Dataset(path, "w", format=kind) as file:
            file.set_auto_maskandscale(False)
            dimensions = tuple(names)
            for name, length in zip(dimensions, np.shape(values)):
                file.createDimension(name, length)
            for name, place in zip(names, places or ()):
                variable = file.createVariable(name, "f8", (name,))
                variable[:] = place
                if unit:
                    variable.units = unit
            variable = file.createVariable("density", dtype, dimensions, fill_value=fill)
            variable.set_auto_maskandscale(False)
            for name, value in attributes.items():
                variable.setncattr(name, value)
            part = slice(None) if only is None else only
            variable[part] = np.asarray(values, dtype)[part]

    return made


PACKED = np.round(A * 64).astype("i2")
HOLED = np.where(A == A[1, 2, 3], 50.0, A)
HOLE = without(A, (1, 2, 3))
CLIP = ["--clip"]
NETCDF = [
    ("plain", nc(), [], A),
    ("single", nc(dtype="f4"), [], A),
    ("metres", nc(places=[v * 3.0856775814913673e16 for v in (X, Y, Z)], unit="m"), [], A),
    ("no-unit", nc(unit=None), [], "unit"),
    ("no-unit-box", nc(unit=None), ["--no-wcs", *BOX], A),
    ("furlongs", nc(unit="furlong"), [], "furlong"),
    ("zyx", nc(A.T, names="zyx", places=(Z, Y, X)), [], A),
    ("yzx", nc(A.transpose(1, 2, 0), names="yzx", places=(Y, Z, X)), [], A),
    ("backwards", nc(A[:, ::-1], places=(X, Y[::-1], Z)), [], A),
    ("indices", nc(A.T, names=("k", "j", "i"), places=None), BOX, A),
    ("numbered", nc(A.T, names=("x3", "x2", "x1"), places=None), BOX, A),
    ("counts", nc(A.T, names=("nz", "ny", "nx"), places=None), BOX, A),
    ("geographic", nc(names=("lon", "lat", "level"), places=None), BOX, "lon, lat, level"),
    ("not uniform", nc(places=(X**3, Y, Z)), [], "not uniform"),
    ("units", nc(A * 1e6, units="m-3"), [], A),
    ("units-grams", nc(units="g cm-3"), [], "mass_per_h"),
    ("units-unknown", nc(units="K"), [], '"K"'),
    ("packed", nc(PACKED, "i2", scale_factor=1 / 64), [], A),
    ("packed-offset", nc(PACKED - 100, "i2", scale_factor=1 / 64, add_offset=100 / 64), [], A),
    ("unsigned", nc((A * 10000).astype("u2").view("i2"), "i2", _Unsigned="true", scale_factor=1e-4), [], np.floor(A * 10000) / 1e4),
    ("unsigned-bytes", nc((A * 60).astype("u1").view("i1"), "i1", _Unsigned="true", scale_factor=1 / 60), [], np.floor(A * 60) / 60),
    ("valid-range", nc(HOLED, valid_range=np.array([0.0, 10.0])), CLIP, HOLE),
    ("valid-range-not-clipped", nc(HOLED, valid_range=np.array([0.0, 10.0])), [], "clip"),
    ("valid-max", nc(HOLED, valid_max=10.0), CLIP, HOLE),
    ("valid-min", nc(-HOLED + 2 * A, valid_min=0.0), CLIP, HOLE),
    ("fill", nc(HOLED, fill=50.0), CLIP, HOLE),
    ("fill-packed", nc(np.where(HOLE == 0, -5, PACKED), "i2", fill=-5, scale_factor=1 / 64), CLIP, HOLE),
    ("fill-default", nc(dtype="f4", only=np.s_[:2]), CLIP, without(A, np.s_[2:])),
    ("fill-default-not-clipped", nc(dtype="f4", only=np.s_[:2]), [], "clip"),
    ("fill-default-integers", nc(PACKED, "i2", only=np.s_[:2], scale_factor=1 / 64), CLIP, without(A, np.s_[2:])),
    ("missing-values", nc(HOLED, missing_value=np.array([-1.0, 50.0])), CLIP, HOLE),
    ("missing-value-single", nc(np.where(HOLE == 0, np.float32(1e20), A), "f4", missing_value=1e20), CLIP, HOLE),
    ("classic", nc(kind="NETCDF3_CLASSIC"), [], "netCDF 3 .*nccopy"),
    ("offset-64", nc(kind="NETCDF3_64BIT_OFFSET"), [], "netCDF 3 .*nccopy"),
    ("data-64", nc(kind="NETCDF3_64BIT_DATA"), [], "netCDF 3 .*nccopy"),
    ("classic-model", nc(kind="NETCDF4_CLASSIC"), [], A),
]


@params(NETCDF)
def test_variables_of_netcdf(case, tmp_path, capfd):
    name, write, options, expected = case
    write(tmp_path / f"{name}.nc")
    hold(tmp_path / f"{name}.nc", options, expected, tmp_path, capfd)


# Arrays in memory.


def labelled(values=A, names="xyz", places=(X, Y, Z), unit="pc", **attributes):
    xarray = pytest.importorskip("xarray")
    coords = {name: (name, place, {"units": unit} if unit else {}) for name, place in zip(names, places or ())}
    return xarray.DataArray(values, dims=tuple(names), coords=coords, attrs=attributes)


ARRAYS = [
    ("float64", lambda: A, {}, A),
    ("float32", lambda: A.astype("f4"), {}, A),
    ("float16", lambda: A.astype("f2"), {}, A.astype("f2")),
    ("big-endian", lambda: A.astype(">f8"), {}, A),
    ("integers", lambda: (A * 64).astype(int), {"factor": 1 / 64}, A),
    ("fortran", lambda: np.asfortranarray(A), {}, A),
    ("transposed", lambda: A.T, {"axes": "zyx"}, A),
    ("strided", lambda: np.repeat(A, 2, axis=1)[:, ::2], {}, A),
    ("backwards", lambda: A[::-1], {}, A[::-1]),
    ("lists", lambda: A.tolist(), {}, A),
    ("quantity", lambda: A / u.cm**3, {}, A),
    ("metres", lambda: A * 1e6 / u.m**3, {}, A),
    ("thousands", lambda: A * u.Unit("1000 cm-3"), {}, r"\.to\('cm\*\*-3'\)"),
    ("grams", lambda: A * u.g / u.cm**3, {}, "mass_per_h = 1.4"),
    ("grams-per-h", lambda: A * 1.4 * 1.6735328e-24 * u.g / u.cm**3, {"mass_per_h": 1.4}, A),
    ("kilograms-per-h", lambda: A * 1.6735328e-21 * u.kg / u.m**3, {"mass_per_h": 1}, A),
    ("kelvins", lambda: A * u.K, {}, "not a .*density"),
    ("masked", lambda: np.ma.masked_equal(A, A[1, 2, 3]), {"clip": True}, HOLE),
    ("masked-not-clipped", lambda: np.ma.masked_equal(A, A[1, 2, 3]), {}, "clip=True"),
    ("masked-quantity", lambda: Masked(A / u.cm**3, A == A[1, 2, 3]), {"clip": True}, HOLE),
    ("masked-by-nothing", lambda: np.ma.masked_less(A, 0), {}, A),
    ("nan", lambda: np.where(HOLE == 0, np.nan, A), {"clip": True}, HOLE),
    ("nan-not-clipped", lambda: np.where(HOLE == 0, np.nan, A), {}, "clip"),
    ("infinite", lambda: np.where(HOLE == 0, np.inf, A), {}, "infinite|finite|inf"),
    ("negative", lambda: -A, {}, "negative|below zero"),
    ("complex", lambda: A + 0j, {}, "real part"),
    ("bool", lambda: A > 1, {}, "float32 or float64"),
    ("texts", lambda: A.astype(str), {}, "float32 or float64"),
    ("objects", lambda: A.astype(object), {}, "float32 or float64"),
    ("flat", lambda: A[0], {}, "2 axes"),
    ("empty", lambda: A[:0], {}, "empty"),
    ("labelled", lambda: labelled(), None, A),
    ("labelled-turned", lambda: labelled().transpose("z", "x", "y"), None, A),
    ("labelled-backwards", lambda: labelled().isel(y=slice(None, None, -1)), None, A),
    ("labelled-kiloparsecs", lambda: labelled(places=(X / 1e3, Y / 1e3, Z / 1e3), unit="kpc"), None, A),
    ("labelled-units", lambda: labelled(A * 1e6, units="m-3"), None, A),
    ("labelled-grams", lambda: labelled(units="g/cm3"), None, "mass_per_h"),
    ("labelled-furlongs", lambda: labelled(unit="furlong"), None, "furlong"),
    ("labelled-names", lambda: labelled(names=("lon", "lat", "depth")), None, "lon, lat, depth"),
    ("labelled-uneven", lambda: labelled(places=(X**3, Y, Z)), None, "not uniform"),
]


@params(ARRAYS)
def test_arrays_in_memory(case):
    _, make, keys, expected = case
    box = {"low": "-2 -3 -4 pc", "high": "2 3 4 pc", **keys} if keys is not None else {}

    def picture(values, **keys):
        scene = bn.Scene(bands="johnson", camera=bn.PerspectiveCamera("7 5 12 pc", "40 deg", size=24))
        scene.fields["cloud"] = bn.Grid(values, **keys)
        scene.dust = bn.Dust("cloud", "0.1 /pc", albedo=0.6)
        scene.stars.append(bn.Star("0.3 0.2 0.4 pc", temperature="12000 K", luminosity="1000 Lsun", visible=False))
        return scene.render().radiance

    if isinstance(expected, str):
        with pytest.raises(bn.SceneError, match=expected):
            picture(make(), **box)
        return
    # The same numbers as a plain array, which test_arrays.py holds to a closed form.
    plain = picture(np.ascontiguousarray(expected), low="-2 -3 -4 pc", high="2 3 4 pc")
    np.testing.assert_allclose(picture(make(), **box), plain, rtol=1e-5)
    assert not np.allclose(picture(np.ascontiguousarray(expected[::-1, ::-1]), low="-2 -3 -4 pc", high="2 3 4 pc"), plain, rtol=1e-2)


# Kernels of point spreads.

ROWS, COLUMNS = np.mgrid[-7:8, -7:8]
#: A point, and half as much to its right and above it, by rows from the top.
SPREAD = 200 * np.exp(-(COLUMNS**2) - ROWS**2) + 100 * np.exp(-((COLUMNS - 4) ** 2) - (ROWS + 2) ** 2)
UP = SPREAD[::-1]


def hdu(values=UP, kind=fits.PrimaryHDU, **cards):
    return kind(values, fits.Header(cards))


def listed(*hdus, behind=b""):
    def write(path):
        fits.HDUList(list(hdus)).writeto(path, output_verify="ignore")
        path.write_bytes(path.read_bytes() + behind)

    return write


def scaled(dtype, **keys):
    def write(path):
        hdu = fits.PrimaryHDU(UP.copy())
        hdu.scale(dtype, **keys)
        hdu.writeto(path)

    return write


WHOLE = np.round(UP)
EMPTY = fits.PrimaryHDU
IMAGE = fits.ImageHDU
KERNELS = [
    ("float64.fits", listed(hdu()), {}, SPREAD),
    ("float32.fits", listed(hdu(UP.astype("f4"))), {}, SPREAD),
    ("int16.fits", listed(hdu(WHOLE.astype("i2"))), {}, WHOLE[::-1]),
    ("int32.fits", listed(hdu(WHOLE.astype("i4"))), {}, WHOLE[::-1]),
    ("int64.fits", listed(hdu(WHOLE.astype("i8"))), {}, WHOLE[::-1]),
    ("uint8.fits", listed(hdu(WHOLE.astype("u1"))), {}, WHOLE[::-1]),
    ("uint16.fits", listed(hdu(WHOLE.astype("u2"))), {}, WHOLE[::-1]),
    ("scaled.fits", scaled("int32", bscale=1e-6), {}, SPREAD),
    ("offset.fits", scaled("int32", bscale=1e-6, bzero=50), {}, SPREAD),
    ("packed.fits", listed(EMPTY(), hdu(kind=partial(fits.CompImageHDU, compression_type="GZIP_1", quantize_level=0))), {}, SPREAD),
    ("gzipped.fits.gz", lambda path: hdu().writeto(path), {}, SPREAD),
    ("extension.fits", listed(EMPTY(), hdu(kind=IMAGE, EXTNAME="PSF")), {}, SPREAD),
    ("named.fits", listed(EMPTY(), hdu(SPREAD, IMAGE, EXTNAME="A"), hdu(kind=IMAGE, EXTNAME="PSF")), {"hdu": "psf"}, SPREAD),
    ("numbered.fits", listed(EMPTY(), hdu(SPREAD, IMAGE), hdu(kind=IMAGE)), {"hdu": "2"}, SPREAD),
    ("misnamed.fits", listed(EMPTY(), hdu(kind=IMAGE, EXTNAME="PSF")), {"hdu": "SCI"}, 'no HDU "SCI"'),
    ("top-down.fits", listed(hdu(SPREAD, ROWORDER="TOP-DOWN")), {}, SPREAD),
    ("bottom-up.fits", listed(hdu(ROWORDER="BOTTOM-UP")), {}, SPREAD),
    ("zeros-behind.fits", listed(hdu(), behind=bytes(2880)), {}, SPREAD),
    ("blanks-behind.fits", listed(hdu(), behind=b" " * 2880), {}, SPREAD),
    ("text-behind.fits", listed(hdu(), behind=b"made by hand".ljust(2880)), {}, SPREAD),
    ("long-text.fits", listed(hdu(LONG="many words " * 20)), {}, SPREAD),
    ("quotes.fits", listed(hdu(OBSERVER="O'Brien's = 7 / 2")), {}, SPREAD),
    ("nan.fits", listed(hdu(np.where(UP > 150, np.nan, UP))), {}, "finite"),
    ("negative.fits", listed(hdu(UP - 5)), {}, "negative"),
    ("nothing.fits", listed(hdu(UP * 0)), {}, "above zero"),
    ("cube.fits", listed(hdu(np.array([UP, UP]))), {}, "2-D image"),
    ("table.fits", listed(EMPTY(), fits.BinTableHDU.from_columns([fits.Column("a", "D", array=[1.0])])), {}, "2-D image"),
    ("empty.fits", listed(EMPTY()), {}, "2-D image"),
    ("cut.fits", lambda path: (hdu().writeto(path), path.write_bytes(path.read_bytes()[:4000])), {}, "truncated"),
    ("text.fits", lambda path: path.write_text("1,2,3\n"), {}, "FITS"),
    ("float32.npy", lambda path: np.save(path, SPREAD[None].astype("f4")), {}, SPREAD),
    ("fortran.npy", lambda path: np.save(path, np.asfortranarray(np.array([SPREAD, SPREAD]))), {}, "in C order"),
    ("hdu.npy", lambda path: np.save(path, SPREAD[None]), {"hdu": "1"}, "remove hdu"),
    ("missing.fits", lambda path: None, {}, "does not exist"),
]


@pytest.fixture(scope="module")
def star(tmp_path_factory):
    return sky(catalogue(tmp_path_factory.mktemp("sky")), size=64).render()


def spread(image, file, **keys):
    psf = {"kind": "kernel", "file": str(file), "pixel_scale": "1.8 arcsec", **keys}
    return image.observe({"aperture": "1 m", "exposure": "1 s", "psf": [psf]}).mean("johnson-V")


@params(KERNELS)
def test_kernels_of_point_spreads(case, star, tmp_path):
    name, write, keys, expected = case
    write(tmp_path / name)
    if isinstance(expected, str):
        with pytest.raises(bn.BarnardError, match=expected) as caught:
            spread(star, tmp_path / name, **keys)
        assert name in str(caught.value)
        return
    # A plain array, which test_instrument.py holds to the Gaussians that it is made of.
    np.save(tmp_path / "plain.npy", expected[None])
    plain = spread(star, tmp_path / "plain.npy")
    np.testing.assert_allclose(spread(star, tmp_path / name, **keys), plain, rtol=1e-5, atol=1e-6 * plain.max())
    np.save(tmp_path / "other.npy", expected[None, ::-1])
    assert np.abs(spread(star, tmp_path / "other.npy") - plain).max() > 0.01 * plain.max()
