"""Reads videos with PyAV by the rules of ``docs/frames.md``: each picture of the file once, in display order, with the
file's own time, upright, with square pixels, in the file's own colours, up to the first damaged one.
"""

from __future__ import annotations

import math
import os
import struct
from collections.abc import Generator, Iterator
from typing import Any, BinaryIO, NamedTuple, Optional, Union

import numpy as np

from ._decode import DEFAULT_DURATION_S, ERROR_MESSAGES, TEXT_DEMUXERS, Damage, Decoder, open_track
from ._errors import MissingPackageError, TraceCutError, WrongTypeError, file_errors, wrong_type
from ._types import F64, U8

#: Bicubic, bit-identical on every machine. The command line and the package for Node give ffmpeg the same flags.
_SCALER_FLAGS = "flags=bicubic+accurate_rnd+full_chroma_int+bitexact"

#: The size at which pixels are square. It never has fewer columns or rows than the file stores.
_DISPLAY_SIZE = "w='if(gt(sar,1),round(iw*sar),iw)':h='if(gt(sar,1),ih,round(ih/sar))'"


class Filter(NamedTuple):
    """An FFmpeg filter with its arguments."""

    name: str
    arguments: Optional[str] = None


class PictureFormat(NamedTuple):
    """Everything a filter graph depends on."""

    width: int
    height: int
    pixel_format: str
    colorspace: int
    color_range: int
    pixel_aspect: str
    turn: tuple[Filter, ...]


class RgbConverter:
    """Converts the pictures of a stream to RGB. Later pictures are scaled to the size of the first."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream
        self._format: Optional[PictureFormat] = None
        self._graph: Any = None
        self._size: Optional[tuple[int, int]] = None

    def convert(self, frame: Any) -> U8:
        """Returns a picture as an array of shape (height, width, 3).

        Raises
        ------
        av.FFmpegError
            If FFmpeg cannot convert pixels of this format.
        """
        picture = self._format_of(frame)
        if picture != self._format:
            self._graph, self._format = _build_graph(picture, self._size), picture
        self._graph.push(frame)
        rgb = np.asarray(self._graph.pull().to_ndarray(), np.uint8)
        self._size = (rgb.shape[1], rgb.shape[0])
        return rgb

    def _format_of(self, frame: Any) -> PictureFormat:
        aspect = self._stream.sample_aspect_ratio or self._stream.codec_context.sample_aspect_ratio or 1
        pixels = (frame.format.name, int(frame.colorspace), int(frame.color_range), str(aspect))
        return PictureFormat(frame.width, frame.height, *pixels, turn_filters(*_display_matrix(frame)))


def _build_graph(picture: PictureFormat, size: Optional[tuple[int, int]]) -> Any:
    """Builds the graph that converts pictures of a format to RGB, at the given size or else at the display size.

    It rotates pictures, then scales and converts them in one step, as ffmpeg does for the command line.
    """
    from av.filter import Graph

    pixels = f"video_size={picture.width}x{picture.height}:pix_fmt={picture.pixel_format}:time_base=1/1"
    colours = f"colorspace={picture.colorspace}:range={picture.color_range}"
    scaled = _DISPLAY_SIZE if size is None else f"w={size[0]}:h={size[1]}"
    filters = [
        Filter("buffer", f"{pixels}:{colours}"),
        Filter("setsar", picture.pixel_aspect),
        *picture.turn,
        Filter("scale", f"{scaled}:{_SCALER_FLAGS}"),
        Filter("setsar", "1"),
        Filter("format", "rgb24"),
        Filter("buffersink"),
    ]
    graph = Graph()
    graph.link_nodes(*(graph.add(each.name, each.arguments) for each in filters))
    graph.configure()
    return graph


def _display_matrix(frame: Any) -> tuple[float, float, float, float]:
    """Returns the 2 × 2 part of the display matrix, which rotates and mirrors; the identity by default."""
    try:
        for data in frame.side_data:
            if data.type.name == "DISPLAYMATRIX":
                a, b, _, c, d = struct.unpack("=5i", bytes(data)[:20])
                return a, b, c, d
    except ValueError:
        # PyAV fails on side data it does not know, but still reports the angle.
        angle = math.radians(-frame.rotation)
        return math.cos(angle), math.sin(angle), -math.sin(angle), math.cos(angle)
    return 1, 0, 0, 1


def turn_filters(a: float, b: float, c: float, d: float) -> tuple[Filter, ...]:
    """Returns the filters that rotate and mirror a picture by its display matrix, the same as ffmpeg's."""
    columns = math.hypot(a, c), math.hypot(b, d)
    if 0 in columns:
        return ()
    angle_deg = round(math.degrees(math.atan2(b / columns[1], a / columns[0]))) % 360
    if angle_deg == 90:
        return (Filter("transpose", "cclock_flip" if c > 0 else "clock"),)
    if angle_deg == 270:
        return (Filter("transpose", "clock_flip" if c < 0 else "cclock"),)
    if angle_deg in (0, 180):
        flips = [Filter("hflip")] if a < 0 and angle_deg == 180 else []
        return (*flips, *([Filter("vflip")] if d < 0 else []))
    return (Filter("rotate", f"{angle_deg}*PI/180"),)


#: Number of bytes read to find out why a file cannot be opened.
_START_BYTES = 32

#: First bytes of video files: Matroska, AVI and WebP, Ogg, GIF, PNG. In MP4 files a length precedes the signature.
_SIGNATURES = (b"\x1aE\xdf\xa3", b"RIFF", b"OggS", b"GIF8", b"\x89PNG")
_MP4_SIGNATURE, _MP4_SIGNATURE_OFFSET = b"ftyp", 4

