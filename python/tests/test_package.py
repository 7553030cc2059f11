"""The package as installed: licences, types, what READMEs and docstrings show, and the notebook."""

from __future__ import annotations

import doctest
import importlib
import importlib.metadata
import pkgutil
import re
import subprocess
import sys
from pathlib import Path

import pytest
import readme
import tracecut
from conftest import ROOT


def installed(name: str) -> str:
    """A licence file as it was installed."""
    files = importlib.metadata.distribution("tracecut").files or []
    (path,) = (path for path in files if path.match(f"*.dist-info/licenses/{name}"))
    return path.locate().read_text("utf-8")


@pytest.mark.parametrize("name", ["LICENSE-APACHE", "LICENSE-MIT"])
def test_the_licences_are_installed(name: str) -> None:
    assert installed(name) == (ROOT / name).read_text("utf-8")


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


PIECES = readme.pieces()


def test_the_readmes_have_their_pieces() -> None:
    assert len(PIECES) == 5 and all("import tracecut" in piece for piece in PIECES)
    assert 8 <= len([line for line in PIECES[0].splitlines() if line.strip()]) <= 10


@pytest.mark.parametrize("number", range(len(PIECES)))
def test_a_piece_of_the_readme_runs(number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    readme.run(PIECES[number])
    assert capsys.readouterr().out.strip()
    if number in (0, 4):
        assert len(list((tmp_path / "masks").glob("*.png"))) == 12


def modules() -> list[str]:
    names = [m.name for m in pkgutil.iter_modules(tracecut.__path__) if m.name != "_tracecut"]
    return ["tracecut", *(f"tracecut.{name}" for name in names)]


def test_the_examples_in_docstrings_are_true() -> None:
    tried = 0
    for name in modules():
        failed, count = doctest.testmod(importlib.import_module(name))
        assert failed == 0, name
        tried += count
    assert tried > 10


def test_everything_public_is_documented() -> None:
    for name in tracecut.__all__:
        thing = getattr(tracecut, name)
        if not callable(thing) or isinstance(thing, str) or name in ("FrameLike", "Frames"):
            continue
        assert thing.__doc__, name
        for method, value in vars(thing).items() if isinstance(thing, type) else ():
            assert method.startswith("_") or not callable(value) or value.__doc__, f"{name}.{method}"


NOTEBOOK = Path(__file__).resolve().parents[1] / "examples" / "stages.ipynb"


@pytest.mark.wheel
def test_the_notebook_shows_every_stage() -> None:
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "outputs are not kept in the repository"
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    pictures = [o for o in outputs if "image/png" in o.get("data", {})]
    assert len(pictures) >= 8
    text = "".join(o.get("text", "") for o in outputs)
    overlap = re.search(r"union of the foreground: ([0-9.]+)", text)
    assert overlap and float(overlap[1]) > 0.7, text
