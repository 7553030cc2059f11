// Long clips in the studio's model: a coarse preview before the first masks, windows shown as they are finished, shots, results of runs
// that are stopped early, and progress, replayed from recorded times (recorded-runs.json: stages in Chromium on two idle cores).

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { afterEach, mock, test } from 'node:test';
import { ClipJob } from '../../build/model/clip-job.js';
import { resizedFrames } from '../../build/model/export-text.js';
import { exportSource } from '../../build/model/export.js';
import { data } from '../../build/model/exports.js';
import { needsPreview } from '../../build/model/preview.js';
import { showCorrected } from '../../build/model/show-result.js';
import { ClipWork, StageClock } from '../../dist/session/progress.js';
import { movingFrames, plainFrame, textureAt } from '../moving.mjs';
import { CLIP, frameGate, maskText, openModel, openSampleWork, waitForState } from './studio.mjs';

const WIDTH = 96;
const HEIGHT = 64;

/** Left edge of the square of `twoShots`. */
const leftAt = (t) => 10 + 2 * (t % 40 < 20 ? t % 40 : 40 - (t % 40));

/** A square that moves to and fro; from frame `cut` on another square over another background. */
function twoShots(count, cut) {
  return Array.from({ length: count }, (_, t) => {
    const [squareX, salt] = [leftAt(t), t < cut ? 1 : 5];
    return plainFrame(WIDTH, HEIGHT, (x, y) => {
      const isInside = x >= squareX && x < squareX + 28 && y >= 16 && y < 48;
      const value = isInside ? textureAt(x - squareX, y, salt + 1) : textureAt(x, y, salt);
      return t < cut ? [value, value, isInside ? 255 - value : value] : [isInside ? 255 : value / 2, value, value / 3];
    });
  });
}

/** Exports data of the result on screen: `coco`, `table` or `tracks`. */
async function exportText(store, id) {
  const source = exportSource(store.state);
  const { stream, read } = resizedFrames(store.state.job, source.masks, WIDTH);
  const edges = { smallest: 0, grow: 0, feather: 0 };
  const subject = { ...source, frames: stream, image: read, edges, objects: (object) => object > 0 };
  const { make } = data.choices.find((choice) => choice.id === id);
  return (await make(subject, { signal: new AbortController().signal, onProgress() {} })).text();
}

test('a clip of one window is one shot, even with a cut', async () => {
  const { app, store } = await openModel(twoShots(20, 10));
  await app.openFiles([CLIP]);
  assert.match(store.state.subline, /^20 frames of 96 × 64 ·/);
  assert.deepEqual([store.state.job.cuts, store.state.job.preview], [[], null]);
});

test('shows windows while later frames are read, and follows objects through each shot', async () => {
  const { app, store } = await openModel(twoShots(110, 70));
  const opening = app.openFiles([CLIP]);
  const { phase, timeline, job, analysis, announcement } = await waitForState(store, (state) => state.isStreaming);
  assert.deepEqual([phase, timeline.numFrames], ['running', 110]);
  assert.ok(job.settledFrames >= 40 && job.settledFrames <= 50, `${job.settledFrames} frames are finished`);
  assert.ok(job.images.length < 100, `${job.images.length} frames were read before any mask was shown`);
  assert.ok(analysis.segmentation.mask(20).some((label) => label > 0));
  assert.match(announcement, /^\d\d of 110 frames are done: 1 moving object$/);

  await opening;
  assert.match(store.state.subline, /^110 frames of 96 × 64 in [34] windows and 2 shots · windows of 50 frames/);
  assert.deepEqual([job.cuts, store.state.timeline.cuts], [[70], [70]]);
  const { segmentation } = store.state.analysis;
  const labelAt = (t) => segmentation.mask(t)[32 * WIDTH + leftAt(t) + 14];
  const labelsIn = (from, to) => [...new Set(Array.from({ length: to - from }, (_, k) => labelAt(from + k)))];
  const [first, second] = [labelsIn(3, 67), labelsIn(73, 107)];
  assert.deepEqual([first.length, second.length], [1, 1], `squares have the labels ${first} and ${second}`);
  assert.ok(first[0] > 0 && second[0] > 0 && first[0] !== second[0]);

  // Objects of different windows are joined in all of them.
  const { corrections } = job;
  assert.equal(corrections.splitsAtPlace, true);
  showCorrected(store, await corrections.join(first[0], second));
  const coco = JSON.parse(await exportText(store, 'coco'));
  assert.equal(coco.images.length, 110);
  assert.ok(coco.annotations.length > 90 && coco.annotations.every(({ track_id: id }) => id !== second[0]));
  assert.match(await exportText(store, 'tracks'), /^110\n\d+\n/);
});

