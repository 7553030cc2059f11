"""Memory does not grow beyond one window, however long the clip is."""

from __future__ import annotations

import subprocess
import sys

import pytest

RUN = """
import resource, sys, time
import tracecut

frames, window, width, height = map(int, sys.argv[1:])
scene = tracecut.synth.Scene("sample", width, height, frames)
begin = time.perf_counter()
result = tracecut.segment(iter(scene), window=window)
seconds = time.perf_counter() - begin
assert len(result) == frames and len(result.shots) == 1, result
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024, round(seconds))
"""


def peak(frames: int, window: int, width: int, height: int) -> int:
    """The peak of resident memory in MiB of a process that segments a made clip."""
    command = [sys.executable, "-c", RUN, *map(str, (frames, window, width, height))]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    print(f"{frames} frames of {width}x{height} in windows of {window}: {text.split()[0]} MiB, {text.split()[1]} s")
    return int(text.split()[0])


@pytest.mark.wheel
def test_a_longer_clip_takes_hardly_more_memory() -> None:
    assert peak(120, 12, 160, 90) <= 1.3 * peak(24, 12, 160, 90)


@pytest.mark.long
def test_1500_frames_of_640x360_take_hardly_more_memory_than_150() -> None:
    assert peak(1500, 50, 640, 360) <= 1.3 * peak(150, 50, 640, 360)
