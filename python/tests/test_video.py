"""Videos: each picture of the file once, upright, with the file's own times, up to where the file is damaged."""

from __future__ import annotations

import io
import json
import pickle
import shutil
import struct
import subprocess
import threading
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tracecut
from conftest import fails
from PIL import Image, features
from tracecut import interchange

av = pytest.importorskip("av")

WIDTH, HEIGHT, NUM_FRAMES = 96, 64, 8

#: Filters that give the command line's pixels.
SCALE = (
    "scale=w='if(gt(sar,1),round(iw*sar),iw)':h='if(gt(sar,1),ih,round(ih/sar))'"
    ":flags=bicubic+accurate_rnd+full_chroma_int+bitexact,setsar=1,format=rgb24"
)

#: Display matrices (a, b, c, d), and how pictures are stored that they bring upright.
TURNS: dict[str, tuple[tuple[int, int, int, int], Any]] = {
    "90": ((0, 1, -1, 0), lambda frame: np.rot90(frame, 1)),
    "180": ((-1, 0, 0, -1), lambda frame: np.rot90(frame, 2)),
    "270": ((0, -1, 1, 0), lambda frame: np.rot90(frame, 3)),
    "mirrored": ((-1, 0, 0, 1), lambda frame: frame[:, ::-1]),
    "upside down": ((1, 0, 0, -1), lambda frame: frame[::-1]),
    "transposed": ((0, 1, 1, 0), lambda frame: frame.transpose(1, 0, 2)),
    "transposed the other way": ((0, -1, -1, 0), lambda frame: np.rot90(frame, 2).transpose(1, 0, 2)),
}


@pytest.fixture(scope="module")
def frames() -> list[np.ndarray]:
    return list(tracecut.synth.Scene("sample", WIDTH, HEIGHT, NUM_FRAMES, seed=3))


def write_video(
    path: Path,
    tracks: Sequence[Sequence[np.ndarray]],
    codec: str = "libx264",
    times_ms: Sequence[int] | None = None,
    aspect: Fraction | None = None,
    container: dict[str, str] | None = None,
    default: int | None = None,
    **options: str,
) -> Path:
    """Writes a video of one or more tracks, 25 pictures a second unless times are given."""
    lossless = {"qp": "0", "g": "4"} if codec == "libx264" else {}
    pixels = {"libx264": "yuv444p", "ffv1": "bgr0", "mjpeg": "yuvj444p", "libvpx": "yuv420p"}[codec]
    with av.open(str(path), "w", options=container or {}) as out:
        streams = [out.add_stream(codec, rate=25, options={**lossless, **options}) for _ in tracks]
        for number, (stream, pictures) in enumerate(zip(streams, tracks)):
            stream.height, stream.width = pictures[0].shape[:2]
            stream.pix_fmt = pixels
            stream.codec_context.time_base = Fraction(1, 1000)
            if aspect is not None:
                stream.codec_context.sample_aspect_ratio = aspect
            if default is not None:
                stream.disposition = av.stream.Disposition.default.value if number == default else 0
        for stream, pictures in zip(streams, tracks):
            for t, picture in enumerate(pictures):
                frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
                frame.pts = 40 * t if times_ms is None else times_ms[t]
                frame.time_base = Fraction(1, 1000)
                out.mux(stream.encode(frame))
            out.mux(stream.encode(None))
    return path


def write_animation(path: Path, frames: Sequence[np.ndarray], duration: Any = 40, **options: Any) -> Path:
    """Writes frames as an animated image; `duration` is that of each frame, in milliseconds."""
    first, *others = (Image.fromarray(frame) for frame in frames)
    first.save(path, save_all=True, append_images=others, duration=duration, **options)
    return path


def set_display_matrix(path: Path, matrix: tuple[int, int, int, int]) -> Path:
    """Gives the first track of an MP4 another display matrix."""
    data = bytearray(path.read_bytes())
    place = data.index(b"tkhd") + 4 + 4 + 20 + 16
    a, b, c, d = (value << 16 for value in matrix)
    data[place : place + 36] = struct.pack(">9i", a, b, 0, c, d, 0, 0, 0, 1 << 30)
    path.write_bytes(data)
    return path


def truncate(path: Path, share: float = 0.6) -> Path:
    """Leaves this share of a file."""
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    return path


def read(source: Any) -> np.ndarray:
    return np.stack(list(tracecut.read_video(source)))


def assert_alike(read_frames: np.ndarray, frames: Sequence[np.ndarray]) -> None:
    assert read_frames.shape == (len(frames), *frames[0].shape)
    assert np.abs(read_frames.astype(int) - np.stack(frames)).mean() < 3


