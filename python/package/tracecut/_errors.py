"""The exceptions of the package, and the checks of arguments and parameters that raise them."""

from __future__ import annotations

import operator
import reprlib
import sys
from collections.abc import Generator, Iterable, Mapping
from contextlib import contextmanager
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from . import _tracecut
from ._params import Params

if TYPE_CHECKING:
    from typing_extensions import Unpack as Unpack

    from ._segment import Result
elif sys.version_info >= (3, 11):
    from typing import Unpack
else:
    # Only programs that read the annotations evaluate it.
    Unpack = Optional

#: Larger numbers are legal for no parameter, and not all are numbers in the native module.
_MAX_NUMBER = 2**64


class TraceCutError(Exception):
    """An error with a stable code and a message that names the value and what is allowed.

    Every error that the package raises is one, and also of Python's own class where there is one: a `TypeError` for an
    argument of a wrong type, an `IndexError` for a frame that does not exist, an `OSError` such as `FileNotFoundError`
    for a file, an `ImportError` for a package that is not installed.

    Parameters
    ----------
    code : str
        ``frame-size``, ``frame-bytes``, ``frame-size-changed``, ``too-few-frames``, ``too-large``, ``decode``,
        ``param``, ``data`` or ``state``, as in Rust, on the command line and in JavaScript; ``file`` for a file that
        cannot be read or written; for videos ``no-video``, ``codec``, ``unsupported`` (PyAV is missing, or cannot read
        the format) and ``truncated`` (truncated or damaged).
    message : str
        Describes the error.

    Attributes
    ----------
    code : str
        The stable code; the message may change.
    frames : int or None
        The number of whole frames before the damage, for the code ``truncated``.
    result : Result or None
        The result of these frames, from `segment` if there are at least two.
    """

    def __init__(self, code: str, message: str) -> None:
        super().__init__(code, message)
        self.code = code
        self.message = message
        self.frames: Optional[int] = None
        self.result: Optional[Result] = None

    def __reduce__(self) -> tuple[type[TraceCutError], tuple[str, str], dict[str, Any]]:
        return type(self), (self.code, self.message), self._state()

    def _state(self) -> dict[str, Any]:
        return {"frames": self.frames, "result": self.result}

    def __str__(self) -> str:
        return self.message


class WrongTypeError(TraceCutError, TypeError):
    """An argument of a wrong type."""


class FrameIndexError(TraceCutError, IndexError):
    """A frame that does not exist."""


class MissingPackageError(TraceCutError, ImportError):
    """A package that is needed and not installed."""


class FileError(TraceCutError, OSError):
    """A file that cannot be read or written."""

    def _state(self) -> dict[str, Any]:
        return {"errno": self.errno, "strerror": self.strerror, "filename": self.filename}


class _MissingFileError(FileError, FileNotFoundError):
    pass


class _ForbiddenFileError(FileError, PermissionError):
    pass


class _ExistingFileError(FileError, FileExistsError):
    pass


class _NoFolderError(FileError, NotADirectoryError):
    pass


class _FolderError(FileError, IsADirectoryError):
    pass


_FILE_ERRORS: dict[type[OSError], type[FileError]] = {
    FileNotFoundError: _MissingFileError,
    FileExistsError: _ExistingFileError,
    PermissionError: _ForbiddenFileError,
    NotADirectoryError: _NoFolderError,
    IsADirectoryError: _FolderError,
}


@contextmanager
def file_errors() -> Generator[None, None, None]:
    """Turns errors of the system into those of the package. No code of the user's may run in the block."""
    try:
        yield
    except TraceCutError:
        raise
    except OSError as error:
        name = "" if error.filename is None else f"{error.filename}: "
        kind = _FILE_ERRORS.get(type(error), FileError)
        found = kind("file", f"{name}{error.strerror or error}")
        found.errno, found.strerror, found.filename = error.errno, error.strerror, error.filename
        raise found from error


def illegal(name: str, value: object, expected: str) -> TraceCutError:
    """Returns the error for an invalid argument."""
    return TraceCutError("param", f"{name} = {_shown(value)} (expected {expected})")


def wrong_type(name: str, value: object, expected: str, code: str = "param") -> TraceCutError:
    """Returns the error for an argument of a wrong type."""
    return WrongTypeError(code, f"{name} = {_shown(value)} (expected {expected})")


