"""Packages of other tools read our exports, and get the same masks to the pixel.

Each test that needs a tool is skipped where its package is not installed.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tracecut
from conftest import ROOT, fails
from PIL import Image
from tracecut import interchange

SIZE = (37, 53)
NAMES = {1: "dog & <cat>", 4: "ball"}


def random_masks(seed: int = 0, frames: int = 5) -> list[np.ndarray]:
    """Masks of blobs and of single pixels, with gaps in the labels; one frame is empty, one is full."""
    random = np.random.default_rng(seed)
    masks = [np.zeros(SIZE, np.uint8), np.full(SIZE, 4, np.uint8)]
    for _ in range(frames - 2):
        coarse = random.choice(np.array([0, 1, 3, 4], np.uint8), (SIZE[0] // 6 + 1, SIZE[1] // 6 + 1))
        mask = np.kron(coarse, np.ones((6, 6), np.uint8))[: SIZE[0], : SIZE[1]]
        mask[random.integers(0, SIZE[0], 9), random.integers(0, SIZE[1], 9)] = 200
        masks.append(mask)
    return masks[:1] + masks[2:] + masks[1:2]


MASKS = random_masks()


def write_frames(folder: Path) -> None:
    """Pictures for tools that look at them."""
    folder.mkdir(parents=True)
    for t in range(len(MASKS)):
        Image.new("RGB", (SIZE[1], SIZE[0])).save(folder / f"{t:05}.jpg")


def combine(parts: dict[int, np.ndarray]) -> np.ndarray:
    """A mask from those of its labels, none of which covers another."""
    mask = np.zeros(SIZE, np.uint8)
    for label, inside in parts.items():
        assert not mask[inside].any()
        mask[inside] = label
    return mask


Recipe = Callable[[str], "dict[str, Any]"]


@pytest.fixture
def recipe(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Recipe:
    """Runs the Python of a section of docs/interchange.md in a folder with the frames; returns its names."""
    write_frames(tmp_path / "coco" / "images")
    interchange.to_coco(MASKS, tmp_path / "coco" / "annotations", objects=NAMES)
    monkeypatch.chdir(tmp_path)
    return run_recipe


def run_recipe(tool: str) -> dict[str, Any]:
    text = (ROOT / "docs" / "interchange.md").read_text("utf-8")
    code = text.split(f"\n## {tool}\n")[1].split("```python\n")[1].split("```")[0]
    names: dict[str, Any] = {"result": MASKS}
    exec(compile(code, f"docs/interchange.md, {tool}", "exec"), names)
    return names


@pytest.mark.wheel
def test_datumaro_writes_the_xml_of_cvat(recipe: Recipe) -> None:
    datumaro = pytest.importorskip("datumaro", reason="datumaro is not installed")
    recipe("CVAT")
    data = datumaro.Dataset.import_from("cvat", "cvat")
    classes = [category.name for category in data.categories()[datumaro.AnnotationType.label].items]
    items = {item.id: item for item in data}
    for t, mask in enumerate(MASKS):
        parts = {}
        for shape in items[f"{t:05}"].annotations:
            assert classes[shape.label] == NAMES.get(shape.group, f"object {shape.group}")
            parts[shape.group] = shape.image.astype(bool)
        assert np.array_equal(combine(parts), mask), t


@pytest.mark.wheel
def test_label_studio_accepts_the_tasks(recipe: Recipe) -> None:
    brush = pytest.importorskip("label_studio_sdk.converter.brush", reason="label-studio-sdk is not installed")
    from label_studio_sdk.label_interface import LabelInterface

    recipe("Label Studio")
    labels = "".join(f'<Label value="object {label}"/>' for label in (1, 3, 4, 200))
    brushes = f'<BrushLabels name="mask" toName="image">{labels}</BrushLabels>'
    config = LabelInterface(f'<View><Image name="image" value="$image"/>{brushes}</View>')
    config.validate()
    tasks = json.loads(Path("tasks.json").read_text(encoding="utf-8"))
    assert len(tasks) == len(MASKS)
    for task, mask in zip(tasks, MASKS):
        (prediction,) = task["predictions"]
        assert config.validate_task({"data": task["data"]})
        assert not config.validate_prediction(prediction, return_errors=True)
        parts = {}
        assert len({region["id"] for region in prediction["result"]}) == len(prediction["result"])
        for region in prediction["result"]:
            # All that Label Studio lists for a result of BrushLabels.
            size = (region["original_height"], region["original_width"])
            assert (size, region["image_rotation"], region["value"]["format"]) == (SIZE, 0, "rle")
            (name,) = region["value"]["brushlabels"]
            pixels = brush.decode_rle(region["value"]["rle"]).reshape(*SIZE, 4)
            parts[int(name.split()[1])] = pixels[..., 3] == 255
        assert np.array_equal(combine(parts), mask)


def test_pycocotools_reads_the_masks(tmp_path: Path) -> None:
    coco = pytest.importorskip("pycocotools.coco", reason="pycocotools is not installed")
    out = interchange.to_coco(MASKS, tmp_path / "coco", objects=NAMES)
    data = coco.COCO(str(out / "labels.json"))
    assert len(data.imgs) == len(MASKS)
    for t, mask in enumerate(MASKS):
        assert data.imgs[t + 1]["file_name"] == f"{t:05}.jpg"
        found = data.loadAnns(data.getAnnIds(imgIds=[t + 1]))
        assert np.array_equal(combine({each["index"]: data.annToMask(each) == 1 for each in found}), mask)
        for each in found:
            rows, columns = np.nonzero(mask == each["index"])
            assert each["area"] == rows.size
            height, width = rows.max() + 1 - rows.min(), columns.max() + 1 - columns.min()
            assert each["bbox"] == [columns.min(), rows.min(), width, height]
            name = NAMES.get(each["index"], f"object {each['index']}")
            assert data.cats[each["category_id"]]["name"] == name


def mask_of_detections(label: Any) -> np.ndarray:
    """The mask that FiftyOne's detections make."""
    parts = {}
    for detection in label.detections if label else []:
        left, top = detection.bounding_box[0] * SIZE[1], detection.bounding_box[1] * SIZE[0]
        height, width = detection.mask.shape
        full = np.zeros(SIZE, bool)
        full[round(top) : round(top) + height, round(left) : round(left) + width] = detection.mask
        assert detection.label == NAMES.get(detection.index, f"object {detection.index}")
        parts[detection.index] = full
    return combine(parts)