@pytest.mark.parametrize("turn", TURNS)
def test_pictures_are_upright(turn: str, frames: list[np.ndarray], tmp_path: Path) -> None:
    matrix, stored = TURNS[turn]
    path = set_display_matrix(write_video(tmp_path / "a.mp4", [[stored(frame) for frame in frames]]), matrix)
    assert_alike(read(path), frames)


def test_pixels_are_square(frames: list[np.ndarray], tmp_path: Path) -> None:
    wide = write_video(tmp_path / "wide.mp4", [[frame[:, ::2] for frame in frames]], aspect=Fraction(2, 1))
    assert read(wide).shape == (NUM_FRAMES, HEIGHT, WIDTH, 3)
    high = write_video(tmp_path / "high.mp4", [frames], aspect=Fraction(3, 4))
    assert read(high).shape == (NUM_FRAMES, 85, WIDTH, 3)
    matrix, stored = TURNS["90"]
    side = write_video(tmp_path / "side.mp4", [[stored(frame)[::2] for frame in frames]], aspect=Fraction(1, 2))
    assert read(set_display_matrix(side, matrix)).shape == (NUM_FRAMES, HEIGHT, WIDTH, 3)


def test_later_pictures_are_scaled_to_the_size_of_the_first(frames: list[np.ndarray], tmp_path: Path) -> None:
    small = [frame[::2, ::2] for frame in frames]
    packets: list[Any] = []
    for pictures in (frames[:4], small[4:]):
        part = write_video(tmp_path / "part.webm", [pictures], "libvpx", crf="4", b="4M")
        with av.open(str(part)) as container:
            packets += [packet for packet in container.demux(video=0) if packet.size]
    with av.open(str(tmp_path / "both.webm"), "w") as out:
        stream = out.add_stream("libvpx", rate=25)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        for t, packet in enumerate(packets):
            packet.stream, packet.time_base, packet.pts, packet.dts = stream, Fraction(1, 1000), 40 * t, 40 * t
            out.mux(packet)
    whole = read(tmp_path / "both.webm")
    assert whole.shape == (NUM_FRAMES, HEIGHT, WIDTH, 3)
    assert np.abs(whole.astype(int) - np.stack(frames)).mean() < 25


def test_times_are_those_of_the_file(frames: list[np.ndarray], tmp_path: Path) -> None:
    times_ms = [0, 40, 70, 500, 540, 600, 1000, 1033]
    path = write_video(tmp_path / "vfr.mp4", [frames], times_ms=times_ms)
    reader = tracecut.read_video(path)
    next(reader)
    assert reader.times.tolist() == [0]
    list(reader)
    assert np.allclose(reader.times, np.array(times_ms) / 1000, atol=1e-3)
    assert np.allclose(reader.durations[:-1], np.diff(times_ms) / 1000, atol=1e-3) and reader.durations[-1] > 0
    result = tracecut.segment(path)
    assert result.times is not None and result.durations is not None
    assert np.array_equal(result.times, reader.times) and np.array_equal(result.durations, reader.durations)
    assert result.frame_rate == pytest.approx(NUM_FRAMES / (result.times[-1] + result.durations[-1]))
    assert tracecut.segment(tracecut.read_video(path)).times is not None
    assert tracecut.segment(frames).times is None and tracecut.segment(frames).frame_rate is None


def test_equal_or_missing_times_are_replaced(frames: list[np.ndarray], tmp_path: Path) -> None:
    path = write_video(tmp_path / "equal.mkv", [frames], "ffv1", times_ms=[0, 40, 40, 40, 160, 200, 240, 280])
    reader = tracecut.read_video(path)
    assert len(list(reader)) == NUM_FRAMES
    assert np.allclose(reader.times, [0, 0.04, 0.08, 0.12, 0.16, 0.2, 0.24, 0.28])
    bare = tracecut.read_video(write_video(tmp_path / "bare.h264", [frames]))
    assert len(list(bare)) == NUM_FRAMES
    assert np.allclose(np.diff(bare.times), 0.04) and np.allclose(bare.durations, 0.04)


