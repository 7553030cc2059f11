"""Masks of a clip as COCO, DAVIS and YouTube-VOS have them, which annotation tools and benchmarks read.

Each function takes the masks as a `tracecut.Result` or as any iterable of arrays, writes what the tool imports, and
needs none of these tools. Labels stay what they are: 0 is the background, and a label is one object over the clip.
What is written is there as a whole or not at all, and nothing that exists is written over.
"""

from ._clip import Masks
from ._coco import to_coco
from ._vos import to_davis, to_youtube_vos

__all__ = [
    "Masks",
    "to_coco",
    "to_davis",
    "to_youtube_vos",
]
