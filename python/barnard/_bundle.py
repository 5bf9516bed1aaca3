"""Packed scenes, and pages with them."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from . import _barnard
from ._files import replace
from ._progress import Listener, listening
from ._rows import scene_error

#: Environment variable with the path of the explorer's page.
_PAGE = "BARNARD_PAGE"


def packed(bake: Callable[[int, Listener | None], bytes], limit: float, progress: bool | Listener | None) -> bytes:
    """Bytes of a bundle of at most `limit` MB, as `bake` makes it."""
    if not 0 < limit < 4000:
        raise scene_error("limit", f"{limit} is out of range; give a number of MB such as 4")
    with listening(progress) as listener:
        return bake(int(1e6 * limit), listener)


def page_path() -> Path | None:
    """The page of the explorer: that of the environment, or of the package; None where neither is there."""
    path = Path(os.environ.get(_PAGE) or Path(__file__).with_name("page.html"))
    return path if path.is_file() else None


def page_of(bundle: bytes) -> str:
    """The page of the explorer with a bundle."""
    path = page_path()
    if path is None:
        raise _barnard.BarnardError(
            f"this installation lacks the page of the explorer; install a released wheel, or make the page with .ci/web and set {_PAGE}"
        )
    return _barnard.html(path.read_text(encoding="utf-8"), bundle)


def written(html: str, path: str | os.PathLike | None) -> str:
    """The page, which is also written to a path if there is one."""
    if path is not None:
        target = Path(path)
        if target.suffix.lower() != ".html":
            raise scene_error("path", f"{target}: the name of a page must end with .html")
        replace(target, lambda out: out.write(html.encode()))
    return html
