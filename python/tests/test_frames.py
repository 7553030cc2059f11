"""Sources of frames, and the intake table."""

from __future__ import annotations

import io
import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tracecut
from conftest import ROOT, fails, write_video
from PIL import ExifTags, Image, ImageOps


def masks(frames: object) -> np.ndarray:
    return tracecut.segment(frames, preset="fast").array()  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def expected(clip: list[np.ndarray]) -> np.ndarray:
    """The masks of the clip."""
    found = masks(clip)
    assert found.any()
    return found


def test_any_array_of_the_same_pixels_gives_the_same_masks(clip: list[np.ndarray], expected: np.ndarray) -> None:
    whole = np.stack(clip)
    alpha = np.concatenate([whole, np.full((*whole.shape[:3], 1), 9, np.uint8)], axis=3)
    assert np.array_equal(masks(whole), expected)
    assert np.array_equal(masks(alpha), expected)
    assert np.array_equal(masks(iter(clip)), expected)
    # Neither row by row in memory, nor next to one another.
    assert np.array_equal(masks([np.asfortranarray(f) for f in clip]), expected)
    assert np.array_equal(masks([np.repeat(f, 2, axis=1)[:, ::2] for f in clip]), expected)
    assert np.array_equal(masks([Image.fromarray(f) for f in clip]), expected)
    assert np.array_equal(masks([Image.fromarray(f).quantize(256) for f in clip]).shape, expected.shape)


def test_grey_frames_give_the_masks_of_equal_colour_frames(clip: list[np.ndarray]) -> None:
    grey = [frame[..., 1] for frame in clip]
    expected = masks([np.repeat(g[..., None], 3, axis=2) for g in grey])
    assert np.array_equal(masks(np.stack(grey)), expected)
    assert np.array_equal(masks([g[..., None] for g in grey]), expected)


def test_folders_files_and_bytes_give_the_same_masks(expected: np.ndarray, folder: Path) -> None:
    files = [folder / f"frame{t}.png" for t in range(len(expected))]
    assert np.array_equal(masks(str(folder)), expected)
    assert np.array_equal(masks(files), expected)
    assert np.array_equal(masks(file.read_bytes() for file in files), expected)


@pytest.mark.parametrize(
    "names",
    [
        ["1.png", "02.png", "2.png", "10.png", "a-3.png", "a.png", "a1.png", "a1_2.png", "A1_10.png", "a2_1.png"],
        ["a.png", "B.png", "IMG_1.JPG", "img_2.jpg", "IMG_2.png", "IMG_3.JPG", "img_10.jpg", "IMG_11.JPG"],
    ],
)
def test_names_are_ordered_by_their_numbers_and_not_by_case(names: list[str]) -> None:
    assert tracecut.in_name_order(reversed(names)) == names


def test_hidden_files_and_folders_are_not_read_as_frames(
    folder: Path, expected: np.ndarray, tmp_path: Path
) -> None:
    clip = tmp_path / "copied"
    shutil.copytree(folder, clip)
    (clip / "._frame0.png").write_bytes(b"\0\5\x16\7\0\2\0\0Mac OS X        ")
    (clip / ".hidden.jpg").write_text("nothing")
    (clip / "frame99.png").mkdir()
    assert np.array_equal(masks(clip), expected)


def test_jpegs_are_decoded(clip: list[np.ndarray]) -> None:
    file = io.BytesIO()
    Image.fromarray(clip[0]).save(file, "JPEG", quality=95)
    ours = tracecut.boundaries(file.getvalue())
    assert ours.pb.shape == clip[0].shape[:2]
    assert np.abs(tracecut.as_array(file.getvalue()).astype(int) - clip[0]).mean() < 8


@pytest.mark.parametrize("kind", ["PNG", "JPEG"])
@pytest.mark.parametrize("mark", range(1, 9))
def test_images_are_upright_as_their_exif_orientation_says(mark: int, kind: str, clip: list[np.ndarray]) -> None:
    exif = Image.Exif()
    exif[ExifTags.Base.Orientation] = mark
    file = io.BytesIO()
    Image.fromarray(clip[0]).save(file, kind, exif=exif, quality=95)
    upright = np.asarray(ImageOps.exif_transpose(Image.open(file)))
    ours = tracecut.as_array(file.getvalue())
    assert ours.shape == upright.shape and np.abs(ours.astype(int) - upright).mean() < 2


def test_videos_are_read_by_pyav(clip: list[np.ndarray], expected: np.ndarray, tmp_path: Path) -> None:
    path = write_video(tmp_path / "clip.mkv", clip, "ffv1", "bgr0")
    read = list(tracecut.read_video(path))
    assert len(read) == len(clip) and all(np.array_equal(a, b) for a, b in zip(read, clip))
    assert np.array_equal(masks(path), expected)
    with path.open("rb") as file:
        assert np.array_equal(masks(file), expected)


