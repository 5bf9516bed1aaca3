"""Packs arrays of 16-bit floats as crates/files/src/builtin/packed.rs reads them: pack.py IN.npz OUT.npz"""

import sys

import numpy as np


def packed(values):
    bits = values.view(np.uint16)
    for axis in range(bits.ndim):
        bits = np.diff(bits, axis=axis, prepend=np.uint16(0))
    signed = bits.view(np.int16)
    folded = ((signed << 1) ^ (signed >> 15)).view(np.uint16)
    return np.stack([folded >> 8, folded & 255]).astype(np.uint8)


with np.load(sys.argv[1]) as arrays:
    np.savez_compressed(sys.argv[2], **{name: packed(np.ascontiguousarray(arrays[name], np.float16)) for name in arrays})
