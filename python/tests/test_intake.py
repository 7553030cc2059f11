"""The intake table (tests/intake) in Python."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tracecut

ROOT = Path(__file__).resolve().parents[2]
TIME_TOLERANCE_S = 0.001
LEAST_OVERLAP = 0.8

pytest.importorskip("av")


def read_table() -> dict[str, Any]:
    """The table, whose files are made; one without cases where node or ffmpeg is missing."""
    if not (shutil.which("node") and shutil.which("ffmpeg")):
        return {"cases": []}
    command = ["node", str(ROOT / "tests" / "intake" / "cases.mjs")]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


TABLE = read_table()
if not TABLE["cases"]:
    pytest.skip("needs node and ffmpeg", allow_module_level=True)


@pytest.mark.parametrize("row", TABLE["cases"], ids=lambda row: row["name"])
def test_file(row: dict[str, Any]) -> None:
    path = Path(TABLE["folder"]) / row["file"]
    refusal = row.get("error") or row.get("except", {}).get("python")
    if refusal:
        with pytest.raises(tracecut.TraceCutError, match=re.compile(row["words"])) as failure:
            tracecut.segment(path)
        assert failure.value.code == refusal
        return
    if row.get("isTruncated"):
        with pytest.raises(tracecut.TraceCutError) as failure:
            tracecut.segment(path)
        assert failure.value.code == "truncated"
        check(row, failure.value.result)
        return
    check(row, tracecut.segment(path))


@pytest.mark.parametrize("file", ["bt709.mp4", "sar.mp4", "vfr.mp4"])
def test_masks_are_those_of_the_command_line(file: str, cli: str, tmp_path: Path) -> None:
    path = Path(TABLE["folder"]) / file
    out = tmp_path / "out"
    subprocess.run([cli, "segment", path, "--out", out, "--format", "npz", "--quiet"], check=True)
    np.testing.assert_array_equal(tracecut.segment(path).array(), np.load(out / "masks.npz")["masks"])


def check(row: dict[str, Any], result: tracecut.Result) -> None:
    """Holds a result against the table."""
    clip = TABLE["clip"]
    assert result.array().shape == (row["numFrames"], clip["height"], clip["width"])
    if row["times"] is None:
        assert result.times is None
    else:
        np.testing.assert_allclose(result.times, row["times"], atol=TIME_TOLERANCE_S)
        if "lastDuration" in row:
            assert result.durations[-1] == pytest.approx(row["lastDuration"], abs=TIME_TOLERANCE_S)
    if row["masks"]:
        for k in (0, row["numFrames"] - 1):
            square = np.zeros((clip["height"], clip["width"]), bool)
            x, y = row["place"]["x"] + 3 * k, row["place"]["y"] + k
            square[y : y + clip["side"], x : x + clip["side"]] = True
            mask = result.labels(k) > 0
            assert (mask & square).sum() / (mask | square).sum() >= LEAST_OVERLAP, f"picture {k}"
