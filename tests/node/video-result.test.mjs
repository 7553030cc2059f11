// What a video reports and collects: progress, masks as runs, objects, trajectories over windows; and frames reduced.

import assert from 'node:assert/strict';
import { before, describe, test } from 'node:test';
import { fitSize, segmentEach, segmentVideo, videoFrames, videoInfo } from 'tracecut';
import { editMasks } from 'tracecut/edit';
import { trajectories } from 'tracecut/stages';
import { countPixels, decodeRuns, encodeRuns } from '../../dist/session/serialize.js';
import { reducePixels } from '../../dist/worker/pixels.js';
import { abortAt, checkTrackFile, each, framesOf, open, plain, png, ready, rejects } from './support.mjs';

const SCENE = { width: 96, height: 54, frames: 16, seed: 4 };
const frames = await framesOf(SCENE);

/** Throws unless the shares never fall, end at 1 and the time left is a number or null. */
function checkReports(reports) {
  assert.ok(reports.length > 0);
  reports.forEach(({ stage, share, secondsLeft }, k) => {
    assert.equal(typeof stage, 'string');
    assert.ok(
      share >= (reports[k - 1]?.share ?? 0) && share <= 1,
      `${share} in ${stage} after ${reports[k - 1]?.share}`,
    );
    assert.ok(secondsLeft === null || (secondsLeft >= 0 && Number.isFinite(secondsLeft)));
  });
  assert.deepEqual([reports.at(-1).share, reports.at(-1).secondsLeft], [1, 0]);
}

/** Returns the reports of a call, which is given options. */
async function reportsOf(call) {
  const reports = [];
  await call({ onProgress: (progress) => reports.push(progress) });
  return reports;
}

/** Segments a source and returns the reports. */
const reportsOfVideo = (source, options) =>
  reportsOf((reporting) => segmentVideo(source, { threads: 1, ...options, ...reporting }).collect());

for (const worker of [false, true])
  test(`a session's run and corrections, ${worker ? 'in a thread' : 'here'}`, async (t) => {
    const session = await ready(t, { worker }, frames.slice(0, 10));
    let result;
    checkReports(await reportsOf(async (options) => (result = await session.run(options))));
    const [{ label }] = result.objects;
    const reports = await reportsOf((options) => session.split(label, undefined, options));
    if (reports.length > 0) checkReports(reports);
  });

test('a run that was aborted continues with a share of what is left', async (t) => {
  const session = await ready(t, {}, frames.slice(0, 10));
  const aborted = session.run(abortAt({ isDue: ({ stage }) => stage === 'superpixels' }));
  await assert.rejects(aborted, { name: 'AbortError' });
  checkReports(await reportsOf((options) => session.run(options)));
});

test('runs without masks, and trajectories without frames', async (t) => {
  const session = await ready(t, { clip: { dense: false } }, frames.slice(0, 10));
  checkReports(await reportsOf((options) => session.run(options)));
  let tracks;
  checkReports(await reportsOf(async (options) => (tracks = await trajectories(frames.slice(0, 10), options))));
  const trackSession = await open(t);
  await trackSession.setTrajectories({ ...tracks });
  assert.equal((await reportsOf((options) => trackSession.run(options))).at(-1).share, 1);
});

test('a clip of many windows has one share over all of them', async () => {
  for (const options of [
    { window: 5, overlap: 3 },
    { step: 2, window: 5 },
  ])
    checkReports(await reportsOfVideo(frames, options));
  const cut = await framesOf({ ...SCENE, frames: 5, seed: 7 });
  checkReports(await reportsOfVideo([...frames.slice(0, 8), ...cut], { window: 6 }));
});

test('the share of a source of unknown length begins when that is known', async () => {
  async function* generated() {
    yield* frames;
  }
  const reports = await reportsOfVideo(generated(), { window: 8 });
  assert.ok(reports.every(({ frames, share }) => frames.total !== null || share === 0));
  checkReports(reports.filter(({ frames }) => frames.total !== null));
});

test('a source that ends early ends at 1 too, and each clip of a queue has its own share', async () => {
  const damaged = [...frames.slice(0, 12), new Uint8Array(9), ...frames.slice(0, 9)];
  checkReports(await reportsOfVideo(damaged, { window: 8, onDamage() {} }));
  const reports = [[], []];
  const clips = ['a', 'b'].map((name) => ({ name, source: frames.slice(0, 8) }));
  for await (const { error } of segmentEach(clips, { onProgress: (p) => reports[p.index].push(p) }))
    assert.equal(error, null);
  reports.forEach((clipReports) => checkReports(clipReports));
});

