"""Runs a folder of clips with Ray: masks as run lengths in Parquet.

    python ray_folder.py CLIPS --out FOLDER [--threads 2] [--set flow.patch_stride=5]

CLIPS is a folder whose entries are clips (videos, or folders of PNG or JPEG files), or a text file with the path of a
clip on each line; both may be local or on any file system that Arrow, and so Ray Data, reads (s3://, gs://, hdfs://).

FOLDER gets two sets of Parquet files, a file for each clip; ``ray.data.read_parquet(FOLDER + "/clips")`` reads one:

- ``clips``: a row for each clip: frames, size, shots, objects, seconds, and what went wrong, if anything did;
- ``objects``: a row for each clip and object: its frames, and a COCO segmentation for each of them.

One task a clip. A task whose worker is lost is run again; a clip that fails is a row and stops nothing. The files of a
clip are written by its task, under names of their own, the row in ``clips`` last: run again, all clips that have one
without an error are left out. The tasks' progress is in Ray's dashboard under ``segment_clip``.
"""

from __future__ import annotations

import argparse
import hashlib
import io
import json
import re
import sys
import time
import traceback
from collections.abc import Iterator
from typing import Any, NamedTuple, Optional

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import tracecut
from pyarrow import fs

IMAGES = (".png", ".jpg", ".jpeg")
#: Peak memory of a process: a fixed part, and bytes for each processed pixel of a window. That is 416 MiB for
#: 640x360, where a clip of 1,500 frames was measured at 311 MiB; the rest is for Ray and Arrow.
BASE_BYTES, BYTES_A_PIXEL = 130 << 20, 26
WINDOW = 50

CLIP_ROW = pa.schema(
    [
        ("clip", pa.string()),
        ("frames", pa.int32()),
        ("width", pa.int32()),
        ("height", pa.int32()),
        ("shots", pa.list_(pa.int32())),
        ("objects", pa.list_(pa.int32())),
        ("object_share", pa.float64()),
        ("seconds", pa.float64()),
        ("error_code", pa.string()),
        ("error", pa.string()),
    ]
)
OBJECT_ROW = pa.schema(
    [
        ("clip", pa.string()),
        ("object", pa.int32()),
        ("pixels", pa.int64()),
        ("first_frame", pa.int32()),
        ("last_frame", pa.int32()),
        ("frame", pa.list_(pa.int32())),
        ("height", pa.int32()),
        ("width", pa.int32()),
        ("counts", pa.list_(pa.string())),
    ]
)


class Task(NamedTuple):
    """What a worker needs to know."""

    clip: str
    out: str
    threads: int
    params: dict[str, Any]


def open_path(path: str) -> tuple[fs.FileSystem, str]:
    """The file system of a path or URI, and the path there."""
    if "://" in path:
        return fs.FileSystem.from_uri(path)
    return fs.LocalFileSystem(), str(path)


def clips_in(path: str) -> list[str]:
    """The clips of a folder, or those that a text file names."""
    system, inside = open_path(path)
    if system.get_file_info(inside).type == fs.FileType.File:
        text = system.open_input_file(inside).read().decode()
        return [line.strip() for line in text.splitlines() if line.strip()]
    prefix = path[: path.index("://") + 3] if "://" in path else ""
    entries = system.get_file_info(fs.FileSelector(inside))
    return sorted(prefix + e.path for e in entries if not e.base_name.startswith("."))


def frames_of(clip: str) -> Iterator[Any]:
    """The frames of a clip, one at a time."""
    system, inside = open_path(clip)
    if system.get_file_info(inside).type == fs.FileType.Directory:
        entries = [e.path for e in system.get_file_info(fs.FileSelector(inside)) if e.path.lower().endswith(IMAGES)]
        for entry in tracecut.in_name_order(entries):
            yield system.open_input_file(entry).read()
    else:
        yield from tracecut.read_video(io.BytesIO(system.open_input_file(inside).read()))


def memory_of(clip: str, max_side: int) -> int:
    """Bytes that a task takes, by the size of the clip's frames: Ray puts no more on a machine than fit."""
    try:
        first = next(frames_of(clip))
        height, width = tracecut.as_array(first).shape[:2]
    except Exception:  # What is wrong with it becomes the clip's row.
        height = width = max_side
    scale = min(1.0, max_side / max(height, width))
    sources = 0 if scale == 1.0 else 3 * height * width * (WINDOW + 1)
    return BASE_BYTES + int(BYTES_A_PIXEL * WINDOW * height * width * scale * scale) + sources


def file_of(task: Task, kind: str) -> str:
    """The Parquet file of a clip: the same at every try, another for every clip."""
    name = hashlib.sha256(task.clip.encode()).hexdigest()[:24]
    return f"{task.out}/{kind}/{name}.parquet"


def write(task: Task, kind: str, rows: list[dict[str, Any]], schema: pa.Schema) -> None:
    """Writes rows at once or not at all."""
    system, path = open_path(file_of(task, kind))
    system.create_dir(path.rsplit("/", 1)[0], recursive=True)
    buffer = io.BytesIO()
    pq.write_table(pa.Table.from_pylist(rows, schema=schema), buffer)
    part = f"{path}.{time.time_ns()}.part"
    with system.open_output_stream(part) as stream:
        stream.write(buffer.getvalue())
    system.move(part, path)


def is_done(task: Task) -> bool:
    """Whether the clip has a row without an error."""
    system, path = open_path(file_of(task, "clips"))
    if system.get_file_info(path).type == fs.FileType.NotFound:
        return False
    return pq.read_table(path, filesystem=system).column("error")[0].as_py() is None


