"""Progress of long work: bars by tqdm where it is installed, lines otherwise, or whatever is asked for."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

#: Hears of progress as (stage, done, all).
Listener = Callable[[str, int, int], None]


@contextmanager
def listening(progress: bool | Listener | None) -> Iterator[Listener | None]:
    """Progress receiver of native work."""
    if not progress:
        yield None
    elif callable(progress):
        yield progress
    else:
        try:
            from tqdm.auto import tqdm
        except ImportError:
            with _lines() as lines:
                yield lines
            return
        bars: dict[str, tqdm] = {}

        def show(stage: str, done: int, whole: int) -> None:
            if stage not in bars:
                bars[stage] = tqdm(total=whole, desc=stage, leave=False)
            bar = bars[stage]
            bar.total = whole
            bar.update(max(done - bar.n, 0))

        try:
            yield show
        finally:
            for bar in bars.values():
                bar.close()


@contextmanager
def _lines() -> Iterator[Listener]:
    last = [""]

    def show(stage: str, done: int, whole: int) -> None:
        line = f"{stage}: {100 * done // max(whole, 1)} %"
        if line != last[0]:
            last[0] = line
            print(f"\r{line:30}", end="", file=sys.stderr, flush=True)

    try:
        yield show
    finally:
        if last[0]:
            print(f"\r{'':30}\r", end="", file=sys.stderr, flush=True)
