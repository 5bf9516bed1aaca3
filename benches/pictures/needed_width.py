"""Needed width of pictures: the narrowest width that keeps their structure.

A picture needs a width w if it returns after a reduction to w and an enlargement back: half of the pixels within 0.33 of 255 levels, and
95 % within 2 levels. A blurred picture needs far less than its own width.

    python3 needed_width.py PICTURE.tif ...

prints width, needed width and their ratio for each picture of 16 bits per colour: 8 bits are dithered, which looks like structure.
Needs NumPy, Pillow and tifffile.
"""

import sys

import numpy as np
import tifffile
from PIL import Image

MEDIAN, MOST = 0.33, 2.0


def returns(channels: list[Image.Image], width: int) -> bool:
    """True if the channels of a picture return from a width in pixels."""
    size = channels[0].size
    height = max(1, round(size[1] * width / size[0]))
    reduced = [channel.resize((width, height), Image.Resampling.LANCZOS) for channel in channels]
    enlarged = [channel.resize(size, Image.Resampling.BICUBIC) for channel in reduced]
    pairs = zip(channels, enlarged, strict=True)
    difference = np.max([np.abs(np.asarray(before) - np.asarray(after)) for before, after in pairs], axis=0)
    return bool(np.median(difference) <= MEDIAN and np.quantile(difference, 0.95) <= MOST)


def needed_width(levels: np.ndarray) -> int:
    """Narrowest width in pixels from which a picture of height x width x 3 levels, 0 to 255, returns."""
    channels = [Image.fromarray(np.ascontiguousarray(levels[..., i])) for i in range(3)]
    width = levels.shape[1]
    low, high = 1, width
    while high - low > max(1, width // 200):
        middle = (low + high) // 2
        low, high = (low, middle) if returns(channels, middle) else (middle, high)
    return high


for path in sys.argv[1:]:
    levels = tifffile.imread(path)[..., :3].astype(np.float32) / 257
    needed, width = needed_width(levels), levels.shape[1]
    print(f"{path}: {width} px wide, {needed} px needed, {needed / width:.2f}", flush=True)
