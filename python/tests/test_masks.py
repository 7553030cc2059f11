"""Masks as runs, as COCO segmentations, as PNG files."""

from __future__ import annotations

import io

import numpy as np
import pytest
import tracecut
from PIL import Image
from tracecut._masks import Runs

SHAPES = [(1, 1), (1, 7), (5, 1), (13, 31), (90, 160)]


def made(shape: tuple[int, int], seed: int) -> np.ndarray:
    """Blobs of several labels."""
    random = np.random.default_rng(seed)
    coarse = random.integers(0, 4, (shape[0] // 5 + 1, shape[1] // 5 + 1), dtype=np.uint8)
    return np.ascontiguousarray(np.kron(coarse, np.ones((5, 5), np.uint8))[: shape[0], : shape[1]])


@pytest.mark.parametrize("shape", SHAPES)
def test_runs_give_the_mask_again(shape: tuple[int, int]) -> None:
    for mask in (made(shape, 1), np.zeros(shape, np.uint8), np.full(shape, 255, np.uint8)):
        runs = Runs(mask)
        assert np.array_equal(runs.mask(), mask) and runs.mask().dtype == np.uint8
        assert np.array_equal(runs.areas(), np.bincount(mask.ravel(), minlength=256))


@pytest.mark.parametrize("shape", SHAPES)
def test_coco_segmentations_are_those_of_pycocotools(shape: tuple[int, int]) -> None:
    from pycocotools import mask as coco

    for label in range(4):
        mask = made(shape, label)
        ours = tracecut.coco_rle(mask, label)
        theirs = coco.encode(np.asfortranarray(mask == label).astype(np.uint8))
        assert ours["counts"].encode() == theirs["counts"] and ours["size"] == list(theirs["size"])
        for segmentation in (ours, theirs):
            assert np.array_equal(tracecut.from_coco_rle(segmentation), mask == label)


def test_a_list_of_lengths_is_a_segmentation() -> None:
    mask = tracecut.from_coco_rle({"size": [2, 3], "counts": [1, 2, 3]})
    assert mask.tolist() == [[False, True, False], [True, False, False]]


@pytest.mark.parametrize(
    "segmentation",
    [
        {},
        {"size": [2, 3], "counts": [1, 2]},
        {"size": [2, 3], "counts": [-1, 7]},
        {"size": [2, 3], "counts": "\x00"},
        {"size": [2, 3], "counts": "P"},
        {"size": [2], "counts": [6]},
    ],
)
def test_what_is_no_segmentation_is_refused(segmentation: dict[str, object]) -> None:
    with pytest.raises(tracecut.TraceCutError) as caught:
        tracecut.from_coco_rle(segmentation)
    assert caught.value.code == "data"


def test_a_png_holds_the_labels_and_the_colours_of_the_benchmarks() -> None:
    mask = made((13, 31), 5)
    image = Image.open(io.BytesIO(tracecut.mask_png(mask)))
    assert image.mode == "P" and np.array_equal(np.asarray(image), mask)
    assert image.getpalette()[:12] == [0, 0, 0, 128, 0, 0, 0, 128, 0, 128, 128, 0]  # type: ignore[index]
    with pytest.raises(tracecut.TraceCutError):
        tracecut.mask_png(np.zeros((2, 2)))  # type: ignore[arg-type]
