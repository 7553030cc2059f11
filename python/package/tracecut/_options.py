"""Checks the keyword arguments of a call, and hands its parameters to the native module."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from . import _tracecut
from ._errors import check_options, illegal, wrong_type
from ._params import Params

if TYPE_CHECKING:
    from typing_extensions import Unpack as Unpack
elif sys.version_info >= (3, 11):
    from typing import Unpack
else:
    # Only programs that read the annotations evaluate it.
    Unpack = Optional

#: Larger numbers are legal for no parameter, and not all are numbers in the native module.
_MAX_NUMBER = 2**64


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
