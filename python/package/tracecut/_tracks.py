"""Trajectories as ``tracks.dat``, the file format of the Moseg benchmark."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Any, Optional, Union

import numpy as np

from . import _tracecut
from ._errors import TraceCutError, file_errors, whole, wrong_type
from ._frames import as_path
from ._types import U32, Trajectories

_MAX_SIDE = 1 << 24


def read_tracks(path: Union[str, "os.PathLike[str]"], size: tuple[int, int]) -> tuple[Trajectories, U32]:
    """Reads a track file.

    Parameters
    ----------
    path : path
    size : (width, height)
        Size of the frames in pixels, which the file lacks.

    Returns
    -------
    Trajectories
    array of uint32
        The label of each trajectory.

    Raises
    ------
    TraceCutError
        ``data``, naming the line; ``file`` if the file cannot be read.
    """
    file, (width, height) = as_path("path", path), size_of(size)
    with file_errors():
        data = file.read_bytes()
    try:
        fields, label = _tracecut.read_tracks(data.decode("utf-8"))
    except (TraceCutError, UnicodeDecodeError) as error:
        raise TraceCutError("data", f"{file}: {error}") from error
    return replace(Trajectories(**fields), width=width, height=height), label


def size_of(size: Any) -> tuple[int, int]:
    """Returns a width and a height."""
    try:
        width, height = size
    except (TypeError, ValueError):
        raise wrong_type("size", size, "width and height") from None
    return whole("width", width, 1, _MAX_SIDE), whole("height", height, 1, _MAX_SIDE)


def check_trajectories(trajectories: Any) -> Trajectories:
    """Returns trajectories whose columns are arrays of the documented types.

    Raises
    ------
    TraceCutError
        ``data`` if they are not.
    """
    if not isinstance(trajectories, Trajectories):
        raise wrong_type("trajectories", trajectories, "Trajectories", "data")
    t = trajectories
    start_frame, offset = _column("start_frame", t.start_frame, np.uint32), _column("offset", t.offset, np.uint32)
    x, y = _column("x", t.x, np.float32), _column("y", t.y, np.float32)
    num_frames = whole("num_frames", t.num_frames, 0, 2**32 - 1)
    width, height = whole("width", t.width, 0, _MAX_SIDE), whole("height", t.height, 0, _MAX_SIDE)
    return Trajectories(num_frames, width, height, start_frame, offset, x, y)


def _column(name: str, values: Any, kind: Any) -> Any:
    """Returns a column as a list of numbers of this type; whole numbers must fit."""
    expected = f"a list of {np.dtype(kind).name}"
    try:
        given: Any = np.asarray(values)
        if given.ndim != 1 or (given.size > 0 and given.dtype.kind not in ("iu" if kind is np.uint32 else "iuf")):
            raise wrong_type(name, values, expected, "data")
        column = np.ascontiguousarray(given, kind)
    except (TypeError, ValueError, OverflowError):
        raise wrong_type(name, values, expected, "data") from None
    if kind is np.uint32 and not np.array_equal(column, given):
        raise wrong_type(name, values, expected, "data")
    return column


def write_tracks(path: Union[str, "os.PathLike[str]"], trajectories: Trajectories, label: Optional[U32] = None) -> None:
    """Writes a track file.

    Parameters
    ----------
    path : path
    trajectories : Trajectories
    label : array of uint32, optional
        The label of each trajectory, without gaps; 0 by default.

    Raises
    ------
    TraceCutError
        ``data`` if they are not as `Trajectories` describes; ``file`` if the file cannot be written.
    """
    file, t = as_path("path", path), check_trajectories(trajectories)
    labels = np.zeros(len(t), np.uint32) if label is None else _column("label", label, np.uint32)
    columns = (t.start_frame.tolist(), t.offset.tolist(), t.x.tolist(), t.y.tolist(), labels.tolist())
    text = _tracecut.write_tracks(t.num_frames, *columns)
    with file_errors():
        file.write_text(text, "utf-8")
