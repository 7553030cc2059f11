"""Sets up an environment, builds the package and runs its tests: ``python python/run_tests.py [arguments of pytest]``.

``--prepare`` creates the environment, ``--build`` builds the module in it, ``--test`` runs the tests; without an option,
all three.

``--wheel`` instead builds the wheel for publishing, installs it into an empty environment and tests it there, with the
tests marked ``wheel``: the notebook, the recipes for other tools, whose packages take long to install, and slow tests.
Twine checks its metadata, and abi3audit that it uses the stable interface of Python alone.

``--long`` instead runs the tests marked ``long``, with Ray and OpenCV, which it adds to the environment, and with
PyTorch where that is installed.
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
PUBLISHING = ["twine", "abi3audit"]
WITHOUT_EXTRAS = ["test_segment.py", "test_session.py", "test_errors.py", "test_types.py"]
WITH_VIDEO_AND_NOTEBOOK = ["test_frames.py", "test_video.py", "test_package.py"]
WITH_OTHER_TOOLS = ["test_interchange.py", "test_documents.py"]
NOTEBOOK = ["matplotlib", "nbclient", "ipykernel"]
OTHER_TOOLS = ["datumaro", "label-studio-sdk", "fiftyone"]
RECIPES = ["opencv-python-headless"]
RAY = "ray>=2.9"
NOTHING_TO_RUN = 5
"""Exit code of pytest if it selects no test of a file."""


def run(*command: object, accepted: tuple[int, ...] = (0,), **environment: str) -> None:
    """Runs a command, and exits with its code unless that is accepted."""
    print("+", *command, flush=True)
    code = subprocess.run([str(word) for word in command], env={**os.environ, **environment}).returncode
    if code not in accepted:
        sys.exit(code)


def python_of(folder: Path) -> Path:
    """Returns the interpreter of an environment, creating it if needed."""
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if not python.exists():
        print(f"+ creating the environment {folder}", flush=True)
        venv.create(folder, with_pip=True)
    return python


def test(python: Path, arguments: list[str], files: list[Path]) -> None:
    """Runs these test files, unless the arguments name others."""
    has_files = any(Path(word.split("::")[0]).exists() for word in arguments)
    command = [python, "-m", "pytest", "-c", HERE / "pyproject.toml", "--rootdir", HERE]
    run(*command, *arguments, *([] if has_files else files), accepted=(0, NOTHING_TO_RUN))


def prepare() -> None:
    """Creates the permanent environment; installs its packages if the list has changed."""
    python = python_of(VENV)
    packages, installed = " ".join(TOOLS), VENV / "packages.txt"
    if not installed.exists() or installed.read_text() != packages:
        run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *TOOLS)
        installed.write_text(packages)


def build() -> None:
    """Installs the module: the one that `npm test` compiled (``TRACECUT_MODULE``), or a new build."""
    python, manifest = python_of(VENV), ["--manifest-path", HERE / "Cargo.toml"]
    compiled = os.environ.get("TRACECUT_MODULE")
    if not compiled:
        run(python, "-m", "maturin", "develop", "--profile", "dev", *manifest, "--locked", VIRTUAL_ENV=str(VENV))
        return
    shutil.copyfile(compiled, HERE / "package" / "tracecut" / "_tracecut.abi3.so")
    command = [python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]
    site = Path(subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip())
    (site / "tracecut.pth").write_text(f"{HERE / 'package'}\n")
    for old in site.glob("tracecut-*.dist-info"):
        shutil.rmtree(old)
    write = ["pep517", "write-dist-info", "--metadata-directory", site, "--interpreter", python]
    run(python, "-m", "maturin", *write, *manifest)
    (information,) = site.glob("tracecut-*.dist-info")
    names = [path.relative_to(site) for path in information.rglob("*") if path.is_file()]
    (information / "RECORD").write_text("".join(f"{name},,\n" for name in names))


def develop(arguments: list[str]) -> None:
    """Runs the tests in the permanent environment."""
    test(python_of(VENV), arguments, [HERE / "tests"])


def long(arguments: list[str]) -> None:
    """Runs the long tests in the permanent environment."""
    run(python_of(VENV), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", RAY, *RECIPES)
    test(python_of(VENV), ["-m", "long", *arguments], [HERE / "tests"])


def wheel(arguments: list[str]) -> None:
    """Runs the tests on the wheel, in an empty environment."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        build = ["-m", "maturin", "build", "--out", out, "--manifest-path", HERE / "Cargo.toml", "--locked"]
        run(python_of(VENV), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", TOOLS[0], *PUBLISHING)
        run(python_of(VENV), *build)
        (package,) = out.glob("*.whl")
        print(f"{package.name}: {package.stat().st_size} bytes")
        run(python_of(VENV), "-m", "twine", "check", "--strict", package)
        run(python_of(VENV), "-m", "abi3audit", "--strict", "--report", package)
        python = python_of(out / "venv")
        run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", package)
        run(python.with_name("tracecut"), "selftest")
        # With only the wheel and NumPy: the code of the READMEs.
        run(python, HERE / "tests" / "documents.py", PYTHONPATH="")
        run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "pytest", "pillow", "pycocotools")
        test(python, ["-m", "not long", *arguments], [HERE / "tests" / name for name in WITHOUT_EXTRAS])
        run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", f"{package}[video]", *NOTEBOOK)
        test(python, ["-m", "not long", *arguments], [HERE / "tests" / name for name in WITH_VIDEO_AND_NOTEBOOK])
        run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *OTHER_TOOLS)
        test(python, ["-m", "not long", *arguments], [HERE / "tests" / name for name in WITH_OTHER_TOOLS])


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