@pytest.mark.wheel
def test_fiftyones_importer_reads_masks_and_identities(tmp_path: Path) -> None:
    """Its importer alone: a data set needs the database, which does not run everywhere."""
    utils = pytest.importorskip("fiftyone.utils.coco", reason="fiftyone is not installed")
    write_frames(tmp_path / "images")
    labels = interchange.to_coco(MASKS, tmp_path / "annotations", objects=NAMES, name="some clip") / "labels.json"
    paths = {"data_path": str(tmp_path / "images"), "labels_path": str(labels)}
    with utils.COCODetectionDatasetImporter(**paths, label_types="segmentations") as importer:
        assert len(importer) == len(MASKS)
        assert importer.get_dataset_info()["description"] == "some clip"
        for path, metadata, label in importer:
            assert (metadata.height, metadata.width) == SIZE
            assert np.array_equal(mask_of_detections(label), MASKS[int(Path(path).stem)])


def enlarge_masks(shape: tuple[int, int]) -> list[np.ndarray]:
    """The masks at another size, by repeating pixels."""
    rows, columns = (np.arange(to) * of // to for to, of in zip(shape, SIZE))
    return [mask[np.ix_(rows, columns)] for mask in MASKS]


def test_the_reader_of_davis_reads_the_masks(tmp_path: Path) -> None:
    """It knows the benchmark's clips alone, so the made one takes the name, length and size of one of them."""
    try:
        from davisinteractive.dataset import Davis
    except (ImportError, AttributeError) as error:  # it asks NumPy for what is no longer there
        pytest.skip(f"davisinteractive is not installed, or not with NumPy before 1.24: {error}")
    known = Davis.dataset["dog-agility"]
    masks = enlarge_masks(tuple(known["image_size"][::-1])) * 5
    assert len(masks) == known["num_frames"]
    interchange.to_davis(masks, tmp_path, name="dog-agility", subset=known["set"])
    read = Davis(str(tmp_path)).load_annotations("dog-agility", dtype=np.uint8)
    assert np.array_equal(read, np.stack(masks))


def test_davis_folders_hold_the_labels_the_list_and_the_colours(tmp_path: Path) -> None:
    folder = interchange.to_davis(MASKS, tmp_path, name="one")
    interchange.to_davis(iter(MASKS[:2]), tmp_path, name="two")
    assert (tmp_path / "ImageSets/2017/val.txt").read_text() == "one\ntwo\n"
    assert folder == tmp_path / "Annotations/480p/one"
    assert sorted(file.name for file in folder.iterdir()) == [f"{t:05}.png" for t in range(len(MASKS))]
    for t, mask in enumerate(MASKS):
        read = Image.open(folder / f"{t:05}.png")
        assert read.mode == "P" and np.array_equal(np.asarray(read), mask)
    palette = read.getpalette()
    assert palette[:15] == [0, 0, 0, 128, 0, 0, 0, 128, 0, 128, 128, 0, 0, 0, 128]
    assert palette[3 * 8 : 3 * 10] == [64, 0, 0, 191, 0, 0]
    assert palette[3 * 21 : 3 * 23] == [128, 64, 128, 22, 22, 22] and palette[-3:] == [255, 255, 255]


def test_youtube_vos_folders_hold_the_labels_and_where_each_is_seen(tmp_path: Path) -> None:
    interchange.to_youtube_vos(MASKS, tmp_path, name="0a1b", objects=NAMES)
    interchange.to_youtube_vos(MASKS[:1], tmp_path, name="empty")
    videos = json.loads((tmp_path / "train/meta.json").read_text(encoding="utf-8"))["videos"]
    assert set(videos) == {"0a1b", "empty"} and videos["empty"] == {"objects": {}}
    read = {f"{t:05}": np.asarray(Image.open(tmp_path / f"train/Annotations/0a1b/{t:05}.png")) for t in range(5)}
    assert all(np.array_equal(read[f"{t:05}"], mask) for t, mask in enumerate(MASKS))
    objects = videos["0a1b"]["objects"]
    assert set(objects) == {"1", "3", "4", "200"}
    for label, entry in objects.items():
        assert entry["category"] == NAMES.get(int(label), f"object {label}")
        assert entry["frames"] == [stem for stem, mask in read.items() if (mask == int(label)).any()]


@pytest.mark.parametrize("of_davis", [True, False])
def test_the_benchmark_script_scores_the_folders(of_davis: bool, tmp_path: Path) -> None:
    """What VOS benchmarks are scored with: equal masks get 100, a pixel less of one object costs that object alone."""
    benchmark = pytest.importorskip("vos_benchmark.benchmark", reason="vos-benchmark is not installed")
    changed = [mask.copy() for mask in MASKS]
    changed[1][np.argwhere(changed[1] == 3)[0][0], np.argwhere(changed[1] == 3)[0][1]] = 0
    write = interchange.to_davis if of_davis else interchange.to_youtube_vos
    truth, other = (write(masks, tmp_path / str(i), name="a") for i, masks in enumerate((MASKS, changed)))
    score = benchmark.VideoEvaluator(str(truth.parent), str(truth.parent), skip_first_and_last=False)
    _, regions, borders = score("a")
    assert set(regions) == {1, 3, 4, 200}
    assert all(value == pytest.approx(100) for value in [*regions.values(), *borders.values()])
    _, regions, _ = benchmark.VideoEvaluator(str(truth.parent), str(other.parent), skip_first_and_last=False)("a")
    assert {label for label, value in regions.items() if value < 99.9999} == {3}


class MaskSource:
    """Like a session: masks by their numbers."""

    num_frames = len(MASKS)

    def labels(self, t: int) -> np.ndarray:
        return MASKS[t]


def coco(masks: Any, path: Path, **options: Any) -> Path:
    return interchange.to_coco(masks, path, **options)


def davis(masks: Any, path: Path, **options: Any) -> Path:
    return interchange.to_davis(masks, path.parent, **{"name": path.name, **options})


def youtube(masks: Any, path: Path, **options: Any) -> Path:
    return interchange.to_youtube_vos(masks, path.parent, **{"name": path.name, **options})


Writer = Callable[..., Path]
WRITERS = [coco, davis, youtube]


def files(folder: Path) -> dict[str, bytes]:
    return {str(each.relative_to(folder)): each.read_bytes() for each in folder.rglob("*") if each.is_file()}


@pytest.mark.parametrize("write", WRITERS)
def test_results_sessions_arrays_and_iterators_are_exported_alike(write: Writer, tmp_path: Path) -> None:
    given = [MASKS, iter(MASKS), np.stack(MASKS), MaskSource(), [np.asfortranarray(mask) for mask in MASKS]]
    written = [files(write(masks, tmp_path / str(i) / "out")) for i, masks in enumerate(given)]
    assert written[0] and all(each == written[0] for each in written)


def test_a_result_is_exported_like_its_session(tmp_path: Path, done: tracecut.Session) -> None:
    result = tracecut.segment(tracecut.synth.Scene("sample", 96, 64, 8, seed=3))
    assert result.objects
    of_result = files(interchange.to_coco(result, tmp_path / "result"))
    assert of_result == files(interchange.to_coco(done, tmp_path / "session"))


@pytest.mark.parametrize("write", WRITERS)
def test_existing_files_are_not_replaced(write: Writer, tmp_path: Path) -> None:
    write(MASKS, tmp_path / "out")
    before = files(tmp_path)
    with fails("param", "nothing is yet|not have yet"):
        write(MASKS[1:], tmp_path / "out")
    assert files(tmp_path) == before


@pytest.mark.parametrize("write", WRITERS)
def test_a_failed_export_leaves_no_files(write: Writer, tmp_path: Path) -> None:
    def broken() -> Iterator[np.ndarray]:
        yield from MASKS[:2]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write(broken(), tmp_path / "new" / "out")
    assert list(tmp_path.iterdir()) == []
    write(MASKS, tmp_path / "new" / "out")


@pytest.mark.parametrize("write", WRITERS)
@pytest.mark.parametrize(
    ("masks", "message"),
    [
        ([], r"masks has 0 frames \(expected at least 1\)"),
        (3, r"masks is a int \(expected a result, or arrays one by one\)"),
        ([MASKS[0], "mask"], "mask of frame 1 is a str"),
        ([MASKS[0].astype(np.int64)], "mask of frame 0 is int64 of shape"),
        ([np.zeros((2, 3, 3), np.uint8)], r"shape \(2, 3, 3\) \(expected an array of uint8"),
        ([np.zeros((0, 3), np.uint8)], r"shape \(0, 3\)"),
        ([MASKS[0], MASKS[0][1:]], r"mask of frame 1 has shape \(36, 53\) \(expected \(37, 53\)"),
    ],
)
def test_invalid_masks_are_refused(write: Writer, masks: Any, message: str, tmp_path: Path) -> None:
    with fails("data", message):
        write(masks, tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["a.png"], "frames has 1 names"),
        ([f"{t}.png" for t in range(6)], "frames has more than 5 names"),
        (["a.png"] * 5, "name of frame 1 is 'a.png'"),
        (["a\nb", "b", "c", "d", "e"], "name of frame 0"),
        ([b"a", "b", "c", "d", "e"], "name of frame 0 is b'a'"),
    ],
)
def test_invalid_names_of_frames_are_refused(names: list[str], message: str, tmp_path: Path) -> None:
    with fails("data", message):
        interchange.to_coco(MASKS, tmp_path / "out", frames=names)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("write", "options", "message"),
    [
        (coco, {"name": ""}, "name = ''"),
        (coco, {"objects": {0: "a"}}, "objects = 0 .expected labels of 1 to 255"),
        (coco, {"objects": {256: "a"}}, "objects = 256"),
        (coco, {"objects": {1: "a\nb"}}, r"objects\[1\] = "),
        (youtube, {"objects": ["a"]}, "objects = .'a'. .expected labels of 1 to 255"),
        (davis, {"name": "../a"}, "name = '../a' .expected a name of a folder"),
        (davis, {"name": ""}, "name = ''"),
        (davis, {"subset": "a/b"}, "subset = 'a/b'"),
        (davis, {"resolution": ".."}, "resolution = '..'"),
        (youtube, {"name": "a\\b"}, "name = "),
        (youtube, {"subset": None}, "subset = None"),
    ],
)
def test_illegal_options_are_refused(
    write: Writer, options: dict[str, Any], message: str, tmp_path: Path
) -> None:
    with fails("param", message):
        write(MASKS, tmp_path / "out", **options)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("write", [davis, youtube])