test('a run stopped early keeps its windows, and continues to the same result', async () => {
  const gate = frameGate();
  const { app, store } = await openModel(movingFrames(90, [64, 48]), { gate });
  await app.openFiles([CLIP]);
  const masks = maskText(store.state);
  // Enough frames for the first window, but not for the second.
  gate.count = 70;
  const running = app.rerun();
  await waitForState(store, ({ job, phase }) => phase === 'running' && job.settledFrames > 0);
  app.cancel();
  await waitForState(store, ({ phase }) => phase === 'done');
  const { job, timeline, notice, subline } = store.state;
  const { numFrames } = timeline;
  assert.ok(numFrames >= 40 && numFrames <= 50, `${numFrames} frames`);
  assert.equal(notice, `Stopped early: ${numFrames} of 90 frames are ready to save. Continue to finish.`);
  assert.match(subline, new RegExp(`^${numFrames} frames of 64 × 48 in [12] windows?`));
  assert.equal(maskText(store.state), masks.split('|').slice(0, numFrames).join('|'));
  assert.deepEqual([job.isPartial, job.corrector, job.pacePerPixel], [true, null, null]);
  assert.equal(JSON.parse(await exportText(store, 'coco')).images.length, numFrames);
  assert.match(await exportText(store, 'tracks'), new RegExp(`^${numFrames}\n[1-9]`));
  assert.match(await exportText(store, 'table'), /\n\d+,/);

  const resuming = app.resume();
  assert.deepEqual([store.state.phase, store.state.timeline.numFrames], ['running', 90]);
  gate.open();
  await Promise.all([running, resuming]);
  assert.equal(maskText(store.state), masks);
  assert.equal(store.state.job, job, 'the same run goes on');
  assert.deepEqual([store.state.notice, job.isPartial, job.corrector], ['', false, job.corrections]);
});

const PREVIEW_SIZE = { width: 320, height: 216 };
const SQUARE = { top: 50, side: 80 };

let largeFrames;

/** Returns a square that moves two pixels a frame, large enough for a preview. */
function createLargeFrames() {
  const { width, height } = PREVIEW_SIZE;
  const { top, side } = SQUARE;
  const colour = (value) => [value, value, value];
  const background = plainFrame(width, height, (x, y) => colour(textureAt(x >> 1, y >> 1, 1)));
  const square = plainFrame(side, side, (x, y) => {
    const value = textureAt(x >> 1, (y + top) >> 1, 2);
    return [value, value, 255 - value];
  });
  return Array.from({ length: 50 }, (_, t) => {
    const data = background.data.slice();
    for (let y = 0; y < side; y += 1)
      data.set(square.data.subarray(4 * y * side, 4 * (y + 1) * side), 4 * ((top + y) * width + 20 + 2 * t));
    return { data, width, height };
  });
}

/** Opens a clip with a preview, whose frames are held back from number `count` on. */
async function openLarge(count) {
  const gate = frameGate(count);
  largeFrames ??= createLargeFrames();
  const model = await openModel(largeFrames, { gate });
  return { ...model, gate, opening: model.app.openFiles([CLIP]) };
}

test('shows a coarse preview of the first frames until there are masks', async () => {
  const { store, gate, opening } = await openLarge(20);
  const { phase, timeline, announcement, job, analysis } = await waitForState(store, ({ preview }) => preview);
  assert.deepEqual([phase, timeline.numFrames, analysis], ['running', 15, null]);
  assert.equal(announcement, 'Coarse preview of the first frames.');
  for (let t = 0; t < 15; t += 1) {
    const masked = t - (t % 2);
    assert.equal(job.preview.maskedFrame(t), masked, 'picture and mask show the same frame');
    let [both, either] = [0, 0];
    job.preview.labels(t).forEach((label, p) => {
      const [x, y] = [(p % PREVIEW_SIZE.width) - 20 - 2 * masked, Math.floor(p / PREVIEW_SIZE.width) - SQUARE.top];
      const isInside = x >= 0 && x < SQUARE.side && y >= 0 && y < SQUARE.side;
      both += Number(isInside && label === 1);
      either += Number(isInside || label > 0);
    });
    assert.ok(both / either > 0.7, `frame ${t}: ${both / either}`);
  }
  gate.open();
  await waitForState(store, ({ preview }) => !preview);
  assert.notEqual(store.state.analysis, null, 'masks replace the preview');
  await opening;
  assert.deepEqual([store.state.phase, store.state.preview], ['done', null]);
});

test('a preview stays after a cancel and gives way to another clip', async () => {
  const { app, store, gate, opening } = await openLarge(20);
  await waitForState(store, ({ preview }) => preview);
  app.cancel();
  assert.equal(store.state.phase, 'stopped');
  assert.notEqual(store.state.preview, null);
  await opening;
  const sample = app.openSample();
  assert.equal(store.state.preview, null);
  gate.open();
  await waitForState(store, ({ phase }) => phase === 'running');
  app.cancel();
  await sample;
});