def _shown(value: Any) -> str:
    """Returns a value as a short text; of an array its type and shape."""
    shape: Any = getattr(value, "shape", ())
    if shape and hasattr(value, "dtype"):
        return f"array of {value.dtype} of shape {tuple(shape)}"
    return repr(value) if isinstance(value, str) else reprlib.repr(value)


def is_bool(value: object) -> bool:
    """Returns True for truth values, which Python and NumPy take for numbers."""
    return isinstance(value, (bool, np.bool_))


def is_text(value: object) -> bool:
    """Returns True for text and bytes, which are no list of items, and no number."""
    return isinstance(value, (str, bytes, bytearray))


def whole(name: str, value: Any, low: int, high: int, kind: str = "a whole number") -> int:
    """Returns a whole number in ``low..=high``, NumPy's included."""
    expected = f"{kind}, {low}..={high}"
    number = _integer(name, value, expected)
    if not low <= number <= high:
        raise illegal(name, number, expected)
    return number


def _integer(name: str, value: Any, expected: str) -> int:
    if is_bool(value):
        raise wrong_type(name, value, expected)
    try:
        return operator.index(value)
    except TypeError:
        raise wrong_type(name, value, expected) from None


def real(name: str, value: Any, expected: str = "a number") -> float:
    """Returns a finite number."""
    try:
        is_number = not (is_bool(value) or is_text(value) or getattr(value, "ndim", 0) > 0)
        number = float(value) if is_number else None
    except (TypeError, ValueError, OverflowError):
        number = None
    if number is None:
        raise wrong_type(name, value, expected)
    if not np.isfinite(number):
        raise illegal(name, value, expected)
    return number


def index_of(t: Any, count: int, name: str = "t", kind: str = "a frame") -> int:
    """Returns the number of a frame, or of another item of ``count``; negative ones count from the end, as in NumPy."""
    legal = f"{kind}, -{count}..={count - 1}" if count > 0 else f"{kind}, of which there is none"
    number = _integer(name, t, legal)
    if not -count <= number < count:
        raise FrameIndexError("param", f"{name} = {number} (expected {legal})")
    return number % count


def check_options(options: dict[str, Any], legal: Iterable[str]) -> None:
    """Refuses the first option that is not legal; the message lists similar ones."""
    names = list(legal)
    for name, value in options.items():
        if name not in names:
            similar = ", ".join(get_close_matches(name, names, 3, 0.0))
            raise illegal(name, value, f"a known option, such as {similar}")


def raw_params(params: Mapping[str, Any], *options: str) -> dict[str, Any]:
    """Returns parameters for the native module, which checks names in sections, and ranges.

    Parameters
    ----------
    params : mapping
        The keyword arguments that the call does not name.
    *options : str
        The names of the others, which misspelt ones may mean.
    """
    check_options({name.split(".")[0]: value for name, value in params.items()}, [*Params.__annotations__, *options])
    return {name: _raw_value(name, value) for name, value in params.items()}


def _raw_value(name: str, value: Any) -> Any:
    if name in Params.__annotations__ and name != "preset":
        if not _is_section(value):
            raise wrong_type(name, value, "a dictionary of parameters")
        return {field: _raw_value(f"{name}.{field}", inner) for field, inner in value.items()}
    if not _is_value(value):
        raise wrong_type(name, value, _legal(name))
    if isinstance(value, int) and abs(value) > _MAX_NUMBER:
        raise illegal(name, value, _legal(name))
    return value


def _is_section(value: object) -> bool:
    return isinstance(value, Mapping)


def _is_value(value: object) -> bool:
    return isinstance(value, (bool, np.bool_, str, int, float, np.integer, np.floating))


def _legal(name: str) -> str:
    """Returns the legal values of a parameter, in the words of the native module."""
    for known, _, kind, low, high, _, choices in (*_tracecut.parameters(False), *_tracecut.parameters(True)):
        if known == name:
            number = f"{low:g}..={high:g}" if kind == "number" else f"{int(low)}..={int(high)}"
            kinds = {"boolean": "true or false", "choice": f"one of {', '.join(choices)}"}
            return kinds.get(kind, f"a{' whole' if kind == 'integer' else ''} number, {number}")
    return "a number, true, false or a name"
