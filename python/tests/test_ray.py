"""The example for Ray: in one process, and on two nodes where a worker is killed and a node is lost."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Optional

import numpy as np
import pytest
import tracecut
from conftest import write_pictures, write_video

pq = pytest.importorskip("pyarrow.parquet")
from pyarrow.fs import LocalFileSystem  # noqa: E402

EXAMPLES = str(Path(__file__).resolve().parents[1] / "examples")
sys.path.insert(0, EXAMPLES)
import ray_folder  # noqa: E402


def make_clips(folder: Path, count: int, frames: int = 6) -> None:
    """Makes folders of PNG files."""
    for number in range(count):
        scene = tracecut.synth.Scene("sample", 96, 64, frames, seed=number)
        write_pictures(folder / f"clip{number}", scene, "{}.png")


def rows(out: Path, kind: str) -> list[dict[str, Any]]:
    """Reads all rows, without what a clock measured."""
    found = [row for file in sorted((out / kind).glob("*.parquet")) for row in pq.read_table(file).to_pylist()]
    return sorted(({k: v for k, v in row.items() if k != "seconds"} for row in found), key=str)


@contextlib.contextmanager
def two_nodes() -> Iterator[tuple[Any, list[Any]]]:
    """Starts a cluster on this machine: a head that takes no tasks, and two workers."""
    ray = pytest.importorskip("ray")
    from ray.cluster_utils import Cluster

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0})
    try:
        nodes = [cluster.add_node(num_cpus=1) for _ in range(2)]
        cluster.wait_for_nodes()
        # The workers import the example, which is a module here and not the program that runs.
        ray.init(address=cluster.address, log_to_driver=False, runtime_env={"env_vars": {"PYTHONPATH": EXAMPLES}})
        yield cluster, nodes
    finally:
        ray.shutdown()
        cluster.shutdown()


def test_clips_become_rows_and_failures_too(tmp_path: Path) -> None:
    make_clips(tmp_path / "clips", 2)
    (tmp_path / "clips" / "broken.mp4").write_bytes(b"no video")
    out = tmp_path / "out"
    assert ray_folder.main([str(tmp_path / "clips"), "--out", str(out), "--here"]) == 1
    clips = {Path(row["clip"]).name: row for row in rows(out, "clips")}
    assert set(clips) == {"clip0", "clip1", "broken.mp4"}
    assert clips["broken.mp4"]["error_code"] in ("no-video", "unsupported") and clips["clip0"]["error"] is None
    expected = tracecut.segment(tmp_path / "clips" / "clip1")
    (row,) = (r for r in rows(out, "objects") if r["clip"].endswith("clip1") and r["object"] == 1)
    for t, counts in zip(row["frame"], row["counts"]):
        mask = tracecut.from_coco_rle({"size": [row["height"], row["width"]], "counts": counts})
        assert (mask == (expected[t] == 1)).all()
    assert row["pixels"] == (expected.array() == 1).sum()


def run(capsys: Any, *words: object) -> str:
    """Runs the example in this process; returns the first line that it prints."""
    ray_folder.main([*map(str, words), "--here"])
    return str(capsys.readouterr().out).splitlines()[0]


def test_another_run_repeats_only_failed_clips(tmp_path: Path, capsys: Any) -> None:
    make_clips(tmp_path / "clips", 2)
    broken = tmp_path / "clips" / "broken"
    broken.mkdir()
    call = [tmp_path / "clips", "--out", tmp_path / "out", "--set", "preset=fast"]
    assert run(capsys, *call) == "3 clips, 0 done before"
    files = {file: file.stat().st_mtime_ns for file in (tmp_path / "out").rglob("*.parquet")}
    make_clips(tmp_path / "other", 1)
    (tmp_path / "other" / "clip0" / "0.png").rename(broken / "0.png")
    (tmp_path / "other" / "clip0" / "1.png").rename(broken / "1.png")
    # macOS puts such files beside those that it copies.
    (broken / "._1.png").write_bytes(b"attributes")
    assert run(capsys, *call) == "3 clips, 2 done before"
    changed = [file for file, when in files.items() if file.stat().st_mtime_ns != when]
    assert len(rows(tmp_path / "out", "clips")) == 3 and len(changed) == 2
    assert all(row["error"] is None for row in rows(tmp_path / "out", "clips"))


def test_rows_belong_to_a_path_and_settings(tmp_path: Path, capsys: Any) -> None:
    make_clips(tmp_path / "a", 1)
    make_clips(tmp_path / "b", 1)
    out = tmp_path / "out"
    fast = ["--set", "preset=fast", "--set", "flow.patch_stride=5"]
    same_fast = ["--set", "flow.patch_stride=5", "--set", "preset=fast"]
    for clips, settings, said in [
        ("a", [], "1 clips, 0 done before"),
        ("a", fast, "1 clips, 0 done before"),
        ("b", [], "1 clips, 0 done before"),
        ("a", [], "1 clips, 1 done before"),
        ("a", same_fast, "1 clips, 1 done before"),
        ("b", fast, "1 clips, 0 done before"),
    ]:
        assert run(capsys, tmp_path / clips, "--out", out, *settings) == said
    keys = {(row["clip"], row["settings"]) for row in rows(out, "clips")}
    assert {settings for _, settings in keys} == {"{}", '{"flow.patch_stride": 5, "preset": "fast"}'}
    assert len(keys) == len(rows(out, "clips")) == 4
    assert {(row["clip"], row["settings"]) for row in rows(out, "objects")} == keys


class EndsBeforeMove:
    """A file system of a worker that is lost when its file is written and has not its name yet."""

    def __init__(self, system: Any) -> None:
        self.system = system

    def __getattr__(self, name: str) -> Any:
        return getattr(self.system, name)

    def move(self, *_: str) -> None:
        raise KeyboardInterrupt


def test_the_unfinished_file_of_a_lost_worker_is_ignored(tmp_path: Path, capsys: Any) -> None:
    make_clips(tmp_path / "clips", 1)
    out = tmp_path / "out"
    task = ray_folder.Task(str(tmp_path / "clips" / "clip0"), str(out), 1, {})
    with pytest.MonkeyPatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(ray_folder, "open_path", lambda path: (EndsBeforeMove(LocalFileSystem()), path))
        ray_folder.write(task, "clips", [{}], ray_folder.CLIP_ROW)
    (left,) = (out / "clips").iterdir()
    left.write_bytes(b"half")
    assert run(capsys, tmp_path / "clips", "--out", out) == "1 clips, 0 done before"
    assert run(capsys, tmp_path / "clips", "--out", out) == "1 clips, 1 done before"
    assert left.exists() and len(pq.read_table(out / "clips").to_pylist()) == 1


def test_a_list_of_clips_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    listed = tmp_path / "clips.txt"
    listed.write_bytes("\ufeff/a/one.mp4\r\n\r\n# a comment\r\ntwo words.mp4\r\ns3://bucket/three.mp4".encode())
    monkeypatch.chdir(tmp_path)
    assert ray_folder.clips_in("clips.txt") == ["/a/one.mp4", f"{tmp_path}/two words.mp4", "s3://bucket/three.mp4"]


def test_memory_follows_the_size_of_frames(tmp_path: Path) -> None:
    make_clips(tmp_path / "clips", 1, frames=2)
    small = ray_folder.measure_clip(f"{tmp_path}/clips/clip0", 640)
    assert ray_folder.BASE_BYTES < small < ray_folder.measure_clip("/nowhere", 640)


def test_a_damaged_video_is_an_error_with_the_rows_before_the_damage(tmp_path: Path, capsys: Any) -> None:
    clips, out = tmp_path / "clips", tmp_path / "out"
    clips.mkdir()
    frames = list(tracecut.synth.Scene("sample", 96, 64, 16, seed=0))
    # Each frame stands alone.
    write_video(clips / "whole.ts", frames, "mpeg2video", "yuv420p", g="1")
    data = (clips / "whole.ts").read_bytes()
    (clips / "cut.ts").write_bytes(data[: len(data) * 2 // 3])
    run(capsys, clips, "--out", out, "--set", "preset=fast")
    found = {Path(row["clip"]).name: row for row in rows(out, "clips")}
    whole, cut = found["whole.ts"], found["cut.ts"]
    assert (whole["frames"], whole["error"]) == (16, None)
    assert np.allclose(np.diff(whole["times"]), 0.04, atol=0.001)
    assert cut["error_code"] == "truncated" and cut["error"].startswith(f"{clips}/cut.ts: ")
    assert 2 <= cut["frames"] == len(cut["times"]) < 16
    assert {Path(row["clip"]).name for row in rows(out, "objects")} == {"whole.ts", "cut.ts"}


def list_clips(tmp_path: Path) -> Path:
    """Lists sixteen clips, and four of which no masks can be made."""
    make_clips(tmp_path, 16, frames=24)
    (tmp_path / "text.mp4").write_bytes(b"no video")
    (tmp_path / "empty").mkdir()
    make_clips(tmp_path / "one", 1, frames=1)
    bad = ["text.mp4", "empty", "one/clip0", "absent.mp4"]
    good = [f"clip{number}" for number in range(16)]
    listed = tmp_path / "clips.txt"
    # Bad ones between good ones.
    listed.write_text("\n".join(str(tmp_path / name) for name in [*bad[:2], *good[:8], *bad[2:], *good[8:]]))
    return listed


def started_here(process: int) -> bool:
    """Is true of this process and all that it has started."""
    while process > 1:
        if process == os.getpid():
            return True
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        process = int(fields[1])
    return False


def busy_worker() -> Optional[int]:
    """Finds a worker of this test's cluster that is segmenting a clip."""
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if (folder / "cmdline").read_bytes().startswith(b"ray::segment_clip") and started_here(int(folder.name)):
                return int(folder.name)
    return None


