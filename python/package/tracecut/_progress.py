"""Progress callbacks, and a tqdm bar."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Optional, Union, cast

from . import _tracecut
from ._errors import MissingPackageError, wrong_type
from ._types import Progress, Stage

#: True for a tqdm bar, or a function that is called with each step.
Listener = Union[bool, Callable[[Progress], object], None]

Raw = Optional[Callable[[str, int, int], object]]

#: The usual time of each stage for a frame, in their order, as on the command line. Trajectories alternate with the flow,
#: and count with it.
_COSTS = dict(_tracecut.stage_costs)
_COSTS["flow"] += _COSTS["trajectories"]
_COSTS["trajectories"] = 0.0
_TOTAL_COST = sum(_COSTS.values())


class Bar:
    """One tqdm bar for a whole run, which counts frames. It never falls, and never exceeds its total.

    Parameters
    ----------
    num_frames : callable
        Returns the number of frames of the run, or None as long as it is not known.
    window, overlap : int
        Number of frames that are processed together, and that neighbouring windows share.
    """

    def __init__(self, num_frames: Callable[[], Optional[int]], window: int, overlap: int) -> None:
        try:
            from tqdm.auto import tqdm
        except ImportError as error:
            reason = "progress=True needs tqdm: pip install 'tracecut[progress]'"
            raise MissingPackageError("unsupported", reason) from error
        self._num_frames = num_frames
        self._window, self._overlap = window, overlap
        self._settled, self._share = 0, 0.0
        # Made at the first step, when the frames of the first window have been read: a short clip's length is known then.
        self._make: Any = lambda: tqdm(total=num_frames(), unit="frame")
        self._bar: Any = None

    def __call__(self, stage: str, done: int, total: int) -> None:
        if self._bar is None:
            self._bar = self._make()
        before = 0.0
        for name, cost in _COSTS.items():
            if name == stage:
                # The cut may take more steps than expected, and some stages may run again.
                self._share = max(self._share, (before + cost * min(1.0, done / total)) / _TOTAL_COST)
                break
            before += cost
        self._bar.set_postfix_str(stage, refresh=False)
        self._move_to(self._settled + int(self._share * self._frames_at_work()))

    def settle(self, num_frames: int) -> None:
        """Notes that the masks of this many more frames are final."""
        self._settled, self._share = self._settled + num_frames, 0.0
        self._move_to(self._settled)

    def finish(self) -> None:
        """Notes that the run is done."""
        total = self._num_frames()
        self._move_to(self._settled if total is None else total)

    def close(self) -> None:
        """Closes the bar."""
        if self._bar is not None:
            self._bar.close()

    def _frames_at_work(self) -> int:
        """Returns the number of frames that the present window settles at least."""
        total = self._num_frames()
        left = None if total is None else max(0, total - self._settled)
        return left if left is not None and left <= self._window else max(0, self._window - self._overlap)

    def _move_to(self, frames: int) -> None:
        if self._bar is None:
            return
        total = self._num_frames()
        if total != self._bar.total:
            self._bar.total = total
            self._bar.refresh()
        reached = frames if total is None else min(frames, total)
        if reached > self._bar.n:
            self._bar.update(reached - self._bar.n)


def raw_listener(progress: Listener, num_frames: Callable[[], Optional[int]], window: int = 0, overlap: int = 0) -> Raw:
    """Returns the callback for the native module."""
    if progress is None or progress is False:
        return None
    if progress is True:
        return Bar(num_frames, window, overlap)
    if not callable(progress):
        raise wrong_type("progress", progress, "True, False or a function")
    listener = progress
    return lambda stage, done, total: listener(Progress(cast("Stage", stage), done, total))


def settle(listener: Raw, num_frames: int) -> None:
    """Tells a bar that the masks of this many more frames are final."""
    if isinstance(listener, Bar):
        listener.settle(num_frames)


def finish(listener: Raw) -> None:
    """Tells a bar that the run is done."""
    if isinstance(listener, Bar):
        listener.finish()


def close(listener: Raw) -> None:
    """Closes the listener if it is a bar."""
    if isinstance(listener, Bar):
        listener.close()
