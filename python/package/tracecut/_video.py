"""Reads videos by PyAV, by the contract of ``docs/frames.md``: each picture of the file once, in display order, with the
file's own time, upright, with square pixels, in the file's own colours, up to the first damaged one.
"""

from __future__ import annotations

import os
from collections.abc import Generator, Iterator
from typing import Any, BinaryIO, Union

import numpy as np

from ._decode import DEFAULT_DURATION_S, ERROR_MESSAGES, TEXT_DEMUXERS, Damage, Decoder, open_track
from ._errors import TraceCutError
from ._types import F64, U8
from ._upright import RgbConverter

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
