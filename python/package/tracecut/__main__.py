"""``python -m tracecut CLIP --out FOLDER``: the masks of clips as PNG files, by the rules of the command line."""

from __future__ import annotations

import argparse
import json
import signal
import sys
import time
from difflib import get_close_matches
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Optional

from ._errors import TraceCutError
from ._segment import WINDOW, Result, segment
from ._session import Session
from ._tracecut import version
from .interchange._output import new_folder

#: Exit codes, those of the command line.
_LATER, _USAGE, _INPUT, _MEMORY, _INTERRUPTED = 1, 2, 3, 4, 130

_EXIT_CODES = {"param": _USAGE, "frame-size": _MEMORY, "too-large": _MEMORY, "state": _LATER}

_HELP = """\
tracecut.parameters() lists the parameters that --set sets; --set preset=fast or preset=paper sets many.

Results in the folder, which appears when everything is done:
  00000.png ...  label of each pixel, 0 for the background, at the size of the frames
  result.json    version, sizes, objects, number of shots, times of the frames of a video, options and settings,
                 and any damage of the clip

Exit codes; of several failures, the lowest:
  0    success
  1    may succeed later: a clip is missing or cannot be opened, PyAV is missing, results cannot be written, or a
       fault of the program
  2    wrong use: an option, a parameter, a folder that already exists
  3    bad input, which will not succeed later: no images or video, frames of different sizes, fewer than two
       frames; or damaged: results hold the frames before the damage
  4    out of memory, or frames too large
  130  interrupted (SIGINT), 143 ended (SIGTERM): no results of the current clip

The program tracecut writes other formats and resumes an interrupted run; see docs/cli.md."""


def main(argv: Optional[list[str]] = None) -> int:
    """Runs the program and returns its exit code."""
    args = _parse(argv)
    failures: list[int] = []
    try:
        # Refuses wrong parameters before anything is touched.
        Session(**dict(args.set))
        for clip, out in zip(args.clips, _targets(args.clips, args.out)):
            code = _attempt(clip, out, args)
            failures += [code] if code else []
    except TraceCutError as error:
        return _print_error(error, _USAGE)
    except KeyboardInterrupt:
        return _print_error("interrupted", _INTERRUPTED)
    if failures and len(args.clips) > 1:
        _print_error(f"{len(failures)} of {len(args.clips)} clips failed", 0)
    return min(failures, default=0)


def _parse(argv: Optional[list[str]]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m tracecut",
        description="Finds the moving objects in videos.",
        epilog=_HELP,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    clips = "folders of PNG or JPEG files in name order, or videos (which need PyAV)"
    parser.add_argument("clips", nargs="+", metavar="CLIP", help=clips)
    out = "folder for the results; with several clips, a folder in it for each"
    parser.add_argument("--out", required=True, type=Path, metavar="FOLDER", help=out)
    parser.add_argument("--overwrite", action="store_true", help="replace existing results")
    window = f"frames of a window, 2 to 400; a longer clip is segmented window by window [{WINDOW}]"
    parser.add_argument("--window", type=int, default=WINDOW, metavar="N", help=window)
    overlap = "frames that neighbouring windows share [10 if the window has more]"
    parser.add_argument("--overlap", type=int, metavar="N", help=overlap)
    threads = "number of threads [as many as the machine runs at once]; results do not depend on it"
    parser.add_argument("--threads", type=int, metavar="N", help=threads)
    setting = "a parameter, such as flow.patch_stride=5; may be repeated"
    parser.add_argument("--set", action="append", default=[], type=_setting, metavar="NAME=VALUE", help=setting)
    parser.add_argument("--version", action="version", version=f"tracecut {version}")
    args, unknown = parser.parse_known_args(argv)
    if unknown:
        known = [name for action in parser._actions for name in action.option_strings]
        similar = ", ".join(get_close_matches(unknown[0], known, 3, 0.0))
        parser.error(f"unknown option {unknown[0]} (expected a known option, such as {similar})")
    return args


def _setting(text: str) -> tuple[str, Any]:
    """Parses NAME=VALUE; the value is a number, true, false, or a name."""
    name, equals, value = text.partition("=")
    if not equals:
        raise argparse.ArgumentTypeError(f"{text!r} (expected NAME=VALUE, such as flow.patch_stride=5)")
    try:
        return name, json.loads(value)
    except json.JSONDecodeError:
        return name, value


def _targets(clips: list[str], out: Path) -> list[Path]:
    """Returns the folder of each clip's results."""
    if len(clips) == 1:
        return [out]
    names = [Path(clip).name if Path(clip).is_dir() else Path(clip).stem for clip in clips]
    for clip, name in zip(clips, names):
        if not name or names.count(name) > 1:
            raise _refuse(clip, "its results would overwrite those of another clip (run it separately)")
    return [out / name for name in names]


def _attempt(clip: str, out: Path, args: argparse.Namespace) -> int:
    """Segments a clip, prints the outcome, and returns the exit code."""
    try:
        _run(clip, out, args)
    except (OSError, ImportError) as error:
        return _print_error(error, _LATER)
    except TraceCutError as error:
        return _print_error(error, _EXIT_CODES.get(error.code, _INPUT))
    except MemoryError:
        return _print_error(f"{clip}: there is not enough memory", _MEMORY)
    return 0


def _run(clip: str, out: Path, args: argparse.Namespace) -> None:
    start, settings = time.perf_counter(), dict(args.set)
    _check_target(out, args.overwrite)
    options = {"window": args.window, **({} if args.overlap is None else {"overlap": args.overlap})}
    report: dict[str, Any] = {"input": clip, "options": options, "settings": settings}
    damage: Optional[TraceCutError] = None
    try:
        bar = _is_terminal() and find_spec("tqdm") is not None
        result = segment(clip, **options, threads=args.threads, progress=bar, **settings)
    except TraceCutError as error:
        if error.result is None:
            raise
        result, damage = error.result, error
        report["truncated"] = {"frames": len(result), "reason": error.message.removeprefix(f"{clip}: ")}
    _write(result, report, out)
    summary = f"{len(result)} frames of {result.width}x{result.height}: {len(result.objects)} object(s)"
    print(f"{summary}, {time.perf_counter() - start:.2f} s; see {out}", flush=True)
    if damage is not None:
        raise damage


def _is_terminal() -> bool:
    return sys.stderr.isatty()


def _check_target(out: Path, overwrite: bool) -> None:
    """Refuses an output folder whose content must not be replaced."""
    if not out.exists() or (out.is_dir() and not any(out.iterdir())):
        return
    if not overwrite:
        raise _refuse(out, "exists already (use --overwrite to replace results, or choose another folder)")
    report = out / "result.json"
    if not report.is_file() or '"workingWidth"' not in report.read_text("utf-8", errors="replace"):
        raise _refuse(out, "has no results of this program and is not replaced: choose another folder")


def _refuse(path: object, reason: str) -> TraceCutError:
    return TraceCutError("param", f"{path}: {reason}")


def _write(result: Result, report: dict[str, Any], out: Path) -> None:
    with new_folder(out, "out", overwrite=True) as folder:
        result.save(folder)
        text = json.dumps({**result.as_json(), **report}, indent=2, ensure_ascii=False)
        (folder / "result.json").write_text(text + "\n", encoding="utf-8")


def _print_error(reason: object, code: int) -> int:
    print(f"error: {reason}", file=sys.stderr, flush=True)
    return code


def _end(number: int, _frame: object) -> None:
    sys.exit(128 + number)


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, _end)
    sys.exit(main())
