"""Progress callbacks and tqdm bars."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Optional, Union

from ._types import Progress

#: True for a tqdm bar, or a function that is called with each step.
Listener = Union[bool, Callable[[Progress], object], None]

Raw = Optional[Callable[[str, int, int], object]]


class Bar:
    """Shows one tqdm bar per stage."""

    def __init__(self) -> None:
        try:
            from tqdm.auto import tqdm
        except ImportError as error:
            raise ImportError("progress=True needs tqdm: pip install 'tracecut[progress]'") from error
        self._tqdm: Any = tqdm
        self._bar: Any = None
        self._stage = ""

    def __call__(self, stage: str, done: int, total: int) -> None:
        if stage == "trajectories":
            return  # Alternates with the flow, which takes far longer.
        if stage != self._stage or done < self._bar.n:
            self.close()
            self._bar, self._stage = self._tqdm(total=total, desc=stage, unit="step"), stage
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """Closes the current bar."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None
            self._stage = ""


def raw_listener(progress: Listener) -> Raw:
    """Returns the callback for the native module."""
    if progress is None or progress is False:
        return None
    if progress is True:
        return Bar()
    listener = progress
    return lambda stage, done, total: listener(Progress(stage, done, total))


def close(listener: Raw) -> None:
    """Closes the listener if it is a bar."""
    if isinstance(listener, Bar):
        listener.close()
