"""The session, stage by stage."""

from __future__ import annotations

import pickle
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from typing import Any, Optional, get_args

import numpy as np
import pytest
import tracecut
from conftest import fails
from tracecut import Session, Stroke, TraceCutError, Trajectories
from tracecut._types import Stage

STAGES = list(get_args(Stage))


def fresh(clip: list[np.ndarray], **params: object) -> Session:
    session = Session(**params)
    session.push_all(clip)
    return session


def all_masks(session: Session) -> np.ndarray:
    return np.stack([session.labels(t) for t in range(session.num_frames)])


def check_missing(*results: Callable[[], object]) -> None:
    """Asserts that these results are missing, with an error that names their stage."""
    for result in results:
        with fails("state", "not available: they come with the stage"):
            result()


def test_results_can_be_read_as_soon_as_their_stage_is_done(clip: list[np.ndarray], done: Session) -> None:
    session = fresh(clip)
    check_missing(session.trajectories, session.clusters, session.objects, session.agreement)
    seen: dict[str, int] = {}
    for progress in session.steps():
        seen[progress.stage] = progress.done
        assert 1 <= progress.done <= progress.total
        if progress.stage == "affinities":
            assert len(session.trajectories()) > 0
            check_missing(session.embedding)
        if progress.stage == "superpixels":
            assert session.clusters().count > 0
    assert list(seen) == STAGES
    assert np.array_equal(all_masks(session), all_masks(done))


def test_trajectories_affinities_and_embedding_fit_together(done: Session) -> None:
    tracks, affinities, embedding = done.trajectories(), done.affinities(), done.embedding()
    count = len(tracks)
    assert tracks.offset[-1] == len(tracks.x) == len(tracks.y) and len(tracks.id) == count
    assert (tracks.num_frames, tracks.width, tracks.height) == (8, 96, 64)
    first = int(tracks.alive(3)[0])
    assert np.array_equal(tracks.at(3)[0], tracks.points(first)[3 - tracks.start_frame[first]])
    assert len(affinities.offset) == count + 1 and affinities.offset[-1] == len(affinities.value)
    assert embedding.vectors.shape == (count, len(embedding.eigenvalues)) and embedding.converged
    assert np.all(np.diff(embedding.eigenvalues) <= 0) and embedding.eigenvalues[0] <= 1 + 1e-9
    dense = np.zeros((count, count))
    rows = np.repeat(np.arange(count), np.diff(affinities.offset.astype(int)))
    dense[rows, affinities.column] = affinities.value
    assert np.array_equal(dense, dense.T)


def test_discontinuities_saliency_components_and_clusters(done: Session) -> None:
    tracks, edges, saliency = done.trajectories(), done.discontinuities(), done.saliency()
    components, clusters, pieces = done.components(), done.clusters(), done.threshold_clusters()
    assert edges.pair.shape == (len(edges.d), 2) and edges.pair.max() < len(tracks)
    assert len(edges.frame_offset) == 9 and edges.frame_offset[-1] == len(edges.frame_edge)
    assert 0 <= edges.d.min() and edges.d.max() <= 1
    assert len(saliency.of_points) == len(saliency.in_context) == len(saliency.foreground) == len(tracks)
    assert saliency.foreground.dtype == bool and saliency.foreground.any() and not saliency.foreground.all()
    assert len(components.count) == 8 and components.of_point.min() >= -1
    assert len(clusters.label) == len(pieces.label) == len(tracks) and clusters.label.max() == clusters.count - 1


def test_maps_of_frames(done: Session, clip: list[np.ndarray]) -> None:
    labels, clusters, objects = done.labels(2), done.cluster_labels(2), done.objects()
    assert np.array_equal(objects[clusters], labels)
    assert labels.dtype == np.uint8 and labels.shape == (64, 96)
    flow = done.flow(0)
    assert flow.u.shape == flow.v.shape == (64, 96) and flow.u.dtype == np.float32
    assert done.saliency_map(7).shape == (64, 96)
    agreement = done.agreement()
    assert agreement[0].shape == (8,) and len(agreement[1]) == objects.max()
    assert 0 <= agreement[0].min() <= agreement[0].max() <= 1
    assert all(isinstance(doubt, range) and 0 <= doubt.start < doubt.stop <= 8 for doubt in done.doubts())
    plate = done.background(1)
    assert plate.shape == (64, 96, 4) and (plate[..., :3] == clip[1])[done.labels(1) == 0].mean() > 0.8
    assert (plate[..., :3] == clip[1])[done.labels(1) == 1].mean() < 0.5
    cells = done.superpixels(0)
    assert cells.label.max() == cells.count - 1 and len(cells.edge) == len(cells.edge_kind)
    assert cells.border_pair.shape == (len(cells.border_pb), 2)
    boundaries = tracecut.boundaries(clip[0])
    assert np.array_equal(done.boundaries(0).pb, boundaries.pb)
    assert np.array_equal(done.boundaries(0).thin, boundaries.thin)