def test_results_and_exports_have_the_times(frames: list[np.ndarray], tmp_path: Path) -> None:
    path = write_video(tmp_path / "a.mp4", [frames], times_ms=[100 * t for t in range(NUM_FRAMES)])
    result = tracecut.segment(path)
    assert len(result) == NUM_FRAMES
    assert result.times is not None and result.objects
    report = json.loads(json.dumps(result.as_json()))
    assert report["times"] == result.times.tolist() and len(report["durations"]) == NUM_FRAMES
    assert report["frameRate"] == pytest.approx(NUM_FRAMES / (result.times[-1] + result.durations[-1]))
    heading, *rows = result.session.object_table(result.times.tolist()).splitlines()
    assert heading.startswith("frame,time,object,")
    assert {row.split(",")[1] for row in rows} <= {f"{t / 10:g}" for t in range(NUM_FRAMES)} and rows
    with pytest.raises(tracecut.TraceCutError, match="times has 1 entries"):
        result.session.object_table([0.0])
    coco = json.loads((interchange.to_coco(result, tmp_path / "coco") / "labels.json").read_text())
    assert [image["timestamp"] for image in coco["images"]] == result.times.tolist()
    without = tracecut.segment(frames).as_json()
    assert "times" not in without and without["frames"] == report["frames"]


