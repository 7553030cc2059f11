"""Segments clips; long clips window by window."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Optional, Union, overload

import numpy as np
import numpy.typing as npt

from . import _masks, _progress, _tracecut
from ._errors import FrameIndexError, TraceCutError, Unpack, file_errors, index_of, raw_params, whole
from ._frames import Frames, Source, as_path, open_frames
from ._params import Params
from ._session import Session, SessionView, threads_of
from ._tracks import check_trajectories
from ._types import F64, U8, Trajectories

#: Frames of a window, as on the command line and in the npm package.
WINDOW = _tracecut.window_frames
_MAX_WINDOW = 400


@dataclass(frozen=True)
class Window:
    """A processed window of a clip.

    Attributes
    ----------
    index : int
        Its number, from 0.
    shot : int
        The number of its shot, from 0.
    first_frame : int
        Number of its first frame in the clip.
    settled : range
        The frames of the clip whose masks are final: over all windows, each frame of the clip once.
    session : SessionView
        All results of the window, until the next window is requested. Its frame 0 is ``first_frame``. Its masks can be
        corrected. Merges and splits apply to this window; later windows find their objects again, and give each the
        label that most of its trajectories have here after all corrections.
    """

    index: int
    shot: int
    first_frame: int
    settled: range
    session: SessionView

    def labels(self, t: int) -> U8:
        """The mask of frame ``t`` of the clip, at the size of the frames; until the next window is requested.

        The clip may go on, so there are no negative frames.
        """
        number = whole("t", t, -(2**62), 2**62, "a frame")
        end = self.first_frame + self.session.num_frames
        if not self.first_frame <= number < end:
            raise FrameIndexError("param", f"t = {t} (expected a frame of the window, {self.first_frame}..={end - 1})")
        return self.session.labels(number - self.first_frame)


def windows(
    frames: Frames,
    *,
    window: int = WINDOW,
    overlap: Optional[int] = None,
    threads: Optional[int] = None,
    progress: _progress.Listener = None,
    **params: Unpack[Params],
) -> Iterator[Window]:
    """Segments a clip of any length window by window, in the memory of one window.

    Objects keep their labels in all windows. A cut ends a window, and starts a new shot with new labels.

    Parameters
    ----------
    frames : frames
        As `segment`.
    window : int, default 50
        Number of frames in a window, 2 to 400.
    overlap : int, optional
        Number of frames shared with the next window, 1 to ``window - 1``; 10 by default if the window has more.
    threads, progress, **params
        As `segment`.

    Yields
    ------
    Window

    Raises
    ------
    TraceCutError
        As `segment`; it ends the iterator, and so does `KeyboardInterrupt`. ``truncated`` follows the windows of all whole
        frames.

    Examples
    --------
    >>> import tracecut
    >>> clip = tracecut.synth.Scene("sample", 96, 54, frames=20)
    >>> for part in tracecut.windows(clip, window=12, overlap=4):
    ...     print(part.settled, part.labels(part.settled[0]).shape)
    range(0, 10) (54, 96)
    range(10, 20) (54, 96)
    """
    plan = _Plan.of(window, overlap, threads, raw_params(params, *_OPTIONS))
    source = open_frames(frames)
    return _then_damage(_run_windows(source, plan, progress), source)


#: The options of `windows`, besides parameters.
_OPTIONS = ("window", "overlap", "threads", "progress")


class _Plan(NamedTuple):
    """The checked options of a run window by window."""

    window: int
    overlap: Optional[int]
    threads: int
    params: dict[str, Any]

    @classmethod
    def of(cls, window: int, overlap: Optional[int], threads: Optional[int], params: dict[str, Any]) -> _Plan:
        size = whole("window", window, 2, _MAX_WINDOW, "a whole number of frames")
        shared = None if overlap is None else whole("overlap", overlap, 1, size - 1, "a whole number of frames")
        return cls(size, shared, threads_of(threads), params)


def _run_windows(source: Source, plan: _Plan, progress: _progress.Listener) -> Iterator[Window]:
    # The usual overlap is at most half of a window.
    overlap = plan.window // 2 if plan.overlap is None else plan.overlap
    listener = _progress.raw_listener(progress, lambda: source.length, plan.window, overlap)
    frames = source.read_whole()
    try:
        raw = _tracecut.Windows(plan.params, frames, plan.window, plan.overlap, source.length, plan.threads, listener)
    except BaseException:
        _progress.close(listener)
        raise
    return _all(raw, listener)


def _all(raw: _tracecut.Windows, listener: _progress.Raw) -> Iterator[Window]:
    try:
        while (item := raw.next()) is not None:
            (index, shot, first, begin, end), session = item
            _progress.settle(listener, end - begin)
            yield Window(index, shot, first, range(first + begin, first + end), SessionView(session))
        _progress.finish(listener)
    finally:
        _progress.close(listener)


def _then_damage(parts: Iterator[Window], source: Source) -> Iterator[Window]:
    yield from parts
    if source.damage is not None:
        raise source.damage


class Result:
    """The masks of a clip, stored as run lengths.

    ``result[t]`` is the mask of frame ``t``, and ``result[2:4]`` an array of masks; negative frames count from the end,
    here and in all methods. Iterating yields all masks in order.

    A result is plain data: it can be copied, pickled, and sent to another process. Copies have no ``session``.

    Attributes
    ----------
    shots : list of int
        The first frame of each shot.
    times : array of float64 or None
        Presentation time of each frame in seconds, as in the video file; None if the frames are not from a video.
    durations : array of float64 or None
        Duration of each frame in seconds.
    working_size : tuple of int
        Width and height at which frames were processed.
    """

    def __init__(self) -> None:
        self.shots: list[int] = []
        self.times: Optional[F64] = None
        self.durations: Optional[F64] = None
        self.working_size: tuple[int, int] = (0, 0)
        self._session: Optional[SessionView] = None
        self._reason = _NO_SESSION
        self._trajectories: Optional[Trajectories] = None
        self._runs: list[_masks.Runs] = []

    def __getstate__(self) -> dict[str, Any]:
        if self._session is None:
            return self.__dict__
        return {**self.__dict__, "_session": None, "_reason": _COPIED, "_trajectories": self.trajectories}

    def __repr__(self) -> str:
        return f"<Result: {len(self)} frames of {self.width}x{self.height}, objects {self.objects}>"

    def __len__(self) -> int:
        return len(self._runs)

    @overload
    def __getitem__(self, t: int) -> U8: ...
    @overload
    def __getitem__(self, t: slice) -> U8: ...
    def __getitem__(self, t: Union[int, slice]) -> U8:
        return self._stack(self._runs[t]) if isinstance(t, slice) else self.labels(t)

    def __iter__(self) -> Iterator[U8]:
        return (runs.mask() for runs in self._runs)

    @property
    def width(self) -> int:
        """Width of the masks and frames in pixels."""
        return self._runs[0].shape[1] if self._runs else 0

    @property
    def height(self) -> int:
        """Height of the masks and frames in pixels."""
        return self._runs[0].shape[0] if self._runs else 0

    @property
    def frame_rate(self) -> Optional[float]:
        """The average number of frames per second, to a millionth; None if frames have no times."""
        if self.times is None or self.durations is None or len(self.times) == 0:
            return None
        return round(float(len(self.times) / (self.times[-1] + self.durations[-1] - self.times[0])), 6)

    @property
    def objects(self) -> list[int]:
        """The labels that appear in any mask, without the background's 0."""
        return [int(label) for label in np.flatnonzero(self.areas().sum(axis=0)) if label > 0]

    @property
    def session(self) -> SessionView:
        """The results of all stages, for a clip of one window, in the process that computed them.

        Raises
        ------
        TraceCutError
            ``state`` for longer clips and for copies of a result; the message says what to do instead.
        """
        if self._session is None:
            raise TraceCutError("state", self._reason)
        return self._session

    @property
    def trajectories(self) -> Trajectories:
        """The trajectories of a clip of one window.

        Raises
        ------
        TraceCutError
            ``state`` for longer clips.
        """
        return self.session.trajectories() if self._trajectories is None else self._trajectories

    def labels(self, t: int) -> U8:
        """The mask of frame ``t``: 0 for the background, or an object's label; shape (height, width)."""
        return self._runs[index_of(t, len(self))].mask()

    def array(self) -> U8:
        """All masks, shape (frames, height, width)."""
        return self._stack(self._runs)

    def _stack(self, runs: list[_masks.Runs]) -> U8:
        return np.stack([each.mask() for each in runs]) if runs else np.zeros((0, self.height, self.width), np.uint8)

    def areas(self) -> npt.NDArray[np.int64]:
        """Number of pixels of each label in each frame, shape (frames, 256)."""
        return np.array([runs.areas() for runs in self._runs], np.int64).reshape(-1, 256)

    def coco(self, t: int) -> dict[int, _masks.CocoRle]:
        """The COCO segmentation of each object in frame ``t``, by label."""
        mask = self.labels(t)
        return {int(label): _masks.coco_rle(mask, int(label)) for label in np.unique(mask) if label > 0}

    def png(self, t: int) -> bytes:
        """The mask of frame ``t`` as a PNG file whose pixels are the labels."""
        return _masks.mask_png(self.labels(t))

    def as_json(self) -> dict[str, Any]:
        """Sizes, objects and times, with the names of the command line's ``result.json``."""
        areas = self.areas()
        times = {}
        if self.times is not None and self.durations is not None:
            times = {"frameRate": self.frame_rate, "times": self.times.tolist(), "durations": self.durations.tolist()}
        return {
            "version": _tracecut.version,
            "width": self.width,
            "height": self.height,
            "workingWidth": self.working_size[0],
            "workingHeight": self.working_size[1],
            "frames": len(self),
            "shots": len(self.shots),
            "objects": [_object_json(label, areas[:, label]) for label in self.objects],
            **times,
        }

    def save(self, folder: Union[str, "os.PathLike[str]"]) -> list[Path]:
        """Writes all masks as ``00000.png`` and so on into a folder, creating it if needed."""
        out = as_path("folder", folder)
        paths = [out / f"{t:05}.png" for t in range(len(self))]
        with file_errors():
            out.mkdir(parents=True, exist_ok=True)
            for t, path in enumerate(paths):
                path.write_bytes(self.png(t))
        return paths

    def _add(self, mask: U8) -> None:
        self._runs.append(_masks.Runs(mask))

    def _set_times(self, source: Source) -> None:
        if source.video is not None:
            self.times, self.durations = source.video.times, source.video.durations


