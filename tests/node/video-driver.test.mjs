// How a clip is cut into windows, with an engine that only counts; where they lie is the wasm module's own answer.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { getRequestSpec } from '../../dist/session/requests.js';
import { Driver } from '../../dist/video/window.js';
import { startInstance } from '../../dist/worker/instance.js';

const wasm = new URL('../../dist/tracecut_bg.wasm', import.meta.url);
const { glue } = await startInstance(new WebAssembly.Module(readFileSync(wasm)));

/** An engine that keeps the numbers of its frames, and holds back those that begin a shot. */
class CountingEngine {
  frames = [];
  held = null;
  runs = 0;
  most = 0;

  constructor(cuts) {
    Object.assign(this, { cuts, session: new glue.Session(undefined) });
  }

  async request(name, ...args) {
    return this[name] ? this[name](...args) : getRequestSpec(name).work(...args)(this.session);
  }

  async pushInShot({ number }) {
    assert.equal(this.held, null, 'a frame is pushed while another is held back');
    const isCutPending = this.frames.length > 0 && this.cuts.includes(number);
    if (isCutPending) this.held = number;
    else this.frames.push(number);
    this.most = Math.max(this.most, this.frames.length);
    return { held: isCutPending };
  }

  async advance(overlap) {
    this.frames = this.held === null ? this.frames.slice(-overlap) : [this.held];
    this.held = null;
  }

  async clear() {
    Object.assign(this, { frames: [], held: null });
    this.session.clear();
  }

  async run() {
    assert.ok(this.frames.length > 0, 'an empty window is run');
    this.runs += 1;
    const info = { width: 1, height: 1, numFrames: this.frames.length };
    return {
      info,
      clusters: {},
      labels: Uint8Array.from(this.frames, (number) => number % 256),
      numbers: [...this.frames],
    };
  }
}

async function drive({ frames, window, overlap, cuts = [], clips = [], isLengthKnown = false }) {
  const engine = new CountingEngine(cuts);
  await engine.request('planWindows', window, overlap);
  let number = 0;
  const clipOf = (at) => (clips.length ? `clip ${clips.filter((begin) => begin <= at).length}` : undefined);
  const nextFrame = async () => {
    const at = number++;
    return at < frames ? { raw: { number: at }, time: at / 10, clip: clipOf(at) } : null;
  };
  const stop = new AbortController().signal;
  const driver = new Driver({
    engine,
    nextFrame,
    countRemaining: () => (isLengthKnown ? Math.max(0, frames - number) : null),
    window,
    stop,
    onStage() {},
    onFrame() {},
  });
  const windows = [];
  for (let result = await driver.next(); result; result = await driver.next()) windows.push(result);
  windows.forEach(({ index }, k) => assert.equal(index, k));
  const outputs = windows.flatMap((result) => [...result.frames()]);
  outputs.forEach(({ labels }, k) => assert.equal(labels[0], k));
  assert.equal(outputs.length, frames);
  return { engine, windows, outputs };
}

/** Returns the first frame of a window, the number of its frames, and which of them are settled. */
const spanOf = (window) => [window.firstFrame, window.numFrames, window.settled];
const shotAndSpanOf = (window) => [window.shot, ...spanOf(window)];

test('each frame is settled once, in order, with its own time and mask, however long the clip, the window, the overlap and the shots', async () => {
  for (const window of [2, 3, 5, 8]) {
    for (let overlap = 1; overlap < window; overlap += 1) {
      for (const frames of [1, 2, 3, 4, 5, 8, 9, 12, 15, 20]) {
        for (const cuts of [[], [1], [window], [window + 1], [3, 4], [window, window + 1, window + 2]]) {
          const isLengthKnown = frames % 2 === 0;
          const { engine, windows, outputs } = await drive({ frames, window, overlap, cuts, isLengthKnown });
          const where = JSON.stringify({ frames, window, overlap, cuts, isLengthKnown });
          assert.deepEqual(
            outputs.map(({ index, labels, time }) => [index, labels[0], time]),
            Array.from({ length: frames }, (_, k) => [k, k, k / 10]),
            where,
          );
          assert.ok(engine.most <= window, `${engine.most} frames in a window: ${where}`);
          assert.equal(engine.runs, windows.length, where);
          const shots = outputs.map(
            ({ index }) =>
              windows.find((w) => w.firstFrame + w.settled.from <= index && index < w.firstFrame + w.settled.to).shot,
          );
          assert.deepEqual(
            shots,
            outputs.map(({ index }) => cuts.filter((cut) => cut <= index).length),
            where,
          );
        }
      }
    }
  }
});