def object_rows(task: Task, result: tracecut.Result) -> list[dict[str, Any]]:
    """A row for each object of a clip."""
    areas = result.areas()
    rows = {
        label: {
            "clip": task.clip,
            "object": label,
            "pixels": int(areas[:, label].sum()),
            "first_frame": int(np.flatnonzero(areas[:, label])[0]),
            "last_frame": int(np.flatnonzero(areas[:, label])[-1]),
            "frame": [],
            "height": result.height,
            "width": result.width,
            "counts": [],
        }
        for label in result.objects
    }
    for t in range(len(result)):
        for label, segmentation in result.coco(t).items():
            rows[label]["frame"].append(t)
            rows[label]["counts"].append(segmentation["counts"])
    return list(rows.values())


def run_clip(task: Task) -> dict[str, Any]:
    """Segments a clip, writes the rows of its objects, and returns the row of the clip."""
    begin = time.perf_counter()
    row: dict[str, Any] = {"clip": task.clip}
    objects: list[dict[str, Any]] = []
    try:
        result = tracecut.segment(frames_of(task.clip), window=WINDOW, threads=task.threads, **task.params)
        objects = object_rows(task, result)
        share = float(result.areas()[:, 1:].sum() / max(1, len(result) * result.width * result.height))
        row.update(frames=len(result), width=result.width, height=result.height, shots=result.shots)
        row.update(objects=result.objects, object_share=share)
    except Exception as error:
        row.update(error_code=getattr(error, "code", type(error).__name__), error=describe(error))
    row["seconds"] = time.perf_counter() - begin
    write(task, "objects", objects, OBJECT_ROW)
    write(task, "clips", [row], CLIP_ROW)
    return row


def describe(error: BaseException) -> str:
    """What went wrong, in a line without colours."""
    text = str(error) or traceback.format_exception_only(type(error), error)[-1]
    return re.sub(r"\x1b\[[0-9;]*m", "", text).strip().splitlines()[-1]


def run_here(tasks: list[Task]) -> Iterator[dict[str, Any]]:
    """One clip after the other, without Ray."""
    return (run_clip(task) for task in tasks)


def run_on_ray(tasks: list[Task], max_side: int, retries: int, address: Optional[str]) -> Iterator[dict[str, Any]]:
    """The clips as tasks of Ray, as they come to an end."""
    import ray

    if not ray.is_initialized():
        ray.init(address=address, log_to_driver=False)
    segment_clip = ray.remote(run_clip)
    same = {"name": "segment_clip", "max_retries": retries}
    open_tasks: dict[Any, Task] = {}
    waiting = list(reversed(tasks))
    most = 4 * max(1, int(ray.cluster_resources().get("CPU", 1)))
    while waiting or open_tasks:
        while waiting and len(open_tasks) < most:
            task = waiting.pop()
            needs = {"num_cpus": task.threads, "memory": memory_of(task.clip, max_side)}
            open_tasks[segment_clip.options(**same, **needs).remote(task)] = task
        (ready,), _ = ray.wait(list(open_tasks), num_returns=1)
        yield outcome(ready, open_tasks.pop(ready))


def outcome(ready: Any, task: Task) -> dict[str, Any]:
    """The row of a clip, also where Ray has given up on its task."""
    import ray

    try:
        return ray.get(ready)
    except ray.exceptions.RayError as error:
        row = {"clip": task.clip, "error_code": type(error).__name__, "error": describe(error)}
        write(task, "objects", [], OBJECT_ROW)
        write(task, "clips", [row], CLIP_ROW)
        return row


def settings_of(texts: list[str]) -> dict[str, Any]:
    """``name=value`` as parameters: JSON, or text."""
    params: dict[str, Any] = {}
    for text in texts:
        name, _, value = text.partition("=")
        try:
            params[name] = json.loads(value)
        except json.JSONDecodeError:
            params[name] = value
    return params


def arguments(words: Optional[list[str]]) -> argparse.Namespace:
    """What the command line says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clips", help="folder of clips, or a text file that names them")
    parser.add_argument("--out", required=True, help="folder for the Parquet files")
    parser.add_argument("--threads", type=int, default=1, help="threads, and processors of Ray, a clip [1]")
    parser.add_argument("--retries", type=int, default=3, help="how often a task whose worker is lost is run again [3]")
    parser.add_argument("--address", help="of a cluster; without it Ray starts on this machine")
    parser.add_argument("--here", action="store_true", help="one clip after the other in this process, without Ray")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="a parameter; may be repeated")
    return parser.parse_args(words)


def main(words: Optional[list[str]] = None) -> int:
    """Runs all clips that have no row yet; gives the number of those that failed."""
    args = arguments(words)
    params = settings_of(args.set)
    max_side = tracecut.Session(**params).params["clip"]["max_side"]
    tasks = [Task(clip, args.out, args.threads, params) for clip in clips_in(args.clips)]
    todo = [task for task in tasks if not is_done(task)]
    print(f"{len(tasks)} clips, {len(tasks) - len(todo)} done before", flush=True)
    begin, failed = time.perf_counter(), 0
    rows = run_here(todo) if args.here else run_on_ray(todo, max_side, args.retries, args.address)
    for count, row in enumerate(rows, 1):
        failed += row.get("error") is not None
        what = row.get("error") or f"{row['frames']} frames, objects {row['objects']}"
        print(f"{count}/{len(todo)} {row['clip']}: {what}", flush=True)
    print(f"{len(todo)} clips in {time.perf_counter() - begin:.1f} s, {failed} failed", flush=True)
    return failed


if __name__ == "__main__":
    sys.exit(1 if main() else 0)
