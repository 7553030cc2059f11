"""The example for Ray: clips on two nodes of which one is lost, as clips in one process."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import tracecut

pq = pytest.importorskip("pyarrow.parquet")
EXAMPLES = str(Path(__file__).resolve().parents[1] / "examples")
sys.path.insert(0, EXAMPLES)
import ray_folder  # noqa: E402


def make_clips(folder: Path, count: int, frames: int = 6) -> None:
    """Folders of PNG files."""
    from PIL import Image

    for number in range(count):
        clip = folder / f"clip{number}"
        clip.mkdir(parents=True)
        for t, frame in enumerate(tracecut.synth.Scene("sample", 96, 64, frames, seed=number)):
            Image.fromarray(frame).save(clip / f"{t}.png")


def rows(out: Path, kind: str) -> list[dict[str, Any]]:
    """All rows, without what a clock measured."""
    found = [row for file in sorted((out / kind).glob("*.parquet")) for row in pq.read_table(file).to_pylist()]
    return sorted(({k: v for k, v in row.items() if k != "seconds"} for row in found), key=str)


@contextlib.contextmanager
def two_nodes() -> Iterator[tuple[Any, list[Any]]]:
    """A cluster on this machine: a head that takes no tasks, and two workers."""
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
    assert clips["broken.mp4"]["error_code"] in ("codec", "ImportError") and clips["clip0"]["error"] is None
    expected = tracecut.segment(tmp_path / "clips" / "clip1")
    (row,) = (r for r in rows(out, "objects") if r["clip"].endswith("clip1") and r["object"] == 1)
    for t, counts in zip(row["frame"], row["counts"]):
        mask = tracecut.from_coco_rle({"size": [row["height"], row["width"]], "counts": counts})
        assert (mask == (expected[t] == 1)).all()
    assert row["pixels"] == (expected.array() == 1).sum()


def test_what_is_done_is_left_out_and_what_failed_is_tried_again(tmp_path: Path, capsys: Any) -> None:
    make_clips(tmp_path / "clips", 2)
    broken = tmp_path / "clips" / "broken"
    broken.mkdir()
    call = [str(tmp_path / "clips"), "--out", str(tmp_path / "out"), "--here", "--set", "preset=fast"]
    assert ray_folder.main(call) == 1
    files = {file: file.stat().st_mtime_ns for file in (tmp_path / "out").rglob("*.parquet")}
    make_clips(tmp_path / "other", 1)
    (tmp_path / "other" / "clip0" / "0.png").rename(broken / "0.png")
    (tmp_path / "other" / "clip0" / "1.png").rename(broken / "1.png")
    assert ray_folder.main(call) == 0
    assert "3 clips, 2 done before" in capsys.readouterr().out
    changed = [file for file, when in files.items() if file.stat().st_mtime_ns != when]
    assert len(rows(tmp_path / "out", "clips")) == 3 and len(changed) == 2


def test_a_list_names_clips_and_memory_follows_their_size(tmp_path: Path) -> None:
    make_clips(tmp_path / "clips", 2, frames=2)
    listed = tmp_path / "clips.txt"
    listed.write_text(f"{tmp_path}/clips/clip1\n\n{tmp_path}/clips/clip0\n")
    assert ray_folder.clips_in(str(listed)) == [f"{tmp_path}/clips/clip1", f"{tmp_path}/clips/clip0"]
    small = ray_folder.memory_of(f"{tmp_path}/clips/clip0", 640)
    assert ray_folder.BASE_BYTES < small < ray_folder.memory_of("/nowhere", 640)


def chosen_clips(tmp_path: Path) -> tuple[str, list[str]]:
    """The clips that the environment's TRACECUT_CLIPS lists, with its TRACECUT_SET; or made ones and a broken one."""
    if "TRACECUT_CLIPS" in os.environ:
        settings = os.environ.get("TRACECUT_SET", "").split()
        return os.environ["TRACECUT_CLIPS"], [word for setting in settings for word in ("--set", setting)]
    make_clips(tmp_path / "clips", 8, frames=12)
    (tmp_path / "clips" / "broken.mp4").write_bytes(b"no video")
    return str(tmp_path / "clips"), []


def timed(*words: str) -> float:
    """Seconds that a run of the example takes."""
    begin = time.perf_counter()
    ray_folder.main(list(words))
    return time.perf_counter() - begin


@pytest.mark.long
def test_a_lost_node_costs_no_clip_and_changes_no_bit(tmp_path: Path) -> None:
    pytest.importorskip("ray")
    clips, settings = chosen_clips(tmp_path)
    count = len(ray_folder.clips_in(clips))
    here, there = tmp_path / "here", tmp_path / "there"
    alone = timed(clips, "--out", str(here), "--here", *settings)
    with two_nodes() as (cluster, nodes):
        lost = threading.Event()

        def lose() -> None:
            while len(list((there / "clips").glob("*.parquet"))) < count // 3:
                time.sleep(0.02)
            cluster.remove_node(nodes[0], allow_graceful=False)
            lost.set()

        thread = threading.Thread(target=lose)
        thread.start()
        together = timed(clips, "--out", str(there), *settings)
        thread.join()
        assert lost.is_set()
    print(f"{count} clips: {alone:.1f} s in one process, {together:.1f} s on two nodes of which one was lost")
    found = rows(there, "clips")
    assert len({row["clip"] for row in found}) == len(found) == count
    assert found == rows(here, "clips") and rows(there, "objects") == rows(here, "objects")
