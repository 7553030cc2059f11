"""Writes output completely or not at all: into a temporary path, then renamed."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Union

from .._errors import file_errors, illegal
from .._frames import as_path

PathLike = Union[str, "os.PathLike[str]"]

#: Number of coloured labels in the DAVIS palette: VOC colours with 191 instead of 192; the other labels are grey.
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
def new_folder(path: PathLike, parameter: str = "path") -> Generator[Path, None, None]:
    """Yields a temporary folder, which is renamed to the path on success and removed on failure.

    Raises
    ------
    TraceCutError
        ``param`` if the path exists.
    """
    out = as_path(parameter, path)
    if os.path.lexists(out):
        raise illegal(parameter, str(out), "a path where nothing is yet")
    with file_errors():
        created = _create_folders(out.parent)
    part = out.with_name(f".{out.name}.{os.getpid()}.part")
    try:
        with file_errors():
            part.mkdir()
        created.append(part)
        yield part
        with file_errors():
            part.rename(out)
    except BaseException:
        if part in created:
            shutil.rmtree(part, ignore_errors=True)
        for folder in reversed(created):
            with suppress(OSError):
                folder.rmdir()
        raise


@contextmanager
def removed_on_failure(folder: Path) -> Generator[None, None, None]:
    """Removes a folder if the block fails."""
    try:
        yield
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


def _create_folders(folder: Path) -> list[Path]:
    """Creates a folder and its missing parents; returns the created ones, the topmost first."""
    missing = [each for each in reversed([folder, *folder.parents]) if not each.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    return missing


def append_text(path: Path, text: str) -> None:
    """Adds a text to a file, creating it if needed."""
    with file_errors(), path.open("a", encoding="utf-8") as file:
        file.write(text)


def read_text(path: Path) -> str:
    """Reads a file; an empty text if there is none."""
    with file_errors():
        return path.read_bytes().decode("utf-8", "replace") if path.exists() else ""


def replace_text(path: Path, text: str) -> None:
    """Replaces a file atomically: readers see the old or the new text."""
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with file_errors():
            path.parent.mkdir(parents=True, exist_ok=True)
            part.write_text(text, encoding="utf-8")
            part.replace(path)
    except BaseException:
        with suppress(OSError):
            part.unlink()
        raise
