"""Functions for single images and pairs of images."""

from __future__ import annotations

from typing import Any, Optional

from . import _tracecut
from ._errors import Unpack, is_bool, raw_params, whole, wrong_type
from ._frames import FrameLike, as_array
from ._masks import check_mask
from ._params import Params
from ._types import U8, BoundaryMap, EnlargedMask, FlowField, ImageDiscontinuities, Parameter, Superpixels


def boundaries(image: FrameLike, **params: Unpack[Params]) -> BoundaryMap:
    """The boundary probability of an image, at its own size.

    Parameters
    ----------
    image : frame
        An array, a Pillow image, or the path or bytes of a PNG or JPEG file.
    **params
        As for `Session`; only ``clip.max_pixels`` is used.
    """
    return BoundaryMap(*_tracecut.boundaries(as_array(image), raw_params(params)))


def superpixels(image: FrameLike, count: Optional[int] = None, **params: Unpack[Params]) -> Superpixels:
    """The Gabriel superpixels of an image, at its own size.

    Parameters
    ----------
    image : frame
        As `boundaries`.
    count : int, optional
        The maximum number of superpixels; by default, as many as the contours above the thresholds enclose.
    **params
        As for `Session`; the sections ``contour`` and ``superpixel`` are used.
    """
    raw = raw_params(params, "count")
    most = None if count is None else whole("count", count, 1, 1 << 26)
    return Superpixels(**_tracecut.superpixels(as_array(image), most, raw))


def image_discontinuities(image: FrameLike, **params: Unpack[Params]) -> ImageDiscontinuities:
    """Boundaries of an image from the discontinuities of its pixel embedding.

    Parameters
    ----------
    image : frame
        As `boundaries`; scaled down to ``still.max_side``.
    **params
        As for `Session`; the section ``still`` is used.
    """
    return ImageDiscontinuities(**_tracecut.image_discontinuities(as_array(image), raw_params(params)))


def flow(first: FrameLike, second: FrameLike, **params: Unpack[Params]) -> FlowField:
    """The optical flow from one image to another of the same size.

    Parameters
    ----------
    first, second : frame
        As `boundaries`.
    **params
        As for `Session`; the section ``flow`` is used.

    Raises
    ------
    TraceCutError
        ``frame-size-changed`` if they differ in size.
    """
    return FlowField(*_tracecut.flow(as_array(first), as_array(second), raw_params(params)))


def enlarge(mask: U8, picture: FrameLike) -> EnlargedMask:
    """Scales a mask to the size of its picture, with borders that follow the picture.

    Parameters
    ----------
    mask : array of uint8, shape (height, width)
        The mask at the working size.
    picture : frame
        The frame at its original size.
    """
    return EnlargedMask(*_tracecut.enlarge(check_mask(mask), as_array(picture)))


def parameters(expert: bool = False) -> list[Parameter]:
    """The parameters with meaning, range and default, in the order of the stages.

    Parameters
    ----------
    expert : bool, default False
        Lists the expert parameters instead of the common ones. All can be set.
    """
    if not is_bool(expert):
        raise wrong_type("expert", expert, "true or false")
    return [_parameter(*raw) for raw in _tracecut.parameters(bool(expert))]


def _parameter(
    name: str, doc: str, kind: Any, low: float, high: float, default: float, choices: list[str]
) -> Parameter:
    text = " ".join(doc.split())
    if kind == "boolean":
        return Parameter(name, text, kind, None, None, bool(default))
    if kind == "choice":
        return Parameter(name, text, kind, None, None, choices[int(default)], tuple(choices))
    number = int if kind == "integer" else float
    return Parameter(name, text, kind, number(low), number(high), number(default))