@pytest.mark.parametrize(
    ("frames", "code", "message"),
    [
        ([np.zeros((4, 5))] * 2, "data", "frame is an array of float64 of shape (4, 5) (expected uint8"),
        ([np.zeros((4, 5, 2), np.uint8)] * 2, "data", "frame is an array of uint8 of shape (4, 5, 2)"),
        (np.zeros((4, 5), np.uint8), "data", "frames are an array of shape 4x5"),
        (np.zeros((4, 5, 3), np.uint8), "data", "frames are an array of shape 4x5x3 (expected (frames, height, width)"),
        ([np.zeros((0, 5), np.uint8)] * 2, "frame-size", "frame size 5x0 is not supported"),
        ([np.zeros((8, n), np.uint8) for n in (9, 10)], "frame-size-changed", "frame 1 is 10x8 (expected 9x8"),
        ([b"no image"], "decode", "image cannot be decoded"),
        ([np.broadcast_to(np.uint8(0), (10**6, 10**6))] * 2, "frame-size", "frame size 1000000x1000000 is not"),
        ([np.broadcast_to(np.uint8(0), (16384, 16384))] * 2, "too-large", "268435456 pixels in a frame (expected"),
    ],
)
def test_invalid_frames_are_refused(frames: object, code: str, message: str) -> None:
    with fails(code) as caught:
        masks(frames)
    assert str(caught.value).startswith(message)


def test_unreadable_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="nowhere"):
        tracecut.segment(tmp_path / "nowhere")
    with pytest.raises(tracecut.TraceCutError, match="has no images"):
        tracecut.segment(tmp_path)
    (tmp_path / "0.png").write_bytes(b"\x89PNG\r\n\x1a\nbroken")
    with pytest.raises(tracecut.TraceCutError, match=r"0\.png: image cannot be decoded"):
        tracecut.segment(tmp_path)


def test_errors_of_the_callers_iterator_are_raised(clip: list[np.ndarray]) -> None:
    def broken() -> object:
        yield from clip[:3]
        raise OSError("the camera is gone")

    with pytest.raises(OSError, match="the camera is gone"):
        masks(broken())


def test_a_session_continues_after_a_frame_above_a_limit() -> None:
    frames = [np.full((16, 20), 9 * t, np.uint8) for t in range(4)]
    session = tracecut.Session(clip={"max_pixels": 320, "max_frames": 3})
    for frame in frames[:3]:
        session.push(frame)
    for frame, name in [(frames[3], "clip.max_frames"), (np.zeros((17, 20), np.uint8), "clip.max_pixels")]:
        with fails("too-large", name):
            session.push(frame)
    session.run()
    assert session.labels(2).shape == (16, 20)
    with fails("too-large", r"320 pixels in a frame \(expected at most 300"):
        tracecut.boundaries(frames[0], clip={"max_pixels": 300})


TIME_TOLERANCE_S = 0.001
LEAST_OVERLAP = 0.8


def read_table() -> dict[str, Any]:
    """Writes the files of the table and returns it; one without cases where node or ffmpeg is missing."""
    if not (shutil.which("node") and shutil.which("ffmpeg")):
        return {"cases": []}
    command = ["node", str(ROOT / "tests" / "intake.mjs")]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


TABLE = read_table()


@pytest.mark.parametrize("row", TABLE["cases"], ids=lambda row: row["name"])
def test_a_file_of_the_intake_table(row: dict[str, Any]) -> None:
    path = Path(TABLE["folder"]) / row["file"]
    refusal = row.get("error") or row.get("except", {}).get("python")
    if not refusal and not row.get("isTruncated"):
        return check(row, tracecut.segment(path))
    with fails(refusal or "truncated", row.get("words")) as failure:
        tracecut.segment(path)
    if not refusal:
        check(row, failure.value.result)


@pytest.mark.skipif(not TABLE["cases"], reason="needs node and ffmpeg")
@pytest.mark.parametrize("file", ["sar.mp4", "vfr.mp4"])
def test_masks_match_the_command_line(file: str, cli: str, tmp_path: Path) -> None:
    path = Path(TABLE["folder"]) / file
    out = tmp_path / "out"
    subprocess.run([cli, "segment", path, "--out", out, "--format", "npz", "--quiet"], check=True)
    np.testing.assert_array_equal(tracecut.segment(path).array(), np.load(out / "masks.npz")["masks"])


def check(row: dict[str, Any], result: tracecut.Result) -> None:
    """Compares a result with the table."""
    clip = TABLE["clip"]
    assert result.array().shape == (row["numFrames"], clip["height"], clip["width"])
    if row["times"] is None:
        assert result.times is None
    else:
        np.testing.assert_allclose(result.times, row["times"], atol=TIME_TOLERANCE_S)
        if "lastDuration" in row:
            assert result.durations[-1] == pytest.approx(row["lastDuration"], abs=TIME_TOLERANCE_S)
    if row["masks"]:
        for k in (0, row["numFrames"] - 1):
            square = np.zeros((clip["height"], clip["width"]), bool)
            x, y = row["place"]["x"] + 3 * k, row["place"]["y"] + k
            square[y : y + clip["side"], x : x + clip["side"]] = True
            mask = result.labels(k) > 0
            assert (mask & square).sum() / (mask | square).sum() >= LEAST_OVERLAP, f"picture {k}"
