"""Fixtures and helpers of several test files."""

from __future__ import annotations

import json
import os
import shutil
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import tracecut
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]


def golden(name: str) -> dict[str, Any]:
    """Returns a golden file, which the tests of Rust and of JavaScript compare with too."""
    return json.loads((ROOT / "tests" / "data" / f"golden-{name}.json").read_text())


def fnv1a(mask: np.ndarray) -> str:
    """Returns the hash of a mask as in the golden files."""
    value = 0x811C9DC5
    for byte in mask.tobytes():
        value = (value ^ byte) * 0x01000193 & 0xFFFFFFFF
    return f"{value:08x}"


@contextmanager
def fails(code: str, message: str | None = None) -> Iterator[pytest.ExceptionInfo[tracecut.TraceCutError]]:
    """Asserts that the block raises an error with this code, and a text in which the pattern is found."""
    with pytest.raises(tracecut.TraceCutError, match=message) as caught:
        yield caught
    assert caught.value.code == code


@pytest.fixture(scope="session")
def clip() -> list[np.ndarray]:
    """Eight frames of a synthetic clip, 96 by 64 pixels."""
    return list(tracecut.synth.Scene("sample", 96, 64, 8, seed=3))


@pytest.fixture(scope="session")
def done(clip: list[np.ndarray]) -> tracecut.Session:
    """A finished session over `clip`; tests do not change it."""
    session = tracecut.Session()
    session.push_all(clip)
    session.run()
    return session


@pytest.fixture(scope="session")
def folder(clip: list[np.ndarray], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the frames of `clip` as PNG files."""
    out = write_pictures(tmp_path_factory.mktemp("clip") / "frames", clip, "frame{}.png")
    (out / "notes.txt").write_text("no frame")
    return out


def write_video(path: Path, frames: Sequence[np.ndarray], codec: str, pixels: str, **options: str) -> Path:
    """Writes a video of 25 pictures a second."""
    av = pytest.importorskip("av")
    with av.open(str(path), "w") as out:
        stream = out.add_stream(codec, rate=25, options=options)
        stream.height, stream.width = frames[0].shape[:2]
        stream.pix_fmt = pixels
        for frame in frames:
            out.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="rgb24")))
        out.mux(stream.encode(None))
    return path


def write_pictures(folder: Path, frames: Iterable[np.ndarray], name: str = "{:05}.png") -> Path:
    """Writes each frame as a file, in a new folder."""
    folder.mkdir(parents=True)
    for t, frame in enumerate(frames):
        Image.fromarray(frame).save(folder / name.format(t))
    return folder


@pytest.fixture(scope="session")
def cli() -> str:
    """The program of the command line: the environment's TRACECUT_CLI, or the newest that was built here."""
    built = [ROOT / "target" / profile / "tracecut" for profile in ("quick", "release", "debug")]
    found = sorted((p for p in built if p.is_file()), key=lambda p: p.stat().st_mtime)
    path = os.environ.get("TRACECUT_CLI") or (str(found[-1]) if found else shutil.which("tracecut"))
    if not path:
        pytest.skip("no command line was built: cargo build --profile quick -p tracecut-cli")
    return path


class PredictorStandIn:
    """Stands in for SAM 2 and SAM 3 with the signatures of SAM 2 1.1.0 and of SAM 3, and notes its prompts."""

    def __init__(self) -> None:
        self.prompts: list[tuple[int, int]] = []
        self.detector = self.backbone = self

    @property
    def tracker(self) -> PredictorStandIn:
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
    """The class of SAM 2's video predictor, or the stand-in where SAM 2 is not installed."""
    try:
        from sam2.sam2_video_predictor import SAM2VideoPredictor

        return SAM2VideoPredictor
    except ImportError:
        return PredictorStandIn


def install_predictors(monkeypatch: pytest.MonkeyPatch) -> list[PredictorStandIn]:
    """Replaces the models by stand-ins, and PyTorch's one function that is used; returns the stand-ins."""
    built: list[PredictorStandIn] = []

    def build(*_: str) -> PredictorStandIn:
        built.append(PredictorStandIn())
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
