"""Where frames come from: arrays, image files, folders of them, videos."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple, Optional, TypeVar, Union

import numpy as np
import numpy.typing as npt

from . import _tracecut
from ._errors import TraceCutError
from ._types import U8

if TYPE_CHECKING:
    from typing_extensions import TypeGuard

#: A frame: an array of uint8 of shape (height, width), (height, width, 3) or (height, width, 4), anything that NumPy
#: makes such an array of (images of Pillow), or the path or the bytes of a PNG or JPEG file.
FrameLike = Union[npt.NDArray[np.uint8], str, "os.PathLike[str]", bytes, Any]

#: A clip: frames one by one, an array of shape (frames, height, width[, channels]), or the path of a folder of images
#: or of a video file.
Frames = Union[npt.NDArray[np.uint8], str, "os.PathLike[str]", Iterable[FrameLike]]

_Path = TypeVar("_Path", str, Path)

_IMAGES = {".png", ".jpg", ".jpeg"}


class Source(NamedTuple):
    """Frames one by one, and how many, where that is known before."""

    frames: Iterator[Any]
    length: Optional[int]


def open_frames(source: Frames) -> Source:
    """The frames of ``source``, read one at a time."""
    if _is_path(source):
        return _of_path(Path(source))
    shape: Any = getattr(source, "shape", None)
    if shape is not None and len(shape) not in (3, 4):
        expected = "expected (frames, height, width) or (frames, height, width, channels)"
        raise TraceCutError("data", f"frames are an array of shape {'x'.join(map(str, shape))} ({expected})")
    frames: Any = source
    length = len(frames) if hasattr(frames, "__len__") else None
    return Source((as_array(frame) for frame in frames), length)


def _is_path(source: object) -> TypeGuard[Union[str, os.PathLike[str]]]:
    return isinstance(source, (str, os.PathLike))


def as_array(frame: FrameLike) -> Any:
    """A frame as an array: of what is an array already, the same; image files are decoded.

    What cannot be a frame is refused where it is used.
    """
    if _is_path(frame):
        return read_image(Path(frame))
    if isinstance(frame, (bytes, bytearray)):
        return _tracecut.decode(bytes(frame))
    picture: Any = frame
    if getattr(picture, "mode", "RGB") not in ("RGB", "RGBA", "L") and hasattr(picture, "convert"):
        picture = picture.convert("RGB")
    return np.asarray(picture)


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
        images = in_name_order(p for p in path.iterdir() if p.suffix.lower() in _IMAGES and p.is_file())
        if not images:
            raise TraceCutError("data", f"{path}: holds no images (expected PNG or JPEG files, one a frame)")
        return Source((read_image(image) for image in images), len(images))
    if not path.exists():
        raise FileNotFoundError(f"{path}: no such file or folder")
    return Source(read_video(path), None)


def in_name_order(paths: Iterable[_Path]) -> list[_Path]:
    """Paths in the order of their names, where runs of digits count as numbers: ``2.png`` before ``10.png``."""
    return sorted(paths, key=_name_key)


def _name_key(path: Union[str, os.PathLike[str]]) -> tuple[list[tuple[int, int, str]], str]:
    name = Path(path).name
    parts = re.findall(r"[0-9]+|[^0-9]+", name)
    key = [(0, len(p.lstrip("0")), p.lstrip("0")) if "0" <= p[0] <= "9" else (1, 0, p) for p in parts]
    return key, name


def read_video(path: Union[str, "os.PathLike[str]", BinaryIO]) -> Iterator[U8]:
    """The frames of a video file as RGB, one at a time, by PyAV.

    Parameters
    ----------
    path : path or file
        A file that FFmpeg reads, such as MP4, WebM or GIF; or an open one that can be read and sought in.

    Raises
    ------
    ImportError
        When PyAV is not installed (``pip install tracecut[video]``).
    TraceCutError
        ``no-video`` when there is no video in the file, ``codec`` when it cannot be decoded.
    """
    try:
        import av
        from av.error import FFmpegError
    except ImportError as error:
        raise ImportError("reading video files needs PyAV: pip install 'tracecut[video]'") from error
    file: Any = path
    name = os.fspath(path) if _is_path(path) else str(getattr(path, "name", "video"))
    try:
        with av.open(name if _is_path(path) else file) as container:
            if not container.streams.video:
                raise TraceCutError("no-video", f"{name}: there is no video in this file")
            stream = container.streams.video[0]
            stream.thread_type = "AUTO"
            for frame in container.decode(stream):
                yield np.asarray(frame.to_ndarray(format="rgb24"), np.uint8)
    except FFmpegError as error:
        raise TraceCutError("codec", f"{name}: cannot be decoded: {error}") from error
