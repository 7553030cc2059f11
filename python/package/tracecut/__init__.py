"""Finds the moving objects in a video, without a trained model and without clicks.

>>> import tracecut
>>> result = tracecut.segment(tracecut.synth.Scene("sample", 160, 90, frames=8), preset="fast")
>>> result[0].dtype
dtype('uint8')
"""

from . import interchange, synth
from ._errors import TraceCutError
from ._frames import FrameLike, Frames, as_array, in_name_order, read_image, read_video
from ._images import boundaries, enlarge, flow, image_discontinuities, parameters, superpixels
from ._masks import Prompt, coco_rle, from_coco_rle, mask_png, prompts
from ._params import Params
from ._segment import Result, Window, segment, windows
from ._session import Session, SessionView
from ._tracecut import version as __version__
from ._tracks import read_tracks, write_tracks
from ._types import (
    Affinities,
    Border,
    BoundaryMap,
    Clusters,
    Components,
    Discontinuities,
    EdgeKind,
    Embedding,
    EnlargedMask,
    Evidence,
    Explanation,
    Flip,
    FlowField,
    ImageDiscontinuities,
    LabelCost,
    Parameter,
    Progress,
    Saliency,
    Stroke,
    SuperpixelLink,
    Superpixels,
    Trajectories,
    Voter,
)
from ._video import VideoReader

__all__ = [
    "Affinities",
    "Border",
    "BoundaryMap",
    "Clusters",
    "Components",
    "Discontinuities",
    "EdgeKind",
    "Embedding",
    "EnlargedMask",
    "Evidence",
    "Explanation",
    "Flip",
    "FlowField",
    "FrameLike",
    "Frames",
    "ImageDiscontinuities",
    "LabelCost",
    "Parameter",
    "Params",
    "Progress",
    "Prompt",
    "Result",
    "Saliency",
    "Session",
    "SessionView",
    "Stroke",
    "SuperpixelLink",
    "Superpixels",
    "TraceCutError",
    "Trajectories",
    "VideoReader",
    "Voter",
    "Window",
    "__version__",
    "as_array",
    "boundaries",
    "coco_rle",
    "enlarge",
    "flow",
    "from_coco_rle",
    "image_discontinuities",
    "in_name_order",
    "interchange",
    "mask_png",
    "parameters",
    "prompts",
    "read_image",
    "read_tracks",
    "read_video",
    "segment",
    "superpixels",
    "synth",
    "windows",
    "write_tracks",
]