const identity = Uint8Array.from({ length: 256 }, (_, k) => k);

/** Numbers that look random and are the same each time. */
function* noise(seed) {
  for (let state = seed; ;) {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    yield state >>> 8;
  }
}

test('label maps come back from runs as they were, whatever they hold', () => {
  const random = noise(7);
  const maps = [new Uint8Array(0), new Uint8Array(1), Uint8Array.of(255), identity];
  maps.push(new Uint8Array(2 ** 24 + 9).fill(3));
  for (let k = 0; k < 30; k += 1)
    maps.push(Uint8Array.from({ length: 500 }, () => (random.next().value % (k + 1)) * 8));
  for (const map of maps) {
    const runs = encodeRuns(map);
    assert.deepEqual(decodeRuns(runs), map);
    const areas = new Array(256).fill(0);
    for (const label of map) areas[label] += 1;
    assert.deepEqual([...countPixels(runs)], areas);
  }
});

test('each pixel of a reduced frame is the mean of what it covers', () => {
  const random = noise(3);
  const frame = { width: 7, height: 5, data: Uint8Array.from({ length: 4 * 35 }, () => random.next().value % 256) };
  assert.deepEqual(reducePixels(frame, 7, 5), frame.data);
  for (const [width, height] of ['1x1', '3x2', '7x1', '4x5', '6x4'].map((size) => size.split('x').map(Number))) {
    const small = reducePixels(frame, width, height);
    // The same by brute force, over 420 × 420 points of the picture.
    for (let y = 0; y < height; y += 1) {
      for (let x = 0; x < width; x += 1) {
        let [sum, count] = [0, 0];
        for (let py = (y * 420) / height; py < ((y + 1) * 420) / height; py += 1) {
          for (let px = (x * 420) / width; px < ((x + 1) * 420) / width; px += 1) {
            sum += frame.data[4 * (Math.floor((py * 5) / 420) * 7 + Math.floor((px * 7) / 420))];
            count += 1;
          }
        }
        const value = small[4 * (y * width + x)];
        const where = `${width}x${height} at ${x},${y}`;
        assert.ok(Math.abs(value - sum / count) <= 0.51, `${where}: ${value}, not ${sum / count}`);
      }
    }
  }
  // Whole rows are added in another way than parts of rows.
  const tall = { width: 3, height: 600, data: Uint8Array.from({ length: 4 * 1800 }, () => random.next().value % 256) };
  const unaligned = new Uint8Array(4 * 1800 + 1).subarray(1);
  unaligned.set(tall.data);
  for (const [width, height] of ['3x300', '2x100', '1x2', '3x1'].map((size) => size.split('x').map(Number)))
    assert.deepEqual(reducePixels(tall, width, height), reducePixels({ ...tall, data: unaligned }, width, height));
  assert.deepEqual(fitSize({ width: 1280, height: 720 }, 480), { width: 480, height: 270 });
  assert.deepEqual(fitSize({ width: 720, height: 1280 }, 100), { width: 56, height: 100 });
  assert.deepEqual(fitSize({ width: 64, height: 2 }, 16), { width: 16, height: 1 });
  assert.deepEqual(fitSize({ width: 64, height: 48 }, 500), { width: 64, height: 48 });
});

