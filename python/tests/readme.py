"""Runs the Python of both READMEs as it stands there, each piece by itself; needs nothing but the package."""

from __future__ import annotations

import os
import re
import sys
import tempfile
from pathlib import Path

README = Path(__file__).resolve().parents[1] / "README.md"
#: The README of the whole repository.
ROOT = README.parents[1] / "README.md"


def pieces() -> list[str]:
    """The pieces of Python in the package's README, then those of the repository's."""
    text = README.read_text("utf-8") + ROOT.read_text("utf-8")
    return re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def run(piece: str) -> None:
    """Runs one of them in the present folder."""
    exec(compile(piece, "README.md", "exec"), {"__name__": "__main__"})


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for code in pieces():
            run(code)
        if len(list(Path("masks").glob("*.png"))) != 12:
            sys.exit("the README's first piece wrote no masks")
        os.chdir(README.parent)
    print(f"{len(pieces())} pieces of the READMEs ran", file=sys.stderr)
