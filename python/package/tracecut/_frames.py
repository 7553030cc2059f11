"""Where frames come from: arrays, image files, folders of them, videos."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _tracecut
from ._errors import TraceCutError
from ._types import U8

#: A frame: an array of uint8 of shape (height, width), (height, width, 3) or (height, width, 4), anything that NumPy
#: makes such an array of (images of Pillow), or the path or the bytes of a PNG or JPEG file.
FrameLike = Union[npt.NDArray[np.uint8], str, "os.PathLike[str]", bytes, Any]

#: A clip: frames one by one, an array of shape (frames, height, width[, channels]), or the path of a folder of images
#: or of a video file.
Frames = Union[npt.NDArray[np.uint8], str, "os.PathLike[str]", Iterable[FrameLike]]

_IMAGES = {".png", ".jpg", ".jpeg"}


class Source(NamedTuple):
    """Frames one by one, and how many, where that is known before."""

    frames: Iterator[Any]
    length: Optional[int]


def open_frames(source: Frames) -> Source:
    """The frames of ``source``, read one at a time."""
    if isinstance(source, (str, os.PathLike)):
        return _of_path(Path(source))
    if isinstance(source, np.ndarray) and source.ndim not in (3, 4):
        shape = "x".join(map(str, source.shape))
        expected = "expected (frames, height, width) or (frames, height, width, channels)"
        raise TraceCutError("data", f"frames are an array of shape {shape} ({expected})")
    length = len(source) if hasattr(source, "__len__") else None  # type: ignore[arg-type]
    return Source((as_frame(frame) for frame in source), length)


def as_frame(frame: FrameLike) -> Any:
    """A frame as an array; what cannot be one is refused where it is looked at."""
    if isinstance(frame, np.ndarray):
        return frame  # pyright: ignore[reportUnknownVariableType]
    if isinstance(frame, (str, os.PathLike)):
        return read_image(Path(frame))
    if isinstance(frame, (bytes, bytearray)):
        return _tracecut.decode(bytes(frame))
    if getattr(frame, "mode", "RGB") not in ("RGB", "RGBA", "L") and hasattr(frame, "convert"):
        frame = frame.convert("RGB")
    return np.asarray(frame)


def read_image(path: Path) -> U8:
    """Reads a PNG or JPEG file.

    Raises
    ------
    TraceCutError
        ``decode`` with the file's name.
    """
    try:
        return _tracecut.decode(path.read_bytes())
    except TraceCutError as error:
        raise TraceCutError(error.code, f"{path}: {error}") from error


def _of_path(path: Path) -> Source:
    if path.is_dir():
        images = sorted((p for p in path.iterdir() if p.suffix.lower() in _IMAGES and p.is_file()), key=_name_key)
        if not images:
            raise TraceCutError("data", f"{path}: holds no images (expected PNG or JPEG files, one a frame)")
        return Source((read_image(image) for image in images), len(images))
    if not path.exists():
        raise FileNotFoundError(f"{path}: no such file or folder")
    return Source(read_video(path), None)


def _name_key(path: Path) -> tuple[list[tuple[int, int, str]], str]:
    """Runs of digits count as numbers, so that ``2.png`` comes before ``10.png``."""
    parts = re.findall(r"[0-9]+|[^0-9]+", path.name)
    key = [(0, len(p.lstrip("0")), p.lstrip("0")) if "0" <= p[0] <= "9" else (1, 0, p) for p in parts]
    return key, path.name


def read_video(path: Union[str, "os.PathLike[str]"]) -> Iterator[U8]:
    """The frames of a video file as RGB, one at a time, by PyAV.

    Parameters
    ----------
    path : path
        A file that FFmpeg reads, such as MP4, WebM or GIF.

    Raises
    ------
    ImportError
        When PyAV is not installed (``pip install tracecut[video]``).
    TraceCutError
        ``no-video`` when there is no video in the file, ``codec`` when it cannot be decoded.
    """
    try:
        import av
    except ImportError as error:
        raise ImportError("reading video files needs PyAV: pip install 'tracecut[video]'") from error
    try:
        with av.open(os.fspath(path)) as container:
            if not container.streams.video:
                raise TraceCutError("no-video", f"{os.fspath(path)}: there is no video in this file")
            stream = container.streams.video[0]
            stream.thread_type = "AUTO"
            for frame in container.decode(stream):
                yield frame.to_ndarray(format="rgb24")
    except av.FFmpegError as error:
        raise TraceCutError("codec", f"{os.fspath(path)}: cannot be decoded: {error}") from error
