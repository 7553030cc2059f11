"""Segments clips to the bits of Rust, JavaScript and the command line; exports of masks; single images."""

from __future__ import annotations

import copy
import inspect
import io
import json
import multiprocessing
import pickle
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tracecut
from conftest import fails, fnv1a, golden, video_predictor
from PIL import Image
from tracecut._masks import Runs
from tracecut.synth import Scene


@pytest.mark.parametrize("name", ["odd", "sample"])
def test_masks_match_rust_and_javascript(name: str) -> None:
    expected = golden(name)
    scene = expected["scene"]
    clip = Scene("sample", scene["width"], scene["height"], scene["frames"], scene["seed"])
    result = tracecut.segment(clip)
    assert [fnv1a(mask) for mask in result] == expected["masks"]
    clusters = result.session.clusters()
    assert clusters.label.tolist() == expected["label"]


def test_windows_match_rust_and_javascript() -> None:
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


def test_masks_match_the_command_line(cli: str, folder: Path, tmp_path: Path) -> None:
    command = [cli, "segment", folder, "--out", tmp_path, "--set", "clip.maxSide=80"]
    subprocess.run(command, check=True, capture_output=True)
    result = tracecut.segment(folder, clip={"max_side": 80})
    assert len(result) == 8 and result.objects
    for t, mask in enumerate(result):
        assert np.array_equal(mask, np.asarray(Image.open(tmp_path / "masks" / f"{t:05}.png")))


def test_windows_settle_each_frame_once_and_drop_earlier_ones() -> None:
    clip = Scene("sample", 96, 64, 12, seed=2)
    settled: list[int] = []
    earlier: tracecut.Window | None = None
    for part in tracecut.windows(clip, window=6, overlap=2, clip={"max_side": 64}, preset="fast"):
        settled += part.settled
        assert part.labels(part.settled[0]).shape == (64, 96)
        assert part.session.working_labels(0).shape == (43, 64)
        with pytest.raises(tracecut.TraceCutError, match="a frame of the window"):
            part.labels(part.first_frame - 1)
        if earlier is not None:
            with fails("state", "the next window was asked for"):
                earlier.labels(earlier.settled[0])
        earlier = part
    assert settled == list(range(12))
    assert earlier is not None and earlier.labels(11).shape == (64, 96)


def test_threads_and_windows_do_not_change_masks(clip: list[np.ndarray]) -> None:
    expected = tracecut.segment(clip, preset="fast").array()
    for options in ({"threads": 1}, {"threads": 3}, {"window": None}, {"window": 8, "overlap": 2}):
        assert np.array_equal(tracecut.segment(clip, preset="fast", **options).array(), expected), options


def test_masks_of_reduced_frames_are_refined_at_the_size_of_the_source() -> None:
    clip = Scene("sample", 160, 90, 6, seed=4)
    small = {"max_side": 80}
    by_windows, at_once = (tracecut.segment(clip, window=w, clip=small) for w in (50, None))
    assert np.array_equal(by_windows.array(), at_once.array())
    coarse = at_once.session.labels(0)
    assert coarse.shape == by_windows[0].shape and not np.array_equal(coarse, by_windows[0])
    enlarged = tracecut.enlarge(at_once.session.working_labels(0), clip[0])
    assert np.array_equal(enlarged.labels, by_windows[0])


def test_a_result_has_objects_areas_shots_and_files(clip: list[np.ndarray], tmp_path: Path) -> None:
    result = tracecut.segment(clip)
    masks = result.array()
    assert masks.shape == (8, 64, 96) and masks.dtype == np.uint8 and (result.width, result.height) == (96, 64)
    assert result.objects == [int(v) for v in np.unique(masks) if v]
    assert np.array_equal(result.areas()[2], np.bincount(masks[2].ravel(), minlength=256))
    assert result.shots == [0] and len(result.trajectories) > 0
    paths = result.save(tmp_path / "masks")
    assert len(paths) == 8 and np.array_equal(np.asarray(Image.open(paths[7])), masks[7])
    for label, segmentation in result.coco(3).items():
        assert np.array_equal(tracecut.from_coco_rle(segmentation), masks[3] == label)