def test_the_label_that_benchmarks_ignore_is_refused(write: Writer, tmp_path: Path) -> None:
    with pytest.raises(tracecut.TraceCutError, match="frame 1 has label 255 .expected 0 to 254"):
        write([MASKS[0], np.full(SIZE, 255, np.uint8)], tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_a_broken_meta_json_is_refused_and_kept(tmp_path: Path) -> None:
    (tmp_path / "train").mkdir()
    path = tmp_path / "train" / "meta.json"
    path.write_text("[]")
    with fails("data", "cannot be read"):
        interchange.to_youtube_vos(MASKS, tmp_path, name="a")
    assert files(tmp_path) == {str(Path("train") / "meta.json"): b"[]"}


def test_a_video_in_meta_json_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "train").mkdir()
    text = json.dumps({"videos": {"a": {"objects": {}}}})
    (tmp_path / "train" / "meta.json").write_text(text)
    with pytest.raises(tracecut.TraceCutError, match="name = 'a' .expected a name that .*meta.json does not have"):
        interchange.to_youtube_vos(MASKS, tmp_path, name="a")
    assert files(tmp_path) == {str(Path("train") / "meta.json"): text.encode()}


@pytest.mark.skipif(sys.platform == "win32", reason="folders cannot be closed for writing there")
@pytest.mark.parametrize("write", [davis, youtube])
def test_a_list_that_cannot_be_written_leaves_no_masks(write: Writer, tmp_path: Path) -> None:
    blocked = tmp_path / ("ImageSets/2017/val.txt" if write is davis else "train/meta.json")
    blocked.mkdir(parents=True)
    with pytest.raises((OSError, tracecut.TraceCutError)):
        write(MASKS, tmp_path / "out")
    assert files(tmp_path) == {}


@pytest.mark.parametrize("write", WRITERS)
def test_frames_are_written_one_by_one(write: Writer, tmp_path: Path) -> None:
    """No mask is kept until the next but one."""
    import weakref

    alive: list[weakref.ref[np.ndarray]] = []

    def frames() -> Iterator[np.ndarray]:
        for t in range(6):
            mask = np.full(SIZE, t, np.uint8)
            alive.append(weakref.ref(mask))
            yield mask
            del mask
            assert sum(ref() is not None for ref in alive) <= 3

    write(frames(), tmp_path / "out")
    assert len(alive) == 6
