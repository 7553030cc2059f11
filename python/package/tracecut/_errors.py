"""The one exception of the package."""

from __future__ import annotations


class TraceCutError(Exception):
    """An error with a stable code and a message that names the value and what is legal.

    Parameters
    ----------
    code : str
        ``frame-size``, ``frame-bytes``, ``frame-size-changed``, ``too-few-frames``, ``too-large``, ``decode``,
        ``param``, ``data`` or ``state``, as in Rust, on the command line and in JavaScript; ``no-video``, ``codec`` and ``truncated`` of
        videos.
    message : str
        What is wrong.

    Attributes
    ----------
    code : str
        What it is about; the message may change, this does not.
    """

    def __init__(self, code: str, message: str) -> None:
        super().__init__(code, message)
        self.code = code
        self.message = message

    def __str__(self) -> str:
        return self.message


def illegal(name: str, value: object, expected: str) -> TraceCutError:
    """The error of an argument that is not legal."""
    return TraceCutError("param", f"{name} = {value!r} (expected {expected})")
