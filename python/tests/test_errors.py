"""Every entry point refuses wrong arguments with one class of error, which names the value and the legal ones."""

from __future__ import annotations

import inspect
import re
import reprlib
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tracecut
from tracecut import Stroke, TraceCutError, Trajectories, interchange

SAYS_WHAT_IS_LEGAL = re.compile("expected|no such file|cannot be decoded|pip install", re.IGNORECASE)

#: A path where nothing is, and no name of a choice.
TEXT = "no such thing"

#: Values that hardly any argument may have.
WRONG: list[Any] = [
    None,
    TEXT,
    b"bytes",
    1.5,
    float("nan"),
    -(10**9),
    10**30,
    True,
    [],
    [None],
    {},
    {"a": 1},
    object(),
    len,
    np.zeros((2, 2)),
    np.zeros((3, 4, 5, 6), np.uint8),
    np.array(["a"]),
    1j,
]


@pytest.fixture(scope="module")
def tracks(done: tracecut.Session) -> Trajectories:
    return done.trajectories()


@pytest.fixture(scope="module")
def calls(clip: list[np.ndarray], tracks: Trajectories, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Each entry point with legal arguments."""
    folder = tmp_path_factory.mktemp("calls")
    (folder / "file.txt").write_text("text")
    scene = tracecut.synth.Scene("sample", 96, 64, 8, seed=3)
    result = tracecut.segment(clip, preset="fast")
    mask = result[0]
    session = tracecut.Session(preset="fast")
    session.push_all(clip)
    session.run()

    def with_undo(correct: Callable[..., object]) -> Callable[..., None]:
        def call(**arguments: Any) -> None:
            correct(**arguments)
            session.undo_correction()

        return call

    window = next(tracecut.windows(clip, preset="fast"))
    section = {"patch_stride": 8}
    in_windows = {
        **{"frames": clip[:2], "window": 50, "overlap": 1},
        **{"threads": 1, "progress": None, "flow": section, "preset": "fast"},
    }
    entry_points: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
        "segment": (tracecut.segment, in_windows),
        "segment with trajectories": (tracecut.segment, {"frames": clip, "trajectories": tracks, "preset": "fast"}),
        "windows": (lambda **options: list(tracecut.windows(**options)), in_windows),
        "Session": (tracecut.Session, {"flow": section, "preset": "fast"}),
        "a parameter": (lambda value: tracecut.Session(flow={"patch_stride": value}), {"value": 4}),
        "a choice": (lambda value: tracecut.Session(discretize={"method": value}), {"value": "rotation"}),
        "a truth value": (lambda value: tracecut.Session(clip={"dense": value}), {"value": False}),
        "push": (lambda frame: tracecut.Session().push(frame), {"frame": clip[0]}),
        "push_all": (lambda frames: tracecut.Session().push_all(frames), {"frames": clip}),
        "set_trajectories": (lambda t: tracecut.Session().set_trajectories(t), {"t": tracks}),
        "Trajectories": (
            lambda **columns: tracecut.Session().set_trajectories(Trajectories(**columns)),
            {
                name: getattr(tracks, name)
                for name in ("num_frames", "width", "height", "start_frame", "offset", "x", "y")
            },
        ),
        "run": (session.run, {"threads": 1, "progress": None}),
        "merge": (with_undo(session.merge), {"into": 1, "from_": 1}),
        "split": (with_undo(session.split), {"label": 1, "at": (0, 10.0, 10.0)}),
        "split at": (with_undo(lambda t, x, y: session.split(1, at=(t, x, y))), {"t": 0, "x": 10.0, "y": 10.0}),
        "together": (with_undo(session.together), {"strokes": [Stroke(0, [(5, 5)])]}),
        "apart": (with_undo(session.apart), {"strokes": [Stroke(0, [(5, 5)]), Stroke(0, [(50, 50)])]}),
        "Stroke": (
            with_undo(lambda **fields: session.together([Stroke(**fields)])),
            {"t": 0, "points": [(5, 5)], "radius": 3.0},
        ),
        "explain": (session.explain, {"t": 0, "x": 3, "y": 4}),
        "clusters_by": (session.clusters_by, {"method": "k-means", "count": 2}),
        "object_table": (session.object_table, {"times": [0.0] * 8}),
        "labels": (session.labels, {"t": 0, "picture": clip[0]}),
        **{
            name: (getattr(session, name), {"t": 0})
            for name in (
                *("flow", "saliency_map", "superpixels", "boundaries", "working_labels", "cluster_labels"),
                "background",
            )
        },
        "Window.labels": (window.labels, {"t": 0}),
        "Result[]": (result.__getitem__, {"t": 0}),
        "Result.labels": (result.labels, {"t": 0}),
        "Result.coco": (result.coco, {"t": 0}),
        "Result.png": (result.png, {"t": 0}),
        "Result.save": (result.save, {"folder": folder / "masks"}),
        "Trajectories.points": (tracks.points, {"i": 0}),
        "Trajectories.at": (tracks.at, {"t": 0}),
        "Trajectories.alive": (tracks.alive, {"t": 0}),
        "Scene": (tracecut.synth.Scene, {"kind": "sample", "width": 32, "height": 32, "frames": 2, "seed": 0}),
        "Scene[]": (scene.__getitem__, {"t": 0}),
        "Scene.mask": (scene.mask, {"t": 0}),
        "Scene.flow": (scene.flow, {"t": 0}),
        "as_array": (tracecut.as_array, {"frame": clip[0]}),
        "boundaries": (tracecut.boundaries, {"image": clip[0], "clip": {}}),
        "superpixels": (tracecut.superpixels, {"image": clip[0], "count": 9, "contour": {}}),
        "image_discontinuities": (
            tracecut.image_discontinuities,
            {"image": clip[0][:9, :9], "still": {"dimensions": 2}},
        ),
        "flow": (tracecut.flow, {"first": clip[0], "second": clip[1], "flow": section}),
        "enlarge": (tracecut.enlarge, {"mask": mask, "picture": clip[0]}),
        "coco_rle": (tracecut.coco_rle, {"mask": mask, "label": 1}),
        "from_coco_rle": (tracecut.from_coco_rle, {"segmentation": {"size": [1, 2], "counts": [1, 1]}}),
        "mask_png": (tracecut.mask_png, {"mask": mask}),
        "prompts": (tracecut.prompts, {"masks": [mask]}),
        "in_name_order": (tracecut.in_name_order, {"paths": ["a"]}),
        "read_image": (tracecut.read_image, {"path": folder / "file.txt"}),
        "read_video": (lambda path: list(tracecut.read_video(path)), {"path": folder / "file.txt"}),
        "read_tracks": (tracecut.read_tracks, {"path": folder / "file.txt", "size": (96, 64)}),
        "write_tracks": (
            tracecut.write_tracks,
            {"path": folder / "tracks.dat", "trajectories": tracks, "label": np.zeros(len(tracks), np.uint32)},
        ),
        "parameters": (tracecut.parameters, {"expert": False}),
        "to_coco": (
            interchange.to_coco,
            {"masks": [mask], "path": folder / "coco", "name": "clip", "frames": ["a"], "objects": {1: "a"}},
        ),
        "to_davis": (
            interchange.to_davis,
            {"masks": [mask], "root": folder / "davis", "name": "clip", "subset": "val", "resolution": "480p"},
        ),
        "to_youtube_vos": (
            interchange.to_youtube_vos,
            {"masks": [mask], "root": folder / "vos", "name": "clip", "subset": "train", "objects": {1: "a"}},
        ),
    }
    return entry_points


#: Entry points that take no argument, or whose arguments are those of another one.
WITHOUT_ARGUMENTS = {"interchange", "synth", "__version__", "FrameLike", "Frames", "Params", "TraceCutError"}


def test_every_entry_point_gets_wrong_arguments(calls: dict[str, Any]) -> None:
    for name in set(tracecut.__all__) - WITHOUT_ARGUMENTS:
        thing = getattr(tracecut, name)
        assert inspect.isclass(thing) or name in calls, name
    known = {name.split(".")[-1] for name in calls}
    for kind in (tracecut.SessionView, tracecut.Session, tracecut.Result, tracecut.Window, tracecut.Trajectories):
        for name, method in vars(kind).items():
            if not name.startswith("_") and callable(method) and len(inspect.signature(method).parameters) > 1:
                assert name in known, f"{kind.__name__}.{name}"


def remove(path: Path) -> None:
    """Removes what a call wrote."""
    shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)


def test_wrong_arguments_raise_an_error_that_names_them(
    calls: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    count, wrong = 0, []
    for name, (call, arguments) in calls.items():
        for parameter in arguments:
            for value in WRONG:
                where = f"{name}({parameter}={reprlib.repr(value)})"
                remove(Path(TEXT))
                given = {**arguments, parameter: value}
                try:
                    call(*given.values()) if name.endswith("[]") else call(**given)
                except TraceCutError as error:
                    count += 1
                    if len(str(error)) > 300 or not SAYS_WHAT_IS_LEGAL.search(str(error)):
                        wrong.append(f"{where}: {error.code}: {error}")
                except BaseException as error:
                    wrong.append(f"{where}: {type(error).__name__}: {error}")
    assert not wrong, "\n".join(wrong)
    assert count > 1000


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: tracecut.segment(None),
            r"frames = None \(expected the path of a folder of images or of a video, an arr",
        ),
        (lambda: tracecut.segment(5), r"frames = 5 \(expected the path of a folder"),
        (lambda: tracecut.segment([None, None]), r"frame = None \(expected an array of uint8 of shape"),
        (lambda: tracecut.segment("a", threads="two"), r"threads = 'two' \(expected a whole number, 1\.\.=256\)"),
        (lambda: tracecut.segment([], flow=5), r"flow = 5 \(expected a dictionary of parameters\)"),
        (
            lambda: tracecut.Session(flow={"patch_stride": None}),
            r"flow\.patch_stride = None \(expected a whole number, 1\.\.=8\)",
        ),
        (lambda: tracecut.Session(clip={"dense": []}), r"clip\.dense = \[\] \(expected true or false\)"),
        (lambda: tracecut.Session(shot={"max_unmatched": ()}), r"max_unmatched = \(\) \(expected a number, 0\.\.=1\)"),
        (lambda: tracecut.synth.Scene(width=2.5), r"width = 2\.5 \(expected a whole number, 1\.\.=4096\)"),
        (
            lambda: tracecut.prompts([np.zeros((2, 2))]),
            r"masks\[0\] = array of float64 of shape \(2, 2\) \(expected an array",
        ),
    ],
)
def test_a_wrong_type_raises_an_error_with_the_legal_type(call: Callable[[], object], message: str) -> None:
    with pytest.raises(TraceCutError, match=message) as caught:
        call()
    assert isinstance(caught.value, TypeError)


@pytest.mark.parametrize(
    ("call", "suggestion"),
    [
        (lambda: tracecut.segment([], thread=2), "threads"),
        (lambda: tracecut.windows([], thread=2), "threads"),
        (lambda: tracecut.segment([], trajectorie=2), "trajectories"),
        (lambda: tracecut.windows([], trajectories=2), "trajectory"),
        (lambda: tracecut.segment([], progres=True), "progress"),
        (lambda: tracecut.segment([], presets="fast"), "preset"),
        (lambda: tracecut.segment([], windw=3), "window"),
        (lambda: tracecut.superpixels(np.zeros((9, 9), np.uint8), cuont=5), "count"),
        (lambda: tracecut.Session(superpixels={}), "superpixel"),
        (lambda: tracecut.Session(**{"flw.patch_stride": 5}), "flow"),
        (lambda: tracecut.flow(np.zeros((9, 9), np.uint8), np.zeros((9, 9), np.uint8), folw={}), "flow"),
    ],
)
def test_a_misspelt_option_raises_an_error_with_a_suggestion(
    call: Callable[[], object], suggestion: str
) -> None:
    with pytest.raises(TraceCutError, match=r"\(expected a known option, such as ") as caught:
        call()
    assert str(caught.value).split("such as ")[1].rstrip(")").split(", ")[0] == suggestion


def test_options_of_other_calls_are_not_suggested() -> None:
    with pytest.raises(TraceCutError) as caught:
        tracecut.Session(thread=2)  # type: ignore[call-arg]
    assert "threads" not in str(caught.value)


def test_errors_of_files_are_also_errors_of_python(clip: list[np.ndarray], tmp_path: Path) -> None:
    result = tracecut.segment(clip[:2], preset="fast")
    (tmp_path / "file").write_text("text")
    for call, kind in [
        (lambda: tracecut.segment(tmp_path / "none"), FileNotFoundError),
        (lambda: tracecut.segment([tmp_path / "none.png"] * 2), FileNotFoundError),
        (lambda: tracecut.read_image(tmp_path), IsADirectoryError),
        (lambda: tracecut.read_tracks(tmp_path / "none", (9, 9)), FileNotFoundError),
        (lambda: result.save(tmp_path / "file"), OSError),
        (lambda: interchange.to_coco(result, tmp_path / "file" / "coco"), FileExistsError),
        (lambda: interchange.to_davis(result, tmp_path / "file", name="a"), NotADirectoryError),
    ]:
        with pytest.raises(kind, match=str(tmp_path)) as caught:
            call()
        assert isinstance(caught.value, TraceCutError) and caught.value.code == "file"
        assert caught.value.errno is not None and str(tmp_path) in caught.value.filename


def test_a_missing_package_is_an_import_error_too(
    clip: list[np.ndarray], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for package in ("av", "tqdm", "tqdm.auto"):
        monkeypatch.setitem(__import__("sys").modules, package, None)
    (tmp_path / "a.mp4").write_bytes(b"no video")
    for call in (lambda: tracecut.read_video(tmp_path / "a.mp4"), lambda: tracecut.segment(clip, progress=True)):
        with pytest.raises(ImportError, match="pip install 'tracecut") as caught:
            call()
        assert isinstance(caught.value, TraceCutError) and caught.value.code == "unsupported"
