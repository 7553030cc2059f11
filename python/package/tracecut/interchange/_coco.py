"""Writes COCO's JSON, which annotation tools import with masks and identities."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Optional

from .._masks import coco_rle
from ._export import (
    Classes,
    Frame,
    Masks,
    PathLike,
    append_text,
    box_of,
    check_text,
    frames_of,
    json_line,
    new_folder,
)


def to_coco(
    masks: Masks,
    path: PathLike,
    *,
    name: str = "clip",
    frames: Optional[Iterable[str]] = None,
    objects: Optional[Mapping[int, str]] = None,
) -> Path:
    """Writes masks in COCO's format: a folder with ``labels.json``.

    Works frame by frame, in the memory of one mask and the names. Each object of each frame is an annotation with a
    mask; its ``track_id`` is its label in all frames.

    Parameters
    ----------
    masks : masks
        A `tracecut.Result`, or arrays of uint8 of shape (height, width) one by one.
    path : path
        The folder, which must not exist.
    name : str, default "clip"
        The description of the data set.
    frames : iterable of str, optional
        The names of the frames, one per mask; ``00000.jpg`` and so on by default.
    objects : mapping of int to str, optional
        The class of each label; ``object 1`` and so on for labels without.

    Returns
    -------
    pathlib.Path
        The folder.

    Raises
    ------
    TraceCutError
        ``data`` for invalid masks or names, ``param`` for other arguments.

    Notes
    -----
    COCO's site describes the format under "Data format". Masks are compressed run lengths, exact to the pixel. The
    identity is stored three times: as ``track_id``, like the command line and JavaScript, under ``attributes`` for CVAT
    and Datumaro, and as ``index`` for FiftyOne.

    Examples
    --------
    >>> import tempfile, tracecut
    >>> from tracecut import interchange
    >>> result = tracecut.segment(tracecut.synth.Scene("sample", 96, 54, frames=4), preset="fast")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [file.name for file in interchange.to_coco(result, folder + "/coco").iterdir()]
    ['labels.json']
    """
    description, classes = check_text("name", name), Classes(objects)
    images: list[dict[str, Any]] = []
    with new_folder(path) as folder:
        file = folder / "labels.json"
        append_text(file, '{"annotations":[')
        count = 0
        for frame in frames_of(masks, frames):
            height, width = (int(side) for side in frame.mask.shape)
            image = {"id": frame.t + 1, "file_name": frame.name, "width": width, "height": height}
            images.append(image if frame.time is None else {**image, "timestamp": frame.time})
            text = ""
            for label in frame.objects():
                count += 1
                text += ("," if count > 1 else "") + "\n" + json_line(_annotation(frame, label, count, classes))
            append_text(file, text)
        categories = [{"id": number, "name": name} for name, number in classes.numbers.items()]
        append_text(file, f'\n],\n"images":{json_line(images)},\n"categories":{json_line(categories)},\n')
        append_text(file, f'"info":{json_line({"description": description})}}}\n')
    return Path(path)


def _annotation(frame: Frame, label: int, number: int, classes: Classes) -> dict[str, Any]:
    inside = frame.mask == label
    return {
        "id": number,
        "image_id": frame.t + 1,
        "category_id": classes.number(label),
        "bbox": list(box_of(inside)),
        "area": int(inside.sum()),
        "segmentation": coco_rle(frame.mask, label),
        "iscrowd": 0,
        "track_id": label,
        "attributes": {"track_id": label},
        "index": label,
    }