def test_frames_are_indexed_as_in_numpy(clip: list[np.ndarray]) -> None:
    result = tracecut.segment(clip, preset="fast")
    masks = result.array()
    for place in (slice(2, 4), slice(None, None, -2), slice(-3, None), slice(6, 2), slice(None), slice(5, 99)):
        assert np.array_equal(result[place], masks[place]) and result[place].dtype == np.uint8
        assert result[place].shape == masks[place].shape
    for t in (-1, -8, np.int64(3), np.uint8(7)):
        assert np.array_equal(result[t], masks[t]) and np.array_equal(result.labels(t), masks[t])
        assert result.png(t) == tracecut.mask_png(masks[t]) and result.coco(t).keys() == set(np.unique(masks[t])) - {0}
    for t in (8, -9, 10**30):
        for call in (result.__getitem__, result.labels, result.coco, result.png):
            with pytest.raises(IndexError, match=rf"t = {t} \(expected a frame, -8\.\.=7\)") as caught:
                call(t)
            assert isinstance(caught.value, tracecut.TraceCutError) and caught.value.code == "param"
    scene = Scene("sample", 96, 64, 8, seed=3)
    assert np.array_equal(scene[-2:], clip[-2:]) and np.array_equal(scene[-1], clip[-1])
    assert scene[5:2].shape == (0, 64, 96, 3) and np.array_equal(scene.mask(-8), scene.mask(0))
    assert np.array_equal(scene.flow(-2).u, scene.flow(6).u)


def test_negative_frames_count_from_the_end_everywhere(done: tracecut.Session) -> None:
    session = done
    for name in ("labels", "working_labels", "cluster_labels", "background", "saliency_map"):
        assert np.array_equal(getattr(session, name)(-2), getattr(session, name)(6)), name
    assert np.array_equal(session.flow(-2).u, session.flow(6).u)
    assert np.array_equal(session.superpixels(-1).label, session.superpixels(7).label)
    assert np.array_equal(session.boundaries(-1).pb, session.boundaries(7).pb)
    assert session.explain(-1, 5, 5) == session.explain(7, 5, 5)
    tracks = session.trajectories()
    assert np.array_equal(tracks.at(-1), tracks.at(7)) and np.array_equal(tracks.alive(-3), tracks.alive(5))
    assert np.array_equal(tracks.points(-1), tracks.points(len(tracks) - 1))
    corrected = [tracecut.Session(preset="fast") for _ in range(2)]
    for each, t in zip(corrected, (-1, 7)):
        each.push_all(Scene("sample", 96, 64, 8, seed=3))
        each.run()
        y, x = (int(v) for v in np.argwhere(each.labels(7) == 1).mean(axis=0))
        each.split(1, at=(t, x, y))
        each.run()
        each.apart([tracecut.Stroke(t, [(x, y)]), tracecut.Stroke(t, [(2, 2)])])
        each.run()
    assert all(np.array_equal(corrected[0].labels(t), corrected[1].labels(t)) for t in range(8))


def test_copies_of_a_result_have_its_data_without_its_session(clip: list[np.ndarray]) -> None:
    result = tracecut.segment(clip, preset="fast")
    tracks = result.trajectories
    for copied in (pickle.loads(pickle.dumps(result)), copy.deepcopy(result), copy.copy(result)):
        assert np.array_equal(copied.array(), result.array()) and copied.objects == result.objects
        assert copied.as_json() == result.as_json() and repr(copied) == repr(result)
        assert np.array_equal(copied.trajectories.x, tracks.x)
        again = pickle.loads(pickle.dumps(copied))
        for orphan in (copied, again):
            with pytest.raises(
                tracecut.TraceCutError, match="a copy of a result has no session.*before you copy"
            ) as caught:
                orphan.session.explain(0, 0, 0)
            assert caught.value.code == "state"
    assert len(pickle.dumps(result)) < 1.2 * (tracks.x.nbytes * 2 + tracks.offset.nbytes * 3) + 100_000
    assert result.session.num_frames == 8, "the first one keeps its session"
    long = tracecut.segment(clip, window=6, overlap=2, preset="fast")
    for each in (long, pickle.loads(pickle.dumps(long))):
        for name in ("session", "trajectories"):
            with pytest.raises(tracecut.TraceCutError, match="several windows has no session.*tracecut.windows"):
                getattr(each, name)


