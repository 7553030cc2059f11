"""What is installed with the package beside its code."""

from __future__ import annotations

import importlib.metadata

import pytest
from conftest import ROOT


def installed(name: str) -> str:
    """A licence file as it was installed."""
    files = importlib.metadata.distribution("tracecut").files or []
    (path,) = (path for path in files if path.match(f"*.dist-info/licenses/{name}"))
    return path.locate().read_text("utf-8")


@pytest.mark.parametrize("name", ["LICENSE-APACHE", "LICENSE-MIT"])
def test_the_licences_are_installed(name: str) -> None:
    assert installed(name) == (ROOT / name).read_text("utf-8")
