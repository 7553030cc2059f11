"""Synthetic clips with known masks and flow."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal, Union, overload

import numpy as np

from . import _tracecut
from ._errors import index_of, whole, wrong_type
from ._types import U8, FlowField

#: The kinds of synthetic clips.
Kind = Literal["sample", "two_walkers", "entangled", "still"]

_MAX_SIDE, _MAX_FRAMES, _MAX_SEED = 4096, 100_000, 2**64 - 1


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
        self, kind: Kind = "sample", width: int = 320, height: int = 180, frames: int = 24, seed: int = 0
    ) -> None:
        given: Any = kind
        if not isinstance(given, str):
            raise wrong_type("kind", given, "sample, two_walkers, entangled or still")
        sizes = whole("width", width, 1, _MAX_SIDE), whole("height", height, 1, _MAX_SIDE)
        self._arguments = (given, *sizes, whole("frames", frames, 1, _MAX_FRAMES), whole("seed", seed, 0, _MAX_SEED))
        self._raw = _tracecut.Scene(*self._arguments)

    def __reduce__(self) -> tuple[type[Scene], tuple[str, int, int, int, int]]:
        return type(self), self._arguments

    def __len__(self) -> int:
        return self._raw.num_frames()

    @overload
    def __getitem__(self, t: int) -> U8: ...
    @overload
    def __getitem__(self, t: slice) -> U8: ...
    def __getitem__(self, t: Union[int, slice]) -> U8:
        if isinstance(t, slice):
            frames = [self._raw.frame(k) for k in range(len(self))[t]]
            return np.stack(frames) if frames else np.zeros((0, *self._raw.frame(0).shape), np.uint8)
        return self._raw.frame(index_of(t, len(self)))

    def __iter__(self) -> Iterator[U8]:
        return (self._raw.frame(t) for t in range(len(self)))

    def mask(self, t: int) -> U8:
        """The true mask of frame ``t``: 0 for the background, or the number of an object; shape (height, width)."""
        return self._raw.mask(index_of(t, len(self)))

    def flow(self, t: int) -> FlowField:
        """The true flow from frame ``t`` to ``t + 1``."""
        return FlowField(*self._raw.flow(index_of(t, len(self))))
