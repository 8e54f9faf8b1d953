"""The program ``raggio``: ``python -m raggio``."""

from __future__ import annotations

import os
import signal
import sys

from . import _raggio


def main() -> int:
    """Runs the program with the arguments of the command line; returns its exit status."""
    # The program takes Ctrl-C itself, and Python would raise KeyboardInterrupt for it once more at the end.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    # `raggio render --cluster` runs a Python that has this module.
    os.environ.setdefault("RAGGIO_PYTHON", sys.executable)
    return _raggio.main(["raggio", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
