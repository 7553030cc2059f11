"""Types: what the type checkers refuse, and that they know the parameters that the library declares."""

from __future__ import annotations

import keyword
import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import get_args, get_type_hints

import documents
import numpy as np
import pytest
import tracecut
from tracecut import _params, synth
from tracecut._progress import _COSTS
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
        text += f"\n\nclass {section.title()}Params({base}, total=False):\n"
        text += f'    """Parameters of the section ``{section}``, with their defaults and ranges."""\n\n'
        text += "".join(field(known[f"{section}.{name}"]) + "\n" for name in fields if not keyword.iskeyword(name))
    text += "\n\nclass Params(TypedDict, total=False):\n"
    text += '    """All parameters: a preset, and a dictionary for each section."""\n\n'
    text += "    preset: Preset\n"
    return text + "".join(f"    {section}: {section.title()}Params\n" for section in tracecut.Session().params)


def test_parameter_types_match_the_library() -> None:
    path = Path(_params.__file__)
    if os.environ.get("REGENERATE"):
        path.write_text(declared(), "utf-8")
    assert path.read_text("utf-8") == declared(), "write it again: REGENERATE=1"


#: What the type checkers must refuse, one mistake a line.
MISTAKES = """\
import tracecut
from tracecut.synth import Scene

clip = Scene("sample", 96, 64, frames=8)
tracecut.segment(clip, thread=2)
tracecut.segment(clip, preset="faster")
tracecut.segment(clip, flow={"patch_stridde": 5})
tracecut.segment(clip, flow={"patch_stride": "5"})
tracecut.segment(clip, clip=480)
tracecut.segment(clip, discretize={"method": "best"})
tracecut.segment(None)
tracecut.segment(clip, windows=5)
tracecut.windows(clip, trajectories=2)
tracecut.Session(flw={"patch_stride": 5})
tracecut.Session(threads=2)
tracecut.superpixels(clip[0], cuont=5)
tracecut.boundaries(clip[0], preset=1)
tracecut.image_discontinuities(clip[0], still={"dimension": 4})
tracecut.flow(clip[0], clip[1], flow={"levels_": 1})
tracecut.Session().clusters_by("best", 2)
tracecut.Session().labels("first")
Scene("simple")
bad: int = tracecut.segment(clip)[0]
tracecut.segment(clip)["first"]
options: tracecut.Params = {"flow": {"patch_strid": 5}}
"""

#: What they must accept.
RIGHT = """\
import tracecut
from tracecut.synth import Scene

clip = Scene("sample", 96, 64, frames=8)
options: tracecut.Params = {"preset": "fast", "clip": {"max_side": 480}, "affinity": {"lambda": 0.1}}
result = tracecut.segment(clip, threads=2, progress=True, flow={"patch_stride": 5}, discretize={"method": "k-means"})
tracecut.segment(clip, **options)
print(result[2:4].shape, result[-1].dtype, clip[1:3].shape, result.session.clusters().count, result.trajectories.x)
"""


#: Blocks of documents need no types for their helpers, and packages that are not installed have none.
MYPY = """\
[mypy]
strict = True
[mypy-tqdm.*,av.*,{untyped}]
ignore_missing_imports = True
[mypy-blocks.*]
allow_untyped_defs = True
allow_untyped_calls = True
allow_incomplete_defs = True
allow_subclassing_any = True
"""
PYRIGHT = "\n# pyright: standard, reportMissingImports=false, reportMissingModuleSource=false\n"


def write_blocks(folder: Path) -> None:
    """Writes the Python of each document into a file, each block in the line that it has in the document."""
    folder.mkdir()
    (folder / "__init__.py").touch()
    for document in documents.documents():
        text = ""
        for block in documents.blocks(document):
            text += "\n" * (block.line - text.count("\n")) + block.code
        (folder / (re.sub(r"\W", "_", document) + ".py")).write_text(text + PYRIGHT)


@pytest.mark.parametrize("tool", ["mypy", pytest.param("pyright", marks=pytest.mark.long)])
def test_type_checkers_find_mistakes_and_accept_the_package_and_documents(tool: str, tmp_path: Path) -> None:
    pytest.importorskip(tool)
    (tmp_path / "mistakes.py").write_text(MISTAKES)
    (tmp_path / "right.py").write_text(RIGHT)
    write_blocks(tmp_path / "blocks")
    modules = {name.split(".")[0] for block in documents.all_blocks() for name in documents.imports(block.code)}
    untyped = ",".join(f"{name}.*" for name in sorted(modules - {"tracecut"}))
    (tmp_path / "mypy.ini").write_text(MYPY.format(untyped=untyped))
    # Pyright takes the Python of PATH otherwise, which may not be this one. Its first run fetches it.
    options = {"mypy": ["--config-file", tmp_path / "mypy.ini"], "pyright": ["--pythonpath", sys.executable]}[tool]
    paths = ["package/tracecut", "tests/typed.py", *(tmp_path / name for name in ("mistakes.py", "right.py", "blocks"))]
    command = [sys.executable, "-m", tool, *map(str, [*options, *paths])]
    checked = subprocess.run(command, cwd=PYTHON, capture_output=True, text=True)
    errors = [line for line in checked.stdout.splitlines() if re.search(r":\d+.*\berror\b", line)]
    found = {re.findall(r"(\w+\.pyi?):(\d+)", line)[-1] for line in errors}
    expected = {("mistakes.py", str(line)) for line in range(5, len(MISTAKES.splitlines()) + 1)}
    assert found == expected, checked.stdout + checked.stderr


def test_annotations_can_be_read_by_programs() -> None:
    for call in (tracecut.segment, tracecut.windows, tracecut.Session.__init__, tracecut.superpixels):
        assert "params" in get_type_hints(call)


def test_names_in_types_match_the_library(clip: list[np.ndarray]) -> None:
    methods = {p.name: p.choices for p in tracecut.parameters() + tracecut.parameters(expert=True)}["discretize.method"]
    assert get_args(Method) == methods
    session = tracecut.Session(preset="fast")
    session.push_all(clip)
    assert tuple(dict.fromkeys(progress.stage for progress in session.steps())) == get_args(Stage)
    assert tuple(_COSTS) == get_args(Stage)
    with pytest.raises(tracecut.TraceCutError) as caught:
        tracecut.Session(preset="none")  # type: ignore[arg-type]
    assert str(caught.value).split("(expected ")[1] == "default, fast or paper)"
    assert get_args(_params.Preset) == ("default", "fast", "paper")
    with pytest.raises(tracecut.TraceCutError) as caught:
        synth.Scene("none")  # type: ignore[arg-type]
    assert re.findall(r"[a-z_]{5,}", str(caught.value).split("(expected ")[1]) == list(get_args(synth.Kind))
