"""Masks in little memory, as COCO has them, and as PNG files."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _tracecut
from ._errors import TraceCutError
from ._types import U8, Bool


class Runs:
    """A mask as runs of equal labels, row by row."""

    __slots__ = ("ends", "shape", "values")

    def __init__(self, mask: U8) -> None:
        flat = mask.ravel()
        last = np.flatnonzero(flat[1:] != flat[:-1])
        self.shape = (int(mask.shape[0]), int(mask.shape[1]))
        self.values = flat[np.append(last, flat.size - 1)]
        self.ends = np.append(last + 1, flat.size).astype(np.uint32)

    def mask(self) -> U8:
        """The mask again."""
        return np.repeat(self.values, self._lengths()).reshape(self.shape)

    def areas(self) -> npt.NDArray[np.int64]:
        """Pixels of each label, 0 to 255."""
        return np.bincount(self.values, weights=self._lengths(), minlength=256).astype(np.int64)

    def _lengths(self) -> npt.NDArray[np.int64]:
        ends = np.concatenate([[0], self.ends]).astype(np.int64)
        return ends[1:] - ends[:-1]


def runs_of(flat: Bool) -> list[int]:
    """Lengths of runs, outside and inside in turn; the first is outside and may be 0."""
    begins = np.flatnonzero(np.diff(flat, prepend=False))
    return [int(length) for length in np.diff(np.concatenate([[0], begins, [flat.size]]))]


def coco_rle(mask: Union[U8, Bool], label: int = 1) -> dict[str, Any]:
    """The pixels of one label as a COCO segmentation, which pycocotools reads.

    Parameters
    ----------
    mask : array of uint8 or bool, shape (height, width)
    label : int, default 1
        What counts as inside.

    Returns
    -------
    dict
        ``{"size": [height, width], "counts": str}``
    """
    if mask.ndim != 2:
        raise TraceCutError("data", f"mask has {mask.ndim} dimensions (expected 2: height and width)")
    # Column by column.
    counts = runs_of((mask == label).T.ravel())
    return {"size": [int(mask.shape[0]), int(mask.shape[1])], "counts": _to_text(counts)}


def from_coco_rle(segmentation: Mapping[str, Any]) -> Bool:
    """The pixels of a COCO segmentation, compressed or as a list of lengths.

    Raises
    ------
    TraceCutError
        ``data`` when it is none.
    """
    try:
        height, width = (int(side) for side in segmentation["size"])
        counts = segmentation["counts"]
        text = counts.decode("ascii") if isinstance(counts, bytes) else counts
        lengths = _from_text(text) if isinstance(text, str) else [int(count) for count in text]
    except (KeyError, TypeError, ValueError, IndexError) as error:
        expected = "expected {'size': [height, width], 'counts': run lengths}"
        raise TraceCutError("data", f"segmentation cannot be read ({expected})") from error
    if min(lengths, default=0) < 0 or sum(lengths) != height * width:
        raise TraceCutError("data", f"counts cover {sum(lengths)} pixels (expected {height * width})")
    inside = np.arange(len(lengths)) % 2 == 1
    return np.repeat(inside, lengths).reshape(width, height).T.copy()


def _to_text(counts: list[int]) -> str:
    """Each length in groups of five bits, from the third on as its difference from the last but one."""
    letters: list[int] = []
    for i, count in enumerate(counts):
        rest = count - counts[i - 2] if i > 2 else count
        more = True
        while more:
            five = rest & 31
            rest >>= 5
            # Bit 16 is the sign: what is left is over when it is nothing but that.
            more = rest != (-1 if five & 16 else 0)
            letters.append(48 + (five | 32 if more else five))
    return bytes(letters).decode("ascii")


def _from_text(text: str) -> list[int]:
    counts: list[int] = []
    at = 0
    while at < len(text):
        value, shift, more = 0, 0, True
        while more:
            five = ord(text[at]) - 48
            if not 0 <= five < 64:
                raise ValueError(text)
            value |= (five & 31) << shift
            more = five & 32 != 0
            at += 1
            shift += 5
            if not more and five & 16:
                value -= 1 << shift
        counts.append(value + (counts[-2] if len(counts) > 2 else 0))
    return counts


def _voc_palette() -> list[int]:
    """The colours that the VOC and DAVIS benchmarks share: bits of the label, three at a time."""
    colours: list[int] = []
    for label in range(256):
        for channel in range(3):
            colours.append(sum((label >> (3 * place + channel) & 1) << (7 - place) for place in range(3)))
    return colours


_PALETTE = _voc_palette()


def mask_png(mask: U8) -> bytes:
    """A mask as a PNG file with a palette, whose pixels are the labels.

    Parameters
    ----------
    mask : array of uint8, shape (height, width)
    """
    return _tracecut.palette_png(mask, _PALETTE)