_NO_SESSION = (
    "a clip of several windows has no session: read results of the stages from each window of "
    "tracecut.windows(frames), or take all frames at once with window=None"
)

_COPIED = (
    "a copy of a result has no session, which stays in the process that computed it: read results of the stages and "
    "make corrections there, before you copy or pickle the result, or run tracecut.segment here"
)


def _object_json(label: int, pixels: npt.NDArray[np.int64]) -> dict[str, int]:
    seen = np.flatnonzero(pixels)
    return {
        "label": label,
        "pixels": int(pixels.sum()),
        "firstFrame": int(seen[0]),
        "lastFrame": int(seen[-1]),
    }


def segment(
    frames: Frames,
    *,
    window: Optional[int] = WINDOW,
    overlap: Optional[int] = None,
    threads: Optional[int] = None,
    progress: _progress.Listener = None,
    trajectories: Optional[Trajectories] = None,
    **params: Unpack[Params],
) -> Result:
    """Finds the moving objects of a clip.

    Parameters
    ----------
    frames : frames
        The path of a folder of images or of a video file (which needs PyAV), an open video file, an array of uint8 of
        shape (frames, height, width, 3), or arrays, Pillow images, or paths or bytes of image files one by one. All have the same
        size; RGB, RGBA or grey.
    window : int or None, default 50
        Length of a window in frames. Longer clips are processed window by window, in the memory of one window; a cut
        starts a new shot with new labels. None takes all frames at once, without cut detection; memory then grows with
        the clip.
    overlap : int, optional
        Number of frames that neighbouring windows share; 10 by default if the window has more.
    threads : int, optional
        As many as the machine runs at once by default; results are bit-identical for any number.
    progress : callable or bool, optional
        Called with a `Progress` at each step; True shows a tqdm bar, which counts frames.
    trajectories : Trajectories, optional
        The trajectories of another tracker, used instead of tracking; all frames are then taken at once.
    **params
        Parameters, as for `Session`.

    Returns
    -------
    Result

    Raises
    ------
    TraceCutError
        ``param`` for an unknown or invalid argument; ``frame-size``, ``frame-size-changed``, ``too-few-frames``,
        ``data`` and ``decode`` for frames; those of `read_video` for videos. For a truncated or damaged video
        (``truncated``) the error has the ``result`` of the ``frames`` before the damage, if there are at least two.
    KeyboardInterrupt
        Within one step of the signal.

    Examples
    --------
    >>> import tracecut
    >>> clip = tracecut.synth.Scene("sample", 160, 90, frames=8)
    >>> result = tracecut.segment(clip, preset="fast")
    >>> len(result), result[0].shape
    (8, (90, 160))
    """
    raw = raw_params(params, *_OPTIONS, "trajectories")
    tracks = None if trajectories is None else check_trajectories(trajectories)
    plan = _Plan.of(WINDOW if window is None else window, overlap, threads, raw)
    source = open_frames(frames)
    try:
        if window is None or tracks is not None:
            result = _at_once(Session(**params), source, tracks, plan.threads, progress)
        else:
            result = _by_windows(_run_windows(source, plan, progress))
    except TraceCutError as error:
        if error.code == "too-few-frames" and source.damage is not None:
            raise source.damage from None
        raise
    result._set_times(source)
    if source.damage is not None:
        source.damage.result = result
        raise source.damage
    return result


