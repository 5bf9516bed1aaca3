"""Whether files of a crate import each other in a circle: python3 .ci/circles.py

A module that imports its own parent, which composes it, is no circle.
"""

import pathlib
import re
import sys

PREFIX = r"(?:crate|super|self)"


def modules(root):
    """Files by module path."""
    found = {}
    for file in root.rglob("*.rs"):
        path = file.relative_to(root).with_suffix("").parts
        found[path[:-1] if path[-1] in ("mod", "lib", "main") else path] = re.sub(
            r"#\[cfg\(test\)\]\s*mod tests \{.*", "", re.sub(r"//.*", "", file.read_text()), flags=re.S
        )
    return found


def expanded(tree):
    """The paths of a use tree: a::{b, c::d} is a::b and a::c::d; names behind `as` stay behind "@"."""
    match = re.match(r"^(.*?)\{(.*)\}$", tree)
    if not match:
        return [tree]
    parts, depth, start = [], 0, 0
    body = match[2]
    for i, c in enumerate(body + ","):
        depth += (c == "{") - (c == "}")
        if c == "," and depth == 0:
            parts.append(body[start:i])
            start = i + 1
    return [path for part in parts if part for path in expanded(match[1] + part)]


def uses(text, visible):
    """The paths that a file imports, or those that it shows to others."""
    head = r"pub(?:\([^)]*\))? use " if visible else r"(?:pub(?:\([^)]*\))? )?use "
    for match in re.finditer(rf"(?:^|\n)\s*{head}([\w:]+[^;]*);", text):
        yield from expanded(re.sub(r"\s+", "", match[1].replace(" as ", "@")))


def resolved(path, own, found, shown, depth=0):
    """The module that a path from module `own` leads to."""
    words = path.split("@")[0].split("::")
    base = () if words[0] == "crate" else own
    while words and words[0] in ("crate", "super", "self"):
        base = base[:-1] if words[0] == "super" else base
        words = words[1:]
    while words and base + (words[0],) in found:
        base, words = base + (words[0],), words[1:]
    behind = shown.get((base, words[0])) if words else None
    return resolved(behind, base, found, shown, depth + 1) if behind and depth < 8 else base


def circles(root):
    found = modules(root)
    shown = {(own, path.split("@")[-1].split("::")[-1]): path for own, text in found.items() for path in uses(text, True)}
    edges = {}
    for own, text in found.items():
        inline = re.findall(rf"(?<![\w:]){PREFIX}(?:::\w+)+", text)
        there = {resolved(path, own, found, shown) for path in [*uses(text, False), *inline] if re.match(PREFIX, path)}
        family = lambda other: other[: len(own)] == own or own[: len(other)] == other
        edges[own] = {other for other in there if other in found and not family(other)}
    # What can be reached from each; a circle is what reaches itself.
    reach = {own: set(edges[own]) for own in edges}
    while True:
        more = {own: reach[own] | set().union(*(reach[other] for other in reach[own])) for own in reach}
        if more == reach:
            break
        reach = more
    return {frozenset(other for other in reach[own] if own in reach[other]) for own in reach if own in reach[own]}


def main():
    wrong = 0
    for root in sorted(pathlib.Path(__file__).parent.parent.glob("crates/*/src")):
        for circle in circles(root):
            names = sorted("::".join(path) for path in circle)
            print(f"{root.parent.name}: {', '.join(names)} import each other")
            wrong += 1
    sys.exit(wrong > 0)


main()
