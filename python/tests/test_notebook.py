"""The notebook runs from its first cell to its last, and finds the objects."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

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
