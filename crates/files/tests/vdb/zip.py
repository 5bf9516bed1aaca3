"""Packs files of OpenVDB by zlib, which Debian's OpenVDB is built without: python zip.py FOLDER (TinyVDB 0.9.0)."""

import sys
from pathlib import Path

import tinyvdb

folder = Path(sys.argv[1])
for name in ("float", "half", "double"):
    for mask, flag in (("", 0), ("_mask", tinyvdb.COMPRESS_ACTIVE_MASK)):
        path = folder / f"{name}_zip{mask}.vdb"
        plain = path.stat().st_size
        file = tinyvdb.open(str(path))
        file.read_grids()
        file.save(str(path), compression=tinyvdb.COMPRESS_ZIP | flag)
        file.close()
        print(path.name, plain, path.stat().st_size)
