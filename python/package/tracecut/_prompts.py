"""Prompts for models that follow an object from a hint, such as SAM 2."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _tracecut
from ._masks import coco_rle
from ._types import U8, Bool


@dataclass(frozen=True)
class Prompt:
    """What tells a promptable model which object is meant.

    The names are those of SAM 2's video predictor; places are in pixels of the masks.

    Attributes
    ----------
    obj_id : int
        The object's label.
    frame_idx : int
        The frame that shows it best.
    box : array of float32, shape (4,)
        Left, top, right and bottom.
    points : array of float32, shape (points, 2)
        Up to three points deep in the object, then up to three beside it.
    labels : array of int32, shape (points,)
        1 for points on the object, 0 for those beside it.
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
        """As an entry of ``prompts.json``, which the command line writes: the mask as COCO run lengths."""
        return {
            "obj_id": self.obj_id,
            "frame_idx": self.frame_idx,
            "box": self.box.astype(int).tolist(),
            "points": self.points.astype(int).tolist(),
            "labels": self.labels.tolist(),
            "mask": coco_rle(self.mask),
        }


def prompts(masks: Iterable[U8]) -> list[Prompt]:
    """A prompt for each object: nobody has to click for models that follow an object from a click, a box or a mask.

    Parameters
    ----------
    masks : Result, or arrays of uint8, shape (height, width)
        The masks of all frames, in order.

    Returns
    -------
    list of Prompt
        By their objects, ascending.
    """
    finder = _tracecut.Prompts()
    for mask in masks:
        finder.add(mask)
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
