"""Decodes the video track of a file by PyAV, up to the first picture that is damaged or missing."""

from __future__ import annotations

import math
import threading
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple, Optional

#: Steps between pictures that are longer by this factor than the one before may have lost pictures in them.
_LONG_STEP = 1.5


class FaultFinder:
    """Compares decoded pictures with the packets of the file, by time stamps in units of the stream. Damage is

    - a picture that the decoder calls corrupt;
    - a packet that is not whole: pictures from its time on;
    - a packet that could not be decoded: the first time of a packet that has no picture;
    - a file that could not be read on: what the end lacks, and pictures that are shown after lost ones.

    What is wrong before the first whole picture does not count: a recording may begin between two key frames.

    Parameters
    ----------
    is_animation : bool
        Whether all pictures are painted over the first one, so that damage of that one counts too.
    marks_are_late : bool
        Whether the mark of a packet that is not whole is on the one before it, as where the demuxer cuts packets out of a
        stream.
    is_cut_off : bool
        Whether the file is known to end too early.
    """

    def __init__(self, is_animation: bool, marks_are_late: bool, is_cut_off: bool) -> None:
        self.is_cut_off = is_cut_off
        self._marks_are_late = marks_are_late
        self._mark_is_due = False
        self._waits_for_key = False
        #: Durations by the times of packets whose pictures are not there yet.
        self._expected: dict[int, int] = {}
        self._torn: set[int] = set()
        self._failed: set[int] = set()
        self._next_decoding = math.inf
        self._last_pts: Optional[int] = None
        self._last_step = math.inf
        self._has_begun = is_animation

    @property
    def lacks_data(self) -> bool:
        """Returns whether the file ends too early, or a packet was not whole."""
        return self.is_cut_off or self._mark_is_due or len(self._torn) > 0

    def add_packet(self, packet: Any) -> None:
        """Takes the next packet of the file."""
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
        """Returns the duration of the picture that was decoded, 0 where the file says none."""
        if pts is None:
            return 0
        self._failed.discard(pts)
        return self._expected.pop(pts, 0)

    def is_whole(self, frame: Any) -> bool:
        """Tells whether a picture is whole, and no other is missing before it."""
        if frame.is_corrupt or frame.pts in self._torn:
            self._waits_for_key = not self._has_begun
            return False
        if not self._has_begun:
            return frame.key_frame or not self._waits_for_key
        return frame.pts is None or not (self._is_missing_before(frame.pts) or self._is_behind_gap(frame.pts))

    def give(self, pts: Optional[int]) -> None:
        """Notes that a whole picture is given."""
        if not self._has_begun:
            self._has_begun = True
            self._forget_before(pts)
        if pts is None:
            return
        if self._last_pts is not None:
            self._last_step = pts - self._last_pts
        self._last_pts = pts

    def is_whole_at_end(self) -> bool:
        """Tells whether nothing is missing after the last picture."""
        return not (self.is_cut_off or self._mark_is_due or self._is_missing_before(math.inf))

    def _is_missing_before(self, pts: float) -> bool:
        is_torn = any(torn < pts for torn in self._torn)
        return is_torn or (len(self._failed) > 0 and any(expected < pts for expected in self._expected))

    def _is_behind_gap(self, pts: int) -> bool:
        """Tells whether lost pictures may come before. None of these is shown before its decoding time."""
        if not self.is_cut_off or self._last_pts is None:
            return False
        return pts > self._next_decoding and pts - self._last_pts > _LONG_STEP * self._last_step

    def _forget_before(self, pts: Optional[int]) -> None:
        if pts is not None:
            self._torn = {torn for torn in self._torn if torn > pts}
            self._failed = {failed for failed in self._failed if failed > pts}
            self._expected = {expected: ticks for expected, ticks in self._expected.items() if expected > pts}


#: Duration of a picture where the file says nothing.
DEFAULT_DURATION_S = 1 / 25

#: Codecs whose pictures are painted over the one before.
_ANIMATION_CODECS = ("gif", "apng")

#: Codecs whose decoder says only by a message that a picture is damaged.
_QUIET_CODECS = ("gif",)

#: Demuxers that cut packets out of a stream.
_STREAM_DEMUXERS = ("mpegts", "mpeg")

#: Demuxers of FFmpeg that make pictures of text.
TEXT_DEMUXERS = ("tty", "bin", "xbin", "adf", "idf")

