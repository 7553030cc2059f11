"""Writes masks in the formats of COCO, DAVIS and YouTube-VOS, which annotation tools and benchmarks read.

Each function takes the masks as a `tracecut.Result` or any iterable of arrays, and needs none of these tools. Labels
stay the same: 0 is the background, and a label is one object throughout the clip. Output is complete or absent, and
existing files are not overwritten.
"""

from ._coco import to_coco
from ._export import Masks
from ._vos import to_davis, to_youtube_vos

__all__ = [
    "Masks",
    "to_coco",
    "to_davis",
    "to_youtube_vos",
]
