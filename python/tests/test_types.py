"""The package and what users write pass the type checkers, and a wrong use does not."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

PYTHON = Path(__file__).resolve().parents[1]
WRONG = "import tracecut\nbad: int = tracecut.segment('clip')[0]\ntracecut.Session().labels('first')\n"


@pytest.mark.parametrize(
    ("tool", "options"),
    [
        ("mypy", []),
        # It takes the Python of PATH otherwise, which may not be this one. Its first run fetches it.
        pytest.param("pyright", ["--pythonpath", sys.executable], marks=pytest.mark.long),
    ],
)
def test_a_wrong_use_is_found_and_nothing_else(tool: str, options: list[str], tmp_path: Path) -> None:
    pytest.importorskip(tool)
    (tmp_path / "wrong.py").write_text(WRONG)
    files = ["package/tracecut", "tests/typed.py", str(tmp_path / "wrong.py")]
    command = [sys.executable, "-m", tool, *options, *files]
    checked = subprocess.run(command, cwd=PYTHON, capture_output=True, text=True)
    errors = [line for line in checked.stdout.splitlines() if re.search(r":\d+.*\berror\b", line)]
    places = sorted({tuple(re.findall(r"(\w+\.pyi?):(\d+)", line)[-1]) for line in errors})
    assert places == [("wrong.py", "2"), ("wrong.py", "3")], checked.stdout + checked.stderr
