"""The program ``raggio``: ``python -m raggio``."""

from __future__ import annotations

import sys

from . import _raggio


def main() -> int:
    """Runs the program with the arguments of the command line; returns its exit status."""
    return _raggio.main(["raggio", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
