// segmentVideo over frames one by one: windows, order, back pressure, halts, ends of all kinds.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  Result,
  segmentVideo,
  synthClip,
  videoFrames,
  videoInfo,
  VideoResult,
  VideoSegmentation,
  WindowResult,
} from 'tracecut';
import { trajectories } from 'tracecut/stages';
import { abortAt, each, endless, framesOf, plain, png, rejects, resultOf, STAGES } from './support.mjs';

/** Windows that are run in a moment. */
const TINY = { width: 48, height: 36, frames: 14, seed: 3 };
/** Large enough for objects to be found. */
const MOVING = { width: 112, height: 63 };

const WINDOWS = { window: 6, overlap: 2, threads: 1 };

async function windowsOf(source, options) {
  const windows = [];
  for await (const window of segmentVideo(source, { threads: 1, ...options })) windows.push(window);
  return windows;
}

const settledFrames = (windows) => windows.flatMap((window) => [...window.frames()]);
const numbers = (count) => Array.from({ length: count }, (_, k) => k);

test('a list of frames comes out window by window, each frame once and in order, with its time', async () => {
  const windows = await windowsOf(await framesOf(TINY), { ...WINDOWS, frameRate: 10 });
  assert.deepEqual(
    windows.map(({ index, shot, firstFrame, numFrames, settled }) => ({ index, shot, firstFrame, numFrames, settled })),
    [
      { index: 0, shot: 0, firstFrame: 0, numFrames: 6, settled: { from: 0, to: 5 } },
      { index: 1, shot: 0, firstFrame: 4, numFrames: 6, settled: { from: 1, to: 5 } },
      { index: 2, shot: 0, firstFrame: 8, numFrames: 6, settled: { from: 1, to: 6 } },
    ],
  );
  const frames = settledFrames(windows);
  assert.deepEqual(each(frames, 'index'), numbers(14));
  const times = numbers(14).map((k) => k / 10);
  assert.deepEqual(each(frames, 'time'), times);
  for (const window of windows) {
    assert.ok(window instanceof WindowResult && window instanceof Result);
    assert.ok(window.times instanceof Float64Array && window.times.length === window.numFrames);
    assert.ok(window.memoryBytes > 0);
    for (const { t, labels } of window.frames()) assert.deepEqual(labels, window.labels(t));
  }
});

