"""Writes docs/python-reference.md anew from the docstrings: python python/write_reference.py"""

from __future__ import annotations

import inspect
from pathlib import Path

import barnard as bn

HEAD = """# Reference of the Python package

Everything public of `import barnard as bn`, from its docstrings (`python python/write_reference.py` writes this page). [python.md](python.md)
is where to begin, [scene-format.md](scene-format.md) has the same keys with all catalogues.
"""

#: Headlines and what stands under them, in the order in which they are met.
CHAPTERS = {
    "Scenes": ["Scene", "Plan", "Certificate", "Image", "Plates", "Exposures", "FitModel", "Fit", "FrameSequence"],
    "Fields": [name for name in bn.tables.__all__ if isinstance(getattr(bn, name), type) and issubclass(getattr(bn, name), bn.tables.Field)],
    "Tables": [],
    "Many pictures": ["map", "tiles", "Result"],
    "Volumes that no machine holds": ["render_bricks"],
    "Catalogues and threads": ["catalogues", "catalogue", "set_threads"],
    "Errors and warnings": ["AccuracyWarning", "BarnardError", "SceneError", "PlanError", "MemoryLimitError", "DeviceError"],
}
CHAPTERS["Tables"] = [name for name in bn.tables.__all__ if name not in CHAPTERS["Fields"]]


def described(name: str, thing: object, level: str) -> str:
    """A headline and the words of one thing."""
    words = inspect.getdoc(thing) or ""
    signature = ""
    if callable(thing) and not (isinstance(thing, type) and issubclass(thing, BaseException)):
        keys = [str(p).split(":")[0].split("=")[0].strip() for p in inspect.signature(thing).parameters.values() if p.name != "self"]
        signature = f"({', '.join(keys)})"
    return f"{level} `{name}{signature}`\n\n```text\n{words}\n```\n"


def members(cls: type) -> list[str]:
    """Methods and properties of a class that are for everyone."""
    return [
        name
        for name, member in vars(cls).items()
        if not name.startswith("_") and (inspect.isfunction(member) or isinstance(member, (property, classmethod))) and inspect.getdoc(member)
    ]


def text() -> str:
    """The text of the page."""
    parts = [HEAD]
    for chapter, names in CHAPTERS.items():
        parts.append(f"## {chapter}\n")
        for name in names:
            thing = getattr(bn, name)
            parts.append(described(name, thing, "###"))
            if isinstance(thing, type) and name in ("Scene", "Plan", "Image", "Exposures", "FrameSequence"):
                for member in members(thing):
                    own = inspect.getattr_static(thing, member)
                    own = own.fget if isinstance(own, property) else getattr(thing, member)
                    shown = described(f"{name}.{member}", own, "####")
                    parts.append(shown.replace("(self)`", "`").replace("()`", "`") if isinstance(vars(thing)[member], property) else shown)
    return "\n".join(parts)


if __name__ == "__main__":
    Path(__file__).parents[1].joinpath("docs", "python-reference.md").write_text(text(), encoding="utf-8")
