"""CVAT: the XML that it calls "CVAT for images 1.1"."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Optional, TextIO
from xml.sax.saxutils import escape, quoteattr

from .._masks import runs_of
from ._clip import Box, Classes, Frame, Masks, box_of, check_text, frames_of
from ._output import PathLike, colour, new_folder


def to_cvat(
    masks: Masks,
    path: PathLike,
    *,
    name: str = "clip",
    frames: Optional[Iterable[str]] = None,
    objects: Optional[Mapping[int, str]] = None,
) -> Path:
    """Writes masks for CVAT: a folder with ``annotations.xml`` and ``labels.json``.

    Frame by frame, in the memory of one mask. Each object of each frame is a shape of the kind mask, and its group is
    its label in all frames. CVAT has no tracks of masks: of a track it would keep the first mask alone.

    Parameters
    ----------
    masks : masks
        A `tracecut.Result`, or arrays of uint8 of shape (height, width) one by one.
    path : path
        The folder, which must not exist.
    name : str, default "clip"
        The name of the task.
    frames : iterable of str, optional
        The frames' names in the task, as many as there are masks; ``00000.jpg`` and so on if not given. In a task
        that was made from a video, CVAT goes by their numbers.
    objects : mapping of int to str, optional
        The class of each label; ``object 1`` and so on of those without.

    Returns
    -------
    pathlib.Path
        The folder.

    Raises
    ------
    TraceCutError
        ``data`` of masks or names that are not as said, ``param`` of the rest.

    Notes
    -----
    The format is described in CVAT's documentation under "XML annotation format", version 1.1: runs are those of
    the pixels in the shape's box row by row, outside first. ``labels.json`` is what the task's label constructor
    takes as raw text.

    Examples
    --------
    >>> import tempfile, tracecut
    >>> from tracecut import interchange
    >>> result = tracecut.segment(tracecut.synth.Scene("sample", 96, 54, frames=4), preset="fast")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     sorted(file.name for file in interchange.to_cvat(result, folder + "/cvat").iterdir())
    ['annotations.xml', 'labels.json']
    """
    task, classes, count = check_text("name", name), Classes(objects), 0
    with new_folder(path) as folder:
        # The head tells what is known at the end only.
        body = folder / "body"
        with body.open("w", encoding="utf-8") as out:
            for frame in frames_of(masks, frames):
                _write_image(out, frame, classes)
                count += 1
        with (folder / "annotations.xml").open("w", encoding="utf-8") as out, body.open(encoding="utf-8") as images:
            out.write(_head(task, count, classes))
            shutil.copyfileobj(images, out)
            out.write("</annotations>\n")
        body.unlink()
        text = json.dumps(_constructor(classes), indent=2, ensure_ascii=False)
        (folder / "labels.json").write_text(text + "\n", encoding="utf-8")
    return Path(path)


def _write_image(out: TextIO, frame: Frame, classes: Classes) -> None:
    height, width = frame.mask.shape
    out.write(f'  <image id="{frame.t}" name={quoteattr(frame.name)} width="{width}" height="{height}">\n')
    for label in frame.objects():
        inside = frame.mask == label
        box = box_of(inside)
        cropped = inside[box.top : box.top + box.height, box.left : box.left + box.width]
        out.write(_mask(classes.name(label), label, box, runs_of(cropped.ravel())))
    out.write("  </image>\n")


def _mask(name: str, label: int, box: Box, runs: list[int]) -> str:
    place = f'left="{box.left}" top="{box.top}" width="{box.width}" height="{box.height}"'
    rle = ", ".join(map(str, runs))
    shape = f'label={quoteattr(name)} source="file" occluded="0" rle="{rle}" {place} z_order="0" group_id="{label}"'
    return f"    <mask {shape}>\n    </mask>\n"


def _head(task: str, count: int, classes: Classes) -> str:
    labels = "".join(
        f"        <label><name>{escape(label['name'])}</name><color>{label['color']}</color>"
        "<type>mask</type><attributes></attributes></label>\n"
        for label in _constructor(classes)
    )
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n<annotations>\n  <version>1.1</version>\n'
        f"  <meta>\n    <task>\n      <name>{escape(task)}</name>\n      <size>{count}</size>\n"
        f"      <mode>annotation</mode>\n      <labels>\n{labels}      </labels>\n    </task>\n  </meta>\n"
    )


def _constructor(classes: Classes) -> list[dict[str, Any]]:
    named = classes.numbers.items()
    return [{"name": name, "color": colour(number), "type": "mask", "attributes": []} for name, number in named]
