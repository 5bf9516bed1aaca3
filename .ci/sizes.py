"""Limits that only shrink: crates of the minimal build and lines of a source file. Usage: python3 .ci/sizes.py"""

import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).parent.parent
# Crates that `cargo run --release` compiles, Barnard's own among them.
MOST_CRATES = 159
MOST_LINES = 450
# Longer files and their lines: split them, then lower or delete their row.
LONGER = {
    "crates/files/tests/inputs.rs": 710,  # one table of damaged inputs per reader
    "python/barnard/scene.py": 558,  # scene and its operations
    "python/barnard/tables.py": 3908,  # generated from the catalogues
    "python/tests/test_inputs.py": 525,  # one table of inputs per reader
    "python/tests/test_instrument.py": 472,  # instruments and exposures
}


def crates():
    """The number of crates in the minimal build, Barnard's own among them."""
    tree = ["cargo", "tree", "-e", "normal,build", "--prefix", "none", "--no-dedupe"]
    lines = subprocess.run(tree, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    return len({tuple(line.split()[:2]) for line in lines if line})


def main():
    wrong = []
    count = crates()
    print(f"{count} crates in the minimal build, at most {MOST_CRATES}")
    if count > MOST_CRATES:
        wrong.append(f"the minimal build has {count} crates; remove dependencies or make them optional")
    files = [path for folder in ("crates", "python") for pattern in ("*.rs", "*.py", "*.wgsl") for path in (ROOT / folder).rglob(pattern)]
    for path in sorted(files):
        name = path.relative_to(ROOT).as_posix()
        count = len(path.read_text(encoding="utf-8").splitlines())
        if count > LONGER.get(name, MOST_LINES):
            wrong.append(f"{name} has {count} lines, at most {LONGER.get(name, MOST_LINES)}; split it")
        elif count <= MOST_LINES and name in LONGER:
            wrong.append(f"{name} has {count} lines; delete its row in .ci/sizes.py")
    wrong += [f"{name} does not exist; delete its row in .ci/sizes.py" for name in LONGER if not (ROOT / name).exists()]
    print("\n".join(wrong) or f"no other source file has more than {MOST_LINES} lines")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
