"""The command `barnard`: `python -m barnard render --builtin pleiades -o nebula.png`."""

import os
import sys

from . import _barnard


def main() -> int:
    """Runs the command with the arguments of this process; its exit code."""
    if sys.platform == "linux" and "XDG_RUNTIME_DIR" not in os.environ:
        # Mesa's layer that sorts devices prints an error outside of a desktop session.
        os.environ["NODEVICE_SELECT"] = "1"
    return _barnard.run(["barnard", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
