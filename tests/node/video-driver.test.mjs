// How a clip is cut into windows, with an engine that only counts; where they lie is the wasm module's own answer.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { getRequestSpec } from '../../dist/session/requests.js';
import { Driver } from '../../dist/video/window.js';
import { startInstance } from '../../dist/worker/instance.js';
import { compileWasm } from './support.mjs';

const { glue } = await startInstance(await compileWasm());

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

/** Returns the shot, the frames of the clip and the settled ones of each window; ends are not included. */
const describeWindows = (windows) =>
  windows.map(({ shot, firstFrame, numFrames, settled: { from, to } }) => {
    const [begin, end] = [firstFrame + from, firstFrame + to];
    return `shot ${shot}: ${firstFrame} to ${firstFrame + numFrames}, settled ${begin} to ${end}`;
  });

test('each frame is settled once, in order, with its own time and mask, however long the clip, the window, the overlap and the shots', async () => {
  for (const window of [2, 3, 5, 8]) {
    for (let overlap = 1; overlap < window; overlap += 1) {
      for (const frames of [1, 2, 3, 4, 5, 8, 9, 12, 15, 20]) {
        for (const cuts of [[], [1], [window], [window + 1], [3, 4], [window, window + 1, window + 2]]) {
          const isLengthKnown = frames % 2 === 0;
          const { engine, windows, outputs } = await drive({ frames, window, overlap, cuts, isLengthKnown });
          const where = JSON.stringify({ frames, window, overlap, cuts, isLengthKnown });
          const facts = outputs.map(({ index, labels, time }) => [index, labels[0], time]);
          const expectedFacts = outputs.map((_, k) => [k, k, k / 10]);
          assert.deepEqual(facts, expectedFacts, where);
          assert.ok(engine.most <= window, `${engine.most} frames in a window: ${where}`);
          assert.equal(engine.runs, windows.length, where);
          const shots = outputs.map(
            ({ index }) =>
              windows.find((w) => w.firstFrame + w.settled.from <= index && index < w.firstFrame + w.settled.to).shot,
          );
          const expectedShots = outputs.map(({ index }) => cuts.filter((cut) => cut <= index).length);
          assert.deepEqual(shots, expectedShots, where);
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
          describeWindows(mine),
          describeWindows(expected.windows),
          JSON.stringify({ lengths, cuts, k }),
        );
      }
    }
  }
});

const LONG = { window: 50, overlap: 10 };
const SHORT = { window: 8, overlap: 4 };

for (const [words, options, ...expected] of [
  [
    'of frames that two windows share the first half is settled by the earlier one',
    { ...LONG, frames: 90 },
    ...['shot 0: 0 to 50, settled 0 to 45', 'shot 0: 40 to 90, settled 45 to 90'],
  ],
  ['a clip of just a window is one window', { ...LONG, frames: 50 }, 'shot 0: 0 to 50, settled 0 to 50'],
  [
    'a clip of one frame more than a window is two windows',
    { ...LONG, frames: 51 },
    ...['shot 0: 0 to 50, settled 0 to 45', 'shot 0: 40 to 51, settled 45 to 51'],
  ],
  // Where the number of frames is known, each window settles the frames that it is in the middle of.
  [
    'the last window is full where the number of frames is known to be one more than a window',
    { ...LONG, frames: 51, isLengthKnown: true },
    ...['shot 0: 0 to 50, settled 0 to 25', 'shot 0: 1 to 51, settled 25 to 51'],
  ],
  [
    'full windows stay where they are where the number of frames is known',
    { ...LONG, frames: 90, isLengthKnown: true },
    ...['shot 0: 0 to 50, settled 0 to 45', 'shot 0: 40 to 90, settled 45 to 90'],
  ],
  [
    'the last of three windows is full where the number of frames is known',
    { ...LONG, frames: 97, isLengthKnown: true },
    ...['shot 0: 0 to 50, settled 0 to 45', 'shot 0: 40 to 90, settled 45 to 68', 'shot 0: 47 to 97, settled 68 to 97'],
  ],
  [
    'a cut right after a full window runs nothing twice: the full window settles all of its frames',
    { ...SHORT, frames: 12, cuts: [8] },
    ...['shot 0: 0 to 8, settled 0 to 8', 'shot 1: 8 to 12, settled 8 to 12'],
  ],
  [
    'a cut elsewhere ends the window at hand, whose frames are all settled',
    { ...SHORT, frames: 10, cuts: [3, 4] },
    ...['shot 0: 0 to 3, settled 0 to 3', 'shot 1: 3 to 4, settled 3 to 4', 'shot 2: 4 to 10, settled 4 to 10'],
  ],
])
  test(words, async () => {
    const { windows, engine } = await drive(options);
    assert.deepEqual(describeWindows(windows), expected);
    assert.equal(engine.runs, expected.length);
  });
