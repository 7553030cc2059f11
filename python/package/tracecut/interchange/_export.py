"""Common parts of the exports: masks with the names of their frames and objects; files written completely or not at all."""

from __future__ import annotations

import itertools
import json
import os
import shutil
from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple, Optional, Protocol, Union, cast

import numpy as np

from .._errors import TraceCutError, file_errors, illegal
from .._frames import as_path
from .._types import U8, Bool

PathLike = Union[str, "os.PathLike[str]"]


class HasLabels(Protocol):
    """Protocol of `tracecut.Session` and its views."""

    @property
    def num_frames(self) -> int:
        """Number of masks."""
        ...

    def labels(self, t: int) -> U8:
        """The mask of frame ``t``."""
        ...


#: Arrays of uint8 of shape (height, width), all of one size, as a `tracecut.Result` gives them; or a session.
Masks = Union[Iterable[U8], HasLabels]


class Frame(NamedTuple):
    """A mask, the number of its frame from 0, the name of its frame, and its time in seconds if it has one."""

    t: int
    name: str
    mask: U8
    time: Optional[float]

    def objects(self) -> list[int]:
        """The labels in the mask, without the background's 0."""
        labels = np.flatnonzero(np.bincount(self.mask.ravel(), minlength=256))
        return [int(label) for label in labels if label > 0]


class Box(NamedTuple):
    """The smallest rectangle around an object, in whole pixels."""

    left: int
    top: int
    width: int
    height: int


def box_of(inside: Bool) -> Box:
    """Returns the bounding box of a mask that is not empty."""
    rows, columns = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
    left, top = int(columns[0]), int(rows[0])
    return Box(left, top, int(columns[-1]) + 1 - left, int(rows[-1]) + 1 - top)


def frames_of(masks: Masks, names: Optional[Iterable[str]]) -> Iterator[Frame]:
    """Yields each mask with the name of its frame.

    Raises
    ------
    TraceCutError
        ``data`` if there is no mask, one is invalid or has another size, or the numbers of names and masks differ.
    """
    missing: Any = object()
    times: Any = getattr(masks, "times", None)
    numbered: Iterator[str] = (f"{t:05}.jpg" for t in itertools.count())
    given_names = numbered if names is None else iter(names)
    first: Optional[U8] = None
    seen: set[str] = set()
    for t, mask in enumerate(_each(masks)):
        name = next(given_names, missing)
        if name is missing:
            raise TraceCutError("data", f"frames has {t} names (expected one for each mask)")
        first = _check_size(t, _check_mask(t, mask), first)
        yield Frame(t, _check_frame_name(t, name, seen), mask, None if times is None else float(times[t]))
    if first is None:
        raise TraceCutError("data", "masks has 0 frames (expected at least 1)")
    if names is not None and next(given_names, missing) is not missing:
        raise TraceCutError("data", f"frames has more than {len(seen)} names (expected one for each mask)")


def _each(masks: Any) -> Iterator[Any]:
    """Iterates over iterables, and over sessions and their views by frame number."""
    if hasattr(masks, "num_frames") and callable(getattr(masks, "labels", None)):
        return (masks.labels(t) for t in range(masks.num_frames))
    try:
        return iter(masks)
    except TypeError as error:
        expected = "expected a result, or arrays one by one"
        raise TraceCutError("data", f"masks is a {type(masks).__name__} ({expected})") from error


def _check_mask(t: int, mask: Any) -> U8:
    expected = "expected an array of uint8 of shape (height, width)"
    if not isinstance(mask, np.ndarray):
        raise TraceCutError("data", f"mask of frame {t} is a {type(mask).__name__} ({expected})")
    array = cast("U8", mask)
    if array.dtype != np.uint8 or array.ndim != 2 or array.size == 0:
        raise TraceCutError("data", f"mask of frame {t} is {array.dtype} of shape {array.shape} ({expected})")
    return array


def _check_size(t: int, mask: U8, first: Optional[U8]) -> U8:
    """Returns the first mask; all masks must have its size."""
    if first is None:
        return mask
    if mask.shape != first.shape:
        raise TraceCutError("data", f"mask of frame {t} has shape {mask.shape} (expected {first.shape} as of frame 0)")
    return first


def _check_frame_name(t: int, name: Any, seen: set[str]) -> str:
    if not _is_text(name) or name in seen:
        raise TraceCutError("data", f"name of frame {t} is {name!r} (expected a text that no other frame has)")
    seen.add(name)
    return str(name)


def _is_text(value: Any) -> bool:
    """Returns True for visible text: no control characters and no lone surrogates."""
    return isinstance(value, str) and value.strip() != "" and value.isprintable()


def check_folder_name(parameter: str, name: Any) -> str:
    """Returns a text that is valid as one folder or file name.

    Raises
    ------
    TraceCutError
        ``param`` if it is not.
    """
    if not _is_text(name) or name.startswith(".") or any(letter in name for letter in '/\\:*?"<>|'):
        raise illegal(parameter, name, 'a name of a folder, without / \\ : * ? " < > | and not beginning with a dot')
    return str(name)


def check_text(parameter: str, value: Any) -> str:
    """Returns a text if it is one line and not empty."""
    if not _is_text(value):
        raise illegal(parameter, value, "a text of one line that is not empty")
    return str(value)


_NAMED = "labels of 1 to 255, each with a name"


class Classes:
    """The class name of each object, and a number for each class in order of first use."""

    def __init__(self, objects: Optional[Mapping[int, str]]) -> None:
        given: Any = {} if objects is None else objects
        if not isinstance(given, Mapping):
            raise illegal("objects", given, _NAMED)
        self._names: dict[int, str] = dict(cast("Mapping[int, str]", given))
        self.numbers: dict[str, int] = {}
        for label, name in self._names.items():
            if not isinstance(cast("Any", label), (int, np.integer)) or not 1 <= label <= 255:
                raise illegal("objects", label, _NAMED)
            check_text(f"objects[{label}]", name)

    def name(self, label: int) -> str:
        """The class of a label; ``object 3`` for an unnamed one."""
        name = self._names.get(label, f"object {label}")
        self.numbers.setdefault(name, len(self.numbers) + 1)
        return name

    def number(self, label: int) -> int:
        """The number of the class of a label, from 1."""
        return self.numbers[self.name(label)]


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
