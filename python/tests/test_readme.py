"""What the READMEs show runs as it stands there."""

from __future__ import annotations

import doctest
import importlib
import pkgutil
from pathlib import Path

import pytest
import readme
import tracecut

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
