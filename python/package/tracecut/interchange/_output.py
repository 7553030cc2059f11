"""Output that is there as a whole or not at all: written beside its place, then renamed."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Union

from .._errors import illegal

PathLike = Union[str, "os.PathLike[str]"]

#: The colours of the DAVIS benchmark: those of VOC with 191 in the place of 192 for the first 22, then greys.
_COLOURED = 22


def davis_palette() -> list[int]:
    """Red, green and blue of each label, 0 to 255."""
    colours: list[int] = []
    for label in range(256):
        for channel in range(3):
            high, low = label >> channel & 1, label >> channel + 3 & 1
            colours.append(label if label >= _COLOURED else min(128 * high + 64 * low, 191))
    return colours


PALETTE = davis_palette()


def json_line(value: Any) -> str:
    """A value as JSON, without spaces."""
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False)


@contextmanager
def new_folder(path: PathLike, parameter: str = "path", overwrite: bool = False) -> Generator[Path, None, None]:
    """A folder to write into, which takes its place when all went well, and is gone when not.

    Raises
    ------
    TraceCutError
        ``param`` when something is at the path, unless that is to be replaced.
    """
    out = Path(path)
    if os.path.lexists(out) and not overwrite:
        raise illegal(parameter, str(out), "a path where nothing is yet")
    made = _make(out.parent)
    part = out.with_name(f".{out.name}.{os.getpid()}.part")
    try:
        part.mkdir()
        made.append(part)
        yield part
        _put_in_place(part, out)
    except BaseException:
        if part in made:
            shutil.rmtree(part, ignore_errors=True)
        for folder in reversed(made):
            with suppress(OSError):
                folder.rmdir()
        raise


def _put_in_place(part: Path, out: Path) -> None:
    old = out.with_name(f".{out.name}.{os.getpid()}.old")
    with suppress(FileNotFoundError):
        out.rename(old)
    part.rename(out)
    shutil.rmtree(old, ignore_errors=True)


@contextmanager
def undone(folder: Path) -> Generator[None, None, None]:
    """Takes a folder away if what is done with it fails."""
    try:
        yield
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


def _make(folder: Path) -> list[Path]:
    """Makes a folder and those above it; gives those that were not there, the highest first."""
    above = [folder, *folder.parents]
    made = [each for each in reversed(above) if not each.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    return made


def replace_text(path: Path, text: str) -> None:
    """Writes a file that readers see as it was or as it is to be, never in between."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        part.write_text(text, encoding="utf-8")
        part.replace(path)
    except BaseException:
        with suppress(OSError):
            part.unlink()
        raise
