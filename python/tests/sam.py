"""SAM 2 and SAM 3, or classes with the signatures of SAM 2 1.1.0 and of SAM 3 where they are not installed."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import numpy as np
import pytest


class Recorded:
    """A predictor that notes its prompts."""

    def __init__(self) -> None:
        self.prompts: list[tuple[int, int]] = []
        self.detector = self.backbone = self

    @property
    def tracker(self) -> Recorded:
        return self

    def init_state(self, video_path: str) -> dict[str, Any]:
        return {"video_path": video_path}

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
    ) -> None:
        self.prompts.append((frame_idx, obj_id))

    def add_new_mask(self, inference_state: Any, frame_idx: int, obj_id: int, mask: Any) -> None:
        assert mask.dtype == bool
        self.prompts.append((frame_idx, obj_id))

    def propagate_in_video(self, inference_state: Any, reverse: bool = False) -> Iterator[tuple[int, list[int], Any]]:
        yield 0, [obj for _, obj in self.prompts], np.zeros((len(self.prompts), 1, 4, 6), np.float32)


def video_predictor() -> Any:
    """The class of SAM 2's video predictor."""
    try:
        from sam2.sam2_video_predictor import SAM2VideoPredictor

        return SAM2VideoPredictor
    except ImportError:
        return Recorded


def install(monkeypatch: pytest.MonkeyPatch) -> list[Recorded]:
    """Replaces the models by recorders, and PyTorch's one function that is used; returns the recorders."""
    built: list[Recorded] = []

    def build(*_: str) -> Recorded:
        built.append(Recorded())
        return built[-1]

    for name, function in [
        ("sam2.build_sam", ("build_sam2_video_predictor", build)),
        ("sam3.model_builder", ("build_sam3_video_model", build)),
        ("torch", ("from_numpy", lambda array: array)),
    ]:
        module = ModuleType(name)
        setattr(module, *function)
        monkeypatch.setitem(sys.modules, name.split(".")[0], ModuleType(name.split(".")[0]))
        monkeypatch.setitem(sys.modules, name, module)
    return built
