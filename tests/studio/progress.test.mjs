// Progress of runs, replayed from recorded times: the share never falls, and the time left is close to the true one.
// recorded-runs.json has the times of stages in Chromium on two idle cores.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { afterEach, mock, test } from 'node:test';
import { ClipJob } from '../../build/model/clip-job.js';
import { ClipWork, StageClock } from '../../dist/session/progress.js';
import { movingFrames } from '../moving.mjs';
import { CLIP, openModel, openSampleWork } from './studio.mjs';

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
    for (; now + TICK_MS < end; now += TICK_MS) estimates.push({ now, left: job.timeLeft(now) });
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
    .map(({ now, left }) => {
      assert.ok(left !== null || now < 0.15 * end, `no estimate at ${now} of ${end}`);
      return left === null ? 1 : Math.max((left - SLACK_MS) / (end - now), (end - now - SLACK_MS) / left);
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
    const whole = slowIn(0, 1, run.ms);
    for (const replayed of [replay(run), replay(run, { when: whole, pace: 2 * PACE })]) {
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
    const left = clock.timeLeft(now);
    if (now < 2000) assert.equal(left, null);
    else assert.ok(Math.abs(left - 500 * (10 - k)) < 1, `${left} after ${k}`);
  }
});

test('a stage that turns out longer does not lower the share', () => {
  const clock = new StageClock([{ id: 'cut', cost: 1 }]);
  const shares = [0.2, 0.9, 0.3, 0.5, 1].map((done) => {
    clock.count('cut', done, 1);
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
});

test('opening a saved project sets no pace for runs', async () => {
  const { store, app } = await openSampleWork();
  assert.equal(store.state.pace, 0);
  await app.openFiles([CLIP]);
  assert.ok(store.state.pace > 0);
});