def with_losses(rows: Iterator[dict[str, Any]], losses: dict[int, Callable[[], bool]]) -> Iterator[dict[str, Any]]:
    """Yields rows, and calls each function after that number of rows, again after each further row until it succeeds."""
    remaining = sorted(losses.items())
    for count, row in enumerate(rows, 1):
        yield row
        if remaining and count >= remaining[0][0] and remaining[0][1]():
            del remaining[0]
    assert not remaining, "something was not lost"


def kill_worker() -> bool:
    """Kills a worker in the middle of a clip, if there is one now."""
    worker = busy_worker()
    if worker is not None:
        os.kill(worker, signal.SIGKILL)
    return worker is not None


@pytest.mark.long
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="finds workers in /proc")
def test_a_killed_worker_and_a_lost_node_lose_no_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("ray")
    listed, here, there = list_clips(tmp_path), tmp_path / "here", tmp_path / "there"
    assert ray_folder.main([str(listed), "--out", str(here), "--here"]) == 4
    # Workers have a module of their own.
    monkeypatch.setattr(ray_folder, "open_clip", lambda clip: pytest.fail(f"the driver reads {clip}"))
    with two_nodes() as (cluster, nodes):
        lose_node = lambda: cluster.remove_node(nodes[0], allow_graceful=False) or True  # noqa: E731
        losses = {4: kill_worker, 8: kill_worker, 11: lose_node}
        on_ray = ray_folder.run_on_ray
        with monkeypatch.context() as patch:
            patch.setattr(ray_folder, "run_on_ray", lambda *options: with_losses(on_ray(*options), losses))
            assert ray_folder.main([str(listed), "--out", str(there)]) == 4
        found = rows(there, "clips")
        assert len({row["clip"] for row in found}) == len(found) == 20
        assert sum(row["error"] is not None for row in found) == 4
        assert found == rows(here, "clips") and rows(there, "objects") == rows(here, "objects")
        files = {file: file.stat().st_mtime_ns for file in (there / "clips").glob("*.parquet")}
        assert ray_folder.main([str(listed), "--out", str(there)]) == 4
        again = {file for file, when in files.items() if file.stat().st_mtime_ns != when}
        assert again == {file for file in files if pq.read_table(file)["error"][0].as_py() is not None}
