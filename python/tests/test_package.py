"""What is installed with the package beside its code."""

from __future__ import annotations

import importlib.metadata
import re
import shutil
import subprocess

import pytest
from conftest import ROOT

LICENCES = "THIRD-PARTY-LICENSES.txt"


def installed(name: str) -> str:
    """A licence file as it was installed."""
    files = importlib.metadata.distribution("tracecut").files or []
    (path,) = (path for path in files if path.match(f"*.dist-info/licenses/{name}"))
    return path.locate().read_text("utf-8")


@pytest.mark.parametrize("name", ["LICENSE-APACHE", "LICENSE-MIT", LICENCES])
def test_the_licences_are_installed(name: str) -> None:
    folder = ROOT / "python" if name == LICENCES else ROOT
    assert installed(name) == (folder / name).read_text("utf-8")


def test_each_crate_has_its_licence_in_words() -> None:
    contents, *texts = re.split(r"^-{80}$", installed(LICENCES), flags=re.MULTILINE)
    parts = re.findall(r"^- (\S+ \S+), ", contents, re.MULTILINE)
    names = {part.split()[0] for part in parts}
    assert {"pyo3", "numpy", "faer", "spade", "rust-std"} <= names and len(parts) > 50
    titles = {title for text in texts for line in text.splitlines() for title in line.split(", ")}
    assert set(parts) <= titles


def test_the_licences_are_those_of_the_crates_in_the_lock_file() -> None:
    if not shutil.which("node"):
        pytest.skip("node, which runs scripts/licences.mjs, is not installed")
    command = ["node", "scripts/licences.mjs", "--print-wheel"]
    printed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    assert (ROOT / "python" / LICENCES).read_text("utf-8") == printed, "run node scripts/licences.mjs"
