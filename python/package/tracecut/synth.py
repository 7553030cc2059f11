"""Synthetic clips with known masks and flow."""

from __future__ import annotations

from collections.abc import Iterator

from . import _tracecut
from ._errors import illegal
from ._types import U8, FlowField


class Scene:
    """A synthetic clip, usable as frames.

    Parameters
    ----------
    kind : str
        ``sample``, ``two_walkers``, ``entangled`` or ``still``.
    width, height : int
        Size of the frames in pixels.
    frames : int
        Number of frames.
    seed : int, default 0
        Seed of the clip.
    """

    def __init__(
        self, kind: str = "sample", width: int = 320, height: int = 180, frames: int = 24, seed: int = 0
    ) -> None:
        for name, value in (("width", width), ("height", height), ("frames", frames), ("seed", seed)):
            if value < 0:
                raise illegal(name, value, "a whole number")
        self._raw = _tracecut.Scene(kind, width, height, frames, seed)

    def __len__(self) -> int:
        return self._raw.num_frames()

    def __getitem__(self, t: int) -> U8:
        if not 0 <= t < len(self):
            raise IndexError(f"t = {t} (expected a frame in 0..{len(self)})")
        return self._raw.frame(t)

    def __iter__(self) -> Iterator[U8]:
        return (self._raw.frame(t) for t in range(len(self)))

    def mask(self, t: int) -> U8:
        """The true mask of frame ``t``: 0 for the background, or the number of an object; shape (height, width)."""
        return self._raw.mask(t)

    def flow(self, t: int) -> FlowField:
        """The true flow from frame ``t`` to ``t + 1``."""
        return FlowField(*self._raw.flow(t))
