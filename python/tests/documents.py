"""Reads the Python of the documents. As a program: runs each block of both READMEs, with only the package."""

from __future__ import annotations

import ast
import os
import re
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[2]
READMES = ["README.md", "python/README.md"]


class Block(NamedTuple):
    """A block of Python, and the document and the line where it begins."""

    document: str
    line: int
    code: str

    def run(self, names: dict[str, Any]) -> None:
        """Runs it in the present folder, after the blocks that left these names."""
        names.setdefault("__name__", "__main__")
        exec(compile("\n" * self.line + self.code, str(ROOT / self.document), "exec"), names)


def documents() -> list[str]:
    """Returns the READMEs, and the documents in `docs`."""
    return [*READMES, *sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / "docs").rglob("*.md"))]


def blocks(document: str) -> list[Block]:
    """Returns the blocks of Python of a document, in order."""
    text = (ROOT / document).read_text("utf-8")
    found = re.finditer(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return [Block(document, text[: match.start(1)].count("\n"), match[1]) for match in found]


def all_blocks() -> list[Block]:
    """Returns the blocks of all documents."""
    return [block for document in documents() for block in blocks(document)]


def imports(code: str) -> list[str]:
    """Returns the names of the modules that a block imports."""
    nodes = list(ast.walk(ast.parse(code)))
    names = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    return names + [node.module for node in nodes if isinstance(node, ast.ImportFrom) and node.module]


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        readme_blocks = [block for document in READMES for block in blocks(document)]
        for block in readme_blocks:
            block.run({})
        if len(list(Path("masks").glob("*.png"))) != 12:
            sys.exit("the README's first block wrote no masks")
        os.chdir(ROOT)
    print(f"{len(readme_blocks)} blocks of the READMEs ran", file=sys.stderr)
