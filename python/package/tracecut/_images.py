"""Single images, and pairs of them."""

from __future__ import annotations

from typing import Any, Optional

from . import _tracecut
from ._errors import illegal
from ._frames import FrameLike, as_array
from ._types import U8, BoundaryMap, EnlargedMask, FlowField, ImageDiscontinuities, Parameter, Superpixels


def boundaries(image: FrameLike, **params: Any) -> BoundaryMap:
    """The boundary probability of an image, at its own size.

    Parameters
    ----------
    image : frame
        An array, an image of Pillow, or the path or the bytes of a PNG or JPEG file.
    **params
        As those of `Session`; ``clip.max_pixels`` alone counts.
    """
    return BoundaryMap(*_tracecut.boundaries(as_array(image), params))


def superpixels(image: FrameLike, count: Optional[int] = None, **params: Any) -> Superpixels:
    """The Gabriel superpixels of an image, at its own size.

    Parameters
    ----------
    image : frame
        As `boundaries`.
    count : int, optional
        The largest number of superpixels; if not given, what the contours above the thresholds enclose.
    **params
        As those of `Session`; the sections ``contour`` and ``superpixel`` count.
    """
    if count is not None and not 1 <= count <= 1 << 26:
        raise illegal("count", count, f"a whole number, 1..={1 << 26}")
    return Superpixels(**_tracecut.superpixels(as_array(image), count, params))


def image_discontinuities(image: FrameLike, **params: Any) -> ImageDiscontinuities:
    """Boundaries of an image by the discontinuities of its pixel embedding.

    Parameters
    ----------
    image : frame
        As `boundaries`; reduced to ``still.max_side``.
    **params
        As those of `Session`; the section ``still`` counts.
    """
    return ImageDiscontinuities(**_tracecut.image_discontinuities(as_array(image), params))


def flow(first: FrameLike, second: FrameLike, **params: Any) -> FlowField:
    """The optical flow from one image to another of the same size: where each pixel goes.

    Parameters
    ----------
    first, second : frame
        As `boundaries`.
    **params
        As those of `Session`; the section ``flow`` counts.

    Raises
    ------
    TraceCutError
        ``frame-size-changed`` when they differ in size.
    """
    return FlowField(*_tracecut.flow(as_array(first), as_array(second), params))


def enlarge(mask: U8, picture: FrameLike) -> EnlargedMask:
    """A mask at the size of its picture, with borders where that has them.

    Parameters
    ----------
    mask : array of uint8, shape (height, width)
        At the size that the frame was processed at.
    picture : frame
        The frame as it was before it was reduced.
    """
    return EnlargedMask(*_tracecut.enlarge(mask, as_array(picture)))


def parameters(expert: bool = False) -> list[Parameter]:
    """The parameters with meaning, range and default, in the order of the stages.

    Parameters
    ----------
    expert : bool, default False
        Those that only research changes, in the place of the others. All can be set.
    """
    return [_parameter(*raw) for raw in _tracecut.parameters(expert)]


def _parameter(
    name: str, doc: str, kind: str, low: float, high: float, default: float, choices: list[str]
) -> Parameter:
    text = " ".join(doc.split())
    if kind == "boolean":
        return Parameter(name, text, kind, None, None, bool(default))
    if kind == "choice":
        return Parameter(name, text, kind, None, None, choices[int(default)], tuple(choices))
    number = int if kind == "integer" else float
    return Parameter(name, text, kind, number(low), number(high), number(default))