def _by_windows(parts: Iterator[Window]) -> Result:
    result = Result()
    shot, num_frames = -1, 0
    for part in parts:
        if part.shot != shot:
            shot = part.shot
            result.shots.append(part.first_frame)
        for t in part.settled:
            result._add(part.labels(t))
        result._session = part.session if part.index == 0 else None
        result.working_size = part.session.working_size or (0, 0)
        num_frames = part.first_frame + part.session.num_frames
    if num_frames < 2:
        needed = "expected at least 2: motion needs two images"
        raise TraceCutError("too-few-frames", f"{num_frames} frame(s) given ({needed})")
    return result


def _at_once(
    session: Session, source: Source, tracks: Optional[Trajectories], threads: int, progress: _progress.Listener
) -> Result:
    originals = _OriginalFrames()
    for frame in source.read_whole():
        session.push(frame)
        originals.add(session, frame)
    if tracks is not None:
        session.set_trajectories(tracks)
    session.run(threads=threads, progress=progress)
    result = Result()
    result._session, result.shots = session, [0]
    result.working_size = session.working_size or (0, 0)
    if session._raw.objects() is not None:
        for t in range(session.num_frames):
            result._add(session.labels(t, originals.get(t)))
    return result


class _OriginalFrames:
    """Frames at their original size, if the run scales them down."""

    def __init__(self) -> None:
        self._frames: list[Any] = []

    def add(self, session: Session, frame: Any) -> None:
        if session.working_size != session.size:
            self._frames.append(frame)

    def get(self, t: int) -> Any:
        return self._frames[t] if self._frames else None