def test_a_pool_of_processes_segments_clips() -> None:
    clips = [Scene("sample", 96, 64, 4, seed=seed) for seed in range(2)]
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        results = list(pool.map(tracecut.segment, clips))
        with pytest.raises(FileNotFoundError, match="nowhere") as caught:
            pool.submit(tracecut.segment, "nowhere").result()
    assert isinstance(caught.value, tracecut.TraceCutError) and caught.value.filename == "nowhere"
    for clip, result in zip(clips, results):
        assert np.array_equal(result.array(), tracecut.segment(clip).array())


@pytest.mark.parametrize("make", [copy.deepcopy, pickle.dumps])
def test_sessions_and_videos_are_not_copied(make: Callable[[Any], Any], clip: list[np.ndarray], tmp_path: Path) -> None:
    window = next(tracecut.windows(clip, preset="fast"))
    for thing in (window, window.session, tracecut.Session()):
        with pytest.raises(TypeError, match="a session stays in its process.*read what you need") as caught:
            make(thing)
        assert isinstance(caught.value, tracecut.TraceCutError)
    pytest.importorskip("av")
    (tmp_path / "a.mp4").write_bytes(b"no video")
    with pytest.raises(tracecut.TraceCutError, match="pass its path instead"):
        make(tracecut.read_video(tmp_path / "a.mp4"))


def camouflaged_square(width: int = 120, height: int = 90, side: int = 30) -> list[np.ndarray]:
    """A square that moves over a ground of the same grey texture: without faint contours only its trajectories are found."""

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


def test_an_object_without_pixels_is_not_listed() -> None:
    result = tracecut.segment(camouflaged_square(), contour={"min_share": 0.0})
    of_clusters = result.session.objects()
    assert of_clusters.max() == 1, "the clip no longer has an object without pixels"
    assert result.objects == [] and result.as_json()["objects"] == [] and result.coco(0) == {}
    assert len(result.session.object_table().splitlines()) == 1 and tracecut.prompts(result) == []


def test_a_cut_begins_a_shot() -> None:
    frames = [*Scene("sample", 96, 64, 6, seed=1), *Scene("sample", 96, 64, 6, seed=7)]
    for options, shots in (({}, [0, 6]), ({"window": 4, "overlap": 1}, [0, 6]), ({"shot": {"max_unmatched": 1.0}}, [0])):
        assert tracecut.segment(frames, preset="fast", **options).shots == shots


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"flow": {"patch_stride": 99}}, "flow.patch_stride = 99 (expected a whole number, 1..=8)"),
        ({"flow.patch_stride": 2.5}, "flow.patch_stride = 2.5 (expected a whole number, 1..=8)"),
        ({"clip": {"dense": 1}}, "clip.dense = 1 (expected true or false)"),
        ({"preset": "best"}, 'preset = "best" (expected default, fast or paper)'),
        ({"flow": {"patch_stridde": 5}}, "flow.patch_stridde = 5 (expected a known parameter, such as flow.patch_stri"),
        ({"window": 1}, "window = 1 (expected a whole number of frames, 2..=400)"),
        ({"window": -5}, "window = -5 (expected a whole number of frames, 2..=400)"),
        ({"window": 8, "overlap": 8}, "overlap = 8 (expected a whole number of frames, 1..=7)"),
        ({"threads": 0}, "threads = 0 (expected a whole number, 1..=256)"),
    ],
)
def test_bad_parameters_are_named(clip: list[np.ndarray], options: dict[str, object], message: str) -> None:
    with fails("param") as caught:
        tracecut.segment(clip, **options)  # type: ignore[arg-type]
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize("count", [0, 1])
def test_motion_needs_two_frames(clip: list[np.ndarray], count: int) -> None:
    for window in (50, None):
        with fails("too-few-frames", f"{count} frame"):
            tracecut.segment(clip[:count], window=window)


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


