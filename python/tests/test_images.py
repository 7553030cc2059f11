"""Single images, pairs of them, made clips."""

from __future__ import annotations

import numpy as np
import pytest
import tracecut
from tracecut.synth import Scene


def halves() -> np.ndarray:
    """A dark and a bright half."""
    image = np.full((30, 40, 3), 60, np.uint8)
    image[:, 20:] = 180
    return image


def test_boundaries_are_where_the_image_changes() -> None:
    pb, thin = tracecut.boundaries(halves())
    assert pb.shape == thin.shape == (30, 40) and abs(int(pb[15].argmax()) - 20) <= 1
    assert np.all((thin == 0) | (thin == pb))


def test_superpixels_part_the_halves() -> None:
    cells = tracecut.superpixels(halves())
    assert not set(cells.label[:, :18].ravel()) & set(cells.label[:, 22:].ravel())
    assert tracecut.superpixels(halves(), count=1).count == 1
    with pytest.raises(tracecut.TraceCutError, match="count = 0"):
        tracecut.superpixels(halves(), count=0)


def test_the_embedding_of_pixels_breaks_between_the_halves() -> None:
    found = tracecut.image_discontinuities(halves(), still={"dimensions": 4})
    row = found.discontinuity[15]
    assert row[18:22].max() == row.max() and row[8] < 0.5 * row.max()
    assert len(found.eigenvalues) == 4 and found.combined.shape == found.spectral.shape == found.pb.shape


def test_flow_is_that_of_the_scene() -> None:
    scene = Scene("sample", 160, 90, 3, seed=2)
    found, true = tracecut.flow(scene[0], scene[1]), scene.flow(0)
    error = np.hypot(found.u - true.u, found.v - true.v)
    assert np.median(error) < 0.2
    with pytest.raises(tracecut.TraceCutError) as caught:
        tracecut.flow(scene[0], scene[1][:-1])
    assert caught.value.code == "frame-size-changed"


def test_made_clips_have_masks_and_refuse_what_is_not_legal() -> None:
    scene = Scene("two_walkers", 96, 64, 4)
    assert len(scene) == 4 and scene[0].shape == (64, 96, 3) and set(np.unique(scene.mask(3))) == {0, 1, 2}
    for options in ({"kind": "none"}, {"width": 0}, {"frames": -1}):
        with pytest.raises(tracecut.TraceCutError):
            Scene(**options)  # type: ignore[arg-type]
    with pytest.raises(IndexError):
        scene[4]
    with pytest.raises(tracecut.TraceCutError, match="t = 4"):
        scene.mask(4)
