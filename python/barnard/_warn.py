"""Warnings at the line of the user."""

from __future__ import annotations

import sys
import warnings


def warn(words: str, category: type[Warning] = UserWarning) -> None:
    """Warns at the first line outside of the package, however deep the call."""
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and frame.f_globals.get("__name__", "").split(".")[0] == __package__:
        frame, level = frame.f_back, level + 1
    warnings.warn(words, category, stacklevel=level)
