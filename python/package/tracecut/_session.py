"""One clip on its way through the stages."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, Optional, TypeVar, Union

import numpy as np

from . import _progress, _tracecut
from ._errors import TraceCutError, illegal
from ._frames import FrameLike, Frames, as_array, open_frames
from ._types import (
    F32,
    U8,
    U32,
    Affinities,
    BoundaryMap,
    Clusters,
    Components,
    Discontinuities,
    Embedding,
    FlowField,
    Progress,
    Saliency,
    Stroke,
    Superpixels,
    Trajectories,
)
from ._why import Explanation, explanation

_Found = TypeVar("_Found")


def threads_of(threads: Optional[int]) -> int:
    """So many, or as many as this process may run at once."""
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if not 1 <= threads <= 256:
        raise illegal("threads", threads, "a whole number, 1..=256")
    return threads


def _made(kind: Callable[..., _Found], raw: Optional[Union[dict[str, Any], tuple[Any, ...]]]) -> Optional[_Found]:
    """Converts a result of the native module to a class; None if there is no result."""
    if raw is None:
        return None
    return kind(**raw) if isinstance(raw, dict) else kind(*raw)


class SessionView:
    """The results of a session, stage by stage; what is not known yet is None, or an error with the code ``state``.

    Masks can be corrected: `merge`, `split`, `together`, `apart`, then `run` to make the masks again, `undo_correction`.

    What is computed at the call is handed over without a copy; what the session keeps is copied once, so that arrays
    stay as they are whatever becomes of the session. Computing releases the interpreter's lock.
    """

    def __init__(self, raw: _tracecut.Session) -> None:
        self._raw = raw

    def __repr__(self) -> str:
        width, height = self.size or (0, 0)
        return f"<{type(self).__name__}: {self.num_frames} frames of {width}x{height}>"

    @property
    def num_frames(self) -> int:
        """Frames pushed."""
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
        """The parameters in force, a dictionary for each section."""
        return self._raw.params()

    def flow(self, t: int) -> FlowField:
        """Forward flow from frame ``t`` to ``t + 1``, in input pixels on the grid of the working size."""
        return FlowField(*self._raw.flow(t))

    def trajectories(self) -> Optional[Trajectories]:
        """Trajectories in input pixels."""
        return _made(Trajectories, self._raw.trajectories())

    def mask_trajectories(self) -> Optional[Trajectories]:
        """The denser ones that masks are made from, in pixels of the working size."""
        return _made(Trajectories, self._raw.mask_trajectories())

    def affinities(self) -> Optional[Affinities]:
        """Returns the affinities of the motions of trajectories."""
        return _made(Affinities, self._raw.affinities())

    def embedding(self) -> Optional[Embedding]:
        """The leading eigenvectors of the affinities."""
        return _made(Embedding, self._raw.embedding())

    def discontinuities(self) -> Optional[Discontinuities]:
        """Neighbouring trajectories, and where the embedding breaks between them."""
        return _made(Discontinuities, self._raw.discontinuities())

    def saliency(self) -> Optional[Saliency]:
        """Returns the saliency of trajectories; None without frames."""
        return _made(Saliency, self._raw.saliency())

    def saliency_map(self, t: int) -> F32:
        """Computes the saliency of each pixel of frame ``t``, 0 to 1, at working size."""
        return self._raw.saliency_map(t)

    def components(self) -> Optional[Components]:
        """Connected pieces of the foreground, frame by frame."""
        return _made(Components, self._raw.components())

    def clusters(self) -> Optional[Clusters]:
        """The cluster of each trajectory."""
        return _made(Clusters, self._raw.clusters())

    def threshold_clusters(self) -> Optional[Clusters]:
        """Segments by cutting discontinuities above ``discontinuity.threshold``."""
        return _made(Clusters, self._raw.threshold_clusters())

    def motion_clusters(self) -> Optional[Clusters]:
        """Computes the clusters with connectedness off, to show its effect."""
        return _made(Clusters, self._raw.motion_clusters())

    def clusters_by(self, method: str, count: int) -> Optional[Clusters]:
        """Discretizes the embedding by another method, to compare with `clusters`.

        Parameters
        ----------
        method : str
            ``"rotation-evidence"``, ``"rotation-merge"``, ``"rotation"`` or ``"k-means"``, as the parameter
            ``discretize.method``.
        count : int
            Clusters before any merging, 1 to the embedding's number of eigenvectors.

        Returns
        -------
        Clusters or None
            None until the discontinuities are known.

        Raises
        ------
        TraceCutError
            ``param`` for a method or a count that is not legal.
        """
        embedding = self.embedding()
        most = 1 if embedding is None else max(1, len(embedding.eigenvalues))
        if not 1 <= count <= most and embedding is not None:
            raise illegal("count", count, f"a whole number, 1..={most}")
        return _made(Clusters, self._raw.clusters_by(method, max(1, count)))

    def superpixels(self, t: int) -> Superpixels:
        """The Gabriel superpixels of frame ``t``, at working size."""
        return Superpixels(**self._raw.superpixels(t))

    def boundaries(self, t: int) -> BoundaryMap:
        """Computes the boundary probability of frame ``t``, at working size."""
        return BoundaryMap(*self._raw.boundaries(t))

    def objects(self) -> Optional[U8]:
        """The mask label of each cluster, 0 for the background; None until the cut is made.

        An object may be without a pixel in any mask: `Result.objects` leaves such out.
        """
        return self._raw.objects()

    def labels(self, t: int, picture: Optional[FrameLike] = None) -> U8:
        """The mask of frame ``t``.

        Parameters
        ----------
        t : int
            The frame.
        picture : frame, optional
            The frame as it was pushed. Where frames are reduced for processing (``clip.max_side``), the borders of the
            mask come to where it has them, as in the files of the command line.

        Returns
        -------
        array of uint8, shape (height, width)
            0 for the background, or the number of an object, the same in all frames.
        """
        return self._raw.labels(t, None if picture is None else as_array(picture))

    def working_labels(self, t: int) -> U8:
        """The mask of frame ``t`` at working size."""
        return self._raw.working_labels(t)

    def cluster_labels(self, t: int) -> U32:
        """Returns the cluster of each pixel of frame ``t``."""
        return self._raw.cluster_labels(t)

    def confidence(self, t: int) -> F32:
        """Computes the probability that each pixel of frame ``t`` is correctly labelled, at working size."""
        return self._raw.confidence(t)

    def object_confidence(self) -> F32:
        """The mean of that for each label, the background first."""
        return self._raw.object_confidence()

    def background(self, t: int) -> U8:
        """The scene of frame ``t`` without the objects: RGBA at working size, alpha 0 where no frame shows it."""
        return self._raw.background(t)

    def explain(self, t: int, x: int, y: int) -> Explanation:
        """Explains the label of a pixel.

        Parameters
        ----------
        t : int
            The frame.
        x, y : int
            The pixel, in input pixels.

        Returns
        -------
        Explanation
            What each label would cost there and why, the trajectories that vote, and what would change the label.

        Raises
        ------
        TraceCutError
            ``state`` unless the run is done and has masks, or when there is no such frame; ``param`` when the pixel is
            not in the frame.
        """
        for name, value in (("t", t), ("x", x), ("y", y)):
            if value < 0:
                raise illegal(name, value, "a whole number, 0 or more")
        return explanation(self._raw.explain(t, x, y))

    def object_table(self, times: Optional[Sequence[float]] = None) -> str:
        """Box, area, centre and mean motion of each object in each frame, as ``objects.csv`` of the command line.

        Parameters
        ----------
        times : sequence of float, optional
            The time of each frame in seconds, such as ``result.times``.

        Raises
        ------
        TraceCutError
            ``data`` unless there are as many as frames.
        """
        given = None if times is None else [float(time) for time in times]
        if given is not None and len(given) != self.num_frames:
            raise TraceCutError("data", f"times has {len(given)} entries (expected {self.num_frames}, one for each frame)")
        return self._raw.object_table(given)

    @property
    def num_corrections(self) -> int:
        """Corrections in force."""
        return self._raw.info()[3]

    def run(self, *, threads: Optional[int] = None, progress: _progress.Listener = None) -> None:
        """Takes all steps, with the same results on any number of threads; of a window, those that corrections ask for.

        Parameters
        ----------
        threads : int, optional
            As many as the machine runs at once if not given.
        progress : callable or bool, optional
            Called with a `Progress` at each step; True shows bars of tqdm.

        Raises
        ------
        KeyboardInterrupt
            Within a step of the signal; calling again goes on.
        TraceCutError
            ``too-few-frames`` with fewer than two.
        """
        listener = _progress.raw_listener(progress)
        try:
            self._raw.run(threads_of(threads), listener)
        finally:
            _progress.close(listener)

    def merge(self, into: int, from_: int) -> None:
        """Merges the object ``from_`` into ``into``; 0 makes it background. Masks can be read at once.

        Raises
        ------
        TraceCutError
            ``state`` unless the run is done and has masks; ``param`` for labels that do not exist.
        """
        self._raw.merge(_label("into", into), _label("from_", from_))

    def split(self, label: int, at: Optional[tuple[int, float, float]] = None) -> None:
        """An object becomes two; `run` makes the masks.

        Parameters
        ----------
        label : int
            The object; 0, which needs a place, makes an object of what is there.
        at : (t, x, y), optional
            A place in the part that is new; without it the smaller part is.

        Raises
        ------
        TraceCutError
            As `merge`, and ``data`` where there is nothing to split.
        """
        self._raw.split(_label("label", label), at)

    def together(self, strokes: Iterable[Stroke]) -> None:
        """All that the strokes touch is one thing; `run` makes the masks. Errors as `split`."""
        self._raw.strokes(False, _raw_strokes(strokes))

    def apart(self, strokes: Iterable[Stroke]) -> None:
        """Makes each stroke an object of its own; `run` makes the masks. Errors as `split`."""
        self._raw.strokes(True, _raw_strokes(strokes))

    def undo_correction(self) -> None:
        """Takes the last correction back.

        Raises
        ------
        TraceCutError
            ``state`` without a correction in force.
        """
        self._raw.undo_correction()


class Session(SessionView):
    """One clip on its way through the stages.

    Push frames (or set trajectories, or both), `run` or `step`, read results; results of a finished stage can be read
    while later ones are still to come. A run that was interrupted goes on where it stood, and ends in the same result.

    Parameters
    ----------
    **params
        Parameters by section, such as ``flow={"patch_stride": 5}``, or ``preset="paper"`` or ``"fast"``; dotted names
        go as ``**{"flow.patch_stride": 5}``. `tracecut.parameters` lists them.

    Raises
    ------
    TraceCutError
        ``param`` for a name that is not known, or a value that is not legal.

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

    def __init__(self, **params: Any) -> None:
        super().__init__(_tracecut.Session(params))

    def push(self, frame: FrameLike) -> None:
        """Adds the next frame.

        Raises
        ------
        TraceCutError
            ``frame-size-changed`` unless it has the size of the first; ``data`` when it is no frame; ``state`` when the
            run has begun. The session stays as it was.
        """
        self._raw.push(as_array(frame))

    def push_all(self, frames: Frames) -> None:
        """Adds all frames of a clip; of a damaged video those before the damage, then it raises ``truncated``."""
        for frame in open_frames(frames).frames:
            self._raw.push(frame)

    def set_trajectories(self, trajectories: Trajectories) -> None:
        """Uses trajectories of any other tracker in the place of those that tracking would find.

        With frames, as many as the trajectories have, masks are made too; without, a run ends with the labels of the
        trajectories.

        Raises
        ------
        TraceCutError
            ``data`` when they are not of the form that `Trajectories` describes, or of another size than the frames;
            ``state`` when the run has begun.
        """
        t = trajectories
        start, offset = np.asarray(t.start_frame, np.uint32).tolist(), np.asarray(t.offset, np.uint32).tolist()
        x, y = (np.ascontiguousarray(v, np.float32) for v in (t.x, t.y))
        self._raw.set_trajectories(t.num_frames, (t.width, t.height), start, offset, x, y)

    def step(self) -> Optional[Progress]:
        """Takes one bounded step; None when nothing is left to do.

        Raises
        ------
        TraceCutError
            ``too-few-frames`` with fewer than two.
        """
        return _made(Progress, self._raw.step())

    def steps(self) -> Iterator[Progress]:
        """Takes all steps, one at a time."""
        while (progress := self.step()) is not None:
            yield progress

    def clear(self) -> None:
        """Drops frames and results; parameters stay."""
        self._raw.clear()


def _label(name: str, label: int) -> int:
    if not 0 <= label <= 255:
        raise illegal(name, label, "a label, 0..=255")
    return label


def _raw_strokes(strokes: Iterable[Stroke]) -> list[tuple[int, float, list[float]]]:
    raw: list[tuple[int, float, list[float]]] = []
    for stroke in strokes:
        points: Sequence[float] = np.asarray(stroke.points, np.float64).reshape(-1, 2).ravel().tolist()
        if stroke.t < 0:
            raise TraceCutError("param", f"t = {stroke.t} (expected a frame)")
        raw.append((stroke.t, float(stroke.radius), list(points)))
    return raw
