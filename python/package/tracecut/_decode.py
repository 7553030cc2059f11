"""Decodes the video track of a file with PyAV, up to the first damaged or missing picture."""

from __future__ import annotations

import math
import threading
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple, Optional

#: A step between pictures longer than the previous one by this factor may contain lost pictures.
_LONG_STEP = 1.5


class FaultFinder:
    """Compares decoded pictures with the packets of the file, by time stamps in units of the stream. Damage is

    - a picture that the decoder marks as corrupt;
    - an incomplete packet: pictures from its time on;
    - a packet that could not be decoded: from the first packet time without a picture;
    - a file that could not be read to its end: missing pictures at the end, and pictures shown after lost ones.

    Faults before the first whole picture do not count: a recording may begin between two key frames.

    Parameters
    ----------
    is_animation : bool
        True if all pictures are painted over the first one, so that damage of the first counts too.
    marks_are_late : bool
        True if the corrupt mark of an incomplete packet is on the previous packet, as when the demuxer cuts packets out
        of a stream.
    is_cut_off : bool
        True if the file is known to end too early.
    """

    def __init__(self, is_animation: bool, marks_are_late: bool, is_cut_off: bool) -> None:
        self.is_cut_off = is_cut_off
        self._marks_are_late = marks_are_late
        self._mark_is_due = False
        self._waits_for_key = False
        #: Durations by the times of packets whose pictures are still pending.
        self._expected: dict[int, int] = {}
        self._torn: set[int] = set()
        self._failed: set[int] = set()
        self._next_decoding = math.inf
        self._last_pts: Optional[int] = None
        self._last_step = math.inf
        self._has_begun = is_animation

    @property
    def lacks_data(self) -> bool:
        """True if the file ends too early, or a packet was incomplete."""
        return self.is_cut_off or self._mark_is_due or len(self._torn) > 0

    def add_packet(self, packet: Any) -> None:
        """Adds the next packet of the file."""
        is_torn = self._mark_is_due if self._marks_are_late else packet.is_corrupt
        self._mark_is_due = self._marks_are_late and packet.is_corrupt
        if packet.pts is not None and is_torn:
            self._torn.add(packet.pts)
        if packet.pts is not None and not packet.is_discard:
            self._expected[packet.pts] = packet.duration or 0
        self._next_decoding = math.inf if packet.dts is None else packet.dts + (packet.duration or 0)

    def add_failure(self, pts: Optional[int]) -> None:
        """Notes that the packet with this time could not be decoded."""
        self._waits_for_key = not self._has_begun
        if pts is not None:
            self._failed.add(pts)

    def add_torn(self, pts: Optional[int]) -> None:
        """Notes that the picture with this time is damaged."""
        if pts is not None:
            self._torn.add(pts)

    def take_duration(self, pts: Optional[int]) -> int:
        """Removes and returns the duration of a decoded picture, 0 if the file has none."""
        if pts is None:
            return 0
        self._failed.discard(pts)
        return self._expected.pop(pts, 0)

    def is_whole(self, frame: Any) -> bool:
        """Returns True if a picture is whole and none is missing before it."""
        if frame.is_corrupt or frame.pts in self._torn:
            self._waits_for_key = not self._has_begun
            return False
        if not self._has_begun:
            return frame.key_frame or not self._waits_for_key
        return frame.pts is None or not (self._is_missing_before(frame.pts) or self._is_behind_gap(frame.pts))

    def add_whole(self, pts: Optional[int]) -> None:
        """Notes that a whole picture was returned."""
        if not self._has_begun:
            self._has_begun = True
            self._forget_before(pts)
        if pts is None:
            return
        if self._last_pts is not None:
            self._last_step = pts - self._last_pts
        self._last_pts = pts

    def is_whole_at_end(self) -> bool:
        """Returns True if nothing is missing after the last picture."""
        return not (self.is_cut_off or self._mark_is_due or self._is_missing_before(math.inf))

    def _is_missing_before(self, pts: float) -> bool:
        is_torn = any(torn < pts for torn in self._torn)
        return is_torn or (len(self._failed) > 0 and any(expected < pts for expected in self._expected))

    def _is_behind_gap(self, pts: int) -> bool:
        """Returns True if lost pictures may come before. None of them is shown before its decoding time."""
        if not self.is_cut_off or self._last_pts is None:
            return False
        return pts > self._next_decoding and pts - self._last_pts > _LONG_STEP * self._last_step

    def _forget_before(self, pts: Optional[int]) -> None:
        if pts is not None:
            self._torn = {torn for torn in self._torn if torn > pts}
            self._failed = {failed for failed in self._failed if failed > pts}
            self._expected = {expected: ticks for expected, ticks in self._expected.items() if expected > pts}


