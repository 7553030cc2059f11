"""What several tests share."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tracecut

ROOT = Path(__file__).resolve().parents[2]


def golden(name: str) -> dict[str, Any]:
    """A golden file, which the tests of Rust and of JavaScript compare with too."""
    return json.loads((ROOT / "tests" / "data" / f"golden-{name}.json").read_text())


def fnv1a(mask: np.ndarray) -> str:
    """The hash of masks in the golden files."""
    value = 0x811C9DC5
    for byte in mask.tobytes():
        value = (value ^ byte) * 0x01000193 & 0xFFFFFFFF
    return f"{value:08x}"


@pytest.fixture(scope="session")
def clip() -> list[np.ndarray]:
    """Eight frames of a made clip, 96 by 64 pixels."""
    return list(tracecut.synth.Scene("sample", 96, 64, 8, seed=3))


@pytest.fixture(scope="session")
def done(clip: list[np.ndarray]) -> tracecut.Session:
    """A session that has seen them; tests do not change it."""
    session = tracecut.Session()
    session.push_all(clip)
    session.run()
    return session


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with twelve frames, 160 by 90 pixels, as PNG files."""
    from PIL import Image

    out = tmp_path_factory.mktemp("frames")
    for t, frame in enumerate(tracecut.synth.Scene("sample", 160, 90, 12, seed=1)):
        Image.fromarray(frame).save(out / f"frame{t}.png")
    (out / "notes.txt").write_text("no frame")
    return out


@pytest.fixture(scope="session")
def cli() -> str:
    """The command line; the environment's TRACECUT_CLI, or the newest that was built here."""
    built = [ROOT / "target" / profile / "tracecut" for profile in ("quick", "release", "debug")]
    found = sorted((p for p in built if p.is_file()), key=lambda p: p.stat().st_mtime)
    path = os.environ.get("TRACECUT_CLI") or (str(found[-1]) if found else shutil.which("tracecut"))
    if not path:
        pytest.skip("no command line was built: cargo build --profile quick -p tracecut-cli")
    return path
