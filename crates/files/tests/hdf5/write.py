"""Writes the HDF5 files of hdf5.zip: python write.py FOLDER (h5py 3.16, HDF5 2.0, xarray with h5netcdf, yt 4.4, hdf5plugin).

Every dataset of the groups "types", "layouts" and "filters" holds the same numbers, which the tests know as a formula.
"""

import sys
import zipfile
from pathlib import Path

import h5py
import hdf5plugin
import numpy as np
import xarray
import yt

SHAPE = (12, 10, 14)
CHUNKS = (5, 4, 6)
i, j, k = np.meshgrid(*(np.arange(n) for n in SHAPE), indexing="ij")
whole = (3 * i + 5 * j + 7 * k) % 61 + 1
numbers = whole / 8


def layouts(file):
    group = file.create_group("layouts")
    data = numbers.astype("<f4")
    group.create_dataset("contiguous", data=data)
    compact = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    compact.set_layout(h5py.h5d.COMPACT)
    space = h5py.h5s.create_simple(SHAPE)
    h5py.h5d.create(group.id, b"compact", h5py.h5t.IEEE_F32LE, space, compact).write(h5py.h5s.ALL, h5py.h5s.ALL, data)
    group.create_dataset("chunked", data=data, chunks=CHUNKS)
    group.create_dataset("one_chunk", data=data, chunks=SHAPE)
    group.create_dataset("one_chunk_packed", data=data, chunks=SHAPE, compression="gzip")
    group.create_dataset("growing", data=data, chunks=CHUNKS, maxshape=(None, *SHAPE[1:]))
    group.create_dataset("growing_packed", data=data, chunks=(1, 4, 6), maxshape=(None, *SHAPE[1:]), compression="gzip")
    group.create_dataset("growing_twice", data=data, chunks=CHUNKS, maxshape=(None, None, SHAPE[2]))
    group.create_dataset("growing_twice_packed", data=data, chunks=(2, 3, 14), maxshape=(None, None, SHAPE[2]), compression="gzip")
    early = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    early.set_chunk(CHUNKS)
    early.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    h5py.h5d.create(group.id, b"allocated_early", h5py.h5t.IEEE_F32LE, space, early).write(h5py.h5s.ALL, h5py.h5s.ALL, data)
    group.create_dataset("four_axes", data=data[:, None], chunks=(5, 1, 4, 6))