RUN = """
import resource, sys, time
import tracecut

frames, window, width, height = map(int, sys.argv[1:])
scene = tracecut.synth.Scene("sample", width, height, frames)
begin = time.perf_counter()
result = tracecut.segment(iter(scene), window=window)
seconds = time.perf_counter() - begin
assert len(result) == frames and len(result.shots) == 1, result
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024, round(seconds))
"""


def peak(frames: int, window: int, width: int, height: int) -> int:
    """The peak of resident memory in MiB of a process that segments a synthetic clip."""
    command = [sys.executable, "-c", RUN, *map(str, (frames, window, width, height))]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    print(f"{frames} frames of {width}x{height} in windows of {window}: {text.split()[0]} MiB, {text.split()[1]} s")
    return int(text.split()[0])


@pytest.mark.wheel
def test_a_longer_clip_takes_hardly_more_memory() -> None:
    assert peak(120, 12, 160, 90) <= 1.3 * peak(24, 12, 160, 90)


@pytest.mark.long
def test_1500_frames_of_640x360_take_hardly_more_memory_than_150() -> None:
    assert peak(1500, 50, 640, 360) <= 1.3 * peak(150, 50, 640, 360)


def halves() -> np.ndarray:
    """A dark and a bright half."""
    image = np.full((30, 40, 3), 60, np.uint8)
    image[:, 20:] = 180
    return image


def test_boundaries_are_where_the_image_changes() -> None:
    pb, thin = tracecut.boundaries(halves())
    assert pb.shape == thin.shape == (30, 40) and abs(int(pb[15].argmax()) - 20) <= 1
    assert np.all((thin == 0) | (thin == pb))


def test_superpixels_separate_the_halves() -> None:
    cells = tracecut.superpixels(halves())
    assert not set(cells.label[:, :18].ravel()) & set(cells.label[:, 22:].ravel())
    assert tracecut.superpixels(halves(), count=1).count == 1
    with pytest.raises(tracecut.TraceCutError, match="count = 0"):
        tracecut.superpixels(halves(), count=0)


def test_discontinuities_are_between_the_halves() -> None:
    found = tracecut.image_discontinuities(halves(), still={"dimensions": 4})
    row = found.discontinuity[15]
    assert row[18:22].max() == row.max() and row[8] < 0.5 * row.max()
    assert len(found.eigenvalues) == 4 and found.combined.shape == found.spectral.shape == found.pb.shape


def test_flow_matches_the_scene() -> None:
    scene = Scene("sample", 160, 90, 3, seed=2)
    found, true = tracecut.flow(scene[0], scene[1]), scene.flow(0)
    error = np.hypot(found.u - true.u, found.v - true.v)
    assert np.median(error) < 0.2
    with fails("frame-size-changed"):
        tracecut.flow(scene[0], scene[1][:-1])


def test_synthetic_clips_have_masks_and_refuse_illegal_arguments() -> None:
    scene = Scene("two_walkers", 96, 64, 4)
    assert len(scene) == 4 and scene[0].shape == (64, 96, 3) and set(np.unique(scene.mask(3))) == {0, 1, 2}
    for options in ({"kind": "none"}, {"width": 0}, {"frames": -1}):
        with pytest.raises(tracecut.TraceCutError):
            Scene(**options)  # type: ignore[arg-type]
    with pytest.raises(IndexError):
        scene[4]
    with pytest.raises(tracecut.TraceCutError, match="t = 4"):
        scene.mask(4)


