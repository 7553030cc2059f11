"""Label Studio: tasks with brush masks for images, and with rectangles for videos."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from numbers import Real
from pathlib import Path
from typing import Any, Optional
from xml.sax.saxutils import quoteattr

from .._errors import illegal
from .._masks import runs_of
from .._types import Bool
from ._clip import Box, Classes, Frame, Masks, box_of, check_text, frames_of
from ._output import PathLike, colour, json_line, new_folder

#: Frames per second of a video of which nothing is known.
_DEFAULT_RATE = 25.0

#: Bits that a length may have.
_SIZES = (3, 4, 8, 16)
_LONGEST = 1 << _SIZES[-1]


def to_label_studio(
    masks: Masks,
    path: PathLike,
    *,
    name: str = "clip",
    frames: Optional[Iterable[str]] = None,
    prefix: Optional[str] = None,
    objects: Optional[Mapping[int, str]] = None,
) -> Path:
    """Writes masks for Label Studio: a folder with ``tasks.json`` and ``config.xml``.

    Frame by frame, in the memory of one mask. Each frame is a task with an image, and each object of it a brush
    region of a prediction, whose name ends with its label. Identities over frames are the names of the classes: a
    task knows of no other.

    Parameters
    ----------
    masks : masks
        A `tracecut.Result`, or arrays of uint8 of shape (height, width) one by one.
    path : path
        The folder, which must not exist.
    name : str, default "clip"
        The clip, which each task's data name, and each region.
    frames : iterable of str, optional
        The frames' names, as many as there are masks; ``00000.jpg`` and so on if not given.
    prefix : str, optional
        What stands before a frame's name in its address, which Label Studio loads the image from;
        ``/data/local-files/?d=NAME/`` if not given, which is its local storage.
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
    Label Studio's documentation has tasks under "Import pre-annotated data" and masks under "BrushLabels". The bits
    of a mask are those of the ``rle-pack`` package: a head, then runs of bytes, four equal ones for a pixel.

    Examples
    --------
    >>> import tempfile, tracecut
    >>> from tracecut import interchange
    >>> result = tracecut.segment(tracecut.synth.Scene("sample", 96, 54, frames=4), preset="fast")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     sorted(file.name for file in interchange.to_label_studio(result, folder + "/studio").iterdir())
    ['config.xml', 'tasks.json']
    """
    clip, classes = check_text("name", name), Classes(objects)
    before = f"/data/local-files/?d={clip}/" if prefix is None else prefix
    with new_folder(path) as folder:
        with (folder / "tasks.json").open("w", encoding="utf-8") as out:
            for frame in frames_of(masks, frames):
                regions = [_brush(clip, frame, label, classes) for label in frame.objects()]
                data = {"image": before + frame.name, "clip": clip, "frame": frame.t, **frame.timestamp("time")}
                out.write(("[\n" if frame.t == 0 else ",\n") + json_line(_task(data, regions)))
            out.write("\n]\n")
        image = '  <Image name="image" value="$image" zoom="true"/>\n'
        labels = f'  <BrushLabels name="mask" toName="image">\n{_labels(classes)}  </BrushLabels>\n'
        (folder / "config.xml").write_text(f"<View>\n{image}{labels}</View>\n", encoding="utf-8")
    return Path(path)


def to_label_studio_video(
    masks: Masks,
    path: PathLike,
    *,
    video: str,
    rate: Optional[float] = None,
    name: str = "clip",
    objects: Optional[Mapping[int, str]] = None,
) -> Path:
    """Writes the boxes of the objects for Label Studio: a folder with ``tasks.json`` and ``config.xml``.

    Label Studio has no masks in videos, so what goes over is the box of each object in each frame, one region with
    a keyframe for each frame in which it is seen. For masks see `to_label_studio`.

    Parameters
    ----------
    masks : masks
        As `to_label_studio`.
    path : path
        The folder, which must not exist.
    video : str
        The address that Label Studio loads the video from.
    rate : float, optional
        Frames per second of the video, above 0. If not given, the average rate of the video that the result came from,
        or 25.
    name : str, default "clip"
        The clip, which the task's data name, and each region.
    objects : mapping of int to str, optional
        As `to_label_studio`.

    Returns
    -------
    pathlib.Path
        The folder.

    Raises
    ------
    TraceCutError
        As `to_label_studio`.

    Notes
    -----
    Label Studio's documentation has the regions under "VideoRectangle": frames count from 1, places are in percent of
    the frame, and a keyframe that is not enabled is the last before the object is gone.
    """
    clip, address, classes = check_text("name", name), check_text("video", video), Classes(objects)
    speed = _check_rate(getattr(masks, "frame_rate", None) or _DEFAULT_RATE if rate is None else rate)
    with new_folder(path) as folder:
        keys: dict[int, list[dict[str, Any]]] = {}
        times: list[float] = []
        count, size = 0, (0, 0)
        for frame in frames_of(masks, None):
            times += [] if frame.time is None else [frame.time]
            count, size = frame.t + 1, (frame.mask.shape[1], frame.mask.shape[0])
            for label in frame.objects():
                keys.setdefault(label, []).append(_key(frame, box_of(frame.mask == label), speed))
        regions = [_rectangle(clip, label, keys[label], count, speed, classes) for label in sorted(keys)]
        for region in regions:
            region.update(original_width=size[0], original_height=size[1])
        data = {"video": address, "clip": clip, **({"times": times} if times else {})}
        (folder / "tasks.json").write_text(f"[\n{json_line(_task(data, regions))}\n]\n", encoding="utf-8")
        shown = f'  <Video name="video" value="$video" framerate="{speed}"/>\n'
        control = '  <VideoRectangle name="box" toName="video"/>\n'
        labels = f'  <Labels name="object" toName="video">\n{_labels(classes)}  </Labels>\n'
        (folder / "config.xml").write_text(f"<View>\n{shown}{control}{labels}</View>\n", encoding="utf-8")
    return Path(path)


def _check_rate(rate: Any) -> float:
    if isinstance(rate, bool) or not isinstance(rate, Real) or not math.isfinite(rate) or rate <= 0:
        raise illegal("rate", rate, "frames per second, above 0")
    return float(rate)


def brush_rle(inside: Bool) -> list[int]:
    """A mask as the bytes of Label Studio's brush, 255 inside and 0 outside."""
    sizes = "".join(f"{size - 1:04b}" for size in _SIZES)
    bits = [f"{4 * inside.size:032b}", f"{8 - 1:05b}", sizes]
    for i, run in enumerate(runs_of(inside.ravel())):
        bits.extend(_runs(4 * run, "11111111" if i % 2 else "00000000"))
    text = "".join(bits)
    text += "0" * (-len(text) % 8)
    return list(int(text, 2).to_bytes(len(text) // 8, "big"))


def _runs(length: int, value: str) -> Iterator[str]:
    """A run in pieces: a bit for one value repeated, two for the size of the length, the length less 1, the value."""
    while length > 0:
        part = min(length, _LONGEST)
        kind = next(i for i, size in enumerate(_SIZES) if part <= 1 << size)
        yield f"1{kind:02b}{part - 1:0{_SIZES[kind]}b}{value}"
        length -= part


def _brush(clip: str, frame: Frame, label: int, classes: Classes) -> dict[str, Any]:
    height, width = (int(side) for side in frame.mask.shape)
    value = {"format": "rle", "rle": brush_rle(frame.mask == label), "brushlabels": [classes.name(label)]}
    region = _region(f"{clip}-{frame.t}-{label}", "brushlabels", "mask", "image", value)
    return {**region, "original_width": width, "original_height": height, "image_rotation": 0}


def _key(frame: Frame, box: Box, rate: float) -> dict[str, Any]:
    height, width = (int(side) for side in frame.mask.shape)
    return {
        "frame": frame.t + 1,
        "time": (frame.t + 1) / rate,
        "enabled": True,
        "rotation": 0,
        "x": 100 * box.left / width,
        "y": 100 * box.top / height,
        "width": 100 * box.width / width,
        "height": 100 * box.height / height,
    }


def _rectangle(
    clip: str, label: int, keys: list[dict[str, Any]], count: int, rate: float, classes: Classes
) -> dict[str, Any]:
    following = [key["frame"] for key in keys[1:]] + [0]
    for key, after in zip(keys, following):
        key["enabled"] = after == key["frame"] + 1
    value = {"framesCount": count, "duration": count / rate, "sequence": keys, "labels": [classes.name(label)]}
    return _region(f"{clip}-{label}", "videorectangle", "box", "video", value)


def _region(number: str, kind: str, control: str, shown: str, value: dict[str, Any]) -> dict[str, Any]:
    return {"id": number, "type": kind, "from_name": control, "to_name": shown, "value": value}


def _task(data: dict[str, Any], regions: list[dict[str, Any]]) -> dict[str, Any]:
    return {"data": data, "predictions": [{"model_version": "tracecut", "result": regions}]}


def _labels(classes: Classes) -> str:
    colours = {name: colour(number) for name, number in classes.numbers.items()}
    return "".join(f'    <Label value={quoteattr(name)} background="{c}"/>\n' for name, c in colours.items())
