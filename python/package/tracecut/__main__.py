"""``python -m tracecut CLIP --out FOLDER``: the masks of a clip as PNG files."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any, Optional

from ._errors import TraceCutError
from ._segment import WINDOW, segment


def setting(text: str) -> tuple[str, Any]:
    """``name=value``: a number, true, false, or a name."""
    name, equals, value = text.partition("=")
    if not equals:
        raise argparse.ArgumentTypeError(f"{text!r} (expected NAME=VALUE, such as flow.patch_stride=5)")
    try:
        return name, json.loads(value)
    except json.JSONDecodeError:
        return name, value


def main(words: Optional[list[str]] = None) -> int:
    """Runs the program; gives its exit code."""
    parser = argparse.ArgumentParser(prog="python -m tracecut", description="Finds the moving objects in a video.")
    parser.add_argument("clip", help="folder of PNG or JPEG files, or a video (which needs PyAV)")
    parser.add_argument("--out", required=True, help="folder for the masks; made if needed")
    parser.add_argument("--window", type=int, default=WINDOW, help=f"frames of a window [{WINDOW}]")
    parser.add_argument("--threads", type=int, help="as many as the machine runs at once if not given")
    parser.add_argument("--set", action="append", default=[], type=setting, metavar="NAME=VALUE", help="a parameter")
    args = parser.parse_args(words)
    try:
        result = segment(args.clip, window=args.window, threads=args.threads, **dict(args.set))
    except (TraceCutError, OSError, ImportError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    result.save(args.out)
    size = f"{result.width}x{result.height}"
    print(f"{len(result)} frames of {size}: {len(result.objects)} object(s); see {args.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
