"""Converts decoded pictures to RGB: upright, with square pixels, all of one size."""

from __future__ import annotations

import math
import struct
from typing import Any, NamedTuple, Optional

import numpy as np

from ._types import U8

#: Bicubic, the same bits on every machine. The command line and the package for Node give ffmpeg the same flags.
_SCALER_FLAGS = "flags=bicubic+accurate_rnd+full_chroma_int+bitexact"

#: The size at which pixels are square. It never has fewer columns or rows than the file stores.
_DISPLAY_SIZE = "w='if(gt(sar,1),round(iw*sar),iw)':h='if(gt(sar,1),ih,round(ih/sar))'"


class Filter(NamedTuple):
    """A filter of FFmpeg, and its arguments."""

    name: str
    arguments: Optional[str] = None


class Form(NamedTuple):
    """All that a filter graph depends on."""

    width: int
    height: int
    pixel_format: str
    colorspace: int
    color_range: int
    pixel_aspect: str
    turn: tuple[Filter, ...]


class RgbConverter:
    """Converts the pictures of a stream to RGB. Later pictures are scaled to the size of the first."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream
        self._form: Optional[Form] = None
        self._graph: Any = None
        self._size: Optional[tuple[int, int]] = None

    def convert(self, frame: Any) -> U8:
        """Returns a picture as an array of shape (height, width, 3).

        Raises
        ------
        av.FFmpegError
            When FFmpeg cannot convert pixels of this format.
        """
        form = self._form_of(frame)
        if form != self._form:
            self._graph, self._form = _build_graph(form, self._size), form
        self._graph.push(frame)
        rgb = np.asarray(self._graph.pull().to_ndarray(), np.uint8)
        self._size = (rgb.shape[1], rgb.shape[0])
        return rgb

    def _form_of(self, frame: Any) -> Form:
        aspect = self._stream.sample_aspect_ratio or self._stream.codec_context.sample_aspect_ratio or 1
        pixels = (frame.format.name, int(frame.colorspace), int(frame.color_range), str(aspect))
        return Form(frame.width, frame.height, *pixels, turn_filters(*_display_matrix(frame)))


def _build_graph(form: Form, size: Optional[tuple[int, int]]) -> Any:
    """Builds the graph from pictures of a form to RGB, at this size or else at the display size.

    It turns pictures, then scales and converts them in one step, as ffmpeg does for the command line.
    """
    from av.filter import Graph

    pixels = f"video_size={form.width}x{form.height}:pix_fmt={form.pixel_format}:time_base=1/1"
    colours = f"colorspace={form.colorspace}:range={form.color_range}"
    scaled = _DISPLAY_SIZE if size is None else f"w={size[0]}:h={size[1]}"
    filters = [
        Filter("buffer", f"{pixels}:{colours}"),
        Filter("setsar", form.pixel_aspect),
        *form.turn,
        Filter("scale", f"{scaled}:{_SCALER_FLAGS}"),
        Filter("setsar", "1"),
        Filter("format", "rgb24"),
        Filter("buffersink"),
    ]
    graph = Graph()
    graph.link_nodes(*(graph.add(each.name, each.arguments) for each in filters))
    graph.configure()
    return graph


def _display_matrix(frame: Any) -> tuple[float, float, float, float]:
    """Returns the four numbers of the display matrix that turn and mirror; those of an upright picture by default."""
    try:
        for data in frame.side_data:
            if data.type.name == "DISPLAYMATRIX":
                a, b, _, c, d = struct.unpack("=5i", bytes(data)[:20])
                return a, b, c, d
    except ValueError:
        # PyAV knows no side data that is newer than it is, and then gives none. It still tells the angle.
        angle = math.radians(-frame.rotation)
        return math.cos(angle), math.sin(angle), -math.sin(angle), math.cos(angle)
    return 1, 0, 0, 1


def turn_filters(a: float, b: float, c: float, d: float) -> tuple[Filter, ...]:
    """Returns the filters that turn and mirror a picture as its display matrix says, which are those of ffmpeg."""
    columns = math.hypot(a, c), math.hypot(b, d)
    if 0 in columns:
        return ()
    angle_deg = round(math.degrees(math.atan2(b / columns[1], a / columns[0]))) % 360
    if angle_deg == 90:
        return (Filter("transpose", "cclock_flip" if c > 0 else "clock"),)
    if angle_deg == 270:
        return (Filter("transpose", "clock_flip" if c < 0 else "cclock"),)
    if angle_deg in (0, 180):
        flips = [Filter("hflip")] if a < 0 and angle_deg == 180 else []
        return (*flips, *([Filter("vflip")] if d < 0 else []))
    return (Filter("rotate", f"{angle_deg}*PI/180"),)