#: Duration of a picture if the file has none.
DEFAULT_DURATION_S = 1 / 25

#: Codecs whose pictures are painted over the previous one.
_ANIMATION_CODECS = ("gif", "apng")

#: Codecs whose decoder reports a damaged picture only by a message.
_QUIET_CODECS = ("gif",)

#: Demuxers that cut packets out of a stream.
_STREAM_DEMUXERS = ("mpegts", "mpeg")

#: FFmpeg demuxers that turn text into pictures.
TEXT_DEMUXERS = ("tty", "bin", "xbin", "adf", "idf")

#: Messages of demuxers that reach a bad position before the end of the file, even while they probe its tracks.
_END_MESSAGES = (
    "ended prematurely",
    "partial file",
    "exceeds containing master element",
    "invalid as first byte of an EBML",
)


class Picture(NamedTuple):
    """A decoded picture with its time and duration in seconds; the duration is 0 if the file has none."""

    frame: Any
    time: float
    duration: float


class Damage(Exception):
    """The next picture of the file is damaged or missing."""


class _ErrorMessages:
    """The error messages of FFmpeg. Its log level is global, and is changed only while there are listeners."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._num_listeners = 0
        self._settings: tuple[Optional[int], bool] = (None, True)

    @contextmanager
    def listen(self) -> Generator[list[tuple[int, str, str]], None, None]:
        """Collects the messages of this thread: level, source and text."""
        from av import logging

        with self._lock:
            if self._num_listeners == 0:
                self._settings = logging.get_level(), logging.get_skip_repeated()
                logging.set_level(logging.ERROR)
                logging.set_skip_repeated(False)
            self._num_listeners += 1
        try:
            with logging.Capture() as messages:
                yield messages
        finally:
            with self._lock:
                self._num_listeners -= 1
                if self._num_listeners == 0:
                    logging.set_level(self._settings[0])
                    logging.set_skip_repeated(self._settings[1])


#: A reader listens while it works, and so does each part of it that checks messages.
ERROR_MESSAGES = _ErrorMessages()


class Track(NamedTuple):
    """A video stream of an open container; ``is_cut_off`` if the file is already known to end too early."""

    container: Any
    stream: Any
    is_cut_off: bool


@contextmanager
def open_track(open_file: Callable[[], Any]) -> Generator[Optional[Track], None, None]:
    """Opens the video track of a file, twice if choosing it needs reading the file; yields None if there is none."""
    container, is_cut_off = _open(open_file)
    with container:
        tracks = _video_tracks(container)
        if len(tracks) < 2:
            yield Track(container, tracks[0], is_cut_off) if tracks else None
            return
        index = _choose_track(container, tracks)
    container, is_cut_off = _open(open_file)
    with container:
        yield Track(container, container.streams[index], is_cut_off)


def _open(open_file: Callable[[], Any]) -> tuple[Any, bool]:
    """Returns a container, and True if FFmpeg reached a premature end while it probed the tracks."""
    with ERROR_MESSAGES.listen() as messages:
        container = open_file()
    return container, any(message in text for _, _, text in messages for message in _END_MESSAGES)


def _video_tracks(container: Any) -> list[Any]:
    """Returns the video streams except covers, in order of preference: default ones, then others by size."""
    from av.stream import Disposition

    tracks = [each for each in container.streams.video if not each.disposition & Disposition.attached_pic]
    others = sorted((each for each in tracks if not each.disposition & Disposition.default), key=_area, reverse=True)
    return [*(each for each in tracks if each.disposition & Disposition.default), *others]


def _area(stream: Any) -> int:
    codec = stream.codec_context
    return 0 if codec is None else int(codec.width) * int(codec.height)


def _choose_track(container: Any, tracks: list[Any]) -> int:
    """Returns the index of the first of these tracks with several pictures, or else of the largest with one.

    Reads the container until this is known or reading fails.
    """
    from av.error import FFmpegError

    num_read = Counter[int]()

    def num_pictures(track: Any) -> int:
        return max(num_read[track.index], int(track.frames))

    with suppress(FFmpegError):
        for packet in container.demux(tracks):
            if num_pictures(tracks[0]) > 1:
                break
            if packet.size > 0 and not packet.is_discard:
                num_read[packet.stream.index] += 1
    clips = [each for each in tracks if num_pictures(each) > 1]
    pictures = [each for each in tracks if num_pictures(each) == 1]
    return int((clips or sorted(pictures, key=_area, reverse=True) or tracks)[0].index)


class Decoder:
    """The pictures of a track."""

    def __init__(self, track: Track) -> None:
        self._container, self._stream, is_cut_off = track
        # With one thread, errors arrive in packet order.
        self._stream.codec_context.thread_count = 1
        is_animation = self._stream.codec_context.name in _ANIMATION_CODECS
        self._faults = FaultFinder(is_animation, self._container.format.name in _STREAM_DEMUXERS, is_cut_off)
        self._has_packets = False

    @property
    def lacks_data(self) -> bool:
        """True if the file ends too early, or a part of it cannot be read."""
        return self._faults.lacks_data or not self._has_packets

    def pictures(self) -> Iterator[Picture]:
        """Yields the pictures in display order, with increasing times. Pictures that end at or before 0 are dropped.

        Raises
        ------
        Damage
            After the last whole picture, if the file is damaged or truncated.
        """
        pending: Optional[Picture] = None
        for picture in self._timed_pictures():
            if pending is not None and picture.time > 0:
                yield pending
            pending = picture if picture.time < 0 else None
            if pending is None:
                yield picture
        if pending is not None and pending.time + pending.duration > 0:
            yield pending

    def _timed_pictures(self) -> Iterator[Picture]:
        """Repairs times: one that is missing or not above the previous one follows it after its duration."""
        previous: Optional[float] = None
        step = DEFAULT_DURATION_S
        for frame, ticks in self._whole_frames():
            duration = float(ticks * self._stream.time_base)
            time = None if frame.pts is None else float(frame.pts * self._stream.time_base)
            if previous is None:
                time = time or 0.0
            elif time is None or time <= previous:
                time = previous + step
            step = duration or (step if previous is None else time - previous)
            previous = time
            yield Picture(frame, time, duration)

    def _whole_frames(self) -> Iterator[tuple[Any, int]]:
        """Yields whole frames with their durations in units of the stream."""
        faults, has_begun = self._faults, False
        for frame in self._frames():
            duration = faults.take_duration(frame.pts)
            if faults.is_whole(frame):
                has_begun = True
                faults.add_whole(frame.pts)
                yield frame, duration
            elif has_begun:
                raise Damage
        if has_begun and not faults.is_whole_at_end():
            raise Damage

    def _frames(self) -> Iterator[Any]:
        for packet in self._packets():
            self._faults.add_packet(packet)
            yield from self._decode(packet)
        yield from self._decode(None)

    def _packets(self) -> Iterator[Any]:
        """Reads packets until the container is broken. Errors before the first packet do not count."""
        from av.error import FFmpegError

        packets = self._container.demux(self._stream)
        while True:
            with ERROR_MESSAGES.listen() as messages:
                try:
                    packet = next(packets, None)
                except FFmpegError:
                    self._faults.is_cut_off = True
                    return
            if self._has_packets and any(source == self._container.format.name for _, source, _ in messages):
                self._faults.is_cut_off = True
                return
            if packet is None:
                return
            # An empty packet would tell the decoder that the stream ends.
            if packet.size > 0:
                self._has_packets = True
                yield packet

    def _decode(self, packet: Optional[Any]) -> list[Any]:
        """Returns the frames that a packet completes, or without a packet the frames left in the decoder."""
        from av.error import FFmpegError

        pts = None if packet is None else packet.pts
        with ERROR_MESSAGES.listen() as messages:
            try:
                frames: list[Any] = self._stream.decode(packet)
            except FFmpegError:
                self._faults.add_failure(pts)
                return []
        if messages and self._stream.codec_context.name in _QUIET_CODECS:
            self._faults.add_torn(pts)
        return frames
