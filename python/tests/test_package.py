"""The package as installed: licences, what docstrings show, and the notebook."""

from __future__ import annotations

import doctest
import importlib
import importlib.metadata
import pkgutil
import re
from pathlib import Path

import pytest
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
