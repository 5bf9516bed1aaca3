"""The cache of long computations."""

import numpy as np
import pytest

import barnard as bn


def turbulent() -> bn.Scene:
    scene = bn.Scene(bands="johnson", camera=bn.PerspectiveCamera("0 0 6 pc", "25 deg", size=8))
    scene.fields["cloud"] = bn.Turbulence(voxels=64)
    scene.dust = bn.Dust("cloud", "0.3 /pc", albedo=0.6)
    scene.stars.append(bn.Star("0.3 0.2 0.4 pc", temperature="12000 K", luminosity="1000 Lsun"))
    return scene


def test_a_second_session_reads_what_the_first_stored(monkeypatch, tmp_path):
    alone = np.asarray(turbulent().render())
    monkeypatch.setenv("BARNARD_CACHE", str(tmp_path))
    assert bn.cache.usage() == bn.cache.Usage(tmp_path, 4 << 30, {})
    first = np.asarray(turbulent().render())
    usage = bn.cache.usage()
    assert usage.kinds["fields"][0] > 0 and usage.size > 100_000
    stored = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    second = np.asarray(turbulent().render())
    assert bn.cache.usage() == usage
    # Reading marks a record as used.
    assert any(path.stat().st_mtime_ns > time for path, time in stored.items())
    assert np.array_equal(first, alone) and np.array_equal(second, alone)
    bn.cache.clear()
    assert bn.cache.usage().size == 0


def test_settings_of_the_cache(monkeypatch):
    monkeypatch.setenv("BARNARD_CACHE", "off")
    assert bn.cache.usage() is None
    monkeypatch.delenv("BARNARD_CACHE")
    monkeypatch.setenv("BARNARD_CACHE_SIZE", "many")
    with pytest.raises(bn.SceneError, match="BARNARD_CACHE_SIZE=many is no size; give a positive number of GiB"):
        bn.cache.usage()