describe('a collected clip', () => {
  let windows;
  let result;
  const frames = framesOf({ width: 160, height: 90, frames: 24, seed: 0 });
  const options = { window: 14, overlap: 8, frameRate: 8 };

  before(async () => {
    windows = [];
    result = await segmentVideo(await frames, options).collect((window) => void windows.push(window));
  });

  test('has the masks and times of its windows', () => {
    assert.deepEqual([result.width, result.height, result.numFrames, windows.length], [160, 90, 24, 3]);
    for (const window of windows) {
      for (const { index, time, labels } of window.frames()) {
        assert.deepEqual(result.labels(index), labels);
        assert.equal(result.times[index], time);
      }
    }
    assert.throws(() => result.labels(24), { code: 'param' });
  });

  test('joins trajectories over windows: some are longer than any window, and no point is lost or added', () => {
    const { count, startFrame, offset, x, y, label } = result.trajectories;
    const lengths = [startFrame.length, offset.length, label.length, offset[count]];
    assert.deepEqual(lengths, [count, count + 1, count, x.length]);
    const points = new Set();
    let longest = 0;
    for (let i = 0; i < count; i += 1) {
      longest = Math.max(longest, offset[i + 1] - offset[i]);
      for (let p = offset[i]; p < offset[i + 1]; p += 1) points.add(`${x[p]} ${y[p]} ${startFrame[i] + p - offset[i]}`);
    }
    assert.ok(longest > options.window, `the longest trajectory has ${longest} points`);
    const windowPoints = new Set();
    for (const { trajectories: tracks, firstFrame } of windows) {
      for (let i = 0; i < tracks.count; i += 1) {
        for (let p = tracks.offset[i]; p < tracks.offset[i + 1]; p += 1)
          windowPoints.add(`${tracks.x[p]} ${tracks.y[p]} ${firstFrame + tracks.startFrame[i] + p - tracks.offset[i]}`);
      }
    }
    assert.deepEqual([...points].sort(), [...windowPoints].sort());
    const labels = [0, ...each(result.objects, 'label')];
    const used = [...new Set(label)];
    const unknown = used.filter((value) => !labels.includes(value));
    assert.deepEqual(unknown, []);
    assert.ok(used.length > 1, 'all trajectories have one label');
  });

  test('writes its trajectories as a track file', () => {
    checkTrackFile(result);
  });

  test('is merged without being computed again, and stays as it was', async () => {
    const [{ label, areas }] = result.objects;
    const editor = editMasks(result);
    await editor.merge(200, label);
    const renamed = await editor.toResult();
    assert.ok(each(renamed.objects, 'label').includes(200));
    const expected = result.labels(3).map((value) => (value === label ? 200 : value));
    assert.deepEqual(renamed.labels(3), expected);
    assert.deepEqual([renamed.times, renamed.end, renamed.shots], [result.times, result.end, result.shots]);
    await editor.merge(0, 200);
    const gone = await editor.toResult();
    assert.ok(!each(gone.objects, 'label').includes(200));
    assert.ok(gone.labels(3).every((value) => value !== 200));
    assert.ok(gone.trajectories.label.every((value) => value !== 200));
    assert.deepEqual(result.objects[0].areas, areas);
    await rejects(editor.merge(1, 1), 'param', /b = 1 \(expected another label/);
    await rejects(editor.merge(300, 1), 'param', /a = 300/);
  });
});

test('onFrame is given each frame before it is segmented, at its size, and is waited for', async () => {
  const frames = (await framesOf({ width: 96, height: 64, frames: 6 })).map((frame) => png(frame));
  const calls = [];
  const onFrame = async ({ width, height, index, time, pixels }) => {
    await new Promise(setImmediate);
    calls.push([width, height, index, time, (await pixels()).data.length]);
  };
  const observed = await segmentVideo(frames, { frameRate: 10, step: 2, size: 48, onFrame }).collect();
  const expected = [0, 0.2, 0.4].map((time, k) => [48, 32, k, time, 4 * 48 * 32]);
  assert.deepEqual(calls, expected);
  const quiet = await segmentVideo(frames, { frameRate: 10, step: 2, size: 48 }).collect();
  assert.deepEqual(observed.runs, quiet.runs);
  const broken = () => Promise.reject(new Error('enough'));
  await assert.rejects(segmentVideo(frames, { onFrame: broken }).collect(), /enough/);
  assert.throws(() => segmentVideo(frames, { onFrame: 3 }), { code: 'param', message: /onFrame = 3/ });
});

test('videoFrames gives the frames of a list as pixels, chosen and reduced', async () => {
  const frames = Array.from({ length: 10 }, (_, k) => plain(40, 20, 20 * k));
  const frameFacts = [];
  const files = frames.map((frame) => png(frame));
  const selection = { frameRate: 10, start: 0.2, step: 3, size: 20 };
  for await (const { frame, index, time } of videoFrames(files, selection))
    frameFacts.push([frame.width, frame.height, frame.data.length, frame.data[0], frame.data[3], index, time]);
  assert.deepEqual(frameFacts, [
    [20, 10, 800, 40, 255, 0, 0.2],
    [20, 10, 800, 100, 255, 1, 0.5],
    [20, 10, 800, 160, 255, 2, 0.8],
  ]);
  await rejects(videoFrames([]).next(), 'no-frames');
  await rejects(videoInfo([plain(8, 8)]), 'unsupported', /list or stream of frames/);
  assert.throws(() => videoFrames([], { window: 3 }), {
    code: 'param',
    message: /window = 3 \(expected a known option; the options are start, end/,
  });
  await assert.rejects(videoFrames(frames, { signal: AbortSignal.abort() }).next(), { name: 'AbortError' });
});
