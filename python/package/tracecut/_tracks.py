"""Trajectories as ``tracks.dat``, the file format of the Moseg benchmark."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Optional, Union

import numpy as np

from . import _tracecut
from ._errors import TraceCutError
from ._types import U32, Trajectories


def read_tracks(
    path: Union[str, "os.PathLike[str]"], size: tuple[int, int]
) -> tuple[Trajectories, U32]:
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
        ``data``, naming the line.
    """
    try:
        fields, label = _tracecut.read_tracks(Path(path).read_text("utf-8"))
    except (TraceCutError, UnicodeDecodeError) as error:
        raise TraceCutError("data", f"{os.fspath(path)}: {error}") from error
    return replace(Trajectories(**fields), width=size[0], height=size[1]), label


def write_tracks(
    path: Union[str, "os.PathLike[str]"], trajectories: Trajectories, label: Optional[U32] = None
) -> None:
    """Writes a track file.

    Parameters
    ----------
    path : path
    trajectories : Trajectories
    label : array of uint32, optional
        The label of each trajectory, without gaps; 0 by default.
    """
    t = trajectories
    labels = np.zeros(len(t), np.uint32) if label is None else np.asarray(label, np.uint32)
    columns = (t.start_frame.tolist(), t.offset.tolist(), t.x.tolist(), t.y.tolist(), labels.tolist())
    Path(path).write_text(_tracecut.write_tracks(t.num_frames, *columns), "utf-8")
