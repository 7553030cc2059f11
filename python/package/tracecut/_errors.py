"""The exception of the package."""

from __future__ import annotations

from typing import TYPE_CHECKING, Optional

if TYPE_CHECKING:
    from ._segment import Result


class TraceCutError(Exception):
    """An error with a stable code and a message that names the value and what is allowed.

    Parameters
    ----------
    code : str
        ``frame-size``, ``frame-bytes``, ``frame-size-changed``, ``too-few-frames``, ``too-large``, ``decode``,
        ``param``, ``data`` or ``state``, as in Rust, on the command line and in JavaScript; for videos
        ``no-video``, ``codec``, ``unsupported`` (by the installed PyAV) and ``truncated`` (truncated or damaged).
    message : str
        Describes the error.

    Attributes
    ----------
    code : str
        The stable code; the message may change.
    frames : int or None
        The number of whole frames before the damage, for the code ``truncated``.
    result : Result or None
        The result of these frames, from `segment` if there are at least two. It stays in its process: a copy of the
        error in another process has none.
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
    """Returns the error for an invalid argument."""
    return TraceCutError("param", f"{name} = {value!r} (expected {expected})")
