"""Processes one clip through the stages."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, Literal, Optional, TypeVar, cast

import numpy as np

from . import _progress, _tracecut
from ._errors import TraceCutError, Unpack, WrongTypeError, index_of, is_text, raw_params, real, whole, wrong_type
from ._frames import FrameLike, Frames, as_array, open_frames
from ._params import Params
from ._tracks import check_trajectories
from ._types import (
    F32,
    U32,
    U8,
    Affinities,
    BoundaryMap,
    Clusters,
    Components,
    Discontinuities,
    Embedding,
    Explanation,
    FlowField,
    Progress,
    Saliency,
    Stage,
    Stroke,
    Superpixels,
    Trajectories,
    explanation,
)

#: The ways to discretize an embedding, those of the parameter ``discretize.method``.
Method = Literal["rotation-merge", "rotation", "k-means", "rotation-evidence"]

_Type = TypeVar("_Type")

_MAX_SIDE = 1 << 24


def threads_of(threads: Optional[int]) -> int:
    """Returns the number of threads: the given one, or as many as this process may run at once."""
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return whole("threads", threads, 1, 256)


def _known(what: str, stage: str, raw: Optional[_Type]) -> _Type:
    """Returns a result of a stage.

    Raises
    ------
    TraceCutError
        ``state`` if there is none.
    """
    if raw is None:
        reason = f"{what} are not available: they come with the stage {stage} (take more steps, or run the session)"
        raise TraceCutError("state", reason)
    return raw


class SessionView:
    """The results of a session, stage by stage. A missing result is an error with the code ``state``.

    Masks can be corrected: `merge`, `split`, `together`, `apart`, then `run` if they must be computed again,
    `undo_correction`.

    Values computed by a call are returned without a copy; values stored in the session are copied once, so arrays stay
    valid whatever happens to the session. Computing releases the interpreter's lock.
    """

    def __init__(self, raw: _tracecut.Session) -> None:
        self._raw = raw

    def __repr__(self) -> str:
        width, height = self.size or (0, 0)
        return f"<{type(self).__name__}: {self.num_frames} frames of {width}x{height}>"

    def __reduce__(self) -> Any:
        reason = "a session stays in its process and cannot be copied: read what you need from it, such as labels(t)"
        raise WrongTypeError("state", f"{reason} or trajectories(), and pass that")

    def _frame(self, t: int) -> int:
        """Returns the number of a frame; negative ones count from the end."""
        return index_of(t, self.num_frames)

    @property
    def num_frames(self) -> int:
        """Number of frames pushed."""
        return self._raw.info()[0]

    @property
    def size(self) -> Optional[tuple[int, int]]:
        """Width and height of the frames in pixels; None before the first."""
        size = self._raw.info()[1]
        return size if size[0] else None

    @property
    def working_size(self) -> Optional[tuple[int, int]]:
        """Width and height at which frames are processed."""
        size = self._raw.info()[2]
        return size if size[0] else None

    @property
    def params(self) -> dict[str, dict[str, Any]]:
        """The current parameters, one dictionary per section."""
        return self._raw.params()

    def flow(self, t: int) -> FlowField:
        """Forward flow from frame ``t`` to ``t + 1``, in input pixels on the grid of the working size."""
        return FlowField(*self._raw.flow(self._frame(t)))

    def trajectories(self) -> Trajectories:
        """Trajectories in input pixels."""
        return Trajectories(**_known("trajectories", "trajectories", self._raw.trajectories()))

    def mask_trajectories(self) -> Trajectories:
        """The denser trajectories for the masks, in pixels of the working size."""
        return Trajectories(
            **_known("trajectories for masks", "trajectories, if there are masks", self._raw.mask_trajectories())
        )

    def affinities(self) -> Affinities:
        """Similarities of the trajectories' motions."""
        return Affinities(*_known("affinities", "affinities", self._raw.affinities()))

    def embedding(self) -> Embedding:
        """The leading eigenvectors of the affinities."""
        return Embedding(**_known("positions in the embedding", "embedding", self._raw.embedding()))

    def discontinuities(self) -> Discontinuities:
        """Discontinuities of the embedding between neighbouring trajectories."""
        return Discontinuities(**_known("discontinuities", "discontinuities", self._raw.discontinuities()))

    def saliency(self) -> Saliency:
        """Saliency of the trajectories; there is none without frames."""
        return Saliency(**_known("saliencies", "saliency, if there are frames", self._raw.saliency()))

    def saliency_map(self, t: int) -> F32:
        """Saliency of each pixel of frame ``t``, 0 to 1, at working size; computed at each call."""
        return self._raw.saliency_map(self._frame(t))

    def components(self) -> Components:
        """Connected components of the foreground, frame by frame."""
        return Components(*_known("components", "connectedness, if there are frames", self._raw.components()))

    def clusters(self) -> Clusters:
        """The cluster of each trajectory."""
        return Clusters(*_known("clusters", "clusters", self._raw.clusters()))

    def threshold_clusters(self) -> Clusters:
        """Connected components after cutting discontinuities above ``discontinuity.threshold``."""
        return Clusters(*_known("clusters", "discontinuities", self._raw.threshold_clusters()))

    def motion_clusters(self) -> Clusters:
        """The clusters without connectedness, for comparison; computed at each call."""
        return Clusters(*_known("clusters", "discontinuities", self._raw.motion_clusters()))

    def clusters_by(self, method: Method, count: int) -> Clusters:
        """Clusters of the embedding by another discretization, for comparison with `clusters`; computed at each call.

        Parameters
        ----------
        method : str
            ``"rotation-evidence"``, ``"rotation-merge"``, ``"rotation"`` or ``"k-means"``, like the parameter
            ``discretize.method``.
        count : int
            Number of clusters before any merging, 1 to the embedding's number of eigenvectors.

        Returns
        -------
        Clusters

        Raises
        ------
        TraceCutError
            ``param`` for an invalid method or count; ``state`` until the discontinuities are known.
        """
        given: Any = method
        if not isinstance(given, str):
            raise wrong_type("method", given, "the name of a method")
        most = whole("count", count, 1, max(1, len(self.embedding().eigenvalues)))
        return Clusters(*_known("clusters", "discontinuities", self._raw.clusters_by(given, most)))

    def superpixels(self, t: int) -> Superpixels:
        """The Gabriel superpixels of frame ``t``, at working size."""
        return Superpixels(**self._raw.superpixels(self._frame(t)))

    def boundaries(self, t: int) -> BoundaryMap:
        """The boundary probability of frame ``t``, at working size; computed at each call."""
        return BoundaryMap(*self._raw.boundaries(self._frame(t)))

    def objects(self) -> U8:
        """The mask label of each cluster, 0 for the background.

        An object may have no pixel in any mask: `Result.objects` omits these.
        """
        return _known("objects", "cut, if there are masks", self._raw.objects())

    def labels(self, t: int, picture: Optional[FrameLike] = None) -> U8:
        """The mask of frame ``t``.

        Parameters
        ----------
        t : int
            The frame; negative ones count from the end, here and in all methods.
        picture : frame, optional
            The frame as it was pushed. If frames are scaled down for processing (``clip.max_side``), the mask's borders
            follow this picture, as in the files of the command line.

        Returns
        -------
        array of uint8, shape (height, width)
            0 for the background, or the number of an object, the same in all frames.
        """
        return self._raw.labels(self._frame(t), None if picture is None else as_array(picture))

    def working_labels(self, t: int) -> U8:
        """The mask of frame ``t`` at working size."""
        return self._raw.working_labels(self._frame(t))

    def cluster_labels(self, t: int) -> U32:
        """The cluster of each pixel of frame ``t``, before clusters become objects or background."""
        return self._raw.cluster_labels(self._frame(t))

    def agreement(self) -> tuple[F32, list[F32]]:
        """The agreement of the masks with those of nearby frames, moved along the flow, 0 to 1.

        Returns
        -------
        tuple of (num_frames,) float32 and list of (num_frames,) float32
            Of all objects as one, then of each object from label 1 on; NaN where there is nothing to compare.
        """
        return _known("agreements", "masks", self._raw.agreement())

    def doubts(self) -> list[range]:
        """The frames whose masks should be looked at: those that agree much less with their neighbours, or jump in size.

        Up to two frames before and after them are in the same range. Empty without masks.
        """
        return [range(first, end) for first, end in self._raw.doubts()]

    def background(self, t: int) -> U8:
        """The scene of frame ``t`` without the objects: RGBA at working size, alpha 0 where no frame shows it."""
        return self._raw.background(self._frame(t))

    def explain(self, t: int, x: int, y: int) -> Explanation:
        """Why a pixel has its label.

        Parameters
        ----------
        t : int
            The frame.
        x, y : int
            The pixel, in input pixels.

        Returns
        -------
        Explanation
            The cost of each label there and its terms, the trajectories that vote, and what would change the label.

        Raises
        ------
        TraceCutError
            ``state`` unless the run is done and has masks; ``param`` if there is no such frame or pixel.
        """
        place = whole("x", x, 0, _MAX_SIDE), whole("y", y, 0, _MAX_SIDE)
        return explanation(self._raw.explain(self._frame(t), *place))

    def object_table(self, times: Optional[Sequence[float]] = None) -> str:
        """Box, area, centre and mean motion of each object in each frame, like ``objects.csv`` of the command line.

        Parameters
        ----------
        times : sequence of float, optional
            The time of each frame in seconds, such as ``result.times``.

        Raises
        ------
        TraceCutError
            ``data`` unless there is one for each frame.
        """
        seconds = None if times is None else [real("times", time) for time in _listed("times", times)]
        if seconds is not None and len(seconds) != self.num_frames:
            expected = f"expected {self.num_frames}, one for each frame"
            raise TraceCutError("data", f"times has {len(seconds)} entries ({expected})")
        return self._raw.object_table(seconds)

    @property
    def num_corrections(self) -> int:
        """Number of active corrections."""
        return self._raw.info()[3]

    def run(self, *, threads: Optional[int] = None, progress: _progress.Listener = None) -> None:
        """Takes all steps, with the same results on any number of threads; in a window, those that corrections need.

        Parameters
        ----------
        threads : int, optional
            As many as the machine runs at once by default.
        progress : callable or bool, optional
            Called with a `Progress` at each step; True shows a tqdm bar.

        Raises
        ------
        KeyboardInterrupt
            Within one step of the signal; calling again continues.
        TraceCutError
            ``too-few-frames`` with fewer than two.
        """
        count, frames = threads_of(threads), self.num_frames
        listener = _progress.raw_listener(progress, lambda: frames or None, frames)
        try:
            self._raw.run(count, listener)
            _progress.finish(listener)
        finally:
            _progress.close(listener)

    def merge(self, into: int, from_: int) -> None:
        """Gives ``into`` the pixels of ``from_``; 0 makes them background. Masks can be read immediately.

        Raises
        ------
        TraceCutError
            ``state`` unless the run is done and has masks; ``param`` for labels that do not exist.
        """
        self._raw.merge(_label("into", into), _label("from_", from_))

    def split(self, label: int, at: Optional[tuple[int, float, float]] = None) -> None:
        """Splits an object in two; `run` computes the masks.

        Parameters
        ----------
        label : int
            The object; 0, which needs a point, makes the part there an object.
        at : (t, x, y), optional
            A point in the part that becomes the new object; by default the smaller part.

        Raises
        ------
        TraceCutError
            As `merge`, and ``data`` if there is nothing to split.
        """
        self._raw.split(_label("label", label), None if at is None else self._point(at))

    def together(self, strokes: Iterable[Stroke]) -> None:
        """Joins everything the strokes touch into one object; `run` computes the masks. Errors as `split`."""
        self._raw.strokes(False, self._raw_strokes(strokes))

    def apart(self, strokes: Iterable[Stroke]) -> None:
        """Makes what each stroke touches a separate object; `run` computes the masks. Errors as `split`."""
        self._raw.strokes(True, self._raw_strokes(strokes))

    def undo_correction(self) -> None:
        """Undoes the last correction.

        Raises
        ------
        TraceCutError
            ``state`` without an active correction.
        """
        self._raw.undo_correction()

    def _point(self, at: Any) -> tuple[int, float, float]:
        values = _listed("at", at, _POINT)
        if len(values) != 3:
            raise wrong_type("at", at, _POINT)
        return index_of(values[0], self.num_frames), real("x", values[1]), real("y", values[2])

    def _raw_strokes(self, strokes: Iterable[Stroke]) -> list[tuple[int, float, list[float]]]:
        raw: list[tuple[int, float, list[float]]] = []
        for stroke in _listed("strokes", strokes, "strokes one by one"):
            if not isinstance(stroke, Stroke):
                raise wrong_type("stroke", stroke, "a Stroke")
            t, radius = index_of(stroke.t, self.num_frames), real("radius", stroke.radius)
            raw.append((t, radius, _coordinates(stroke.points)))
        return raw


