"""Prompts for models that follow an object from a hint."""

from __future__ import annotations

import inspect
import json
from typing import Any

import numpy as np
import tracecut


def made() -> list[np.ndarray]:
    """Object 3 is largest in frame 1, object 7 in frame 0."""
    masks = [np.zeros((40, 60), np.uint8) for _ in range(3)]
    for t, side in enumerate((5, 12, 7)):
        masks[t][10 : 10 + side, 10 : 10 + 2 * side] = 3
        masks[t][30 : 36 - t, 45:50] = 7
    return masks


def test_each_object_has_its_best_frame_its_box_points_and_mask() -> None:
    masks = made()
    found = tracecut.prompts(masks)
    assert [(p.obj_id, p.frame_idx) for p in found] == [(3, 1), (7, 0)]
    assert found[0].box.tolist() == [10, 10, 33, 21]
    for prompt in found:
        mask = masks[prompt.frame_idx] == prompt.obj_id
        assert prompt.mask.dtype == bool and np.array_equal(prompt.mask, mask)
        assert prompt.labels.tolist() == [1, 1, 1, 0, 0, 0]
        on = [bool(mask[int(y), int(x)]) for x, y in prompt.points]
        assert on == [True] * 3 + [False] * 3
    assert tracecut.prompts([np.zeros((4, 4), np.uint8)]) == []


def test_json_holds_the_same() -> None:
    for prompt in tracecut.prompts(made()):
        entry = json.loads(json.dumps(prompt.as_json()))
        assert entry["points"] == prompt.points.tolist() and entry["box"] == prompt.box.tolist()
        assert np.array_equal(tracecut.from_coco_rle(entry["mask"]), prompt.mask)


def video_predictor() -> Any:
    """SAM 2's, or a class with the signatures of its version 1.1.0 where it is not installed."""
    try:
        from sam2.sam2_video_predictor import SAM2VideoPredictor

        return SAM2VideoPredictor
    except ImportError:

        class Recorded:
            def add_new_points_or_box(
                self,
                inference_state: Any,
                frame_idx: int,
                obj_id: int,
                points: Any = None,
                labels: Any = None,
                clear_old_points: bool = True,
                normalize_coords: bool = True,
                box: Any = None,
            ) -> None: ...

            def add_new_mask(self, inference_state: Any, frame_idx: int, obj_id: int, mask: Any) -> None: ...

        return Recorded


def test_sam_2_takes_them() -> None:
    predictor, state = video_predictor(), object()
    for prompt in tracecut.prompts(made()):
        inspect.signature(predictor.add_new_points_or_box).bind(predictor, state, **prompt.as_points_and_box())
        inspect.signature(predictor.add_new_mask).bind(predictor, state, **prompt.as_mask())
        assert prompt.points.shape == (len(prompt.labels), 2) and prompt.points.dtype == np.float32
        assert prompt.box.shape == (4,) and prompt.mask.ndim == 2