def test_the_table_of_objects_has_their_areas(done: Session) -> None:
    heading, *rows = done.object_table().splitlines()
    frame, label, area = (heading.split(",").index(name) for name in ("frame", "object", "area"))
    cells = [row.split(",") for row in rows]
    areas = {(int(row[frame]), int(row[label])): int(row[area]) for row in cells}
    expected = {(t, int(v)): int((done.labels(t) == v).sum()) for t in range(8) for v in np.unique(done.labels(t)) if v}
    assert areas == expected


def test_changing_a_returned_array_does_not_change_the_session(clip: list[np.ndarray]) -> None:
    session = fresh(clip)
    session.run()
    tracks, mask = session.trajectories(), session.labels(0)
    x, kept = tracks.x.copy(), mask.copy()
    tracks.x[:] = -1
    mask[:] = 77
    later = session.trajectories()
    assert np.array_equal(later.x, x) and np.array_equal(session.labels(0), kept)
    again = session.labels(0)
    session.clear()
    assert np.array_equal(again, kept) and session.num_frames == 0
    check_missing(session.trajectories)


def test_trajectories_are_written_read_and_set(clip: list[np.ndarray], done: Session, tmp_path) -> None:
    tracks, clusters = done.trajectories(), done.clusters()
    alone = Session()
    alone.set_trajectories(tracks)
    alone.run()
    assert len(alone.clusters().label) == len(tracks)
    check_missing(alone.objects, alone.saliency, alone.agreement)
    with_frames = tracecut.segment(clip, trajectories=tracks)
    assert with_frames.array().shape == (8, 64, 96)
    tracecut.write_tracks(tmp_path / "tracks.dat", tracks, clusters.label)
    read, label = tracecut.read_tracks(tmp_path / "tracks.dat", (96, 64))
    assert np.array_equal(label, clusters.label) and np.array_equal(read.offset, tracks.offset)
    assert np.abs(read.x - tracks.x).max() <= 0.0006 and (read.width, read.num_frames) == (96, 8)


def test_inconsistent_trajectories_are_refused(clip: list[np.ndarray]) -> None:
    xy = np.zeros(4, np.float32)
    offset, start = np.array([0, 4], np.uint32), np.zeros(1, np.uint32)
    session = Session()
    for tracks in (
        Trajectories(4, 96, 64, start, np.array([0, 3], np.uint32), xy, xy),
        Trajectories(4, 96, 64, start, offset, xy, np.full(4, np.nan, np.float32)),
    ):
        with fails("data"):
            session.set_trajectories(tracks)
    with pytest.raises(TraceCutError, match="trajectories of 4 frames .expected 8"):
        tracecut.segment(clip, trajectories=Trajectories(4, 96, 64, start, offset, xy, xy))


def test_corrections_change_the_masks_and_are_undone(clip: list[np.ndarray]) -> None:
    session = fresh(clip)
    session.run()
    first = all_masks(session)
    session.split(1)
    session.run()
    before = all_masks(session)
    assert np.array_equal(before > 0, first > 0) and before.max() == 2
    session.merge(1, 2)
    assert np.array_equal(all_masks(session), np.where(before == 2, 1, before)) and session.num_corrections == 2
    session.undo_correction()
    assert np.array_equal(all_masks(session), before)
    session.merge(into=0, from_=1)
    assert not (all_masks(session) == 1).any()
    session.undo_correction()
    y, x = (int(v) for v in np.argwhere(before[0] == 1).mean(axis=0))
    session.together([Stroke(0, [(x, y), (x + 3, y)], 2)])
    session.run()
    session.apart([Stroke(0, [(x, y)], 2), Stroke(0, np.array([[2.0, 2.0]]), 2)])
    session.run()
    assert session.num_corrections == 3 and session.labels(0)[y, x] != session.labels(0)[2, 2]
    for _ in range(3):
        session.undo_correction()
    assert np.array_equal(all_masks(session), first)