test('several clips in one stream, of several sizes, are each what they are alone', async () => {
  const clips = { a: TINY, b: { width: 60, height: 36, frames: 8, seed: 1 }, c: { ...TINY, frames: 3, seed: 9 } };
  async function* stream() {
    for (const [clip, scene] of Object.entries(clips)) for (const frame of await framesOf(scene)) yield { frame, clip };
  }
  const windows = await windowsOf(stream(), { ...WINDOWS, frameRate: 10 });
  const plainOf = ({ index: _, clip: __, memoryBytes: ___, ...window }) => structuredClone(window);
  for (const [clip, scene] of Object.entries(clips)) {
    async function* clipFrames() {
      yield* await framesOf(scene);
    }
    const separate = await windowsOf(clipFrames(), { ...WINDOWS, frameRate: 10 });
    const mine = windows.filter((window) => window.clip === clip);
    assert.ok(separate.every((window) => window.clip === null));
    const [actual, expected] = [mine, separate].map((list) =>
      list.map((window) => ({ ...plainOf(window), seconds: 0 })),
    );
    assert.deepEqual(actual, expected, clip);
  }
  assert.equal(WindowResult.fromJSON(JSON.stringify(windows[3])).clip, 'b');
  await rejects(segmentVideo(stream(), WINDOWS).collect(), 'data', /clip = "b" \(expected a: .*iterate/);
  const [frame] = await framesOf(TINY);
  const wrong = ['a', 7].map((clip) => ({ frame, clip }));
  await rejects(windowsOf(wrong), 'data', /clip of frame 1 = 7 .*string/);
});

test('the selection of frames applies to each of several clips', async () => {
  const frames = await framesOf(TINY);
  const stream = ['a', 'b'].flatMap((clip) => frames.map((frame) => ({ frame, clip })));
  const windows = await windowsOf(stream, { start: 0.2, end: 0.9, step: 3, frameRate: 10 });
  const facts = windows.map(({ clip, times }) => `${clip} ${times.join(' ')}`);
  assert.deepEqual(facts, ['a 0.2 0.5 0.8', 'b 0.2 0.5 0.8']);
});

test('a clip of one window gives what a session gives', async () => {
  const frames = await framesOf();
  const expected = await resultOf();
  const [window] = await windowsOf(frames);
  assert.equal(window.numFrames, frames.length);
  for (let t = 0; t < frames.length; t += 1) assert.deepEqual(window.labels(t), expected.labels(t));
  assert.deepEqual(window.trajectories.x, expected.trajectories.x);
});

test('the session of the last window stays open, with its queries and corrections', async () => {
  const frames = await framesOf();
  const video = segmentVideo(frames, { keep: true });
  assert.equal(video.session, null);
  assert.throws(() => video.labels(0), { code: 'state' });
  /** @type {Uint8Array[]} */
  const early = [];
  const collected = await video.collect(() => void early.push(video.labels(0)));
  assert.deepEqual(early, [collected.labels(0)]);
  const session = video.session;
  const result = await session.run();
  for (let t = 0; t < frames.length; t += 1) assert.deepEqual(result.labels(t), collected.labels(t));
  assert.ok((await session.flow(0)).u.length > 0 && (await result.explain(2, 3, 3)).costs.length > 0);
  const { label } = result.objects[0];
  const without = await session.merge(0, label);
  assert.ok(!without.objects.some((object) => object.label === label));
  assert.deepEqual((await session.undo()).labels(3), collected.labels(3));
  session.close();

  const tracks = segmentVideo(frames, { keep: true, clip: { dense: false } });
  for await (const window of tracks) assert.deepEqual(window.objects, []);
  assert.ok((await tracks.session.run()).trajectories.count > 0);
  tracks.session.close();
  assert.deepEqual(VideoSegmentation.defaults, { window: 50, overlap: 10 });
});

test('frames come from lists, generators, streams and promises, as pixels, files, or with a time', async () => {
  const frames = (await framesOf(TINY)).slice(0, 3);
  const expected = settledFrames(await windowsOf(frames)).map(({ labels }) => labels);
  async function* generator() {
    for (const [k, frame] of frames.entries()) yield { frame, time: 5 + k / 2 };
  }
  const sources = {
    generator: generator(),
    stream: new ReadableStream({
      start: (controller) => (frames.forEach((frame) => controller.enqueue(frame)), controller.close()),
    }),
    files: frames.map((frame) => png(frame)),
    promises: frames.map(async (frame) => png(frame)),
    set: new Set(frames),
  };
  for (const [name, source] of Object.entries(sources)) {
    const outputs = settledFrames(await windowsOf(source));
    assert.deepEqual(each(outputs, 'labels'), expected, name);
    assert.deepEqual(each(outputs, 'time'), name === 'generator' ? [5, 5.5, 6] : [0, 0.04, 0.08], name);
  }
});

test('start, end, step, maxFrames and size choose and reduce the frames', async () => {
  const frames = await framesOf(TINY);
  const options = { frameRate: 10, start: 0.2, end: 1.2, step: 2, maxFrames: 4, size: 32 };
  const [window] = await windowsOf(frames, options);
  assert.deepEqual([window.width, window.height], [32, 24]);
  assert.deepEqual([...window.times], [0.2, 0.4, 0.6, 0.8]);
  const pngFiles = frames.map((frame) => png(frame));
  const [files] = await windowsOf(pngFiles, options);
  for (let t = 0; t < 4; t += 1) assert.deepEqual(files.labels(t), window.labels(t));
});

test('superpixels, boundaries and saliency maps are there for the last window, while one is in the loop', async () => {
  const windows = [];
  const sizes = [];
  for await (const window of segmentVideo(await framesOf(TINY), WINDOWS)) {
    windows.push(window);
    if (window.index < 2) await rejects(window.superpixels(0), 'state', /superpixels of this window are gone/);
    else
      sizes.push(
        (await window.superpixels(2)).label.length,
        (await window.boundaries(2)).pb.length,
        (await window.saliencyMap(2)).saliency.length,
      );
  }
  assert.deepEqual(sizes, [48 * 36, 48 * 36, 48 * 36]);
  for (const window of windows) await rejects(window.saliencyMap(0), 'state', /gone/);
});

test('progress reports decoding and every stage, window by window', async () => {
  const reports = [];
  await windowsOf(await framesOf(TINY), { ...WINDOWS, onProgress: (progress) => reports.push(progress) });
  for (const index of [0, 1, 2]) {
    const windowReports = reports.filter(({ window }) => window === index);
    assert.deepEqual(new Set(windowReports.map(({ stage }) => stage)), new Set(['decode', ...STAGES]));
    for (const { stage, done, total } of windowReports)
      assert.ok(done > 0 && done <= total, `${stage}: ${done} of ${total}`);
    const decoded = windowReports.filter(({ stage }) => stage === 'decode');
    assert.deepEqual([decoded.at(-1).done, decoded.at(-1).total], [6, 6]);
  }
  assert.ok(reports.every(({ frames }) => frames.total === 14));
  const counts = reports.map(({ frames }) => frames.done);
  const ascending = counts.toSorted((a, b) => a - b);
  assert.deepEqual(counts, ascending);
  assert.equal(counts.at(-1), 14);
});

/** Returns `onProgress` and `computed(window)`, which settles when the masks of that window are computed. */
function watchWindows() {
  const windows = new Map();
  const entry = (index) => {
    if (!windows.has(index)) {
      const created = {};
      created.promise = new Promise((resolve) => (created.resolve = resolve));
      windows.set(index, created);
    }
    return windows.get(index);
  };
  const onProgress = ({ stage, window, ...progress }) =>
    stage === 'masks' && progress.done === progress.total && entry(window).resolve();
  return { onProgress, computed: (index) => entry(index).promise };
}

/** Runs another clip to its end, in turns with everything else in this thread: work that can go on does so meanwhile. */
const runAnotherClip = async () => void (await windowsOf(await framesOf(TINY), WINDOWS));

test('one window is computed ahead of the one that is looked at, and no more', async () => {
  const source = endless((await framesOf(TINY)).slice(0, 1));
  const { onProgress, computed } = watchWindows();
  const video = segmentVideo(source, { ...WINDOWS, onProgress });
  const iterator = video[Symbol.asyncIterator]();
  assert.equal(source.numTaken, 0, 'frames are taken before anybody asks');
  await iterator.next();
  await computed(1);
  await runAnotherClip();
  // Window 1, the four new frames of window 2, and the one that tells that it is full.
  assert.equal(source.numTaken, 6 + 4 + 1);
  await iterator.next();
  await computed(2);
  await runAnotherClip();
  assert.equal(source.numTaken, 6 + 4 + 4 + 1);
  await iterator.return();
  await source.ended;
});

/** A stream of frames that counts what is pulled; without `frames` it is silent, and calls `onPull`. */
function counted(frames, onPull) {
  const source = { pulled: 0, cancelled: null };
  const pull = (controller) =>
    frames ? controller.enqueue(frames[source.pulled++ % frames.length]) : (onPull(), never);
  const cancel = (reason) => void (source.cancelled = [reason]);
  source.stream = new ReadableStream({ pull, cancel }, { highWaterMark: 0 });
  return source;
}

const never = new Promise(() => {});

test('a stream is read no faster than its masks are used: at most a window and four frames are in flight', async () => {
  const source = counted(await framesOf(TINY));
  let numSettled = 0;
  let peak = 0;
  const onFrame = () => void (peak = Math.max(peak, source.pulled - numSettled));
  const { onProgress, computed } = watchWindows();
  for await (const window of segmentVideo(source.stream, { ...WINDOWS, onFrame, onProgress })) {
    numSettled += [...window.frames()].length;
    await computed(window.index + 1);
    if (window.index === 3) break;
  }
  assert.ok(peak >= WINDOWS.window && peak <= WINDOWS.window + 4, `${peak} frames in flight`);
  assert.equal(source.cancelled?.length, 1);
  const { pulled } = source;
  await runAnotherClip();
  assert.equal(source.pulled, pulled);
});

test('a stream is cancelled when reading ends early, also while it is silent, and not before it is read', async () => {
  const frames = await framesOf(TINY);
  const wrong = counted([{ frame: frames[0], time: 1 }]);
  await rejects(windowsOf(wrong.stream), 'data', /frame 1 has time = 1 s/);
  const enough = counted(frames);
  await windowsOf(enough.stream, { maxFrames: 3 });
  const controller = new AbortController();
  const silent = counted(null, () => setImmediate(() => controller.abort()));
  await assert.rejects(windowsOf(silent.stream, { signal: controller.signal }), { name: 'AbortError' });
  for (const { stream, cancelled } of [wrong, enough, silent]) {
    assert.equal(cancelled?.length, 1);
    assert.equal(stream.locked, false);
  }
  const unread = counted(frames);
  await assert.rejects(windowsOf(unread.stream, { signal: AbortSignal.abort() }), { name: 'AbortError' });
  await rejects(videoInfo(unread.stream), 'unsupported', /no info/);
  assert.deepEqual([unread.pulled, unread.cancelled, unread.stream.locked], [0, null, false]);
  unread.stream.getReader();
  await rejects(windowsOf(unread.stream), 'data', /source = a ReadableStream .*nothing else reads/);
});

test('results are also a stream: the same windows, one ahead of its reader; cancelling it ends the work', async () => {
  const frames = await framesOf(TINY);
  const written = [];
  const { readable } = segmentVideo(frames, WINDOWS);
  await readable.pipeTo(new WritableStream({ write: (window) => void written.push(...window.frames()) }));
  const expected = settledFrames(await windowsOf(frames, WINDOWS));
  assert.deepEqual(written, expected);

  const source = counted(frames);
  const { onProgress, computed } = watchWindows();
  const video = segmentVideo(source.stream, { ...WINDOWS, onProgress });
  const reader = video.readable.getReader();
  assert.equal(video.readable.locked, true, 'it is one stream');
  await runAnotherClip();
  assert.equal(source.pulled, 0);
  assert.ok((await reader.read()).value instanceof WindowResult);
  await computed(1);
  await runAnotherClip();
  assert.equal(source.pulled, 6 + 4 + 1);
  await rejects(video.collect(), 'state');
  await reader.cancel();
  assert.equal(source.cancelled?.length, 1);

  const broken = segmentVideo(counted([plain(8, 8), plain(9, 9)]).stream).readable.getReader();
  await rejects(broken.read(), 'frame-size-changed');
});

test('leaving the loop ends the work and the source', async () => {
  const source = endless(await framesOf(TINY));
  const video = segmentVideo(source, WINDOWS);
  for await (const window of video) {
    if (window.index === 1) break;
  }
  await source.ended;
  const { numTaken } = source;
  await runAnotherClip();
  assert.equal(source.numTaken, numTaken);
  await rejects(video.collect(), 'state');
});

test('an abort in the middle rejects with its reason and ends the source; the same clip can be run again to the same masks', async () => {
  const frames = await framesOf(TINY);
  const expected = settledFrames(await windowsOf(frames, WINDOWS)).map(({ labels }) => labels);
  for (const stage of ['decode', 'flow', 'superpixels']) {
    const reason = new Error('changed my mind');
    const source = endless(frames);
    const stop = abortAt({ reason, isDue: (progress) => progress.stage === stage && progress.window === 1 });
    await assert.rejects(windowsOf(source, { ...WINDOWS, ...stop }), reason);
    await source.ended;
  }
  assert.deepEqual(each(settledFrames(await windowsOf(frames, WINDOWS)), 'labels'), expected);
});

test('an abort is heard before the first frame, and while the source is silent', async () => {
  await assert.rejects(windowsOf([plain(8, 8)], { signal: AbortSignal.abort() }), { name: 'AbortError' });
  const controller = new AbortController();
  const silent = {
    async *[Symbol.asyncIterator]() {
      setImmediate(() => controller.abort());
      await never;
    },
  };
  await assert.rejects(windowsOf(silent, { signal: controller.signal }), { name: 'AbortError' });
});

test('close, free and dispose end pending calls; results stay', async () => {
  for (const end of ['close', 'free', Symbol.dispose]) {
    const video = segmentVideo(endless(await framesOf(TINY)), WINDOWS);
    const iterator = video[Symbol.asyncIterator]();
    const { value } = await iterator.next();
    const next = iterator.next().then(() => iterator.next());
    video[end]();
    video[end]();
    await rejects(next, 'closed');
    assert.equal(value.labels(0).length, 48 * 36);
  }
  const unused = segmentVideo([]);
  unused.close();
  await rejects(unused.collect(), 'closed');
});

test('a segmentation is used once', async () => {
  const video = segmentVideo([plain(16, 16)]);
  assert.ok(video instanceof VideoSegmentation);
  await video.collect();
  await rejects(video.collect(), 'state', /once; call segmentVideo again/);
  assert.throws(() => video[Symbol.asyncIterator](), { code: 'state' });
});

test('one frame is all background; no frame is an error, and so are frames of different sizes', async () => {
  const [window] = await windowsOf([plain(24, 16, (x) => 10 * x)]);
  assert.deepEqual([...new Set(window.labels(0))], [0]);
  assert.deepEqual(window.settled, { from: 0, to: 1 });
  await rejects(windowsOf([]), 'no-frames', /no frames/);
  await rejects(windowsOf([plain(8, 8)], { start: 3, end: 4 }), 'no-frames', /from 3 s to 4 s.*at 0 s to 0 s/);
  await rejects(windowsOf([plain(24, 16), plain(16, 24)]), 'frame-size-changed', /16.*24/);
  await rejects(windowsOf([plain(24, 16), 'two']), 'data', /frame = "two"/);
  await rejects(windowsOf(Array(2).fill({ frame: plain(8, 8), time: 1 })), 'data', /frame 1 has time = 1/);
  await rejects(windowsOf([{ frame: plain(8, 8), time: NaN }]), 'data', /time = NaN/);
});

test('a damaged frame ends the clip: the masks equal those of the frames before it alone', async () => {
  const frames = (await framesOf({ ...TINY, width: 32, height: 24, frames: 9 })).map((frame) => png(frame));
  const broken = frames[0].subarray(0, 60);
  const options = { window: 4, overlap: 1, threads: 1 };
  async function* stream(list) {
    yield* list;
  }
  for (const place of [2, 5, 8]) {
    const damaged = () => stream(frames.with(place, broken));
    const expected = await segmentVideo(stream(frames.slice(0, place)), options).collect();
    const error = await segmentVideo(damaged(), options)
      .collect()
      .catch((fault) => fault);
    let damageReport = null;
    const result = await segmentVideo(damaged(), {
      ...options,
      onDamage: (damage) => (damageReport = damage),
    }).collect();
    assert.deepEqual([error.code, error.frames], ['decode', place]);
    assert.deepEqual([damageReport.frames, damageReport.total], [place, null]);
    for (const truncatedResult of [error.result, result]) {
      assert.deepEqual(truncatedResult.runs, expected.runs, `damage at frame ${place}`);
      assert.deepEqual(truncatedResult.truncated, { frames: place, reason: error.message });
    }
  }
  assert.equal((await segmentVideo(stream(frames), options).collect()).truncated, null);
  await rejects(segmentVideo(stream(frames.with(1, broken)), options).collect(), 'decode', /frame 1/);
});

test('options out of range are named with their range, at once', () => {
  const cases = [
    [{ window: 1 }, /window = 1 \(expected a whole number, 2..=400\)/],
    [{ window: 401 }, /window = 401/],
    [{ window: 10, overlap: 10 }, /overlap = 10 \(expected a whole number, 1..=9\)/],
    [{ overlap: 0 }, /overlap = 0/],
    [{ start: '1' }, /start = "1" \(expected a number of seconds\)/],
    [{ start: 2, end: 2 }, /end = 2 \(expected more than start = 2\)/],
    [{ end: NaN }, /end = NaN/],
    [{ step: 0 }, /step = 0/],
    [{ maxFrames: 1.5 }, /maxFrames = 1.5/],
    [{ size: 8 }, /size = 8 \(expected a whole number, 16..=16384\)/],
    [{ frameRate: 0 }, /frameRate = 0/],
    [{ signal: {} }, /signal = an Object \(expected an AbortSignal\)/],
    [{ onProgress: 1 }, /onProgress = 1/],
    [{ clip: { dense: false } }, /clip.dense = false/],
    [{ keep: 1 }, /keep = 1 \(expected true or false\)/],
    ['fast', /options = "fast"/],
  ];
  for (const [options, message] of cases)
    assert.throws(() => segmentVideo([], options), { name: 'TraceCutError', code: 'param', message });
});

test('an unknown parameter is refused, and a small window gets a small overlap', async () => {
  await rejects(windowsOf([plain(8, 8)], { flow: { speed: 1 } }), 'param', /flow.speed/);
  const windows = await windowsOf(await framesOf(TINY), { window: 7 });
  assert.deepEqual(each(windows, 'firstFrame'), [0, 1, 2, 3, 4, 5, 6, 7]);
});

test('the bytes of files are refused in Node, with what to do instead', async () => {
  for (const source of [new Blob(['x']), new Uint8Array(9)]) {
    const message = /browsers only.*pass the path.*framesOfVideo.*PNG or JPEG/;
    await rejects(segmentVideo(source).collect(), 'unsupported', message);
  }
  for (const source of [undefined, null, 7, {}])
    await rejects(segmentVideo(source).collect(), 'data', /source = .*expected a File or Blob/);
});

test('a cut begins a new shot at its frame, with new labels', async () => {
  const firstShot = await framesOf({ ...MOVING, frames: 12, seed: 0 });
  const secondShot = await framesOf({ ...MOVING, frames: 10, seed: 5 });
  const result = await segmentVideo([...firstShot, ...secondShot]).collect();
  assert.deepEqual(result.shots, [
    { first: 0, last: 11 },
    { first: 12, last: 21 },
  ]);
  const objectsIn = (from, to) =>
    result.objects.filter((object) => object.firstFrame <= to && object.lastFrame >= from);
  const [before, after] = [objectsIn(0, 11), objectsIn(12, 21)].map((objects) => each(objects, 'label'));
  assert.ok(before.length > 0 && after.length > 0, 'no objects were found');
  assert.ok(before.every((label) => !after.includes(label)));
  assert.ok(result instanceof VideoResult);
});

test('an object keeps its label from window to window', async () => {
  const clip = await synthClip({ ...MOVING, frames: 16, seed: 0 });
  const frames = numbers(16).map((t) => clip.frame(t));
  const result = await segmentVideo(frames, { window: 10, overlap: 5 }).collect();
  const votes = new Map();
  for (let t = 0; t < 16; t += 1) {
    const mask = clip.mask(t);
    result.labels(t).forEach((label, p) => mask[p] === 1 && votes.set(label, (votes.get(label) ?? 0) + 1));
  }
  const total = [...votes.values()].reduce((sum, count) => sum + count, 0);
  const [[label, count]] = [...votes].sort(([, a], [, b]) => b - a);
  assert.ok(label > 0 && count > 0.9 * total, `label ${label} has ${count} of ${total} pixels`);
});

test('the last frame ends when its source says so', async () => {
  const frames = [...flat(4)];
  const timed = (last) => frames.map((frame, t) => ({ frame, time: t / 10, ...(t === 3 ? { duration: last } : {}) }));
  const endOf = async (source, options) => (await segmentVideo(source, options).collect()).end;
  assert.equal(await endOf(timed(0.75)), 0.3 + 0.75);
  assert.equal(await endOf(timed(0.75), { window: 3, overlap: 1 }), 0.3 + 0.75);
  assert.equal(await endOf(timed(undefined)), null);
  assert.equal(await endOf(timed(0.75), { step: 3 }), null);
  await rejects(endOf(timed(0)), 'data', /duration = 0 of frame 3 \(expected seconds, above 0\)/);
  await rejects(endOf(timed('long')), 'data', /duration = long/);
});

test('many windows leave no listeners behind', async () => {
  const warnings = [];
  const note = (warning) => warnings.push(warning.name);
  process.on('warning', note);
  try {
    const result = await segmentVideo(flat(30), { window: 3, overlap: 1 }).collect();
    assert.equal(result.numFrames, 30);
    // A warning is emitted by process.nextTick.
    await new Promise((resolve) => process.nextTick(resolve));
  } finally {
    process.off('warning', note);
  }
  assert.deepEqual(warnings, []);
});

/** Small plain frames: nothing to find, so that windows take no time. */
function* flat(count) {
  for (let t = 0; t < count; t += 1)
    yield { data: new Uint8ClampedArray(4 * 24 * 16).fill(120), width: 24, height: 16 };
}

const CLIP = { width: 80, height: 45, frames: 24, seed: 3 };
const HALTED_WINDOWS = { window: 12, overlap: 4 };

const everything = (result) => ({
  times: [...result.times],
  shots: result.shots,
  labels: result.times.reduce((labels, _, t) => [...labels, String(result.labels(t))], []),
  tracks: result.toTracksDat(),
});

for (const threads of [1, 2]) {
  test(`paused in every stage of the second window, ${threads} threads: the same result`, async () => {
    const frames = await framesOf(CLIP);
    const options = { ...HALTED_WINDOWS, threads };
    const halted = new Set();
    let [expected, partial, isOver] = [null, null, false];
    let fail;
    const failure = new Promise((_, reject) => (fail = reject));
    /** Resumes the paused video; the first time after the same clip has run to its end. */
    const resume = async () => {
      expected ??= everything(await segmentVideo(frames, options).collect());
      await new Promise(setImmediate);
      assert.equal(isOver, false, 'it went on while it was paused');
      partial ??= video.collected;
      video.resume();
    };
    const video = segmentVideo(frames, {
      ...options,
      onProgress({ stage, window }) {
        if (window !== 1 || halted.has(stage) || video.paused) return;
        halted.add(stage);
        video.pause();
        resume().catch(fail);
      },
    });
    const collecting = video.collect().finally(() => (isOver = true));
    const result = await Promise.race([collecting, failure]);
    assert.ok(halted.size >= 4 && halted.has('decode'), `paused in ${[...halted]}`);
    assert.deepEqual(everything(result), expected);
    assert.ok(partial instanceof VideoResult);
    assert.ok(partial.numFrames >= 6 && partial.numFrames < 24, `${partial.numFrames} frames`);
    const { labels, times } = everything(partial);
    assert.deepEqual(labels, expected.labels.slice(0, partial.numFrames));
    assert.deepEqual(times, expected.times.slice(0, partial.numFrames));
    assert.equal(partial.shots.at(-1).last, partial.numFrames - 1);
    const { startFrame, offset, count } = partial.trajectories;
    assert.ok(count > 100);
    for (let i = 0; i < count; i += 1)
      assert.ok(startFrame[i] + offset[i + 1] - offset[i] <= partial.numFrames, 'a track leads beyond the end');
  });
}

test('a paused segmentation can be closed; one that has not begun waits', async () => {
  const frames = await framesOf(CLIP);
  const video = segmentVideo(frames, HALTED_WINDOWS);
  assert.equal(video.collected, null);
  video.pause();
  video.pause();
  const collecting = video.collect();
  collecting.catch(() => {});
  await runAnotherClip();
  assert.equal(video.collected, null);
  assert.equal(video.paused, true);
  video.close();
  await rejects(collecting, 'closed');
});

test('aborts, and errors of the caller’s source and callbacks, pass unchanged', async () => {
  const frames = (await framesOf(TINY)).slice(0, 4);
  const callerError = new RangeError('mine');
  const fail = () => {
    throw callerError;
  };
  async function* failing() {
    yield frames[0];
    fail();
  }
  for (const [source, options] of [
    [failing(), {}],
    [frames, { onFrame: fail }],
    [frames, { onProgress: fail }],
    [frames, { signal: AbortSignal.abort(callerError) }],
  ]) {
    await assert.rejects(segmentVideo(source, options).collect(), (error) => error === callerError);
  }
  for (const call of [
    (signal) => segmentVideo(frames, { signal }).collect(),
    (signal) => trajectories(frames, { signal }),
    (signal) => videoFrames(frames, { signal }).next(),
  ])
    await assert.rejects(call(AbortSignal.abort()), { name: 'AbortError' });
  await assert.rejects(trajectories(failing()), (error) => error === callerError);
  await assert.rejects(trajectories(frames, { onProgress: fail }), (error) => error === callerError);
});
