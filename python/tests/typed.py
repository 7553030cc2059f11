"""What users write, for the type checkers; never run."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Optional

import numpy as np
import numpy.typing as npt
import tracecut
from tracecut import Clusters, Explanation, Progress, Result, Session, Trajectories, VideoReader, Window

Mask = npt.NDArray[np.uint8]


def masks(folder: Path) -> list[Mask]:
    result: Result = tracecut.segment(folder, preset="fast", threads=2, progress=True)
    return [mask for mask in result]


def stream(frames: Iterator[Mask]) -> Iterator[tuple[int, Mask]]:
    window: Window
    for window in tracecut.windows(frames, window=40, flow={"patch_stride": 5}):
        for t in window.settled:
            yield t, window.labels(t)


def corrected(frames: Iterator[Mask]) -> Iterator[Mask]:
    for window in tracecut.windows(frames):
        window.session.split(1, at=(0, 3.5, 4))
        window.session.run(threads=2)
        why: Explanation = window.session.explain(0, 3, 4)
        votes: Optional[int] = None if why.flip is None else why.flip.votes
        print(votes, [cost.total for cost in why.costs])
        yield window.labels(window.settled[0])


def told(progress: Progress) -> None:
    stage: str = progress.stage
    print(stage, progress.done / progress.total)


def stages(frames: list[Mask], tracks: Optional[Trajectories]) -> Clusters:
    session = Session(clip={"max_side": 320})
    for frame in frames:
        session.push(frame)
    if tracks is not None:
        session.set_trajectories(tracks)
    session.run(progress=told)
    session.merge(1, 2)
    u: npt.NDArray[np.float32] = session.flow(0).u
    print(u.mean())
    return session.clusters()


def failure(frames: list[Mask]) -> str:
    try:
        tracecut.segment(frames)
    except tracecut.TraceCutError as error:
        return error.code
    return ""


def timed(video: Path) -> list[tuple[float, Mask]]:
    reader: VideoReader = tracecut.read_video(video)
    frames: list[Mask] = list(reader)
    print(reader.durations.sum(), len(frames))
    try:
        result: Result = tracecut.segment(video)
    except tracecut.TraceCutError as error:
        if error.result is None:
            raise
        result = error.result
    return [] if result.times is None else list(zip(result.times.tolist(), result))
