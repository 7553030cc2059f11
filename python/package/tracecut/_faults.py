"""Finds the first picture of a video that is damaged or missing."""

from __future__ import annotations

import math
from typing import Any, Optional

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
        """Whether the file ends too early, or a packet was not whole."""
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