def test_the_correction_of_a_window_applies_to_the_next_one() -> None:
    clip = list(tracecut.synth.Scene("sample", 128, 72, 12, seed=1))

    def run(correct: Callable[[tracecut.SessionView], object]) -> list[np.ndarray]:
        masks: list[np.ndarray] = []
        for window in tracecut.windows(clip, window=8, overlap=4):
            if window.index == 0:
                correct(window.session)
            masks += [window.labels(t) for t in window.settled]
        return masks

    def rename(session: tracecut.SessionView) -> None:
        before = all_masks(session)
        assert before.max() == 2
        steps: list[str] = []
        session.split(1)
        assert session.num_corrections == 1
        session.run(threads=2, progress=lambda p: steps.append(p.stage))
        after = all_masks(session)
        assert "cut" in steps and np.array_equal(after > 0, before > 0) and after.max() == 3
        session.merge(3, 1)
        assert np.array_equal(all_masks(session), np.where(after == 1, 3, after))
        session.undo_correction()
        session.undo_correction()
        assert np.array_equal(all_masks(session), before) and session.num_corrections == 0
        session.split(1)
        session.run()
        session.merge(3, 1)

    plain, renamed = run(lambda _: None), run(rename)
    # The second window takes the label that the correction gave.
    assert np.array_equal(renamed[-1], np.where(plain[-1] == 1, 3, plain[-1])) and (plain[-1] == 1).any()


def test_an_earlier_window_cannot_be_corrected() -> None:
    clip = tracecut.synth.Scene("sample", 96, 64, 12, seed=3)
    parts = tracecut.windows(clip, window=8, overlap=4, preset="fast")
    first = next(parts)
    with pytest.raises(TraceCutError, match="there is no correction to undo"):
        first.session.undo_correction()
    last = next(parts)
    for correct in (lambda s: s.split(1), lambda s: s.run(), lambda s: s.undo_correction()):
        with fails("state", "the next window was asked for"):
            correct(first.session)
    assert next(parts, None) is None
    last.session.merge(0, 1)
    assert not last.labels(11).any()


def test_an_explanation_has_the_costs_of_the_cut(done: Session) -> None:
    label, cells = done.labels(2), done.superpixels(2).label
    clusters, objects, affinities = done.clusters(), done.objects(), done.affinities()
    sources = set()
    for y in range(1, 64, 9):
        for x in range(2, 96, 9):
            why = done.explain(2, x, y)
            sources.add(why.source)
            assert why.label == label[y, x] and why.superpixel == cells[y, x]
            assert [c.cluster for c in why.costs] == list(range(clusters.count))
            assert [c.label for c in why.costs] == objects.tolist()
            assert all(c.total == sum(c[3:7]) for c in why.costs)
            links = [sum(link.cost for link in why.links if link.cluster != c.cluster) for c in why.costs]
            assert [c.links for c in why.costs] == links
            assert sum(c.votes for c in why.costs) == sum(v.cluster >= 0 for v in why.voters)
            assert all(cells[round(v.y), round(v.x)] == why.superpixel for v in why.voters)
            assert why.nearest is not None
            row = slice(int(affinities.offset[why.nearest]), int(affinities.offset[why.nearest + 1]))
            known = dict(zip(affinities.column[row].tolist(), affinities.value[row].tolist()))
            known.pop(why.nearest, None)
            assert why.affinities and all(known[to] == value for to, value in why.affinities)
            assert max(known.values()) == why.affinities[0][1]
            # The cut chose: no cluster of another label is cheaper.
            assert why.flip is not None and why.flip.margin >= 0
            totals = [c.total for c in why.costs]
            assert totals[why.flip.cluster] - totals[why.cluster] == why.flip.margin
    assert "superpixel" in sources


def test_an_explanation_has_strokes_and_borders_between_objects(clip: list[np.ndarray]) -> None:
    session = fresh(clip)
    session.run()
    y, x = (int(v) for v in np.argwhere(session.labels(0) == 1).mean(axis=0))
    inside = (x, y)
    session.apart([Stroke(0, [inside], 2), Stroke(0, [(2, 2)], 2)])
    session.run()
    assert session.explain(0, 2, 2).source == "stroke"
    tracks = session.trajectories()
    border = session.explain(0, *inside).border
    assert border is not None and border.edges > 0 and 0 <= border.mean <= border.d <= 1
    assert {border.i, border.j} <= set(tracks.alive(0).tolist())


