"""Sets up an environment, builds the package and runs its tests: ``python python/run_tests.py [arguments of pytest]``.

``--prepare`` makes the environment, ``--build`` the module in it, ``--test`` runs the tests of what was built: without one
of them, all three.

``--wheel`` builds the wheel as it would be published instead, installs it into an empty environment and tests it there,
and what is marked ``wheel``: the notebook and the recipes for other tools, whose packages take long to install, and
what runs for many seconds.

``--long`` runs what is marked ``long`` instead, with Ray, which it adds to the environment.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
VENV = Path(os.environ.get("TRACECUT_VENV") or HERE / ".venv")
TOOLS = ["maturin>=1.7,<2", "numpy", "pytest", "mypy", "pyright", "pycocotools", "pillow", "av", "tqdm", "pyarrow"]
WITHOUT_EXTRAS = ["test_segment.py", "test_session.py"]
WITH_VIDEO_AND_NOTEBOOK = ["test_frames.py", "test_video.py", "test_package.py"]
NOTEBOOK = ["matplotlib", "nbclient", "ipykernel"]
OTHER_TOOLS = ["datumaro", "label-studio-sdk", "fiftyone"]
RAY = "ray>=2.9"
NOTHING_TO_RUN = 5
"""The code of pytest where all that is in a file is left to another run."""


def run(*command: object, fine: tuple[int, ...] = (0,), **environment: str) -> None:
    """Runs a command, and ends with its code unless that is fine."""
    print("+", *command, flush=True)
    code = subprocess.run([str(word) for word in command], env={**os.environ, **environment}).returncode
    if code not in fine:
        sys.exit(code)


def python_of(folder: Path) -> Path:
    """The interpreter of an environment, which is made if it is not there."""
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if not python.exists():
        print(f"+ making the environment {folder}", flush=True)
        venv.create(folder, with_pip=True)
    return python


def test(python: Path, arguments: list[str], files: list[Path]) -> None:
    """Runs these files of tests, unless the arguments name others."""
    named = any(Path(word.split("::")[0]).exists() for word in arguments)
    command = [python, "-m", "pytest", "-c", HERE / "pyproject.toml", "--rootdir", HERE]
    run(*command, *arguments, *([] if named else files), fine=(0, NOTHING_TO_RUN))


def prepare() -> None:
    """The environment, which stays; its packages are asked for when this file has changed."""
    python = python_of(VENV)
    wanted, had = " ".join(TOOLS), VENV / "packages.txt"
    if not had.exists() or had.read_text() != wanted:
        run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *TOOLS)
        had.write_text(wanted)


def build() -> None:
    """The module in the environment: the one that ``TRACECUT_MODULE`` names, which `npm test` has compiled, or a new one."""
    python, manifest = python_of(VENV), ["--manifest-path", HERE / "Cargo.toml"]
    compiled = os.environ.get("TRACECUT_MODULE")
    if not compiled:
        run(python, "-m", "maturin", "develop", "--profile", "dev", *manifest, "--locked", VIRTUAL_ENV=str(VENV))
        return
    shutil.copyfile(compiled, HERE / "package" / "tracecut" / "_tracecut.abi3.so")
    asked = [python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]
    site = Path(subprocess.run(asked, check=True, capture_output=True, text=True).stdout.strip())
    (site / "tracecut.pth").write_text(f"{HERE / 'package'}\n")
    for old in site.glob("tracecut-*.dist-info"):
        shutil.rmtree(old)
    write = ["pep517", "write-dist-info", "--metadata-directory", site, "--interpreter", python]
    run(python, "-m", "maturin", *write, *manifest)
    (information,) = site.glob("tracecut-*.dist-info")
    names = [path.relative_to(site) for path in information.rglob("*") if path.is_file()]
    (information / "RECORD").write_text("".join(f"{name},,\n" for name in names))


def develop(arguments: list[str]) -> None:
    """The tests in the environment that stays."""
    test(python_of(VENV), arguments, [HERE / "tests"])


def long(arguments: list[str]) -> None:
    """Runs what takes minutes in the environment that stays."""
    run(python_of(VENV), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", RAY)
    test(python_of(VENV), ["-m", "long", *arguments], [HERE / "tests"])


def wheel(arguments: list[str]) -> None:
    """The tests on the wheel, in an environment that has nothing else."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        build = ["-m", "maturin", "build", "--out", out, "--manifest-path", HERE / "Cargo.toml", "--locked"]
        run(python_of(VENV), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", TOOLS[0])
        run(python_of(VENV), *build)
        (built,) = out.glob("*.whl")
        print(f"{built.name}: {built.stat().st_size} bytes")
        python = python_of(out / "venv")
        run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", built)
        # Nothing but the wheel and NumPy: the ten lines of the README, as they stand there.
        run(python, HERE / "tests" / "readme.py", PYTHONPATH="")
        run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "pytest", "pillow", "pycocotools")
        test(python, ["-m", "not long", *arguments], [HERE / "tests" / name for name in WITHOUT_EXTRAS])
        run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", f"{built}[video]", *NOTEBOOK)
        test(python, ["-m", "not long", *arguments], [HERE / "tests" / name for name in WITH_VIDEO_AND_NOTEBOOK])
        run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *OTHER_TOOLS)
        test(python, ["-m", "not long", *arguments], [HERE / "tests" / "test_interchange.py"])


STEPS = {
    "--prepare": prepare,
    "--build": build,
    "--test": lambda: develop(rest),
    "--long": lambda: long(rest),
    "--wheel": lambda: wheel(rest),
}

if __name__ == "__main__":
    chosen = [word for word in sys.argv[1:] if word in STEPS]
    rest = [word for word in sys.argv[1:] if word not in STEPS]
    for word in chosen or ["--prepare", "--build", "--test"]:
        STEPS[word]()
