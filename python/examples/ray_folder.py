"""Segments a folder of clips with Ray and writes masks as run lengths in Parquet.

    python ray_folder.py CLIPS --out FOLDER [--threads 2] [--set flow.patch_stride=5]

CLIPS is a folder whose entries are clips (videos, or folders of PNG or JPEG files), or a text file with the path of a
clip on each line, where lines that are empty or begin with # are no clips. Both may be local or on any file system that
Arrow, and so Ray Data, reads (s3://, gs://, hdfs://). All machines must see local paths.

FOLDER gets two sets of Parquet files; ``ray.data.read_parquet(FOLDER + "/clips")`` reads one of them:

- ``clips``: a row for each clip: frames, size, times, shots, objects, seconds, and the error if there was one;
- ``objects``: a row for each clip and object: its frames, and a COCO segmentation for each of them.

A row belongs to a clip's path and the settings (``--set``). Runs with other settings add rows of their own.

Each clip is one task. Workers alone open clips. Ray runs a task again if its worker is lost. A clip that fails becomes a
row with the error and stops no other clip; a damaged video has an error and the results of the frames before the damage.
The task writes the files of its clip, the row in ``clips`` last. Another run does only the clips that have no row without
an error. Ray's dashboard shows the tasks as ``segment_clip``.

The exit code is 1 if any clip has an error.
"""

from __future__ import annotations

import argparse
import hashlib
import io
import json
import os
import re
import sys
import time
import traceback
from collections.abc import Iterator
from typing import Any, NamedTuple, Optional

import numpy as np
import pyarrow as pa
import pyarrow.dataset as ds
import pyarrow.parquet as pq
import tracecut
from pyarrow import fs

IMAGES = (".png", ".jpg", ".jpeg")
#: Peak memory of a process: a fixed part, and bytes for each processed pixel of a window. That is 416 MiB for
#: 640x360, where a clip of 1,500 frames was measured at 311 MiB; the rest is for Ray and Arrow.
BASE_BYTES, BYTES_A_PIXEL = 130 << 20, 26
WINDOW = 50
#: Bytes that are read of a video at once: a request to an object store takes longer than to send them.
READ_BYTES = 4 << 20