def test_other_discretizations_can_be_compared(done: Session, clip: list[np.ndarray]) -> None:
    clusters = done.clusters()
    for method in ("rotation-merge", "rotation", "k-means"):
        found = done.clusters_by(method, 2)
        assert len(found.label) == len(clusters.label)
        assert found.count == found.label.max() + 1 <= 2
    with pytest.raises(TraceCutError, match=r"method = \"best\" \(expected one of rotation-merge, rotation, k-means"):
        done.clusters_by("best", 2)
    with pytest.raises(TraceCutError, match=r"count = 99 \(expected a whole number, 1\.\.="):
        done.clusters_by("k-means", 99)
    by_motion = done.motion_clusters()
    without = fresh(clip, connectedness={"mode": "off"})
    without.run()
    expected = without.clusters()
    assert np.array_equal(by_motion.label, expected.label)
    unknown = fresh(clip)
    check_missing(lambda: unknown.clusters_by("rotation", 2), unknown.motion_clusters)


@pytest.mark.parametrize(
    ("correct", "code"),
    [
        (lambda s: s.merge(1, 99), "param"),
        (lambda s: s.merge(1, 300), "param"),
        (lambda s: s.split(0), "param"),
        (lambda s: s.together([]), "param"),
        (lambda s: s.apart([Stroke(99, [(0, 0)])]), "param"),
        (lambda s: s.apart([Stroke(-9, [(0, 0)])]), "param"),
        (lambda s: s.undo_correction(), "state"),
        (lambda s: s.explain(0, 96, 0), "param"),
        (lambda s: s.explain(0, 0, -1), "param"),
        (lambda s: s.explain(8, 0, 0), "param"),
        (lambda s: s.background(2**64 - 1), "param"),
        (lambda s: s.labels(8), "param"),
        (lambda s: s.flow(7), "state"),
        (lambda s: s.push(np.zeros((64, 96), np.uint8)), "state"),
    ],
)
def test_refused_calls_change_nothing(done: Session, correct, code: str) -> None:
    before = all_masks(done)
    with fails(code):
        correct(done)
    assert np.array_equal(all_masks(done), before)


def test_a_panic_of_the_library_is_raised_as_an_exception() -> None:
    with pytest.raises(BaseException, match="on purpose") as caught:
        tracecut._tracecut.panic_on_purpose()
    assert type(caught.value).__name__ == "PanicException" and not isinstance(caught.value, Exception)


def test_an_error_can_be_pickled() -> None:
    error = pickle.loads(pickle.dumps(TraceCutError("param", "flow.x = 1 (expected more)")))
    assert (error.code, str(error)) == ("param", "flow.x = 1 (expected more)")


@pytest.mark.parametrize("threads", [1, 2])
def test_a_callback_is_called_for_each_step_and_may_raise(clip: list[np.ndarray], done: Session, threads: int) -> None:
    class Enough(Exception):
        pass

    seen_progress: list[tracecut.Progress] = []

    def listen(progress: tracecut.Progress) -> None:
        seen_progress.append(progress)
        if len(seen_progress) == 10:
            raise Enough

    session = fresh(clip)
    with pytest.raises(Enough):
        session.run(threads=threads, progress=listen)
    assert len(seen_progress) == 10
    session.run(threads=threads, progress=listen)
    assert {p.stage for p in seen_progress} == set(STAGES)
    assert np.array_equal(all_masks(session), all_masks(done))


def test_windows_end_where_a_callback_raises(clip: list[np.ndarray]) -> None:
    def listen(progress: tracecut.Progress) -> None:
        raise KeyError(progress.stage)

    parts = tracecut.windows(clip, progress=listen)
    with pytest.raises(KeyError, match="flow"):
        next(parts)
    assert next(parts, None) is None


def test_results_cannot_be_read_during_a_run(clip: list[np.ndarray]) -> None:
    session = fresh(clip)
    seen_progress: list[str] = []

    def listen(_: tracecut.Progress) -> None:
        with pytest.raises(TraceCutError, match="the session is at work") as caught:
            session.labels(0)
        seen_progress.append(caught.value.code)

    session.run(progress=listen)
    assert set(seen_progress) == {"state"}


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Makes SIGINT raise `KeyboardInterrupt`, also in a process that a shell has started in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
def test_an_interrupted_run_continues(done: Session, clip: list[np.ndarray]) -> None:
    session = fresh(clip)
    steps = 0

    def listen(_: tracecut.Progress) -> None:
        nonlocal steps
        steps += 1
        if steps == 5:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        session.run(progress=listen)
    # The signal arrives while Python runs or at the next step, and no later.
    assert steps <= 6
    session.run()
    assert np.array_equal(all_masks(session), all_masks(done))


