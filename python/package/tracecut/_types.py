"""Results of the stages as groups of arrays, and the explanation of a pixel's label."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from ._errors import index_of

U8 = npt.NDArray[np.uint8]
U32 = npt.NDArray[np.uint32]
I32 = npt.NDArray[np.int32]
F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]


#: The stages of a run, in their order; flow and trajectories alternate.
Stage = Literal[
    "flow",
    "trajectories",
    "affinities",
    "embedding",
    "discontinuities",
    "saliency",
    "connectedness",
    "clusters",
    "superpixels",
    "cut",
    "masks",
]


class Progress(NamedTuple):
    """Progress of a run: ``done`` of ``total`` steps of ``stage``. During the cut the total may grow."""

    stage: Stage
    done: int
    total: int


class FlowField(NamedTuple):
    """Motion of each pixel, in pixels: ``u`` to the right and ``v`` down, each of shape (height, width)."""

    u: F32
    v: F32


class BoundaryMap(NamedTuple):
    """Boundary probability in 0 to 1: ``pb`` of all pixels, ``thin`` the same on ridges one pixel wide, 0 elsewhere."""

    pb: F32
    thin: F32


class EnlargedMask(NamedTuple):
    """A mask at the size of its picture: its labels, and the opacity of the objects, 0 to 255."""

    labels: U8
    alpha: U8


@dataclass(frozen=True)
class Clusters:
    """The cluster of each trajectory, ``0`` to ``count - 1``; 0 has most points."""

    count: int
    label: U32


@dataclass(frozen=True)
class Components:
    """Connected components of the foreground: their number in each frame, and the one of each point, -1 for none."""

    count: U32
    of_point: I32


class Affinities(NamedTuple):
    """A symmetric sparse matrix, row by row: ``scipy.sparse.csr_matrix((value, column, offset))``."""

    offset: U32
    column: U32
    value: F32


@dataclass(frozen=True)
class Trajectories:
    """Points tracked through a clip.

    Trajectory ``i`` has the points ``offset[i]`` to ``offset[i + 1]`` of ``x`` and ``y``, in pixels with pixel centres
    at integers, one per frame from ``start_frame[i]`` on.

    Parameters
    ----------
    num_frames : int
        Number of frames of the clip.
    width, height : int
        Size of its frames in pixels.
    start_frame : array of uint32, shape (count,)
    offset : array of uint32, shape (count + 1,)
    x, y : array of float32, shape (points,)
    id : array of uint32, shape (count,), optional
        Identity of each trajectory in the clip, the same in all windows.
    """

    num_frames: int
    width: int
    height: int
    start_frame: U32
    offset: U32
    x: F32
    y: F32
    id: U32 = field(default_factory=lambda: np.zeros(0, np.uint32))

    def __len__(self) -> int:
        return len(self.start_frame)

    def points(self, i: int) -> F32:
        """The points of trajectory ``i``: x and y, shape (points, 2)."""
        i = index_of(i, len(self), "i", "a trajectory")
        here = slice(int(self.offset[i]), int(self.offset[i + 1]))
        return np.stack([self.x[here], self.y[here]], axis=1)

    def alive(self, t: int) -> npt.NDArray[np.intp]:
        """The trajectories that have a point in frame ``t``."""
        t = index_of(t, self.num_frames)
        start = self.start_frame.astype(np.int64)
        return np.flatnonzero((start <= t) & (t < start + np.diff(self.offset.astype(np.int64))))

    def at(self, t: int) -> F32:
        """The points in frame ``t`` of the trajectories in `alive`: x and y, shape (alive, 2)."""
        t = index_of(t, self.num_frames)
        alive = self.alive(t)
        point = self.offset[alive].astype(np.int64) + t - self.start_frame[alive]
        return np.stack([self.x[point], self.y[point]], axis=1)


@dataclass(frozen=True)
class Embedding:
    """The spectral embedding of the trajectories.

    Attributes
    ----------
    eigenvalues : array of float64, shape (dimensions,)
        Largest first.
    vectors : array of float64, shape (trajectories, dimensions)
        The position of each trajectory in the embedding.
    embedded : array of bool, shape (trajectories,)
        True for trajectories that have a position.
    converged : bool
        True if the eigensolver reached its tolerance.
    residual : float
        Residual of the eigenpairs.
    """

    eigenvalues: F64
    vectors: F64
    embedded: Bool
    converged: bool
    residual: float


@dataclass(frozen=True)
class Discontinuities:
    """Discontinuities between neighbouring trajectories: drops of their affinity below the local level.

    Attributes
    ----------
    pair : array of uint32, shape (pairs, 2)
        Trajectories that are neighbours in some frame.
    d : array of float64, shape (pairs,)
        Discontinuity between them, 0 to 1.
    frame_offset, frame_edge : array of uint32
        The pairs that are neighbours in frame ``t`` are ``frame_edge[frame_offset[t]:frame_offset[t + 1]]``.
    """

    pair: U32
    d: F64
    frame_offset: U32
    frame_edge: U32


@dataclass(frozen=True)
class Saliency:
    """Saliency of the trajectories, 0 to 1.

    Attributes
    ----------
    of_points : array of float32, shape (trajectories,)
        From its own points: nearly their maximum.
    in_context : array of float32, shape (trajectories,)
        Averaged over trajectories with similar motion.
    foreground : array of bool, shape (trajectories,)
        True where ``in_context`` is above the threshold.
    """

    of_points: F32
    in_context: F32
    foreground: Bool


class EdgeKind:
    """Kinds of edges between superpixels."""

    CONSTRAINT = 0
    FRAME = 1
    GABRIEL = 2
    DELETED = 3


@dataclass(frozen=True)
class Superpixels:
    """The Gabriel superpixels of an image.

    Attributes
    ----------
    count : int
        Number of superpixels.
    label : array of uint32, shape (height, width)
        The superpixel of each pixel.
    border_pair : array of uint32, shape (borders, 2)
        Superpixels that touch.
    border_length, border_pb : array of float32, shape (borders,)
        Length of their border in pixels, and the mean boundary probability along it.
    edge : array of float32, shape (edges, 4)
        The triangulation: x and y of both ends.
    edge_kind : array of uint8, shape (edges,)
        See `EdgeKind`.
    """

    count: int
    label: U32
    border_pair: U32
    border_length: F32
    border_pb: F32
    edge: F32
    edge_kind: U8


@dataclass(frozen=True)
class ImageDiscontinuities:
    """Discontinuities of the pixel embedding of an image; maps of shape (height, width) with values in 0 to 1.

    Attributes
    ----------
    pb : array of float32
        Boundary probability, the input of the embedding.
    discontinuity : array of float32
        Discontinuities of the embedding.
    spectral : array of float32
        Gradients of its eigenvectors, for comparison.
    combined : array of float32
        Boundary probability combined with the discontinuities.
    eigenvalues : array of float64
        Largest first; empty for an image without boundaries.
    """

    pb: F32
    discontinuity: F32
    spectral: F32
    combined: F32
    eigenvalues: F64


@dataclass(frozen=True)
class Stroke:
    """A brush stroke that marks an object.

    Parameters
    ----------
    t : int
        The frame; negative ones count from the end.
    points : sequence of (x, y)
        Its path in input pixels.
    radius : float
        Radius of the brush in input pixels.
    """

    t: int
    points: Any
    radius: float = 3.0


@dataclass(frozen=True)
class Parameter:
    """A parameter with its dotted name, such as ``flow.patch_stride``.

    Attributes
    ----------
    name, doc : str
    kind : str
        ``number``, ``integer``, ``boolean`` or ``choice``.
    low, high : float, optional
        Range of a number.
    default : bool, int, float or str
    choices : tuple of str
        Values of a choice.
    """

    name: str
    doc: str
    kind: Literal["number", "integer", "boolean", "choice"]
    low: Optional[float]
    high: Optional[float]
    default: Any
    choices: tuple[str, ...] = ()


class Evidence(NamedTuple):
    """Evidence for an object, or against it if negative: from the ``background``, and from appearance (``looks``)."""

    background: float
    looks: float


class LabelCost(NamedTuple):
    """The cost of assigning a cluster to a superpixel, with all others unchanged.

    Attributes
    ----------
    cluster : int
    label : int
        The mask label of the cluster.
    votes : int
        The cluster's trajectories in the superpixel.
    trajectories, evidence, links, forbidden : float
        The cost from its trajectories; from background and appearance; from links to superpixels of other clusters; and
        from strokes that forbid it.
    total : float
        Their sum.
    """

    cluster: int
    label: int
    votes: int
    trajectories: float
    evidence: float
    links: float
    forbidden: float
    total: float


class SuperpixelLink(NamedTuple):
    """A linked superpixel: one that shares a border (same ``t``), or one in the previous or next frame.

    Attributes
    ----------
    t, superpixel, cluster : int
        Its frame, its number there, and its cluster.
    tracks : int
        Number of shared trajectories.
    cost : float
        The cost of a different cluster.
    """

    t: int
    superpixel: int
    cluster: int
    tracks: int
    cost: float


class Voter(NamedTuple):
    """A trajectory in a superpixel, in input pixels; ``cluster`` is -1 if unknown."""

    x: float
    y: float
    cluster: int


class Flip(NamedTuple):
    """The cheapest cluster of another label, and its extra cost.

    ``votes`` more of its trajectories here would make it as cheap; None if no number would.
    """

    cluster: int
    margin: float
    votes: Optional[int]


class Border(NamedTuple):
    """The edges of the frame between trajectories of two labels: their number and mean discontinuity.

    The largest discontinuity ``d`` is between the trajectories ``i`` and ``j``.
    """

    edges: int
    mean: float
    i: int
    j: int
    d: float


@dataclass(frozen=True)
class Explanation:
    """Why a pixel has its label.

    Costs are in units of the energy, in whole steps of 1/65536, so that their sums are exact: the difference of two
    totals equals the difference of the energies that the cut compared.

    Attributes
    ----------
    label : int
        The label in the masks.
    source : str
        The source of the label: ``superpixel``, the cut; ``border``, border refinement; or ``stroke``. The costs are
        the superpixel's in any case.
    superpixel : int
        Its number in the frame.
    cluster : int
        The cluster that the cut gave the superpixel.
    weight : float
        The weight of the superpixel's trajectories, 0 if none votes.
    evidence : Evidence
    costs : list of LabelCost
        The cost of each cluster.
    links : list of SuperpixelLink
        The links of the superpixel to others.
    voters : list of Voter
        The trajectories in it.
    nearest : int or None
        The clustered trajectory nearest to the pixel; None if the frame has none.
    affinities : list of (int, float)
        Its 8 largest affinities, as pairs of the other trajectory and the affinity.
    flip : Flip or None
        None if there is no other label.
    border : Border or None
        None if no edge joins the two labels.
    """

    label: int
    source: str
    superpixel: int
    cluster: int
    weight: float
    evidence: Evidence
    costs: list[LabelCost]
    links: list[SuperpixelLink]
    voters: list[Voter]
    nearest: Optional[int]
    affinities: list[tuple[int, float]]
    flip: Optional[Flip]
    border: Optional[Border]


def explanation(raw: dict[str, Any]) -> Explanation:
    """Builds an explanation from the native module's values."""
    classes: dict[str, Any] = {
        "evidence": Evidence(*raw["evidence"]),
        "costs": [LabelCost(*cost) for cost in raw["costs"]],
        "links": [SuperpixelLink(*link) for link in raw["links"]],
        "voters": [Voter(*voter) for voter in raw["voters"]],
        "flip": raw["flip"] and Flip(*raw["flip"]),
        "border": raw["border"] and Border(*raw["border"]),
    }
    return Explanation(**{**raw, **classes})
