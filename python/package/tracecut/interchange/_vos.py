"""Writes the folders of DAVIS and YouTube-VOS: palette PNG files whose pixel values are the labels."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Optional

from .. import _tracecut
from .._errors import TraceCutError, file_errors, illegal
from .._frames import as_path
from ._export import (
    PALETTE,
    Classes,
    Masks,
    PathLike,
    check_folder_name,
    frames_of,
    new_folder,
    read_text,
    removed_on_failure,
    replace_text,
)

#: The label of ignored pixels in both benchmarks.
_VOID = 255


def to_davis(masks: Masks, root: PathLike, *, name: str, subset: str = "val", resolution: str = "480p") -> Path:
    """Adds a clip to a folder in the layout of DAVIS 2017, creating it if needed.

    Masks go to ``Annotations/480p/NAME/00000.png`` and so on, frame by frame, and the clip's name into
    ``ImageSets/2017/val.txt``. Put the frames into ``JPEGImages/480p/NAME/00000.jpg`` and so on.

    Parameters
    ----------
    masks : masks
        A `tracecut.Result`, or arrays of uint8 of shape (height, width) one by one. Labels are 0 to 254: DAVIS
        ignores pixels of 255.
    root : path
        The data set. Add one clip at a time: two at once may lose a name in the list.
    name : str
        The clip; the data set must not contain it yet.
    subset : str, default "val"
        The list that names it.
    resolution : str, default "480p"
        The folder in ``Annotations``.

    Returns
    -------
    pathlib.Path
        The folder with the masks.

    Raises
    ------
    TraceCutError
        ``data`` for invalid masks, ``param`` for other arguments.

    Notes
    -----
    The folders follow the benchmark's README, and the colours its own masks.

    Examples
    --------
    >>> import tempfile, tracecut
    >>> from tracecut import interchange
    >>> result = tracecut.segment(tracecut.synth.Scene("sample", 96, 54, frames=4), preset="fast")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     len(list(interchange.to_davis(result, folder, name="made").iterdir()))
    4
    """
    clip, base = check_folder_name("name", name), as_path("root", root)
    listed = base / "ImageSets" / "2017" / f"{check_folder_name('subset', subset)}.txt"
    folder = base / "Annotations" / check_folder_name("resolution", resolution) / clip
    _write_masks(masks, folder)
    with removed_on_failure(folder):
        names = read_text(listed).split("\n")
        others = [each.strip() for each in names if each.strip() and each.strip() != clip]
        replace_text(listed, "\n".join([*others, clip]) + "\n")
    return folder


def to_youtube_vos(
    masks: Masks,
    root: PathLike,
    *,
    name: str,
    subset: str = "train",
    objects: Optional[Mapping[int, str]] = None,
) -> Path:
    """Adds a clip to a folder in the layout of YouTube-VOS, creating it if needed.

    Masks go to ``train/Annotations/NAME/00000.png`` and so on, frame by frame, and each object with its category and
    its frames into ``train/meta.json``. Put the frames into ``train/JPEGImages/NAME/00000.jpg`` and so on.

    Parameters
    ----------
    masks : masks
        As `to_davis`.
    root : path
        The data set. Add one clip at a time: two at once may lose one in ``meta.json``.
    name : str
        The video's ID; the data set must not contain it yet.
    subset : str, default "train"
        The folder in the data set.
    objects : mapping of int to str, optional
        The category of each label; ``object 1`` and so on for labels without.

    Returns
    -------
    pathlib.Path
        The folder with the masks.

    Raises
    ------
    TraceCutError
        ``data`` for invalid masks or ``meta.json``, ``param`` for other arguments.

    Notes
    -----
    Folders and ``meta.json`` follow the benchmark's training set. The colours are those of DAVIS; readers use the
    labels.
    """
    clip, classes = check_folder_name("name", name), Classes(objects)
    base = as_path("root", root) / check_folder_name("subset", subset)
    path = base / "meta.json"
    meta = _read_meta(path)
    if clip in meta["videos"]:
        raise illegal("name", clip, f"a name that {path} does not have yet")
    folder = base / "Annotations" / clip
    seen = _write_masks(masks, folder)
    entry = {str(label): {"category": classes.name(label), "frames": seen[label]} for label in sorted(seen)}
    with removed_on_failure(folder):
        meta["videos"][clip] = {"objects": entry}
        replace_text(path, json.dumps(meta, indent=1, ensure_ascii=False) + "\n")
    return folder


def _write_masks(masks: Masks, folder: Path) -> dict[int, list[str]]:
    """Writes one file per mask; returns the frames of each label."""
    seen: dict[int, list[str]] = {}
    with new_folder(folder, "name") as out:
        for frame in frames_of(masks, None):
            stem = f"{frame.t:05}"
            for label in frame.objects():
                seen.setdefault(label, []).append(stem)
            if _VOID in seen:
                expected = "expected 0 to 254: 255 are pixels that the benchmark does not count"
                raise TraceCutError("data", f"mask of frame {frame.t} has label {_VOID} ({expected})")
            with file_errors():
                (out / f"{stem}.png").write_bytes(_tracecut.palette_png(frame.mask, PALETTE))
    return seen


def _read_meta(path: Path) -> dict[str, Any]:
    text = read_text(path)
    if not path.exists():
        return {"videos": {}}
    try:
        meta = json.loads(text)
        if isinstance(meta["videos"], dict):
            return dict(meta)
    except (ValueError, KeyError, TypeError):
        pass
    raise TraceCutError("data", f"{path} cannot be read (expected an object with videos)")