def types(file):
    group = file.create_group("types")
    for kind in ("f2", "f4", "f8", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8"):
        for order in "<>":
            values = numbers if kind[0] == "f" else whole
            name = {"<": "little", ">": "big"}[order] + "_" + kind
            group.create_dataset(name, data=values.astype(order + kind), chunks=CHUNKS, compression="gzip", shuffle=True)
    file["a_type"] = np.dtype("<f4")
    group.create_dataset("named_f4", data=numbers.astype("<f4"), dtype=file["a_type"])


def filters(file):
    group = file.create_group("filters")
    data = numbers.astype("<f4")
    for name, how in {
        "gzip": {"compression": "gzip"},
        "gzip_shuffle": {"compression": "gzip", "shuffle": True},
        "lzf": {"compression": "lzf"},
        "lzf_shuffle": {"compression": "lzf", "shuffle": True},
        "szip_ec": {"compression": "szip", "compression_opts": ("ec", 8)},
        "szip_nn": {"compression": "szip", "compression_opts": ("nn", 16)},
        "fletcher32": {"fletcher32": True},
        "fletcher32_gzip_shuffle": {"fletcher32": True, "compression": "gzip", "shuffle": True},
    }.items():
        group.create_dataset(name, data=data, chunks=CHUNKS, **how)
    group.create_dataset("scaleoffset_i4", data=whole.astype("<i4"), chunks=CHUNKS, scaleoffset=0)
    # Incompressible chunks are kept as they are.
    noise = np.random.default_rng(1).integers(0, 2**32, SHAPE, dtype="u4")
    file.create_dataset("noise/lzf", data=noise, chunks=CHUNKS, compression="lzf")
    file.create_dataset("noise/plain", data=noise)
    long = np.zeros((2, 8, 5000), "f4")
    long[:, :, 4000:] = 2.5
    file.create_dataset("long/lzf", data=long, chunks=(2, 8, 5000), compression="lzf")


def holes(file):
    """Chunks that were never written have the fill value."""
    for name, fill in (("holes", 0.0), ("filled", 2.5)):
        dataset = file.create_dataset(f"{name}/f4", SHAPE, "<f4", chunks=CHUNKS, fillvalue=fill, compression="gzip")
        dataset[5:10, 4:8, 6:12] = numbers[5:10, 4:8, 6:12]
    file.create_dataset("nothing/f4", SHAPE, "<f4")


def packed(file):
    """Numbers as netCDF packs them, and some that stand for none."""
    dataset = file.create_dataset("packed/i2", data=(4 * (numbers - 3)).astype("<i2"), chunks=CHUNKS)
    dataset.attrs["scale_factor"], dataset.attrs["add_offset"] = 0.25, 3.0
    dataset.attrs["_FillValue"] = np.int16(4)
    dataset = file.create_dataset("packed/f4", data=numbers.astype("<f4"))
    dataset.attrs["missing_value"] = np.float32(2.5)


def links(file):
    file["links/hard"] = file["layouts/chunked"]
    file["links/soft"] = h5py.SoftLink("/layouts/chunked")
    file["links/nowhere"] = h5py.SoftLink("/links/nowhere")
    file["links/outside"] = h5py.ExternalLink("other.h5", "/layouts/chunked")
    file["links/back"] = file["/"]
    many = file.create_group("links/many")
    for number in range(40):
        many.create_group(f"group_{number:02}").attrs["number"] = number
    file["links/many/group_17/f4"] = file["layouts/chunked"]


def refused(file):
    group = file.create_group("refused")
    group.create_dataset("texts", data=np.full((2, 2, 2), b"text"))
    group.create_dataset("records", data=np.zeros((2, 2, 2), [("a", "f4"), ("b", "f4")]))
    group.create_dataset("complex", data=np.zeros((2, 2, 2), "c8"))
    group.create_dataset("flat", data=np.zeros((4, 4), "f4"))
    group.create_dataset("empty", data=np.zeros((4, 0, 4), "f4"))
    bfloat = h5py.h5t.IEEE_F32LE.copy()
    bfloat.set_fields(15, 7, 8, 0, 7)
    bfloat.set_size(2)
    bfloat.set_ebias(127)
    h5py.h5d.create(group.id, b"bfloat", bfloat, h5py.h5s.create_simple((2, 2, 2)))
    twelve = h5py.h5t.STD_I16LE.copy()
    twelve.set_precision(12)
    h5py.h5d.create(group.id, b"twelve_bits", twelve, h5py.h5s.create_simple((2, 2, 2)))
    group.create_dataset("never_written", (2**18, 2**18, 2**18), "u1")
    group.create_dataset("blosc", data=numbers.astype("f4"), chunks=CHUNKS, **hdf5plugin.Blosc())
    group.create_dataset("zstd", data=numbers.astype("f4"), chunks=CHUNKS, **hdf5plugin.Zstd())


def places(folder):
    data = numbers.astype("f4")
    with h5py.File(folder / "labels.h5", "w") as file:
        dataset = file.create_dataset("gas/n_H", data=data)
        dataset.attrs["unit"] = "cm^-3"
        for axis, label in zip(dataset.dims, "zyx"):
            axis.label = label
    with h5py.File(folder / "edges.h5", "w") as file:
        file["density"] = data
        for name, edge in (("domain_left_edge", [0.0, 0.0, 0.0]), ("domain_right_edge", [14.0, 10.0, 12.0])):
            file.attrs[name], file.attrs[f"{name}_units"] = edge, "pc"
    steps = {"z": -2.0 + 0.5 * np.arange(12), "y": 3.0 - 0.25 * np.arange(10), "x": 10.0 + np.arange(14.0)}
    coordinates = {name: (name, values, {"units": "pc"}) for name, values in steps.items()}
    density = xarray.DataArray(data, dims=("z", "y", "x"), coords=coordinates, attrs={"units": "m^-3"})
    density.to_dataset(name="density").to_netcdf(folder / "xarray.nc", engine="h5netcdf")
    uneven = density.assign_coords(y=("y", np.arange(10.0) ** 2, {"units": "pc"}))
    uneven.to_dataset(name="density").to_netcdf(folder / "uneven.nc", engine="h5netcdf")
    density.drop_vars(["x", "y", "z"]).to_dataset(name="density").to_netcdf(folder / "no_coordinates.nc", engine="h5netcdf")
    box = np.array([[-1.0, 1.0], [-2.0, 2.0], [0.0, 7.0]])
    source = yt.load_uniform_grid({("gas", "density"): (data, "g/cm**3")}, SHAPE, length_unit=(2.0, "pc"), bbox=box, nprocs=1)
    grid = source.covering_grid(0, left_edge=source.domain_left_edge, dims=source.domain_dimensions)
    grid.save_as_dataset(str(folder / "yt.h5"), fields=[("gas", "density")])


def main(folder):
    for version in ("earliest", "latest"):
        with h5py.File(folder / f"{version}.h5", "w", libver=version) as file:
            for part in (layouts, types, filters, holes, packed, links, refused):
                part(file)
    with h5py.File(folder / "behind.h5", "w", userblock_size=1024) as file:
        layouts(file)
    places(folder)
    with zipfile.ZipFile(folder / "hdf5.zip", "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for path in sorted(folder.glob("*.[hn]*")):
            if path.suffix != ".zip":
                archive.write(path, path.name)
                print(path.name, path.stat().st_size)


main(Path(sys.argv[1]))
