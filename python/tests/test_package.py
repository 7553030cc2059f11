"""The package as installed: licences, the program, the examples in docstrings, and the notebook."""

from __future__ import annotations

import doctest
import importlib
import importlib.metadata
import json
import os
import pkgutil
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import tracecut
from conftest import ROOT


def installed(name: str) -> str:
    """A licence file as it was installed."""
    files = importlib.metadata.distribution("tracecut").files or []
    (path,) = (path for path in files if path.match(f"*.dist-info/licenses/{name}"))
    return path.locate().read_text("utf-8")


@pytest.mark.parametrize("name", ["LICENSE-APACHE", "LICENSE-MIT"])
def test_the_licences_are_installed(name: str) -> None:
    assert installed(name) == (ROOT / name).read_text("utf-8")


def program() -> list[str]:
    """The command that starts the installed program ``tracecut`` as its console script does."""
    (entry,) = (e for e in importlib.metadata.distribution("tracecut").entry_points if e.group == "console_scripts")
    assert entry.name == "tracecut"
    module, function = entry.value.split(":")
    return [sys.executable, "-c", f"import sys; from {module} import {function}; sys.exit({function}())"]


@pytest.mark.parametrize(
    ("code", "arguments"),
    [
        (0, ["segment", "--help"]),
        (0, ["--version"]),
        (1, ["segment", "missing.mp4", "--out", "out"]),
        (2, ["segment", "clip.mp4", "--out", "out", "--thread", "2"]),
        (3, ["segment", os.devnull, "--out", "out"]),
        (4, ["segment", "FOLDER", "--out", "out", "--set", "clip.maxPixels=1000"]),
    ],
)
def test_the_program_prints_and_exits_like_the_rust_program(
    code: int, arguments: list[str], cli: str, folder: Path, tmp_path: Path
) -> None:
    arguments = [str(folder) if word == "FOLDER" else word for word in arguments]
    outputs = []
    for command in ([cli], program()):
        ran = subprocess.run([*command, *arguments], cwd=tmp_path, capture_output=True, text=True)
        outputs.append((ran.returncode, ran.stdout, ran.stderr))
    assert outputs[0][0] == code and outputs[1] == outputs[0]


def test_the_package_runs_as_a_module() -> None:
    ran = subprocess.run([sys.executable, "-m", "tracecut", "--version"], check=True, capture_output=True, text=True)
    assert ran.stdout == f"tracecut {tracecut.__version__}\n"


def files(folder: Path) -> dict[str, bytes]:
    """The files below a folder; of the report, what does not depend on the time."""
    found = {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    report = json.loads(found["result.json"])
    measured = ("seconds", "cpuSeconds", "peakMemoryBytes")
    found["result.json"] = json.dumps({name: value for name, value in report.items() if name not in measured}).encode()
    return found


def test_the_program_writes_the_files_of_the_rust_program(cli: str, folder: Path, tmp_path: Path) -> None:
    options = ["--frames", "4", "--format", "png,rle,npz,tracks,overlay"]
    for name, command in (("rust", [cli]), ("python", program())):
        subprocess.run([*command, "segment", folder, "--out", tmp_path / name, *options], check=True)
    expected = files(tmp_path / "rust")
    assert len(expected) > 12 and files(tmp_path / "python") == expected


@pytest.mark.skipif(sys.platform == "win32", reason="signals are for Unix")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_signals_end_the_program_without_partial_results(number: int, code: int, tmp_path: Path) -> None:
    command = [*program(), "segment", "-", "--out", str(tmp_path / "out"), "--log", "json"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, **pipes) as process:
        assert process.stdin is not None and process.stderr is not None
        # It waits for the second frame.
        process.stdin.write(b"YUV4MPEG2 W16 H16 F25:1 Cmono\nFRAME\n" + bytes(256))
        process.stdin.flush()
        assert json.loads(process.stderr.readline())["event"] == "begin"
        process.send_signal(number)
        assert process.wait() == code
        assert b"Traceback" not in process.stderr.read()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform == "win32", reason="Windows reports other errors")
def test_the_program_ends_quietly_if_nobody_reads_its_output() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    ran = subprocess.run([*program(), "params"], stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert (ran.returncode, ran.stderr) == (0, b"")


def modules() -> list[str]:
    names = [m.name for m in pkgutil.iter_modules(tracecut.__path__) if m.name != "_tracecut"]
    return ["tracecut", *(f"tracecut.{name}" for name in names)]


def test_examples_in_docstrings_run() -> None:
    tried = 0
    for name in modules():
        failed, count = doctest.testmod(importlib.import_module(name))
        assert failed == 0, name
        tried += count
    assert tried > 10


def test_everything_public_is_documented() -> None:
    for name in tracecut.__all__:
        thing = getattr(tracecut, name)
        if not callable(thing) or isinstance(thing, str) or name in ("FrameLike", "Frames"):
            continue
        assert thing.__doc__, name
        for method, value in vars(thing).items() if isinstance(thing, type) else ():
            assert method.startswith("_") or not callable(value) or value.__doc__, f"{name}.{method}"


NOTEBOOK = Path(__file__).resolve().parents[1] / "examples" / "stages.ipynb"


@pytest.mark.wheel
def test_the_notebook_shows_every_stage() -> None:
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "outputs are not kept in the repository"
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    pictures = [o for o in outputs if "image/png" in o.get("data", {})]
    assert len(pictures) >= 8
    text = "".join(o.get("text", "") for o in outputs)
    overlap = re.search(r"union of the foreground: ([0-9.]+)", text)
    assert overlap and float(overlap[1]) > 0.7, text
