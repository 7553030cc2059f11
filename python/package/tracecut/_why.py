"""Explains why a pixel has its label."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Optional


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
    """A trajectory in a superpixel, in input pixels; ``cluster`` is -1 if unknown.

    An outlier moves unlike its surroundings, and votes for all objects.
    """

    x: float
    y: float
    cluster: int
    is_outlier: bool


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