def test_the_default_track_is_read_or_the_largest_that_moves(frames: list[np.ndarray], tmp_path: Path) -> None:
    small = [frame[::2, ::2] for frame in frames]
    path = tmp_path / "tracks.mkv"
    assert read(write_video(path, [small, frames], default=1)).shape[1:3] == (HEIGHT, WIDTH)
    assert read(write_video(path, [small, frames], default=0)).shape[1:3] == (HEIGHT // 2, WIDTH // 2)
    poster = np.zeros((4 * HEIGHT, 4 * WIDTH, 3), np.uint8)
    assert len(read(write_video(path, [[poster], frames], "mjpeg", default=0))) == NUM_FRAMES
    assert len(read(write_video(path, [[poster]], "mjpeg"))) == 1


def test_the_format_of_a_file_is_found_by_its_content(frames: list[np.ndarray], tmp_path: Path) -> None:
    durations = [40, 120] * 4
    gif = write_animation(tmp_path / "a.gif", frames, durations).rename(tmp_path / "a.mp4")
    reader = tracecut.read_video(gif)
    assert len(list(reader)) == NUM_FRAMES
    assert np.allclose(reader.durations, [0.04, 0.12] * 4)
    png = write_animation(tmp_path / "a.png", frames, durations).rename(tmp_path / "animated")
    assert np.array_equal(read(png), np.stack(frames))
    video = write_video(tmp_path / "b.mp4", [frames]).rename(tmp_path / "no-ending-%d")
    assert_alike(read(video), frames)
    assert_alike(read(io.BytesIO(video.read_bytes())), frames)


@pytest.mark.parametrize(
    ("name", "data", "code", "message"),
    [
        ("a.mp4", b"", "no-video", "is empty"),
        ("a.mp4", b"these are only words\n" * 9, "no-video", "is not a video (expected"),
        ("a.mp4", b"\0\0\0\x18ftypmp42\0\0\0\0mp42isom", "truncated", "is cut off: the index, which MP4"),
        ("a.mkv", b"\x1aE\xdf\xa3\x01", "truncated", "is cut off or damaged before the first frame"),
    ],
)
def test_files_that_are_no_video_are_refused(name: str, data: bytes, code: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes(data)
    for source in (path, io.BytesIO(data)):
        with fails(code) as caught:
            tracecut.segment(tracecut.read_video(source))
        assert message in str(caught.value)
    assert str(caught.value).startswith("video: ") and caught.value.result is None


def test_sound_and_unknown_codecs_are_refused(frames: list[np.ndarray], tmp_path: Path) -> None:
    with av.open(str(tmp_path / "sound.m4a"), "w") as out:
        stream = out.add_stream("aac", rate=8000)
        sound = av.AudioFrame.from_ndarray(np.zeros((1, 1024), np.float32), format="fltp", layout="mono")
        sound.sample_rate = 8000
        out.mux(stream.encode(sound))
        out.mux(stream.encode(None))
    with fails("no-video", "has no video track"):
        tracecut.segment(tmp_path / "sound.m4a")
    path = write_video(tmp_path / "a.mp4", [frames])
    path.write_bytes(path.read_bytes().replace(b"avc1", b"zzz1").replace(b"avcC", b"zzzC"))
    with fails("codec", "its codec cannot be decoded by PyAV"):
        tracecut.segment(path)


def test_an_animated_webp_is_read_or_refused_as_such(frames: list[np.ndarray], tmp_path: Path) -> None:
    if not features.check("webp"):
        pytest.skip("Pillow cannot write WebP here")
    path = write_animation(tmp_path / "a.webp", frames)
    try:
        assert len(tracecut.segment(path)) == NUM_FRAMES
    except tracecut.TraceCutError as error:
        assert error.code == "unsupported" and "is an animated WebP" in str(error)


def test_an_animated_avif_has_its_pictures_and_not_its_cover(frames: list[np.ndarray], tmp_path: Path) -> None:
    if not features.check("avif"):
        pytest.skip("Pillow cannot write AVIF here")
    transparent = [np.dstack([frame, np.full_like(frame[..., 0], 128)]) for frame in frames]
    options = {"quality": 95, "subsampling": "4:4:4"}
    reader = tracecut.read_video(write_animation(tmp_path / "a.avif", transparent, [40, 120] * 4, **options))
    assert_alike(np.stack(list(reader)), frames)
    assert np.allclose(reader.durations, [0.04, 0.12] * 4)


@pytest.mark.parametrize(
    ("name", "codec", "container", "windows"),
    [
        ("a.mp4", "libx264", {"movflags": "faststart"}, [50]),
        ("a.mkv", "libx264", {}, [50]),
        ("a.mkv", "ffv1", {}, [50, 3, None]),
    ],
)
def test_frames_before_damage_are_kept(
    name: str,
    codec: str,
    container: dict[str, str],
    windows: list[int | None],
    frames: list[np.ndarray],
    tmp_path: Path,
) -> None:
    whole = write_video(tmp_path / f"whole-{name}", [frames], codec, container=container)
    path = truncate(Path(shutil.copy(whole, tmp_path / name)))
    reader, good = tracecut.read_video(path), []
    with fails("truncated", r"is cut off or damaged at frame \d") as caught:
        good += reader
    assert caught.value.frames == len(good)
    assert 2 <= len(good) < NUM_FRAMES and np.array_equal(np.stack(good), read(whole)[: len(good)])
    expected = tracecut.segment(good).array()
    for window in windows:
        with fails("truncated") as caught:
            tracecut.segment(path, window=window)
        assert caught.value.frames == len(good)
        result = caught.value.result
        assert result is not None and len(result) == len(good)
        assert result.times is not None and np.array_equal(result.times, reader.times)
        assert window == 3 or np.array_equal(result.array(), expected)
    settled: list[int] = []
    with pytest.raises(tracecut.TraceCutError, match="is cut off"):
        for part in tracecut.windows(path, window=3, overlap=1):
            settled += part.settled
    assert settled == list(range(len(good)))


def test_damage_in_the_middle_ends_a_clip_there(frames: list[np.ndarray], tmp_path: Path) -> None:
    path = write_video(tmp_path / "a.mp4", [frames], container={"movflags": "faststart"}, g="1", bf="0")
    with av.open(str(path)) as container:
        places = [(packet.pos, packet.size) for packet in container.demux(video=0) if packet.size]
    data = bytearray(path.read_bytes())
    start, size = places[5]
    data[start : start + size // 2] = b"\x55" * (size // 2)
    path.write_bytes(data)
    with pytest.raises(tracecut.TraceCutError) as caught:
        tracecut.segment(path)
    assert (caught.value.code, caught.value.frames) == ("truncated", 5)
    for count in (0, 1):
        path.write_bytes(data[: places[count][0] + 20])
        with pytest.raises(tracecut.TraceCutError, match="is cut off or damaged") as caught:
            tracecut.segment(path)
        assert (caught.value.code, caught.value.frames, caught.value.result) == ("truncated", count, None)


def test_a_recording_may_begin_between_two_key_frames(frames: list[np.ndarray], tmp_path: Path) -> None:
    path = write_video(tmp_path / "a.ts", [frames])
    with av.open(str(path)) as container:
        places = [packet.pos for packet in container.demux(video=0) if packet.size]
    path.write_bytes(path.read_bytes()[places[1] :])
    assert_alike(read(path), frames[4:])


def test_damage_at_the_beginning_drops_frames_to_the_next_key(frames: list[np.ndarray], tmp_path: Path) -> None:
    path = write_video(tmp_path / "a.mp4", [frames], container={"movflags": "faststart"}, bf="0")
    with av.open(str(path)) as container:
        start, size = next((packet.pos, packet.size) for packet in container.demux(video=0))
    data = bytearray(path.read_bytes())
    data[start + size // 2 : start + size // 2 + 40] = bytes((i * 37 + 11) & 255 for i in range(40))
    path.write_bytes(data)
    assert_alike(read(path), frames[4:])


@pytest.mark.parametrize("kind", ["gif", "png"])
def test_an_animation_with_a_broken_first_picture_fails(kind: str, frames: list[np.ndarray], tmp_path: Path) -> None:
    path = write_animation(tmp_path / f"a.{kind}", frames)
    with av.open(str(path)) as container:
        size = next(packet.size for packet in container.demux(video=0))
    data = bytearray(path.read_bytes())
    # Behind the palette of 768 bytes that a GIF may have.
    data[900:size] = bytes((i * 37 + 11) & 255 for i in range(size - 900))
    with pytest.raises(tracecut.TraceCutError) as caught:
        list(tracecut.read_video(io.BytesIO(data)))
    assert caught.value.code in ("truncated", "codec") and not caught.value.frames


def test_a_pickled_error_has_its_result(frames: list[np.ndarray], tmp_path: Path) -> None:
    path = truncate(write_video(tmp_path / "a.mkv", [frames]))
    with pytest.raises(tracecut.TraceCutError) as caught:
        tracecut.segment(path)
    copy = pickle.loads(pickle.dumps(caught.value))
    assert (copy.code, copy.frames) == ("truncated", caught.value.frames)
    assert np.array_equal(copy.result.array(), caught.value.result.array())
    assert str(copy) == str(caught.value)


def test_readers_in_threads_do_not_report_damage_of_each_other(frames: list[np.ndarray], tmp_path: Path) -> None:
    whole = write_video(tmp_path / "whole.mkv", [frames], "ffv1")
    damaged = truncate(Path(shutil.copy(whole, tmp_path / "damaged.mkv")))
    before = (av.logging.get_level(), av.logging.get_skip_repeated())
    outcomes: dict[int, list[str]] = {}

    def work(number: int) -> None:
        outcomes[number] = []
        for _ in range(8):
            try:
                list(tracecut.read_video(damaged if number % 2 else whole))
                outcomes[number].append("whole")
            except tracecut.TraceCutError as error:
                outcomes[number].append(error.code)

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert outcomes == {number: [("whole", "truncated")[number % 2]] * 8 for number in range(4)}
    assert (av.logging.get_level(), av.logging.get_skip_repeated()) == before


@pytest.fixture(scope="module")
def ffmpeg() -> str:
    found = shutil.which("ffmpeg")
    if not found:
        pytest.skip("there is no ffmpeg")
    return found


FORMS = {
    "bt709": "scale=out_color_matrix=bt709:out_range=tv,format=yuv420p -c:v libx264 -qp 0 -colorspace bt709 -color_range tv",
    "bt601": "format=yuv420p -c:v libx264 -qp 0",
    "full range": "scale=out_range=pc,format=yuvj420p -c:v mjpeg -q:v 2",
    "ten bits": "scale=out_color_matrix=bt2020,format=yuv422p10le -c:v ffv1 -colorspace bt2020nc -color_range tv",
    "odd size and other pixels": "crop=95:63,setsar=4/3,format=yuv444p -c:v ffv1",
    "alpha": "format=rgba,colorchannelmixer=aa=.5,format=yuva420p -c:v ffv1",
}


@pytest.mark.parametrize("form", FORMS)
def test_pixels_match_those_of_ffmpeg(
    form: str, ffmpeg: str, frames: list[np.ndarray], tmp_path: Path
) -> None:
    source = write_video(tmp_path / "source.mkv", [frames[:3]], "ffv1")
    path = tmp_path / "a.mkv"
    quiet = [ffmpeg, "-nostdin", "-v", "error", "-i"]
    subprocess.run([*quiet, source, "-vf", *FORMS[form].split(), path], check=True)
    command = [*quiet, path, "-fps_mode", "passthrough", "-vf", SCALE, "-f", "rawvideo", "-"]
    expected = subprocess.run(command, check=True, capture_output=True).stdout
    assert read(path).tobytes() == expected


def test_masks_of_a_video_match_the_command_line(cli: str, ffmpeg: str, tmp_path: Path) -> None:
    clip = list(tracecut.synth.Scene("sample", 160, 90, 12, seed=1))
    path = write_video(tmp_path / "a.mkv", [clip], "ffv1", times_ms=[40 * t + 200 * (t > 5) for t in range(12)])
    video = tmp_path / "b.mp4"
    filters, *options = FORMS["bt709"].split()
    subprocess.run([ffmpeg, "-v", "error", "-i", path, "-vf", filters, *options, "-crf", "20", video], check=True)
    done = subprocess.run([cli, "segment", video, "--out", tmp_path / "out", "--format", "npz"], capture_output=True)
    assert done.returncode == 0, done.stderr
    expected, result = np.load(tmp_path / "out" / "masks.npz"), tracecut.segment(video)
    assert np.array_equal(result.array(), expected["masks"]) and result.objects
    assert np.array_equal(np.asarray(result.times), expected["times"])
    assert np.allclose(np.asarray(result.durations), expected["durations"], rtol=0, atol=1e-9)
