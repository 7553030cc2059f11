"""The one exception of the package."""

from __future__ import annotations

from typing import TYPE_CHECKING, Optional

if TYPE_CHECKING:
    from ._segment import Result


class TraceCutError(Exception):
    """An error with a stable code and a message that names the value and what is legal.

    Parameters
    ----------
    code : str
        ``frame-size``, ``frame-bytes``, ``frame-size-changed``, ``too-few-frames``, ``too-large``, ``decode``,
        ``param``, ``data`` or ``state``, as in Rust, on the command line and in JavaScript; of videos ``no-video``,
        ``codec``, ``unsupported`` (the installed PyAV lacks something) and ``truncated`` (cut off or damaged).
    message : str
        What is wrong.

    Attributes
    ----------
    code : str
        What it is about; the message may change, this does not.
    frames : int or None
        The number of whole frames before the damage, of the code ``truncated``.
    result : Result or None
        The result of these frames, of `segment` where there are at least two of them. It stays in its process: a copy
        of the error in another one has none.
    """

    def __init__(self, code: str, message: str) -> None:
        super().__init__(code, message)
        self.code = code
        self.message = message
        self.frames: Optional[int] = None
        self.result: Optional[Result] = None

    def __reduce__(self) -> tuple[type[TraceCutError], tuple[str, str], dict[str, Optional[int]]]:
        return type(self), (self.code, self.message), {"frames": self.frames}

    def __str__(self) -> str:
        return self.message


def illegal(name: str, value: object, expected: str) -> TraceCutError:
    """The error of an argument that is not legal."""
    return TraceCutError("param", f"{name} = {value!r} (expected {expected})")