def act_during(call: Callable[[], object], act: Callable[[], object]) -> None:
    """Calls `act` in another thread as soon as `call` gives the interpreter's lock away."""
    begun = threading.Event()
    thread = threading.Thread(target=lambda: begun.wait() and act())
    thread.start()
    interval = sys.getswitchinterval()
    # The other thread gets the lock only where this one gives it away.
    sys.setswitchinterval(1000)
    try:
        begun.set()
        call()
    finally:
        sys.setswitchinterval(interval)
        thread.join()


@pytest.mark.usefixtures("interruptible")
def test_a_signal_from_another_thread_ends_a_run_without_a_callback(clip: list[np.ndarray]) -> None:
    session = fresh(clip)
    with pytest.raises(KeyboardInterrupt):
        act_during(session.run, lambda: signal.raise_signal(signal.SIGINT))
    check_missing(session.objects)
    assert session.step() is not None


def test_other_threads_run_while_a_session_computes(clip: list[np.ndarray]) -> None:
    session = fresh(clip)
    events: list[str] = []

    def run() -> None:
        session.run()
        events.append("end")

    act_during(run, lambda: events.append("other thread"))
    assert events == ["other thread", "end"]


def test_other_threads_run_while_an_image_is_processed(clip: list[np.ndarray]) -> None:
    answered = threading.Event()

    def process() -> None:
        for _ in range(50):
            if not answered.is_set():
                tracecut.superpixels(clip[0])
        assert answered.is_set()

    act_during(process, answered.set)


@pytest.fixture
def bars(monkeypatch: pytest.MonkeyPatch) -> list[list[tuple[int, Optional[int]]]]:
    """The states of each bar of tqdm: after each change, the frames done and the total."""
    tqdm = pytest.importorskip("tqdm.auto")
    shown: list[list[tuple[int, Optional[int]]]] = []

    class Recorded(tqdm.tqdm):
        def __init__(self, *args: Any, **options: Any) -> None:
            super().__init__(*args, **options)
            self.shown: list[tuple[int, Optional[int]]] = []
            shown.append(self.shown)

        def update(self, n: float = 1) -> Optional[bool]:
            outcome = super().update(n)
            self.shown.append((self.n, self.total))
            return outcome

    monkeypatch.setattr(tqdm, "tqdm", Recorded)
    return shown


def check_bar(bars: list[list[tuple[int, Optional[int]]]], total: int) -> None:
    """Asserts that one bar was shown and rose to its total."""
    (shown,) = bars
    done = [frames for frames, _ in shown]
    assert done == sorted(set(done)) and shown[-1] == (total, total)
    assert all(of in (None, total) for _, of in shown)
    bars.clear()


def test_a_run_has_one_bar_that_ends_at_the_number_of_frames(bars: list[Any]) -> None:
    clip = list(tracecut.synth.Scene("sample", 96, 64, 12, seed=3))
    for frames, options in (
        (clip, {"window": None}),
        (clip, {"window": 5, "overlap": 1}),
        (iter(clip), {}),
        (iter(clip), {"window": 6, "overlap": 4}),
    ):
        tracecut.segment(frames, progress=True, preset="fast", **options)
        num_changes = len(bars[0])
        check_bar(bars, 12)
        assert num_changes > 5, "the bar moves within windows"


def test_a_bar_counts_the_frames_of_all_shots(bars: list[Any]) -> None:
    frames = [*tracecut.synth.Scene("sample", 96, 64, 6, seed=1), *tracecut.synth.Scene("sample", 96, 64, 6, seed=7)]
    for options in ({"window": 50}, {"window": 4, "overlap": 1}):
        assert tracecut.segment(frames, progress=True, preset="fast", **options).shots == [0, 6]
        check_bar(bars, 12)


def test_the_bar_of_a_correction_and_of_windows(bars: list[Any], clip: list[np.ndarray]) -> None:
    for window in tracecut.windows(clip, window=6, overlap=2, progress=True, preset="fast"):
        assert window.settled
    check_bar(bars, 8)
    session = fresh(clip)
    session.run(progress=True)
    check_bar(bars, 8)
    session.split(1)
    session.run(progress=True)
    check_bar(bars, 8)
    with pytest.raises(TraceCutError):
        tracecut.segment([clip[0], clip[1], clip[2][:-1]], progress=True)
