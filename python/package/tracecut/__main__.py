"""The program ``tracecut``, also ``python -m tracecut``: the command line in Rust (docs/cli.md)."""

from __future__ import annotations

import sys

from ._tracecut import run_program


def main() -> int:
    """Runs the program with the arguments of this process and returns its exit code."""
    return run_program(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
