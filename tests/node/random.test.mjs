// Random calls of a session's interface, awaited or not, with aborts and closes in between: each call ends in what it
// promises or in an error with a code, none hangs, and the next session works. `TRACECUT_SEEDS=FIRST..LAST` takes
// other seeds.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { createSession, TraceCutError } from 'tracecut';
import { fingerprint, plain, segment } from './support.mjs';

const [first, last] = (process.env.TRACECUT_SEEDS ?? '0..60').split('..').map(Number);

/** What a session may answer; `poisoned` would be a fault of ours. */
const CODES = [
  'frame-size',
  'frame-bytes',
  'frame-size-changed',
  'too-few-frames',
  'too-large',
  'decode',
  'param',
  'data',
].concat(['state', 'closed', 'busy']);

/** SplitMix64, as the library has it, in 32 bits: a number below `n`. */
function generator(seed) {
  let state = (seed * 0x9e3779b9) | 0;
  return (n) => {
    state = (state + 0x9e3779b9) | 0;
    let z = Math.imul(state ^ (state >>> 16), 0x85ebca6b);
    z = Math.imul(z ^ (z >>> 13), 0xc2b2ae35);
    return ((z ^ (z >>> 16)) >>> 0) % n;
  };
}

/** Frames with a block that moves, now and then of another size or of too few bytes. */
function frameOf(below, t, [width, height]) {
  if (below(12) === 0) return plain(width + 1, height);
  if (below(20) === 0) return { data: new Uint8ClampedArray(7), width, height };
  if (below(40) === 0) return [null, 'frame', {}, new Uint8Array(9)][below(4)];
  return plain(width, height, (x, y) => (x >= t && x < t + 12 && y > 4 && y < 16 ? 250 : (x * 31 + y * 17) % 97));
}

function tracksOf(below, [width, height]) {
  const count = below(20);
  const odd = () => [0, 1, 3, 4294967294, 4294967295][below(5)];
  const tracks = {
    numFrames: 2 + below(6),
    width,
    height,
    startFrame: Uint32Array.from({ length: count }, () => (below(30) === 0 ? odd() : 0)),
    offset: Uint32Array.from({ length: count + 1 }, (_, i) => (below(60) === 0 ? odd() : 2 * i)),
    x: Float32Array.from({ length: 2 * count }, () => (below(60) === 0 ? NaN : below(width))),
    y: Float32Array.from({ length: 2 * count }, () => (below(60) === 0 ? 1e30 : below(height))),
  };
  return tracks;
}

const stroke = (below) => ({
  t: below(5),
  points: [
    [below(40), below(30)],
    [below(40) - 2, below(30)],
  ],
  radius: below(4),
});

/** A run's signal, aborted before, while it runs, or never. */
function runOptions(below) {
  const controller = new AbortController();
  if (below(3) > 0) return {};
  let steps = below(30);
  if (steps === 0) controller.abort();
  return { signal: controller.signal, onProgress: () => (steps -= 1) <= 0 && controller.abort() };
}

/** One call of any kind. */
function call(below, session, size, t) {
  const place = [below(6), below(45), below(35)];
  const calls = [
    () => session.run(runOptions(below)),
    () => session.clear(),
    () => session.setTrajectories(tracksOf(below, size)),
    () => session.merge(below(4), below(4), runOptions(below)),
    () => session.split(below(3), below(2) ? { t: place[0], x: place[1], y: place[2] } : undefined),
    () => session.together([stroke(below)]),
    () => session.apart([stroke(below), stroke(below)], runOptions(below)),
    () => session.undo(),
    () => session[['flow', 'boundaries', 'superpixels', 'background', 'saliencyMap'][below(5)]](place[0]),
    () => session.run(runOptions(below)).then((result) => result.explain(...place)),
    () => session.run().then((result) => result.labels(place[0])),
    () => void (below(6) === 0 && session.close()),
  ];
  return below(2) === 0 ? () => session.push(frameOf(below, t, size)) : calls[below(calls.length)];
}

/** Waits for a call; throws unless it ends well or as documented. */
async function settled(seed, act) {
  try {
    await act();
  } catch (error) {
    if (error?.name === 'AbortError') return;
    const known = error instanceof TraceCutError && CODES.includes(error.code);
    assert.ok(known || error instanceof RangeError, `seed ${seed}: ${error?.stack ?? error}`);
  }
}

async function play(seed) {
  const below = generator(seed);
  const size = [24 + below(20), 20 + below(14)];
  const options = [{}, { preset: 'fast' }, { threads: 1 }, { threads: 3 }, { clip: { dense: false } }][below(5)];
  const session = await createSession(options);
  const waiting = [];
  for (let t = 0; t < 4 + below(24); t += 1) {
    const outcome = settled(seed, call(below, session, size, t));
    if (below(3) === 0) waiting.push(outcome);
    else await outcome;
  }
  await Promise.all(waiting);
  if (below(2) === 0) session.close();
  await settled(seed, () => session.run());
  session.close();
  await assert.rejects(session.run(), { code: 'closed' });
}

test('random calls in any order end in what they promise, or in an error with a code', async () => {
  const clip = Array.from({ length: 4 }, (_, t) => plain(32, 24, (x, y) => (x > 2 * t && x < 2 * t + 9 ? 200 : x * y)));
  const expected = fingerprint(await segment(clip));
  for (let seed = first; seed < last; seed += 1) await play(seed);
  assert.equal(fingerprint(await segment(clip)), expected);
});
