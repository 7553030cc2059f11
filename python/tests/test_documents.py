"""The Python of all documents runs, the blocks of a document one after the other (test_types.py checks their types)."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import documents
import numpy as np
import pytest
import tracecut
from conftest import install_predictors, write_pictures, write_video

#: Blocks that need more than their package, and are run elsewhere.
ELSEWHERE = {
    "fiftyone": "FiftyOne needs its database; test_interchange.py runs its importer",
    "cv2": "test_recipes_run runs it",
    "torch.utils.data": "test_recipes_run runs it",
}

def test_the_documents_have_blocks_of_python() -> None:
    counts = {document: len(documents.blocks(document)) for document in documents.documents()}
    assert counts["README.md"] == 1 and counts["python/README.md"] >= 4 and counts["docs/interchange.md"] == 7
    (first,) = documents.blocks("README.md")
    assert 5 <= len([line for line in first.code.splitlines() if line.strip()]) <= 10


def write_clip(folder: Path) -> None:
    """Writes the frames of a clip as PNG files, and as a video."""
    frames = list(tracecut.synth.Scene("sample", 160, 90, 8, seed=1))
    write_pictures(folder / "frames", frames)
    write_video(folder / "clip.mp4", frames, "mpeg4", "yuv420p")


@pytest.fixture(scope="module")
def places(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, dict[str, Any]]]:
    """A folder for each document, and the names that its blocks have left so far."""
    found: dict[str, tuple[Path, dict[str, Any]]] = {}
    for document in documents.documents():
        if documents.blocks(document):
            folder = tmp_path_factory.mktemp("document")
            write_clip(folder)
            if document == "docs/interchange.md":
                # Annotation tools show these.
                frames = map(tracecut.read_image, sorted((folder / "frames").iterdir()))
                write_pictures(folder / "coco" / "images", frames, "{:05}.jpg")
            found[document] = (folder, {})
    return found


@pytest.mark.parametrize("block", documents.all_blocks(), ids=lambda block: f"{block.document}:{block.line + 1}")
def test_code_blocks_run_in_order(
    block: documents.Block, places: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, names = places[block.document]
    monkeypatch.chdir(folder)
    built = install_predictors(monkeypatch) if "sam" in block.code else []
    for module in documents.imports(block.code):
        if module in ELSEWHERE:
            pytest.skip(ELSEWHERE[module])
        if module.split(".")[0] not in sys.modules and importlib.util.find_spec(module.split(".")[0]) is None:
            pytest.skip(f"{module} is not installed")
    block.run(names)
    for predictor in built:
        assert {label for _, label in predictor.prompts} == {prompt.obj_id for prompt in names["prompts"]}
    if "result.save" in block.code:
        assert len(list((folder / "masks").glob("*.png"))) == 12


def python_with(module: str) -> str:
    """The interpreter of the environment or of the system, if it has this module."""
    for python in (sys.executable, "/usr/bin/python3"):
        if (
            shutil.which(python)
            and not subprocess.run([python, "-c", f"import {module}"], capture_output=True).returncode
        ):
            return python
    pytest.skip(f"{module} is not installed (PyTorch: `pip install torch`, or `apt-get install python3-torch`)")


@pytest.mark.long
@pytest.mark.parametrize(("module", "output"), [("cv2", "outlines.mp4"), ("torch", None)])
def test_recipes_run(module: str, output: str | None, tmp_path: Path) -> None:
    (block,) = (block for block in documents.blocks("docs/recipes.md") if f"import {module}\n" in block.code)
    python = python_with(module)
    write_clip(tmp_path)
    (tmp_path / "recipe.py").write_text(block.code)
    search = os.pathsep.join([str(Path(tracecut.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "PYTHONPATH": search}
    ran = subprocess.run([python, "recipe.py"], cwd=tmp_path, capture_output=True, text=True, env=environment)
    assert ran.returncode == 0, ran.stderr
    if output is None:
        shapes = "torch.Size([4, 3, 90, 160]) torch.Size([4, 90, 160])\n"
        assert ran.stdout == 2 * shapes
        return
    before, after = list(tracecut.read_video(tmp_path / "clip.mp4")), list(tracecut.read_video(tmp_path / output))
    result = tracecut.segment(tmp_path / "clip.mp4")
    assert result.objects and len(after) == len(before) == 8
    import cv2

    for frame, outlined, mask in zip(before, after, result):
        # Yellow along the objects' borders, and no change far from them.
        inside, square = (mask > 0).astype(np.uint8), np.ones((3, 3), np.uint8)
        border = inside > cv2.erode(inside, square)
        far = cv2.dilate(border.astype(np.uint8), square, iterations=12) == 0
        red, green, blue = (outlined[..., k].astype(int) for k in range(3))
        assert border.any() and np.median((np.minimum(red, green) - blue)[border]) > 100
        assert abs(outlined[far].astype(int) - frame[far]).mean() < 8
