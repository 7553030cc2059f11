"""Explanations of pixel labels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Optional


class Evidence(NamedTuple):
    """Evidence for an object, or against one if negative: of the ``background`` model, and of appearance."""

    background: float
    looks: float


class LabelCost(NamedTuple):
    """The cost of giving a superpixel to a cluster, with all other labels fixed.

    Attributes
    ----------
    cluster : int
    label : int
        That of the cluster in the masks.
    votes : int
        The cluster's trajectories in the superpixel.
    trajectories, colours, evidence, links, forbidden : float
        The cost by its trajectories; by colours, where no trajectory has a say; by background and looks; by links to
        superpixels of other clusters; and where a stroke forbids it.
    total : float
        Their sum.
    """

    cluster: int
    label: int
    votes: int
    trajectories: float
    colours: float
    evidence: float
    links: float
    forbidden: float
    total: float


class SuperpixelLink(NamedTuple):
    """A superpixel that shares a border (same ``t``), or is of the frame before or after.

    Attributes
    ----------
    t, superpixel, cluster : int
        Its frame, its number there, and its cluster.
    tracks : int
        Trajectories that both have.
    cost : float
        Of having another cluster than that one.
    """

    t: int
    superpixel: int
    cluster: int
    tracks: int
    cost: float


class Voter(NamedTuple):
    """A trajectory in a superpixel, in input pixels; ``cluster`` is -1 where that is not known.

    A ``stranger`` moves like nothing around it, and counts for all objects.
    """

    x: float
    y: float
    cluster: int
    stranger: bool


class Flip(NamedTuple):
    """The cheapest cluster of another label, and what it costs more.

    ``votes`` more trajectories of it here would make it as cheap; None where no number would.
    """

    cluster: int
    margin: float
    votes: Optional[int]


class Border(NamedTuple):
    """The edges of the frame between trajectories of two labels: their number, their mean discontinuity.

    The greatest discontinuity ``d`` is that between the trajectories ``i`` and ``j``.
    """

    edges: int
    mean: float
    i: int
    j: int
    d: float


@dataclass(frozen=True)
class Explanation:
    """The explanation of a pixel's label.

    Costs are in units of the energy, in whole steps of 1/65536, so that their sums are exact: the difference of two
    totals equals the difference of the energies that the cut compared.

    Attributes
    ----------
    label : int
        In the masks.
    source : str
        What gave the pixel its label: ``superpixel``, by the cut; ``border``, the step after it; or ``stroke``. The
        costs always belong to the superpixel.
    superpixel : int
        Its number in the frame.
    cluster : int
        That the cut gave the superpixel.
    weight : float
        How much the superpixel's trajectories count, 0 where none has a say.
    evidence : Evidence
    costs : list of LabelCost
        Of each cluster.
    links : list of SuperpixelLink
        What binds the superpixel to others.
    voters : list of Voter
        The trajectories in it.
    nearest : int or None
        The clustered trajectory nearest to the pixel; None where none is alive.
    affinities : list of (int, float)
        Its 8 greatest affinities, each after the trajectory that it is to.
    flip : Flip or None
        None where there is no other label.
    border : Border or None
        None where no edge joins both labels.
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
    """An explanation from what the native module gives."""
    classes: dict[str, Any] = {
        "evidence": Evidence(*raw["evidence"]),
        "costs": [LabelCost(*cost) for cost in raw["costs"]],
        "links": [SuperpixelLink(*link) for link in raw["links"]],
        "voters": [Voter(*voter) for voter in raw["voters"]],
        "flip": raw["flip"] and Flip(*raw["flip"]),
        "border": raw["border"] and Border(*raw["border"]),
    }
    return Explanation(**{**raw, **classes})
