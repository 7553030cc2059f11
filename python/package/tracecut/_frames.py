"""Reads frames from arrays, image files, folders of images, and videos."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Optional, TypeVar, Union, cast

import numpy as np
import numpy.typing as npt

from . import _tracecut
from ._errors import TraceCutError, file_errors, wrong_type
from ._types import U8
from ._video import VideoReader

if TYPE_CHECKING:
    from typing_extensions import TypeGuard

#: A frame: an array of uint8 of shape (height, width), (height, width, 3) or (height, width, 4), anything that NumPy
#: converts to such an array (Pillow images), or the path or the bytes of a PNG or JPEG file.
FrameLike = Union[npt.NDArray[np.uint8], str, "os.PathLike[str]", bytes, Any]

#: A clip: frames one by one (those of `read_video` bring their times), an array of shape (frames, height, width[,
#: channels]), the path of a folder of images or of a video file, or an open video file.
Frames = Union[npt.NDArray[np.uint8], str, "os.PathLike[str]", BinaryIO, Iterable[FrameLike]]

_CLIP = "the path of a folder of images or of a video, an array of shape (frames, height, width[, channels]), or frames"
_FRAME = "an array of uint8 of shape (height, width[, channels]), a Pillow image, or the path or bytes of an image file"

_Path = TypeVar("_Path", str, Path)

_IMAGES = {".png", ".jpg", ".jpeg"}


class Source:
    """Frames one by one, and their video if there is one.

    Attributes
    ----------
    num_read : int
        The number of frames read so far.
    length : int or None
        The number of frames that there are, if it is known in advance or all are read.
    damage : TraceCutError or None
        The reason why `read_whole` ended before the clip.
    """

    def __init__(self, frames: Iterator[Any], length: Optional[int] = None) -> None:
        self.frames = frames
        self.length = length
        self.num_read = 0
        self.video = frames if isinstance(frames, VideoReader) else None
        self.damage: Optional[TraceCutError] = None

    def read_whole(self) -> Iterator[Any]:
        """Yields the frames before any damage, which is stored instead of raised."""
        try:
            for frame in self.frames:
                self.num_read += 1
                yield frame
        except TraceCutError as error:
            if error.code != "truncated":
                raise
            self.damage = error
        self.length = self.num_read


def open_frames(source: Frames) -> Source:
    """Opens a clip; its frames are read one at a time."""
    if _is_path(source):
        return _open_path(Path(source))
    if isinstance(source, VideoReader):
        return Source(source)
    if hasattr(source, "read") and hasattr(source, "seek"):
        return Source(read_video(cast("BinaryIO", source)))
    shape: Any = getattr(source, "shape", None)
    if shape is not None and (len(shape) not in (3, 4) or _is_frame(shape)):
        expected = "expected (frames, height, width) or (frames, height, width, channels)"
        raise TraceCutError("data", f"frames are an array of shape {'x'.join(map(str, shape))} ({expected})")
    given: Any = source
    if not _is_iterable(given):
        raise wrong_type("frames", source, _CLIP, "data")
    length = len(given) if hasattr(given, "__len__") else None
    return Source((as_array(frame) for frame in given), length)


def _is_frame(shape: Sequence[int]) -> bool:
    """Returns True for the shape of one picture in colours."""
    return len(shape) == 3 and shape[2] in (3, 4)


def _is_iterable(source: object) -> bool:
    """Returns True unless frames cannot be read from it one by one; those of a mapping would be its keys."""
    has_items = hasattr(source, "__iter__") or hasattr(source, "__getitem__")
    return has_items and not isinstance(source, (bytes, bytearray, Mapping))


def _is_path(source: object) -> TypeGuard[Union[str, os.PathLike[str]]]:
    return isinstance(source, (str, os.PathLike))


def as_array(frame: FrameLike) -> Any:
    """Returns a frame as an array. Arrays stay the same, image files are decoded.

    Invalid frames are refused where they are used.
    """
    if _is_path(frame):
        return read_image(Path(frame))
    if isinstance(frame, (bytes, bytearray)):
        return _tracecut.decode(bytes(frame))
    picture: Any = frame
    if getattr(picture, "mode", "RGB") not in ("RGB", "RGBA", "L") and hasattr(picture, "convert"):
        picture = picture.convert("RGB")
    try:
        array = np.asarray(picture)
    except (TypeError, ValueError) as error:
        raise wrong_type("frame", frame, _FRAME, "data") from error
    if array.ndim == 0 or array.dtype == object:
        raise wrong_type("frame", frame, _FRAME, "data")
    return array


def read_image(path: Union[str, "os.PathLike[str]"]) -> U8:
    """Reads a PNG or JPEG file.

    Raises
    ------
    TraceCutError
        ``decode`` with the file's name; ``file`` if it cannot be read.
    """
    file = as_path("path", path)
    with file_errors():
        data = file.read_bytes()
    try:
        return _tracecut.decode(data)
    except TraceCutError as error:
        raise TraceCutError(error.code, f"{path}: {error}") from error


def as_path(name: str, path: Any) -> Path:
    """Returns the path of a file or folder."""
    if not _is_path(path):
        raise wrong_type(name, path, "a path")
    return Path(path)


def _open_path(path: Path) -> Source:
    with file_errors():
        if not path.is_dir():
            return Source(read_video(path))
        images = in_name_order(p for p in path.iterdir() if _is_frame_name(p.name) and p.is_file())
    if not images:
        raise TraceCutError("data", f"{path}: has no images (expected PNG or JPEG files, one per frame)")
    return Source((read_image(image) for image in images), len(images))


def _is_frame_name(name: str) -> bool:
    """Returns True for images that are not hidden: macOS adds hidden files with the same suffix."""
    return Path(name).suffix.lower() in _IMAGES and not name.startswith(".")


def in_name_order(paths: Iterable[_Path]) -> list[_Path]:
    """Sorts paths by name in natural order: digits by their value, letters ignoring case.

    ``2.png`` comes before ``10.png``, and ``img_3.png`` between ``IMG_2.png`` and ``IMG_4.png``.
    """
    given: Any = paths
    if _is_path(given) or not hasattr(given, "__iter__"):
        raise wrong_type("paths", given, "paths one by one")
    listed = list(paths)
    for path in listed:
        as_path("path", path)
    return sorted(listed, key=_name_key)


def _name_key(path: Union[str, os.PathLike[str]]) -> tuple[list[tuple[int, int, str]], str]:
    """Returns the sort key of a name; the exact name breaks ties. Same order as on the command line."""
    name = Path(path).name
    parts = re.findall(r"([0-9]+)|([^0-9])", name.lower())
    return [_digits_key(digits) if digits else (int(letter > "9") * 2, 0, letter) for digits, letter in parts], name


def _digits_key(digits: str) -> tuple[int, int, str]:
    """Returns the key of a number, which sorts where digits sort among characters."""
    value = digits.lstrip("0")
    return 1, len(value), value


def read_video(path: Union[str, "os.PathLike[str]", BinaryIO]) -> VideoReader:
    """Reads the frames of a video file one at a time, with PyAV.

    Each picture of the file comes once, in display order, as RGB: upright, with square pixels, all at the size of the
    first, in the file's colours, with the same pixels as on the command line and in Node. Of several video tracks the
    default one is read, or else the largest; cover images are skipped.

    Parameters
    ----------
    path : path or file
        A file that FFmpeg reads, such as MP4, WebM or GIF, whatever its name; or an open, seekable file.

    Returns
    -------
    VideoReader
        An iterator of arrays of shape (height, width, 3), with the ``times`` and ``durations`` of the frames read so
        far.

    Raises
    ------
    TraceCutError
        ``file``, also an `OSError`, if the file does not exist or cannot be opened; ``unsupported``, also an
        `ImportError`, if PyAV is not installed (``pip install tracecut[video]``).
        With the first frame, or later: ``no-video`` if the file is not a video or has no video track, ``codec`` if it
        cannot be decoded, ``unsupported`` if this PyAV cannot read its format; ``truncated``, after the whole frames,
        if it is truncated or damaged.
    """
    return VideoReader(path)
