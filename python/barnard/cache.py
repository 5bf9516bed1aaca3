"""Cache of long computations: solved gas, sampled fields, multiple scattering and settings of films.

A later run with the same inputs reads them instead of computing them again, with the same bits; another version of Barnard
computes them anew. All processes of a user share the cache.

Two environment variables control it: `BARNARD_CACHE` is its folder (default: that of the platform) or `off`, and
`BARNARD_CACHE_SIZE` its limit in GiB (default 4). Records used least recently are removed beyond the limit.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from . import _barnard

__all__ = ["Usage", "clear", "usage"]


@dataclass(frozen=True)
class Usage:
    """Folder, limit and records of the cache."""

    #: Folder of the records.
    folder: Path
    #: Limit of their size [bytes].
    limit: int
    #: By kind of computation, the number of records and their size [bytes].
    kinds: dict[str, tuple[int, int]]

    @property
    def size(self) -> int:
        """Size of all records [bytes]."""
        return sum(size for _, size in self.kinds.values())


def usage() -> Usage | None:
    """Usage of the cache; None without a cache."""
    facts = _barnard.cache_facts()
    if facts is None:
        return None
    folder, limit, kinds = facts
    return Usage(Path(folder), limit, {kind: (records, size) for kind, records, size in kinds})


def clear() -> None:
    """Removes all records.

    Raises
    ------
    BarnardError
        If a file cannot be removed.
    """
    _barnard.clear_cache()