test('a run goes on without a preview that fails', async () => {
  const { app, store, gate, opening } = await openLarge(5);
  const { job } = await waitForState(store, (state) => state.job?.images.length === 5);
  const closed = new Promise((resolve) => job.preview.abort.signal.addEventListener('abort', resolve));
  job.preview.frames.error(new Error('no frames'));
  await closed;
  gate.open();
  await waitForState(store, () => job.images.length === 50 && job.stages[1].done > 0);
  assert.deepEqual([store.state.phase, job.preview.masks], ['running', null]);
  app.cancel();
  await opening;
});

test('only clips whose masks take long have a preview', () => {
  const clip = { kind: 'video', width: 1920, height: 1080 };
  const trim = { start: 0, frames: 50, step: 1, side: 480 };
  assert.equal(needsPreview(clip, trim), true);
  assert.equal(needsPreview(clip, { ...trim, frames: 15 }), false);
  assert.equal(needsPreview({ ...clip, width: 200, height: 100 }, { ...trim, frames: 500 }), false);
});

const RUNS = JSON.parse(readFileSync(new URL('recorded-runs.json', import.meta.url), 'utf8'));
const PREDICTED = RUNS.filter(({ name }) => !/three clusterings/.test(name));

const SIZE = { width: 480, height: 270 };
/** Pace of the sample on the same machine, in milliseconds per pixel and frame. */
const PACE = 300 / (SIZE.width * SIZE.height);
const TICK_MS = 100;
/** Steps of the time left on screen: shorter times are all the same to the user. */
const SLACK_MS = 1000;

afterEach(() => mock.reset());

/** Replays a run. @param when maps recorded times to times of the replay */
function replay({ frames, readsFile, ms, events }, { when = (t) => t, pace = PACE } = {}) {
  let now = 0;
  mock.method(performance, 'now', () => now);
  const images = { ...SIZE, length: 0 };
  const source = { ...SIZE, ...(readsFile ? { direct() {} } : {}) };
  const job = new ClipJob(source, { frames, side: SIZE.width }, {}, ClipJob.stages, images, pace);
  const shares = [];
  const estimates = [];
  const tickUntil = (end) => {
    for (; now + TICK_MS < end; now += TICK_MS) estimates.push({ now, timeLeft: job.timeLeft(now) });
    now = end;
  };
  job.start();
  for (const event of events.split(', ')) {
    const [, at, stage, done, total, window] = event.match(/^(\d+) (\w+) (\d+)(?:\/(\d+) (\d+))?$/);
    tickUntil(when(Number(at)));
    if (stage === 'frames') {
      images.length = Number(done);
      job.mark('frames', images.length, Math.max(frames, images.length));
    } else job.advance({ stage, done: Number(done), total: Number(total), window: Number(window) });
    shares.push(job.share);
  }
  tickUntil(when(ms));
  mock.reset();
  return { shares, estimates, end: when(ms) };
}

/** Returns the largest factor between the estimated and the true time left, in the last part of a run. */
function worstFactor({ estimates, end }, fromShare) {
  const factors = estimates
    .filter(({ now }) => now >= Math.max(2500, fromShare * end))
    .map(({ now, timeLeft }) => {
      assert.ok(timeLeft !== null || now < 0.15 * end, `no estimate at ${now} of ${end}`);
      return timeLeft === null ? 1 : Math.max((timeLeft - SLACK_MS) / (end - now), (end - now - SLACK_MS) / timeLeft);
    });
  return Math.max(1, ...factors);
}

/** Returns the times of a machine that is twice as slow in a part of the run. */
const slowIn = (from, to, ms) => (t) => t + Math.max(0, Math.min(t, to * ms) - from * ms);

for (const run of RUNS)
  test(`the share of ${run.name} never falls and ends at 1`, () => {
    for (const when of [(t) => t, slowIn(0, 1, run.ms), slowIn(0.1, 0.3, run.ms)]) {
      const { shares } = replay(run, { when });
      shares.forEach((share, k) => assert.ok(share >= (shares[k - 1] ?? 0) && share <= 1));
      assert.equal(shares.at(-1), 1);
    }
  });

for (const run of PREDICTED)
  test(`the time left of ${run.name} is within 1.5 after a tenth and 1.2 after half`, () => {
    const slow = slowIn(0, 1, run.ms);
    for (const replayed of [replay(run), replay(run, { when: slow, pace: 2 * PACE })]) {
      assert.ok(worstFactor(replayed, 0.1) <= 1.5, `${worstFactor(replayed, 0.1)}`);
      assert.ok(worstFactor(replayed, 0.5) <= 1.2, `${worstFactor(replayed, 0.5)}`);
    }
    // A machine that was busy for a while cannot be predicted to be free again.
    const busy = replay(run, { when: slowIn(0.1, 0.3, run.ms) });
    assert.ok(worstFactor(busy, 0.6) <= 1.25, `${worstFactor(busy, 0.6)}`);
    // The first run of a page has no pace of an earlier one.
    assert.ok(worstFactor(replay(run, { pace: 0 }), 0.5) <= 1.2);
  });

