"""Masks as run lengths, in COCO's format, as PNG files, and as prompts for models such as SAM 2."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, TypedDict, Union, cast

import numpy as np
import numpy.typing as npt

from . import _tracecut
from ._errors import TraceCutError, whole, wrong_type
from ._types import U8, Bool

_MASK = "an array of uint8 of shape (height, width)"


def check_mask(mask: Any, name: str = "mask") -> U8:
    """Returns a mask; bool becomes uint8.

    Raises
    ------
    TraceCutError
        ``data`` if it is not an array of uint8 or bool of two dimensions.
    """
    if not isinstance(mask, np.ndarray):
        raise wrong_type(name, mask, _MASK, "data")
    array = cast("npt.NDArray[Any]", mask)
    if array.ndim != 2 or array.size == 0 or array.dtype.name not in ("uint8", "bool"):
        raise wrong_type(name, array, _MASK, "data")
    return array.astype(np.uint8, copy=False)


class CocoRle(TypedDict):
    """A segmentation in COCO's format: height and width, and compressed run lengths."""

    size: list[int]
    counts: str


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
        """The decoded mask."""
        return np.repeat(self.values, self._lengths()).reshape(self.shape)

    def areas(self) -> npt.NDArray[np.int64]:
        """Number of pixels of each label, 0 to 255."""
        return np.bincount(self.values, weights=self._lengths(), minlength=256).astype(np.int64)

    def _lengths(self) -> npt.NDArray[np.int64]:
        ends = np.concatenate([[0], self.ends]).astype(np.int64)
        return ends[1:] - ends[:-1]


def coco_rle(mask: Union[U8, Bool], label: int = 1) -> CocoRle:
    """The pixels of one label as a COCO segmentation, as pycocotools reads it.

    Parameters
    ----------
    mask : array of uint8 or bool, shape (height, width)
    label : int, default 1
        The label to encode.

    Returns
    -------
    dict
        ``{"size": [height, width], "counts": str}``
    """
    array, value = check_mask(mask), whole("label", label, 0, 255, "a label")
    lengths = _tracecut.run_lengths((array == value).astype(np.uint8))
    return {"size": [int(array.shape[0]), int(array.shape[1])], "counts": _tracecut.run_text(lengths)}


def from_coco_rle(segmentation: Mapping[str, Any]) -> Bool:
    """The pixels of a COCO segmentation, compressed or as a list of lengths.

    Raises
    ------
    TraceCutError
        ``data`` if it is not a valid segmentation.
    """
    try:
        height, width = (int(side) for side in segmentation["size"])
        counts = segmentation["counts"]
        text = counts.decode("ascii") if isinstance(counts, bytes) else counts
        lengths = _tracecut.run_counts(text) if isinstance(text, str) else [int(count) for count in text]
        return _tracecut.run_mask(lengths, width, height).astype(bool)
    except (LookupError, TypeError, ValueError, OverflowError) as error:
        expected = "expected {'size': [height, width], 'counts': run lengths}"
        raise TraceCutError("data", f"segmentation cannot be read ({expected})") from error


def _voc_palette() -> list[int]:
    """The colours of the VOC and DAVIS benchmarks: bits of the label, three at a time."""
    colours: list[int] = []
    for label in range(256):
        for channel in range(3):
            colours.append(sum((label >> (3 * bit + channel) & 1) << (7 - bit) for bit in range(3)))
    return colours


_PALETTE = _voc_palette()


def mask_png(mask: U8) -> bytes:
    """A mask as a PNG file with a palette, whose pixels are the labels.

    Parameters
    ----------
    mask : array of uint8, shape (height, width)
    """
    return _tracecut.palette_png(check_mask(mask), _PALETTE)


@dataclass(frozen=True)
class Prompt:
    """A prompt that selects one object for a model such as SAM 2.

    The names are those of SAM 2's video predictor; positions are in pixels of the masks.

    Attributes
    ----------
    obj_id : int
        The object's label.
    frame_idx : int
        The frame that shows it best.
    box : array of float32, shape (4,)
        Left, top, right and bottom.
    points : array of float32, shape (points, 2)
        Up to three points deep inside the object, then up to three outside it.
    labels : array of int32, shape (points,)
        1 for points inside the object, 0 for points outside.
    mask : array of bool, shape (height, width)
        The largest connected part of the object.
    """

    obj_id: int
    frame_idx: int
    box: npt.NDArray[np.float32]
    points: npt.NDArray[np.float32]
    labels: npt.NDArray[np.int32]
    mask: Bool

    def as_points_and_box(self) -> dict[str, Any]:
        """Arguments of SAM 2's ``add_new_points_or_box``, besides its state."""
        return {name: getattr(self, name) for name in ("frame_idx", "obj_id", "points", "labels", "box")}

    def as_mask(self) -> dict[str, Any]:
        """Arguments of SAM 2's ``add_new_mask``, besides its state."""
        return {name: getattr(self, name) for name in ("frame_idx", "obj_id", "mask")}

    def as_json(self) -> dict[str, Any]:
        """An entry of the command line's ``prompts.json``, with the mask as COCO run lengths."""
        return {
            "obj_id": self.obj_id,
            "frame_idx": self.frame_idx,
            "box": self.box.astype(int).tolist(),
            "points": self.points.astype(int).tolist(),
            "labels": self.labels.tolist(),
            "mask": coco_rle(self.mask),
        }


def prompts(masks: Iterable[U8]) -> list[Prompt]:
    """A prompt for each object, for models that follow an object from a click, a box or a mask.

    Parameters
    ----------
    masks : Result, or arrays of uint8, shape (height, width)
        The masks of all frames, in order.

    Returns
    -------
    list of Prompt
        Sorted by object.
    """
    given: Any = masks
    if not hasattr(given, "__iter__"):
        raise wrong_type("masks", given, "a result, or masks one by one", "data")
    finder = _tracecut.Prompts()
    for t, mask in enumerate(masks):
        finder.add(check_mask(mask, f"masks[{t}]"))
    return [_prompt(raw) for raw in finder.finish()]


def _prompt(raw: dict[str, Any]) -> Prompt:
    inside, outside = raw["inside"], raw["outside"]
    return Prompt(
        obj_id=raw["object"],
        frame_idx=raw["frame"],
        box=np.asarray(raw["bounds"], np.float32),
        points=np.asarray([*inside, *outside], np.float32).reshape(-1, 2),
        labels=np.asarray([1] * len(inside) + [0] * len(outside), np.int32),
        mask=raw["mask"].astype(bool),
    )