#: Words of demuxers that come to a wrong place of the file before its end, even while they look for its tracks.
_END_WORDS = (
    "ended prematurely",
    "partial file",
    "exceeds containing master element",
    "invalid as first byte of an EBML",
)


class Picture(NamedTuple):
    """A decoded picture with its time in seconds, and its duration, which is 0 where the file says none."""

    frame: Any
    time: float
    duration: float


class Damage(Exception):
    """The next picture of the file is damaged or missing."""


class _ErrorMessages:
    """The error messages of FFmpeg. Its log level, one for the whole process, is changed only while somebody listens."""

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


#: Listened to for as long as a reader works, and by each part of it that looks at messages.
ERROR_MESSAGES = _ErrorMessages()


class Track(NamedTuple):
    """A video stream of an open container, which is known to be cut off or not yet known to be."""

    container: Any
    stream: Any
    is_cut_off: bool


@contextmanager
def open_track(open_file: Callable[[], Any]) -> Generator[Optional[Track], None, None]:
    """Opens the video track of a file, twice where the file has to be read to choose it; None where there is none."""
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
    """Returns a container, and whether FFmpeg came to a premature end while it looked for the tracks."""
    with ERROR_MESSAGES.listen() as messages:
        container = open_file()
    return container, any(words in text for _, _, text in messages for words in _END_WORDS)


def _video_tracks(container: Any) -> list[Any]:
    """Returns the video streams that are no covers, in the order of preference: default ones, then others by their size."""
    from av.stream import Disposition

    tracks = [each for each in container.streams.video if not each.disposition & Disposition.attached_pic]
    others = sorted((each for each in tracks if not each.disposition & Disposition.default), key=_area, reverse=True)
    return [*(each for each in tracks if each.disposition & Disposition.default), *others]


def _area(stream: Any) -> int:
    codec = stream.codec_context
    return 0 if codec is None else int(codec.width) * int(codec.height)


def _choose_track(container: Any, tracks: list[Any]) -> int:
    """Returns the index of the first of these tracks that has several pictures, or else of the largest that has one.

    Reads the container until this is known, or the container is broken.
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
        # With one thread, errors come in the order of the packets.
        self._stream.codec_context.thread_count = 1
        is_animation = self._stream.codec_context.name in _ANIMATION_CODECS
        self._faults = FaultFinder(is_animation, self._container.format.name in _STREAM_DEMUXERS, is_cut_off)
        self._has_packets = False

    @property
    def lacks_data(self) -> bool:
        """Returns whether the file ends too early, or a part of it cannot be read."""
        return self._faults.lacks_data or not self._has_packets

    def pictures(self) -> Iterator[Picture]:
        """Gives the pictures in display order, with increasing times. Those that end at or before 0 are not shown.

        Raises
        ------
        Damage
            After the last whole picture, if the file is damaged or cut off.
        """
        held: Optional[Picture] = None
        for picture in self._timed_pictures():
            if held is not None and picture.time > 0:
                yield held
            held = picture if picture.time < 0 else None
            if held is None:
                yield picture
        if held is not None and held.time + held.duration > 0:
            yield held

    def _timed_pictures(self) -> Iterator[Picture]:
        """Mends times: one that is missing or not above the one before it follows that after its duration."""
        before: Optional[float] = None
        step = DEFAULT_DURATION_S
        for frame, ticks in self._whole_frames():
            duration = float(ticks * self._stream.time_base)
            time = None if frame.pts is None else float(frame.pts * self._stream.time_base)
            if before is None:
                time = time or 0.0
            elif time is None or time <= before:
                time = before + step
            step = duration or (step if before is None else time - before)
            before = time
            yield Picture(frame, time, duration)

    def _whole_frames(self) -> Iterator[tuple[Any, int]]:
        """Gives whole frames with their durations in units of the stream."""
        faults, has_begun = self._faults, False
        for frame in self._frames():
            duration = faults.take_duration(frame.pts)
            if faults.is_whole(frame):
                has_begun = True
                faults.give(frame.pts)
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
        """Reads packets up to where the container is broken. Errors before the first packet do not count."""
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
            # An empty one would mean the end to the decoder.
            if packet.size > 0:
                self._has_packets = True
                yield packet

    def _decode(self, packet: Optional[Any]) -> list[Any]:
        """Returns the frames that a packet completes, or without one those that are left in the decoder."""
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
