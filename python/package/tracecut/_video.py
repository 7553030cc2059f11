"""Reads videos by PyAV, by the contract of ``docs/frames.md``: each picture of the file once, in display order, with the
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
from ._errors import TraceCutError
from ._types import F64, U8

#: Bicubic, the same bits on every machine. The command line and the package for Node give ffmpeg the same flags.
_SCALER_FLAGS = "flags=bicubic+accurate_rnd+full_chroma_int+bitexact"

#: The size at which pixels are square. It never has fewer columns or rows than the file stores.
_DISPLAY_SIZE = "w='if(gt(sar,1),round(iw*sar),iw)':h='if(gt(sar,1),ih,round(ih/sar))'"


class Filter(NamedTuple):
    """A filter of FFmpeg, and its arguments."""

    name: str
    arguments: Optional[str] = None


class Form(NamedTuple):
    """All that a filter graph depends on."""

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
        self._form: Optional[Form] = None
        self._graph: Any = None
        self._size: Optional[tuple[int, int]] = None

    def convert(self, frame: Any) -> U8:
        """Returns a picture as an array of shape (height, width, 3).

        Raises
        ------
        av.FFmpegError
            When FFmpeg cannot convert pixels of this format.
        """
        form = self._form_of(frame)
        if form != self._form:
            self._graph, self._form = _build_graph(form, self._size), form
        self._graph.push(frame)
        rgb = np.asarray(self._graph.pull().to_ndarray(), np.uint8)
        self._size = (rgb.shape[1], rgb.shape[0])
        return rgb

    def _form_of(self, frame: Any) -> Form:
        aspect = self._stream.sample_aspect_ratio or self._stream.codec_context.sample_aspect_ratio or 1
        pixels = (frame.format.name, int(frame.colorspace), int(frame.color_range), str(aspect))
        return Form(frame.width, frame.height, *pixels, turn_filters(*_display_matrix(frame)))


def _build_graph(form: Form, size: Optional[tuple[int, int]]) -> Any:
    """Builds the graph from pictures of a form to RGB, at this size or else at the display size.

    It turns pictures, then scales and converts them in one step, as ffmpeg does for the command line.
    """
    from av.filter import Graph

    pixels = f"video_size={form.width}x{form.height}:pix_fmt={form.pixel_format}:time_base=1/1"
    colours = f"colorspace={form.colorspace}:range={form.color_range}"
    scaled = _DISPLAY_SIZE if size is None else f"w={size[0]}:h={size[1]}"
    filters = [
        Filter("buffer", f"{pixels}:{colours}"),
        Filter("setsar", form.pixel_aspect),
        *form.turn,
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
    """Returns the four numbers of the display matrix that turn and mirror; by default of an upright picture."""
    try:
        for data in frame.side_data:
            if data.type.name == "DISPLAYMATRIX":
                a, b, _, c, d = struct.unpack("=5i", bytes(data)[:20])
                return a, b, c, d
    except ValueError:
        # PyAV knows no side data that is newer than it is, and then gives none. It still tells the angle.
        angle = math.radians(-frame.rotation)
        return math.cos(angle), math.sin(angle), -math.sin(angle), math.cos(angle)
    return 1, 0, 0, 1


def turn_filters(a: float, b: float, c: float, d: float) -> tuple[Filter, ...]:
    """Returns the filters that turn and mirror a picture as its display matrix says, which are those of ffmpeg."""
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


#: Bytes that are looked at to tell why a file cannot be opened.
_START_BYTES = 32

#: How files begin that hold videos: Matroska, AVI and WebP, Ogg, GIF, PNG. MP4 files have their mark behind a length.
_SIGNATURES = (b"\x1aE\xdf\xa3", b"RIFF", b"OggS", b"GIF8", b"\x89PNG")
_MP4_SIGNATURE, _MP4_SIGNATURE_PLACE = b"ftyp", 4

#: The part of an animated WebP's head behind `RIFF` and the length, and the byte of the flags, of which one says so.
_ANIMATED_WEBP, _WEBP_FLAGS_PLACE, _WEBP_ANIMATION_FLAG = b"WEBPVP8X", 20, 2


class VideoReader(Iterator[U8]):
    """An iterator over the frames of a video, arrays of shape (height, width, 3); `read_video` makes it."""

    def __init__(self, file: Union[str, "os.PathLike[str]", BinaryIO]) -> None:
        if isinstance(file, (str, os.PathLike)):
            self._name = os.fspath(file)
            self._stream: Any = None
        else:
            self._name = str(getattr(file, "name", "video"))
            self._stream = file
        self._start = self._read_start()
        self._pyav = _load_pyav()
        self._times: list[float] = []
        self._last_duration = 0.0
        self._frames = self._read()

    def __iter__(self) -> VideoReader:
        return self

    def __next__(self) -> U8:
        with ERROR_MESSAGES.listen():
            return next(self._frames)

    @property
    def times(self) -> F64:
        """The presentation times of the frames read so far, in seconds, as the file says them."""
        return np.array(self._times, np.float64)

    @property
    def durations(self) -> F64:
        """Seconds from each of these frames to the next one, and of the last one as the file says it."""
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
                # With its protocol named, no file name means anything else.
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
        """Returns the first bytes. A file that is missing or may not be read is an error of the system's."""
        if self._stream is None:
            with open(self._name, "rb") as file:
                return file.read(_START_BYTES)
        self._stream.seek(0)
        return bytes(self._stream.read(_START_BYTES))

    def _unreadable(self) -> TraceCutError:
        if not self._start:
            return self._error("no-video", "is empty")
        if self._start.startswith(_MP4_SIGNATURE, _MP4_SIGNATURE_PLACE):
            return self._truncated("is cut off: the index, which MP4 files may have at their end, is missing")
        if self._start.startswith(_SIGNATURES):
            return self._truncated("is cut off or damaged before the first frame")
        return self._error("no-video", "is not a video (expected one that FFmpeg reads, such as MP4, WebM or GIF)")

    def _without_picture(self, decoder: Decoder, codec: str) -> TraceCutError:
        if decoder.lacks_data:
            return self._truncated("is cut off or damaged before the first frame")
        if self._start.startswith(_ANIMATED_WEBP, 8) and self._start[_WEBP_FLAGS_PLACE] & _WEBP_ANIMATION_FLAG:
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
        raise ImportError("reading video files needs PyAV: pip install 'tracecut[video]'") from error
    if not hasattr(stream, "Disposition"):
        raise ImportError(f"reading video files needs PyAV 14.1 or newer (this is {av.__version__})")
    return av
