"""The command `barnard`: `python -m barnard render --builtin pleiades -o nebula.png`."""

import sys

from . import _barnard


def main() -> int:
    """Runs the command with the arguments of this process; its exit code."""
    return _barnard.run(["barnard", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