SHAPES = [(1, 1), (1, 7), (5, 1), (13, 31), (90, 160)]


def random_mask(shape: tuple[int, int], seed: int) -> np.ndarray:
    """Returns blobs of several labels."""
    random = np.random.default_rng(seed)
    coarse = random.integers(0, 4, (shape[0] // 5 + 1, shape[1] // 5 + 1), dtype=np.uint8)
    return np.ascontiguousarray(np.kron(coarse, np.ones((5, 5), np.uint8))[: shape[0], : shape[1]])


@pytest.mark.parametrize("shape", SHAPES)
def test_run_lengths_decode_to_the_mask(shape: tuple[int, int]) -> None:
    for mask in (random_mask(shape, 1), np.zeros(shape, np.uint8), np.full(shape, 255, np.uint8)):
        runs = Runs(mask)
        assert np.array_equal(runs.mask(), mask) and runs.mask().dtype == np.uint8
        assert np.array_equal(runs.areas(), np.bincount(mask.ravel(), minlength=256))


@pytest.mark.parametrize("shape", SHAPES)
def test_coco_segmentations_are_those_of_pycocotools(shape: tuple[int, int]) -> None:
    from pycocotools import mask as coco

    for label in range(4):
        mask = random_mask(shape, label)
        ours = tracecut.coco_rle(mask, label)
        theirs = coco.encode(np.asfortranarray(mask == label).astype(np.uint8))
        assert ours["counts"].encode() == theirs["counts"] and ours["size"] == list(theirs["size"])
        for segmentation in (ours, theirs):
            assert np.array_equal(tracecut.from_coco_rle(segmentation), mask == label)


def test_uncompressed_run_lengths_are_a_segmentation() -> None:
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
def test_invalid_segmentations_are_refused(segmentation: dict[str, object]) -> None:
    with fails("data"):
        tracecut.from_coco_rle(segmentation)


def test_a_png_has_the_labels_and_the_palette_of_the_benchmarks() -> None:
    mask = random_mask((13, 31), 5)
    image = Image.open(io.BytesIO(tracecut.mask_png(mask)))
    assert image.mode == "P" and np.array_equal(np.asarray(image), mask)
    assert image.getpalette()[:12] == [0, 0, 0, 128, 0, 0, 0, 128, 0, 128, 128, 0]  # type: ignore[index]
    with pytest.raises(tracecut.TraceCutError):
        tracecut.mask_png(np.zeros((2, 2)))  # type: ignore[arg-type]


def two_objects() -> list[np.ndarray]:
    """Object 3 is largest in frame 1, object 7 in frame 0."""
    masks = [np.zeros((40, 60), np.uint8) for _ in range(3)]
    for t, side in enumerate((5, 12, 7)):
        masks[t][10 : 10 + side, 10 : 10 + 2 * side] = 3
        masks[t][30 : 36 - t, 45:50] = 7
    return masks


def test_prompts_have_the_best_frame_box_points_and_mask_of_each_object() -> None:
    masks = two_objects()
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


def test_prompts_are_written_as_json() -> None:
    for prompt in tracecut.prompts(two_objects()):
        entry = json.loads(json.dumps(prompt.as_json()))
        assert entry["points"] == prompt.points.tolist() and entry["box"] == prompt.box.tolist()
        assert np.array_equal(tracecut.from_coco_rle(entry["mask"]), prompt.mask)


def test_prompts_fit_the_signatures_of_sam_2() -> None:
    predictor, state = video_predictor(), object()
    for prompt in tracecut.prompts(two_objects()):
        inspect.signature(predictor.add_new_points_or_box).bind(predictor, state, **prompt.as_points_and_box())
        inspect.signature(predictor.add_new_mask).bind(predictor, state, **prompt.as_mask())
        assert prompt.points.shape == (len(prompt.labels), 2) and prompt.points.dtype == np.float32
        assert prompt.box.shape == (4,) and prompt.mask.ndim == 2
