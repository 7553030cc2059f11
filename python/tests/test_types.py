"""The package and what users write pass the type checkers, and a wrong use does not."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

PYTHON = Path(__file__).resolve().parents[1]
WRONG = "import tracecut\nbad: int = tracecut.segment('clip')[0]\ntracecut.Session().labels('first')\n"


def check(tool: str, *files: str) -> subprocess.CompletedProcess[str]:
    pytest.importorskip(tool)
    return subprocess.run([sys.executable, "-m", tool, *files], cwd=PYTHON, capture_output=True, text=True)


@pytest.mark.parametrize("tool", ["mypy", "pyright"])
def test_everything_is_typed(tool: str) -> None:
    checked = check(tool)
    assert checked.returncode == 0, checked.stdout + checked.stderr


@pytest.mark.parametrize("tool", ["mypy", "pyright"])
def test_a_wrong_use_is_found(tool: str, tmp_path: Path) -> None:
    (tmp_path / "wrong.py").write_text(WRONG)
    checked = check(tool, str(tmp_path / "wrong.py"))
    assert checked.returncode != 0 and "wrong.py:2" in checked.stdout and "wrong.py:3" in checked.stdout