CLIP_ROW = pa.schema(
    [
        ("clip", pa.string()),
        ("settings", pa.string()),
        ("frames", pa.int32()),
        ("width", pa.int32()),
        ("height", pa.int32()),
        ("shots", pa.list_(pa.int32())),
        ("objects", pa.list_(pa.int32())),
        ("object_share", pa.float64()),
        ("times", pa.list_(pa.float64())),
        ("seconds", pa.float64()),
        ("version", pa.string()),
        ("error_code", pa.string()),
        ("error", pa.string()),
    ]
)
OBJECT_ROW = pa.schema(
    [
        ("clip", pa.string()),
        ("settings", pa.string()),
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

    @property
    def key(self) -> dict[str, str]:
        """The columns that tell its rows from others."""
        return {"clip": self.clip, "settings": settings_text(self.params)}


def settings_text(params: dict[str, Any]) -> str:
    """Writes parameters as JSON, in one order."""
    return json.dumps(params, sort_keys=True)


def absolute(path: str) -> str:
    """Returns a URI as it is, and a local path from the root: workers run in other folders."""
    return path if "://" in path else os.path.abspath(path)


def open_path(path: str) -> tuple[fs.FileSystem, str]:
    """Returns the file system of a path or URI, and the path there."""
    if "://" in path:
        return fs.FileSystem.from_uri(path)
    return fs.LocalFileSystem(), path


def clips_in(path: str) -> list[str]:
    """Lists the clips of a folder, or those that a text file names."""
    system, inside = open_path(path)
    if system.get_file_info(inside).type == fs.FileType.File:
        lines = system.open_input_file(inside).read().decode("utf-8-sig").split("\n")
        clips = [line.rstrip("\r") for line in lines if line.strip() and not line.startswith("#")]
        return [absolute(clip) for clip in clips]
    prefix = path[: path.index("://") + 3] if "://" in path else ""
    entries = system.get_file_info(fs.FileSelector(inside))
    return sorted(prefix + entry.path for entry in entries if not entry.base_name.startswith("."))


class ClipFile(io.BufferedReader):
    """A video on any file system, with the name that errors give."""

    name = ""


def open_clip(clip: str) -> Iterator[Any]:
    """Opens a clip, whose frames are read one at a time."""
    system, inside = open_path(clip)
    if system.get_file_info(inside).type != fs.FileType.Directory:
        file = ClipFile(system.open_input_file(inside), READ_BYTES)
        file.name = clip
        return tracecut.read_video(file)
    entries = system.get_file_info(fs.FileSelector(inside))
    images = [entry.path for entry in entries if is_image(entry)]
    return (system.open_input_file(image).read() for image in tracecut.in_name_order(images))


def is_image(entry: fs.FileInfo) -> bool:
    """Is true of files whose names end as those of images do, except hidden ones."""
    name = entry.base_name
    return entry.type == fs.FileType.File and name.lower().endswith(IMAGES) and not name.startswith(".")


def measure_clip(clip: str, max_side: int) -> int:
    """Estimates the bytes that a task takes, from the size of the clip's first frame."""
    try:
        height, width = tracecut.as_array(next(iter(open_clip(clip)))).shape[:2]
    except Exception:  # The task meets the same error and makes a row of it.
        height = width = max_side
    return task_bytes(height, width, max_side)


def task_bytes(height: int, width: int, max_side: int) -> int:
    """Estimates the bytes that a task takes. Ray starts no more tasks on a machine than fit."""
    scale = min(1.0, max_side / max(height, width))
    sources = 0 if scale == 1.0 else 3 * height * width * (WINDOW + 1)
    return BASE_BYTES + int(BYTES_A_PIXEL * WINDOW * height * width * scale * scale) + sources


def file_of(task: Task, kind: str) -> str:
    """Returns the Parquet file of a task: the same at every try, another for every clip and settings."""
    name = hashlib.sha256(json.dumps(task.key).encode()).hexdigest()[:24]
    return f"{task.out}/{kind}/{name}.parquet"


def write(task: Task, kind: str, rows: list[dict[str, Any]], schema: pa.Schema) -> None:
    """Writes rows at once or not at all."""
    system, path = open_path(file_of(task, kind))
    folder, name = path.rsplit("/", 1)
    system.create_dir(folder, recursive=True)
    buffer = io.BytesIO()
    pq.write_table(pa.Table.from_pylist([{**task.key, **row} for row in rows], schema=schema), buffer)
    # Readers of the folder leave hidden files out. One of a lost worker stays.
    part = f"{folder}/.{name}.{time.time_ns()}"
    with system.open_output_stream(part) as stream:
        stream.write(buffer.getvalue())
    system.move(part, path)


def clips_done(out: str, settings: str) -> set[str]:
    """Returns the clips that have a row with these settings and without an error."""
    system, folder = open_path(f"{out}/clips")
    if system.get_file_info(folder).type == fs.FileType.NotFound:
        return set()
    rows = ds.dataset(folder, schema=CLIP_ROW, format="parquet", filesystem=system)
    is_done = (ds.field("settings") == settings) & ds.field("error").is_null()
    return set(rows.to_table(columns=["clip"], filter=is_done)["clip"].to_pylist())


def object_rows(result: tracecut.Result) -> list[dict[str, Any]]:
    """Makes a row for each object of a clip."""
    areas = result.areas()
    rows = {
        label: {
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
    """Segments a clip, writes the rows of its objects and then its own, and returns the latter."""
    begin = time.perf_counter()
    result, problem = segment(task)
    row: dict[str, Any] = {**task.key, "version": tracecut.__version__}
    if result is not None:
        share = float(result.areas()[:, 1:].sum() / (len(result) * result.width * result.height))
        row.update(frames=len(result), width=result.width, height=result.height, shots=result.shots)
        row.update(objects=result.objects, object_share=share, times=result.times)
    if problem is not None:
        row.update(error_code=getattr(problem, "code", type(problem).__name__), error=describe(problem))
    row["seconds"] = time.perf_counter() - begin
    write(task, "objects", [] if result is None else object_rows(result), OBJECT_ROW)
    write(task, "clips", [row], CLIP_ROW)
    return row


def segment(task: Task) -> tuple[Optional[tracecut.Result], Optional[Exception]]:
    """Returns the result, or the error, or both: of a damaged video the result of the frames before the damage."""
    try:
        return tracecut.segment(open_clip(task.clip), window=WINDOW, threads=task.threads, **task.params), None
    except Exception as error:
        return getattr(error, "result", None), error


def describe(error: BaseException) -> str:
    """Returns the last line of an error, without colours."""
    text = str(error) or traceback.format_exception_only(type(error), error)[-1]
    return re.sub(r"\x1b\[[0-9;]*m", "", text).strip().splitlines()[-1]


def run_here(tasks: list[Task]) -> Iterator[dict[str, Any]]:
    """Runs one clip after the other, without Ray."""
    return (run_clip(task) for task in tasks)


def run_on_ray(tasks: list[Task], max_side: int, retries: int, address: Optional[str]) -> Iterator[dict[str, Any]]:
    """Runs the clips as tasks of Ray, and gives their rows as they end."""
    import ray

    if not ray.is_initialized():
        ray.init(address=address, log_to_driver=False)
    measure = ray.remote(name="measure_clip", max_retries=retries)(measure_clip)
    segment = ray.remote(name="segment_clip", max_retries=retries)(run_clip)
    waiting = list(reversed(tasks))
    measured: dict[Any, Task] = {}
    running: dict[Any, Task] = {}
    most = 4 * max(1, int(ray.cluster_resources().get("CPU", 1)))
    while waiting or measured or running:
        while waiting and len(measured) + len(running) < most:
            task = waiting.pop()
            measured[measure.remote(task.clip, max_side)] = task
        (ready,), _ = ray.wait([*measured, *running], num_returns=1)
        if ready in running:
            yield outcome(ready, running.pop(ready))
        else:
            task = measured.pop(ready)
            needs = {"num_cpus": task.threads, "memory": measured_bytes(ready, max_side)}
            running[segment.options(**needs).remote(task)] = task


def measured_bytes(ready: Any, max_side: int) -> int:
    """Returns a worker's estimate, or that of a square clip if Ray has given up on the worker's task."""
    import ray

    try:
        return ray.get(ready)
    except ray.exceptions.RayError:
        return task_bytes(max_side, max_side, max_side)


def outcome(ready: Any, task: Task) -> dict[str, Any]:
    """Returns the row of a clip, which is written here if Ray has given up on the task."""
    import ray

    try:
        return ray.get(ready)
    except ray.exceptions.RayError as error:
        row = {**task.key, "version": tracecut.__version__}
        row.update(error_code=type(error).__name__, error=describe(error))
        write(task, "objects", [], OBJECT_ROW)
        write(task, "clips", [row], CLIP_ROW)
        return row


def settings_of(texts: list[str]) -> dict[str, Any]:
    """Reads ``name=value`` as parameters: JSON, or text."""
    params: dict[str, Any] = {}
    for text in texts:
        name, _, value = text.partition("=")
        try:
            params[name] = json.loads(value)
        except json.JSONDecodeError:
            params[name] = value
    return params


def arguments(words: Optional[list[str]]) -> argparse.Namespace:
    """Reads the command line."""
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
    """Runs all clips that are not done; returns the number of those with an error."""
    args = arguments(words)
    params, out = settings_of(args.set), absolute(args.out)
    max_side = tracecut.Session(**params).params["clip"]["max_side"]
    tasks = [Task(clip, out, args.threads, params) for clip in dict.fromkeys(clips_in(absolute(args.clips)))]
    done = clips_done(out, settings_text(params))
    todo = [task for task in tasks if task.clip not in done]
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
