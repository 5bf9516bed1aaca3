"""Checks that all builds of the workspace share one compilation of the core crates. Usage: python3 .ci/features.py

Cargo compiles a crate anew for each set of features of its dependencies. A larger build that turns on another feature of a small dependency
would therefore compile the core again, for minutes.
"""

import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).parent.parent
CORE = "barnard-files"
BUILDS = {
    "cargo test -F formats": ["-F", "formats"],
    "tests of all features": ["-p", "barnard-cli", "-p", "barnard-gpu", "-p", "barnard-study", "-p", "barnard-explorer", "-p", "barnard-viewer", "--all-features"],
    "the Python package": ["-p", "barnard-python"],
}


def packages(selection, kinds):
    """Packages of a build, each with its features."""
    tree = ["cargo", "tree", *selection, "-e", kinds, "--prefix", "none", "--no-dedupe", "--format", "{p}|{f}"]
    lines = subprocess.run(tree, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    return dict(line.removesuffix(" (*)").split("|") for line in lines if line)


def main():
    core = packages(["-p", CORE, "--all-features"], "normal,build")
    built = {name: packages(selection, "normal,build,dev") for name, selection in BUILDS.items()}
    wrong = []
    for package in sorted(core):
        features = {name: set(build[package].split(",")) - {""} for name, build in built.items()}
        union = set().union(*features.values())
        wrong += [f"{package} lacks {', '.join(sorted(union - own))} in {name}" for name, own in features.items() if own != union]
    if wrong:
        print("\n".join(wrong))
        print("add these features to crates/unified/Cargo.toml")
    else:
        print(f"{CORE} and its {len(core) - 1} dependencies have the same features in {len(BUILDS)} builds")
    sys.exit(bool(wrong))


main()