test('the time left includes masks that are computed again as soon as that begins', () => {
  const run = RUNS.find(({ name }) => /three clusterings/.test(name));
  assert.ok(worstFactor(replay(run), 0.8) <= 1.5);
});

test('counts every frame once, wherever shots end windows', () => {
  const withoutCuts = [50, 90, 130, 170, 210, 221];
  for (const ends of [withoutCuts, [50, 71, 121, 161, 201, 221], [3, 53, 93, 133, 173, 213, 221]]) {
    const work = new ClipWork(221, 50, 10, true);
    let window = 0;
    for (const end of ends) {
      const read = Math.min(end + 1, 221);
      for (let k = 0; k <= 10; k += 1) {
        work.begin(window, read);
        for (const stage of ['flow', 'cut', 'masks'])
          assert.ok(work.done(stage, k, 10) <= work.total(stage) + 1e-9, `${stage} of window ${window} of ${ends}`);
        assert.ok(work.total('flow') >= 221);
      }
      window += 1;
    }
  }
  const short = new ClipWork(40, 50, 10, true);
  assert.deepEqual([short.total('flow'), short.total('masks'), short.done('masks', 40, 40)], [40, 40, 40]);
  assert.equal(new ClipWork(221, 50, 10, true).total('masks'), 300);
  assert.equal(new ClipWork(221, 50, 10, false).total('masks'), 271);
});

test('estimates no time before a step was computed; reading frames predicts nothing', () => {
  let now = 0;
  mock.method(performance, 'now', () => now);
  const clock = new StageClock([
    { id: 'frames', cost: 1, total: 10, isReading: true },
    { id: 'flow', cost: 1, total: 10 },
  ]);
  clock.start();
  for (let k = 1; k <= 10; k += 1) {
    now += 1000;
    clock.mark('frames', k);
    assert.equal(clock.timeLeft(now), null);
  }
  assert.ok(Math.abs(clock.share - 0.5) < 1e-9);
  for (let k = 1; k <= 10; k += 1) {
    now += 200;
    clock.mark('flow', k);
    assert.ok(Math.abs(clock.timeLeft(now) - 200 * (10 - k)) < 50, `${clock.timeLeft(now)}`);
  }
  assert.equal(clock.share, 1);
});

test('the stage on screen is the current one, not the last finished one', () => {
  const clock = new StageClock([
    { id: 'frames', cost: 1 },
    { id: 'flow', cost: 1 },
  ]);
  assert.equal(clock.stageOnScreen, 'frames');
  clock.mark('frames', 1, 1);
  assert.equal(clock.stageOnScreen, 'flow');
});

test('estimates the time of saving frames after two seconds', () => {
  let now = 0;
  mock.method(performance, 'now', () => now);
  const clock = new StageClock([{ id: 'frames', cost: 1 }]);
  clock.start();
  for (let k = 1; k <= 10; k += 1) {
    now += 500;
    clock.mark('frames', k, 10);
    const timeLeft = clock.timeLeft(now);
    if (now < 2000) assert.equal(timeLeft, null);
    else assert.ok(Math.abs(timeLeft - 500 * (10 - k)) < 1, `${timeLeft} after ${k}`);
  }
});

test('a stage that turns out longer does not lower the share', () => {
  const clock = new StageClock([{ id: 'cut', cost: 1 }]);
  const shares = [0.2, 0.9, 0.3, 0.5, 1].map((amount) => {
    clock.count('cut', amount, 1);
    return clock.share;
  });
  shares.forEach((share, k) => assert.ok(share >= (shares[k - 1] ?? 0)));
  assert.equal(shares.at(-1), 1);
});

test('the share of a run in the model never falls and ends at 1', async () => {
  const { app, store } = await openModel(movingFrames(8, [64, 48]));
  let shares = [];
  store.watch(['share', 'phase'], ({ share, phase }) => phase === 'running' && shares.push(share));
  for (const open of [() => app.openSample(), () => app.openFiles([CLIP])]) {
    shares = [];
    await open();
    assert.equal(shares[0], 0);
    shares.slice(1).forEach((share, k) => assert.ok(share >= shares[k], `${share} after ${shares[k]}`));
    assert.equal(store.state.share, 1);
  }
  assert.ok(store.state.pace > 0);
  assert.equal((await openSampleWork()).store.state.pace, 0, 'opening a saved project sets no pace for runs');
});