test('a clip in a stream of several comes in the windows that it has alone', async () => {
  for (const lengths of [
    [1, 1, 1],
    [5, 6, 7],
    [6, 1, 12],
    [13, 3],
  ]) {
    for (const cuts of [[], [2], [5], [6], [1, 2, 3], [5, 6]]) {
      const begins = lengths.map((_, k) => lengths.slice(0, k).reduce((sum, length) => sum + length, 0));
      const frames = lengths.reduce((sum, length) => sum + length, 0);
      const { windows } = await drive({ frames, window: 6, overlap: 2, cuts, clips: begins });
      for (const [k, begin] of begins.entries()) {
        const clipCuts = cuts.map((cut) => cut - begin).filter((cut) => cut > 0);
        const expected = await drive({ frames: lengths[k], window: 6, overlap: 2, cuts: clipCuts });
        const mine = windows.filter(({ clip }) => clip === `clip ${k + 1}`);
        assert.deepEqual(
          mine.map(shotAndSpanOf),
          expected.windows.map(shotAndSpanOf),
          JSON.stringify({ lengths, cuts, k }),
        );
      }
    }
  }
});

test('of frames that two windows share the first half is settled by the earlier one', async () => {
  const { windows } = await drive({ frames: 90, window: 50, overlap: 10 });
  assert.deepEqual(windows.map(spanOf), [
    [0, 50, { from: 0, to: 45 }],
    [40, 50, { from: 5, to: 50 }],
  ]);
});

test('a clip of just a window, and one more frame, are one window and two', async () => {
  assert.equal((await drive({ frames: 50, window: 50, overlap: 10 })).windows.length, 1);
  const { windows } = await drive({ frames: 51, window: 50, overlap: 10 });
  assert.deepEqual(windows.map(spanOf), [
    [0, 50, { from: 0, to: 45 }],
    [40, 11, { from: 5, to: 11 }],
  ]);
});

test('where the number of frames is known the last window is full too, and each window settles what it is in the middle of', async () => {
  for (const [frames, expected] of [
    [
      51,
      [
        [0, 50, { from: 0, to: 25 }],
        [1, 50, { from: 24, to: 50 }],
      ],
    ],
    [
      90,
      [
        [0, 50, { from: 0, to: 45 }],
        [40, 50, { from: 5, to: 50 }],
      ],
    ],
    [
      97,
      [
        [0, 50, { from: 0, to: 45 }],
        [40, 50, { from: 5, to: 28 }],
        [47, 50, { from: 21, to: 50 }],
      ],
    ],
  ]) {
    const { windows } = await drive({ frames, window: 50, overlap: 10, isLengthKnown: true });
    assert.deepEqual(windows.map(spanOf), expected);
  }
});

test('a cut right after a full window runs nothing twice: the full window settles all of its frames', async () => {
  const { windows, engine } = await drive({ frames: 12, window: 8, overlap: 4, cuts: [8] });
  assert.deepEqual(windows.map(shotAndSpanOf), [
    [0, 0, 8, { from: 0, to: 8 }],
    [1, 8, 4, { from: 0, to: 4 }],
  ]);
  assert.equal(engine.runs, 2);
});

test('a cut elsewhere ends the window at hand, whose frames are all settled', async () => {
  const { windows } = await drive({ frames: 10, window: 8, overlap: 4, cuts: [3, 4] });
  assert.deepEqual(windows.map(shotAndSpanOf), [
    [0, 0, 3, { from: 0, to: 3 }],
    [1, 3, 1, { from: 0, to: 1 }],
    [2, 4, 6, { from: 0, to: 6 }],
  ]);
});