#: The header of an animated WebP after `RIFF` and the length, the offset of its flags, and the animation flag.
_ANIMATED_WEBP, _WEBP_FLAGS_OFFSET, _WEBP_ANIMATION_FLAG = b"WEBPVP8X", 20, 2


class VideoReader(Iterator[U8]):
    """An iterator over the frames of a video, as arrays of shape (height, width, 3); see `read_video`."""

    def __init__(self, file: Union[str, "os.PathLike[str]", BinaryIO]) -> None:
        if isinstance(file, (str, os.PathLike)):
            self._name = os.fspath(file)
            self._stream: Any = None
        elif hasattr(file, "read") and hasattr(file, "seek"):
            self._name = str(getattr(file, "name", "video"))
            self._stream = file
        else:
            raise wrong_type("path", file, "a path, or an open file")
        self._start = self._read_start()
        self._pyav = _load_pyav()
        self._times: list[float] = []
        self._last_duration = 0.0
        self._frames = self._read()

    def __iter__(self) -> VideoReader:
        return self

    def __reduce__(self) -> Any:
        reason = "a video that is being read cannot be copied, or sent to another process: pass its path instead"
        raise WrongTypeError("state", reason)

    def __next__(self) -> U8:
        with ERROR_MESSAGES.listen():
            return next(self._frames)

    @property
    def times(self) -> F64:
        """The presentation times of the frames read so far, in seconds, as in the file."""
        return np.array(self._times, np.float64)

    @property
    def durations(self) -> F64:
        """Seconds from each of these frames to the next; the last one's duration is the file's."""
        steps: list[float] = np.diff(self.times).tolist()
        last = self._last_duration or (steps[-1] if steps else DEFAULT_DURATION_S)
        return np.array([*steps, last][: len(self._times)], np.float64)

    def _read(self) -> Generator[U8, None, None]:
        with open_track(self._open) as track:
            if track is None:
                raise self._error("no-video", "has no video track")
            codec = track.stream.codec_context
            if codec is None:
                raise self._error("codec", f"its codec cannot be decoded by PyAV {self._pyav.__version__}")
            decoder = Decoder(track)
            yield from self._convert(decoder, RgbConverter(track.stream))
            if not self._times:
                raise self._without_picture(decoder, codec.name)

    def _convert(self, decoder: Decoder, converter: RgbConverter) -> Iterator[U8]:
        try:
            for picture in decoder.pictures():
                frame = self._to_rgb(picture.frame, converter)
                self._times.append(picture.time)
                self._last_duration = picture.duration
                yield frame
        except Damage as damage:
            raise self._truncated(f"is cut off or damaged at frame {len(self._times)}") from damage

    def _to_rgb(self, frame: Any, converter: RgbConverter) -> U8:
        try:
            return converter.convert(frame)
        except self._pyav.FFmpegError as error:
            raise self._error("codec", f"its pixels ({frame.format.name}) cannot be converted to RGB") from error

    def _open(self) -> Any:
        try:
            if self._stream is None:
                # With an explicit protocol, a file name cannot be taken for a URL.
                container = self._pyav.open(f"file:{self._name}")
            else:
                self._stream.seek(0)
                container = self._pyav.open(self._stream)
        except self._pyav.FFmpegError as error:
            raise self._unreadable() from error
        if container.format.name in TEXT_DEMUXERS:
            container.close()
            raise self._unreadable()
        return container

    def _read_start(self) -> bytes:
        """Returns the first bytes. A missing or unreadable file raises the system's error."""
        if self._stream is None:
            with file_errors(), open(self._name, "rb") as file:
                return file.read(_START_BYTES)
        self._stream.seek(0)
        return bytes(self._stream.read(_START_BYTES))

    def _unreadable(self) -> TraceCutError:
        if not self._start:
            return self._error("no-video", "is empty")
        if self._start.startswith(_MP4_SIGNATURE, _MP4_SIGNATURE_OFFSET):
            return self._truncated("is cut off: the index, which MP4 files may have at their end, is missing")
        if self._start.startswith(_SIGNATURES):
            return self._truncated("is cut off or damaged before the first frame")
        return self._error("no-video", "is not a video (expected one that FFmpeg reads, such as MP4, WebM or GIF)")

    def _without_picture(self, decoder: Decoder, codec: str) -> TraceCutError:
        if decoder.lacks_data:
            return self._truncated("is cut off or damaged before the first frame")
        if self._start.startswith(_ANIMATED_WEBP, 8) and self._start[_WEBP_FLAGS_OFFSET] & _WEBP_ANIMATION_FLAG:
            reason = f"is an animated WebP, which PyAV {self._pyav.__version__} cannot read (convert it to APNG or GIF)"
            return self._error("unsupported", reason)
        return self._error("codec", f"no picture of its {codec} video can be decoded")

    def _truncated(self, reason: str) -> TraceCutError:
        error = self._error("truncated", reason)
        error.frames = len(self._times)
        return error

    def _error(self, code: str, reason: str) -> TraceCutError:
        return TraceCutError(code, f"{self._name}: {reason}")


def _load_pyav() -> Any:
    try:
        import av
        from av import stream
    except ImportError as error:
        reason = "reading video files needs PyAV: pip install 'tracecut[video]'"
        raise MissingPackageError("unsupported", reason) from error
    if not hasattr(stream, "Disposition"):
        reason = f"reading video files needs PyAV 14.1 or newer (this is {av.__version__})"
        raise MissingPackageError("unsupported", reason)
    return av
