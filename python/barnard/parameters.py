"""Parameters of a scene: every value that can be swept, animated or fitted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from . import _barnard


@dataclass(frozen=True)
class Parameter:
    """A value of a scene that can be changed; `Scene.parameters` lists all.

    Attributes
    ----------
    path : text
        Such as "star[0].temperature", for `Scene.sweep`, `Scene.explore`, `Scene.fit` and `Animation`.
    value : number, list of numbers, text or boolean
        Current value, in `unit`.
    unit : text
        Unit as scene files write it; empty for plain numbers and texts.
    low, high : number
        Allowed range in `unit`; infinite without a limit.
    type : text
        Type with its range or choices, such as "temperature between 1 K and 1000000000 K".
    summary : text
        Meaning in one line.
    is_default : boolean
        True if the scene does not state the value.
    """

    path: str
    value: bool | float | str | list[float] | list[str]
    unit: str
    low: float
    high: float
    type: str
    summary: str
    is_default: bool


def parameters_of(tree: dict[str, Any]) -> dict[str, Parameter]:
    """Parameters of a scene's tree by path."""
    return {row["path"]: Parameter(**row) for row in _barnard.parameters(tree)}
