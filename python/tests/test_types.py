"""Types: what the type checkers refuse, and that they know the parameters that the library declares."""

from __future__ import annotations

import keyword
import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import get_args

import pytest
import tracecut
from tracecut import _params, synth
from tracecut._session import Method
from tracecut._types import Stage

PYTHON = Path(__file__).resolve().parents[1]
WIDTH = 120

HEADING = '''"""The parameters as types, from the declarations of the library.

Written by ``REGENERATE=1 python3 python/run_tests.py python/tests/test_types.py``.
"""

from __future__ import annotations

from typing import Literal, TypedDict

Preset = Literal["default", "fast", "paper"]
'''


def field(parameter: tracecut.Parameter) -> str:
    """The lines of a parameter: its type, and its meaning, which editors show."""
    numbers = {"number": "float", "integer": "int", "boolean": "bool"}
    choices = ", ".join(f'"{name}"' for name in parameter.choices)
    kind = numbers.get(parameter.kind) or f"Literal[{choices}]"
    bounds = "" if parameter.low is None else f" ({parameter.low} to {parameter.high})"
    doc = parameter.doc.replace("\\", "\\\\")
    doc = f'"""{doc} Default: {parameter.default}{bounds}."""'
    lines = textwrap.wrap(doc, WIDTH - 4, break_on_hyphens=False, break_long_words=False)
    return "\n".join(f"    {line}" for line in (f"{parameter.name.split('.')[1]}: {kind}", *lines))


def declared() -> str:
    """The file of types as it should be."""
    known = {parameter.name: parameter for expert in (False, True) for parameter in tracecut.parameters(expert)}
    text = HEADING
    for section, fields in tracecut.Session().params.items():
        base = "TypedDict"
        for name in filter(keyword.iskeyword, fields):
            base = f"_{name.title()}"
            text += f'\n\n{base} = TypedDict("{base}", {{"{name}": float}}, total=False)\n'
        text += f'\n\nclass {section.title()}Params({base}, total=False):\n'
        text += f'    """Parameters of the section ``{section}``, with their defaults and ranges."""\n\n'
        text += "".join(field(known[f"{section}.{name}"]) + "\n" for name in fields if not keyword.iskeyword(name))
    text += '\n\nclass Params(TypedDict, total=False):\n    """All parameters: a preset, and a dictionary for each section."""\n\n'
    text += "    preset: Preset\n"
    return text + "".join(f"    {section}: {section.title()}Params\n" for section in tracecut.Session().params)


def test_the_types_of_the_parameters_are_those_that_the_library_declares() -> None:
    path = Path(_params.__file__)
    if os.environ.get("REGENERATE"):
        path.write_text(declared(), "utf-8")
    assert path.read_text("utf-8") == declared(), "write it again: REGENERATE=1"
