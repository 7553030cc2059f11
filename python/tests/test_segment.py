"""Clips to masks: the same bits as from Rust, JavaScript and the command line."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import tracecut
from conftest import fnv1a, golden
from PIL import Image
from tracecut.synth import Scene


@pytest.mark.parametrize("name", ["odd", "sample"])
def test_masks_are_those_of_rust_and_javascript(name: str) -> None:
    expected = golden(name)
    scene = expected["scene"]
    clip = Scene("sample", scene["width"], scene["height"], scene["frames"], scene["seed"])
    result = tracecut.segment(clip)
    assert [fnv1a(mask) for mask in result] == expected["masks"]
    assert result.session is not None
    clusters = result.session.clusters()
    assert clusters is not None
    assert clusters.label.tolist() == expected["label"]


def test_windows_are_those_of_rust_and_javascript() -> None:
    expected = golden("windows")
    scene = expected["scene"]
    frames = (
        frame
        for shot in scene["shots"]
        for frame in Scene("sample", shot["width"], shot["height"], shot["frames"], shot["seed"])
    )
    parts = tracecut.windows(frames, window=scene["window"], overlap=scene["overlap"])
    for part, window in zip(parts, expected["windows"]):
        place = (part.index, part.shot, part.first_frame)
        assert place == (window["index"], window["shot"], window["firstFrame"])
        assert part.settled == range(part.first_frame + window["from"], part.first_frame + window["to"])
        assert [fnv1a(part.labels(t)) for t in part.settled] == window["masks"]
    assert next(parts, None) is None


@pytest.mark.parametrize("setting", [None, ("clip.maxSide", 96)])
def test_masks_are_those_of_the_command_line(
    cli: str, folder: Path, tmp_path: Path, setting: tuple[str, int] | None
) -> None:
    chosen = ["--set", f"{setting[0]}={setting[1]}"] if setting else []
    subprocess.run([cli, "segment", folder, "--out", tmp_path, *chosen], check=True, capture_output=True)
    result = tracecut.segment(folder, **({"clip": {"max_side": setting[1]}} if setting else {}))
    assert len(result) == 12 and result.objects
    for t, mask in enumerate(result):
        assert np.array_equal(mask, np.asarray(Image.open(tmp_path / "masks" / f"{t:05}.png")))


def test_windows_settle_each_frame_once_and_keep_no_more() -> None:
    clip = Scene("sample", 96, 64, 20, seed=2)
    settled: list[int] = []
    earlier: tracecut.Window | None = None
    for part in tracecut.windows(clip, window=8, overlap=3, clip={"max_side": 64}):
        settled += part.settled
        assert part.labels(part.settled[0]).shape == (64, 96)
        assert part.session.working_labels(0).shape == (43, 64)
        with pytest.raises(tracecut.TraceCutError, match="a frame of the window"):
            part.labels(part.first_frame - 1)
        if earlier is not None:
            with pytest.raises(tracecut.TraceCutError, match="the next window was asked for") as caught:
                earlier.labels(earlier.settled[0])
            assert caught.value.code == "state"
        earlier = part
    assert settled == list(range(20))
    assert earlier is not None and earlier.labels(19).shape == (64, 96)


def test_threads_windows_and_all_at_once_give_the_same_bits(clip: list[np.ndarray]) -> None:
    expected = tracecut.segment(clip).array()
    for options in ({"threads": 1}, {"threads": 3}, {"window": None}, {"window": 8, "overlap": 2}):
        assert np.array_equal(tracecut.segment(clip, **options).array(), expected), options


def test_borders_of_reduced_frames_come_to_those_of_the_source() -> None:
    clip = Scene("sample", 160, 90, 6, seed=4)
    small = {"max_side": 80}
    by_windows, at_once = (tracecut.segment(clip, window=w, clip=small) for w in (50, None))
    assert np.array_equal(by_windows.array(), at_once.array())
    assert at_once.session is not None
    coarse = at_once.session.labels(0)
    assert coarse.shape == by_windows[0].shape and not np.array_equal(coarse, by_windows[0])
    enlarged = tracecut.enlarge(at_once.session.working_labels(0), clip[0])
    assert np.array_equal(enlarged.labels, by_windows[0])


def test_a_result_tells_of_its_masks(clip: list[np.ndarray], tmp_path: Path) -> None:
    result = tracecut.segment(clip)
    masks = result.array()
    assert masks.shape == (8, 64, 96) and masks.dtype == np.uint8 and (result.width, result.height) == (96, 64)
    assert result.objects == [int(v) for v in np.unique(masks) if v]
    assert np.array_equal(result.areas()[2], np.bincount(masks[2].ravel(), minlength=256))
    assert result.shots == [0] and result.trajectories is not None
    paths = result.save(tmp_path / "masks")
    assert len(paths) == 8 and np.array_equal(np.asarray(Image.open(paths[7])), masks[7])
    for label, segmentation in result.coco(3).items():
        assert np.array_equal(tracecut.from_coco_rle(segmentation), masks[3] == label)


def camouflaged_square(width: int = 120, height: int = 90, side: int = 30) -> list[np.ndarray]:
    """A square that moves over a ground of the same grey texture: its trajectories are found, its pixels are not."""

    def texture(rows: int, columns: int, seed: int) -> np.ndarray:
        noise = np.random.default_rng(seed).normal(128, 60, (rows + 2, columns + 2))
        smooth = sum(noise[y : y + rows, x : x + columns] for y in range(3) for x in range(3)) / 9
        return np.clip(smooth, 0, 255).astype(np.uint8)

    ground, square = texture(height, width, 1), texture(side, side, 2)
    frames = []
    for t in range(10):
        frame = ground.copy()
        frame[20 + t : 20 + t + side, 24 + 3 * t : 24 + 3 * t + side] = square
        frames.append(frame)
    return frames


def test_an_object_without_pixels_is_none() -> None:
    result = tracecut.segment(camouflaged_square())
    assert result.session is not None
    of_clusters = result.session.objects()
    assert of_clusters is not None and of_clusters.max() == 1, "the clip has lost what it is for"
    assert result.objects == [] and result.as_json()["objects"] == [] and result.coco(0) == {}
    assert len(result.session.object_table().splitlines()) == 1 and tracecut.prompts(result) == []


def test_a_cut_begins_a_shot() -> None:
    frames = [*Scene("sample", 96, 64, 6, seed=1), *Scene("sample", 96, 64, 6, seed=7)]
    assert tracecut.segment(frames).shots == [0, 6]
    assert tracecut.segment(frames, window=4, overlap=1).shots == [0, 6]
    assert tracecut.segment(frames, shot={"unmatched": 1.0}).shots == [0]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"flow": {"patch_stride": 99}}, "flow.patch_stride = 99 (expected a whole number, 1..=8)"),
        ({"flow.patch_stride": 2.5}, "flow.patch_stride = 2.5 (expected a whole number, 1..=8)"),
        ({"clip": {"dense": 1}}, "clip.dense = 1 (expected true or false)"),
        ({"preset": "best"}, 'preset = "best" (expected default, fast or paper)'),
        ({"flow": {"patch_stridde": 5}}, "flow.patch_stridde = 5 (expected a known parameter, such as flow.patch_stri"),
        ({"window": 1}, "window = 1 (expected a whole number of frames, 2..=400)"),
        ({"window": -5}, "window = -5 (expected a whole number of frames)"),
        ({"window": 8, "overlap": 8}, "overlap = 8 (expected a whole number of frames, 1..=7)"),
        ({"threads": 0}, "threads = 0 (expected a whole number, 1..=256)"),
    ],
)
def test_bad_parameters_are_named(clip: list[np.ndarray], options: dict[str, object], message: str) -> None:
    with pytest.raises(tracecut.TraceCutError) as caught:
        tracecut.segment(clip, **options)  # type: ignore[arg-type]
    assert caught.value.code == "param" and str(caught.value).startswith(message)


@pytest.mark.parametrize("count", [0, 1])
def test_motion_needs_two_frames(clip: list[np.ndarray], count: int) -> None:
    for window in (50, None):
        with pytest.raises(tracecut.TraceCutError, match=f"{count} frame") as caught:
            tracecut.segment(clip[:count], window=window)
        assert caught.value.code == "too-few-frames"


def test_parameters_are_listed_and_can_be_set() -> None:
    shown, expert = tracecut.parameters(), tracecut.parameters(expert=True)
    names = {p.name: p for p in shown + expert}
    assert len(shown) <= 20 and len(names) == len(shown) + len(expert)
    stride = names["flow.patch_stride"]
    assert (stride.kind, stride.low, stride.high) == ("integer", 1, 8) and "patch" in stride.doc.lower()
    in_force = tracecut.Session(**{name: p.default for name, p in names.items()}).params
    assert in_force == tracecut.Session().params
    for name, parameter in names.items():
        section, field = name.split(".")
        assert in_force[section][field] == parameter.default, name
    numbers = {"max_side": np.int64(100), "dense": np.bool_(False)}
    assert tracecut.Session(clip=numbers).params["clip"] == {**in_force["clip"], "max_side": 100, "dense": False}


def test_the_module_runs_as_a_program(folder: Path, tmp_path: Path) -> None:
    def program(*words: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "tracecut", *map(str, words)]
        return subprocess.run(command, capture_output=True, text=True)

    done = program(folder, "--out", tmp_path / "masks", "--set", "preset=fast", "--set", "clip.max_side=100")
    assert done.returncode == 0 and done.stdout.startswith("12 frames of 160x90: ")
    expected = tracecut.segment(folder, preset="fast", clip={"max_side": 100})
    for t, mask in enumerate(expected):
        assert np.array_equal(mask, np.asarray(Image.open(tmp_path / "masks" / f"{t:05}.png")))
    failed = program(folder, "--out", tmp_path, "--set", "clip.max_side=1")
    assert failed.returncode == 2 and failed.stderr.startswith("error: clip.max_side = 1 (expected")