class Session(SessionView):
    """Processes one clip through the stages.

    Push frames (or set trajectories, or both), `run` or `step`, then read results. Results of a finished stage can be
    read before later stages are done. An interrupted run continues where it stopped, with the same result.

    Parameters
    ----------
    **params
        Parameters by section, such as ``flow={"patch_stride": 5}``, or ``preset="paper"`` or ``"fast"``; dotted names
        as ``**{"flow.patch_stride": 5}``, which type checkers do not know. `tracecut.parameters` lists them.

    Raises
    ------
    TraceCutError
        ``param`` for an unknown name or an invalid value.

    Examples
    --------
    >>> import tracecut
    >>> clip = tracecut.synth.Scene("sample", 96, 54, frames=4)
    >>> session = tracecut.Session(clip={"seed": 1})
    >>> session.push_all(clip)
    >>> for progress in session.steps():
    ...     if progress.stage == "clusters":
    ...         print(session.clusters().count > 0)
    True
    >>> session.labels(0).shape
    (54, 96)
    """

    def __init__(self, **params: Unpack[Params]) -> None:
        super().__init__(_tracecut.Session(raw_params(params)))

    def push(self, frame: FrameLike) -> None:
        """Adds the next frame.

        Raises
        ------
        TraceCutError
            ``frame-size-changed`` unless it has the size of the first; ``data`` if it is not a frame; ``state`` if the
            run has begun. The session stays unchanged.
        """
        self._raw.push(as_array(frame))

    def push_all(self, frames: Frames) -> None:
        """Adds all frames of a clip. For a damaged video, adds those before the damage and raises ``truncated``."""
        for frame in open_frames(frames).frames:
            self._raw.push(frame)

    def set_trajectories(self, trajectories: Trajectories) -> None:
        """Uses the trajectories of another tracker instead of tracking.

        With frames, one for each frame of the trajectories, the run also computes masks; without frames, it ends with
        the labels of the trajectories.

        Raises
        ------
        TraceCutError
            ``data`` if they are not as `Trajectories` describes, or differ from the frames in size; ``state`` if the
            run has begun.
        """
        t = check_trajectories(trajectories)
        columns = t.start_frame.tolist(), t.offset.tolist()
        self._raw.set_trajectories(t.num_frames, (t.width, t.height), *columns, t.x, t.y)

    def step(self) -> Optional[Progress]:
        """Takes one bounded step; returns None when the run is done.

        Raises
        ------
        TraceCutError
            ``too-few-frames`` with fewer than two.
        """
        step = self._raw.step()
        return None if step is None else Progress(cast("Stage", step[0]), *step[1:])

    def steps(self) -> Iterator[Progress]:
        """Takes all steps, one at a time."""
        while (progress := self.step()) is not None:
            yield progress

    def clear(self) -> None:
        """Drops frames and results; parameters stay."""
        self._raw.clear()


_POINT = "a point: frame, x and y"


def _label(name: str, label: int) -> int:
    return whole(name, label, 0, 255, "a label")


def _listed(name: str, values: Any, expected: str = "numbers one by one") -> list[Any]:
    try:
        if not is_text(values):
            return list(values)
    except TypeError:
        pass
    raise wrong_type(name, values, expected)


def _coordinates(points: Any) -> list[float]:
    """Returns x and y of each point in turn."""
    try:
        array = np.asarray(points, np.float64)
        coordinates: list[float] = array.reshape(-1, 2).ravel().tolist()
    except (TypeError, ValueError, OverflowError):
        raise wrong_type("points", points, "x and y of each point") from None
    return coordinates
