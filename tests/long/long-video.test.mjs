// A clip of 320 frames: bounded memory, and objects that keep their labels from window to window.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { segmentVideo } from '../../dist/node/index.js';
import { plainFrame, textureAt } from '../moving.mjs';

const MAX_MEMORY_RATIO = 1.3;
const [WIDTH, HEIGHT] = [320, 180];
/** Each of three objects, squares of this side, has rows of its own. */
const [SIDE, ROWS] = [44, 60];

if (process.argv[2] === 'segment') console.log(JSON.stringify(await segmentLong(Number(process.argv[3]))));
else
  test('takes hardly more memory than a clip of 100 frames, and objects keep their labels', (t) => {
    const [short, long] = [100, 320].map(segmentInProcess);
    assert.deepEqual(
      long.indices,
      Array.from({ length: 320 }, (_, k) => k),
    );
    for (const kind of ['memoryBytes', 'peakBytes']) {
      const ratio = long[kind] / short[kind];
      t.diagnostic(`${kind}: ${megabytes(long[kind])} and ${megabytes(short[kind])}, ${ratio.toFixed(3)}`);
      assert.ok(ratio <= MAX_MEMORY_RATIO, `${kind}: ${ratio}`);
    }
    assert.deepEqual(long.shots, [0]);
    const labels = [1, 2, 3].map((object) => {
      const windows = long.votes.map((votes) => mostCommon(votes[object])).filter((label) => label > 0);
      t.diagnostic(`object ${object} is found in ${windows.length} of ${long.votes.length} windows, as ${windows}`);
      assert.ok(windows.length > long.votes.length / 2, `object ${object} is found in ${windows.length} windows`);
      return [...new Set(windows)];
    });
    assert.deepEqual(labels.flat().sort(), [1, 2, 3], 'each object has one label, and no two have the same');
  });

/** Runs `segmentLong` in a process of its own, whose peak memory is known. */
function segmentInProcess(numFrames) {
  const args = ['--expose-gc', fileURLToPath(import.meta.url), 'segment', String(numFrames)];
  const { NODE_TEST_CONTEXT, ...env } = process.env;
  return JSON.parse(execFileSync(process.execPath, args, { encoding: 'utf8', env }));
}

/** Left side of an object, which goes to and fro. */
function leftOf(object, t) {
  const span = WIDTH - SIDE;
  const way = (t * (3.5 - 0.5 * object) + 70 * object) % (2 * span);
  return Math.round(way < span ? way : 2 * span - way);
}

/** The object at a pixel, 0 for none. */
function objectAt(x, y, t) {
  const object = Math.floor(y / ROWS) + 1;
  const [right, down] = [x - leftOf(object, t), (y % ROWS) - 8];
  return right >= 0 && right < SIDE && down >= 0 && down < SIDE ? object : 0;
}

/** Grey value of smooth spots of six pixels. */
function spotsAt(x, y, salt) {
  const [column, row] = [Math.floor(x / 6), Math.floor(y / 6)];
  const [right, down] = [x / 6 - column, y / 6 - row];
  const across = (r) =>
    textureAt(2 * column, 2 * r, salt) * (1 - right) + textureAt(2 * column + 2, 2 * r, salt) * right;
  return across(row) * (1 - down) + across(row + 1) * down;
}

/** Segments three squares before a scene, frame by frame, and keeps only counts. */
async function segmentLong(numFrames) {
  async function* stream() {
    for (let t = 0; t < numFrames; t += 1)
      yield plainFrame(WIDTH, HEIGHT, (x, y) => {
        const object = objectAt(x, y, t);
        return Array(3).fill(spotsAt(object ? x - leftOf(object, t) : x, y, object));
      });
  }
  const outcome = { indices: [], shots: new Set(), memoryBytes: 0, peakBytes: 0, votes: [] };
  for await (const window of segmentVideo(stream())) {
    // votes[object][label]: pixels of the object that have the label.
    const votes = Array.from({ length: 4 }, () => ({}));
    for (const { index, labels } of window.frames()) {
      outcome.indices.push(index);
      labels.forEach((label, p) => {
        const object = objectAt(p % WIDTH, Math.floor(p / WIDTH), index);
        votes[object][label] = (votes[object][label] ?? 0) + 1;
      });
    }
    outcome.votes.push(votes);
    outcome.shots.add(window.shot);
    outcome.memoryBytes = Math.max(outcome.memoryBytes, window.memoryBytes);
    globalThis.gc();
  }
  return { ...outcome, shots: [...outcome.shots], peakBytes: 1024 * process.resourceUsage().maxRSS };
}

const mostCommon = (votes) => Number(Object.entries(votes).sort(([, a], [, b]) => b - a)[0][0]);
const megabytes = (bytes) => `${(bytes / 2 ** 20).toFixed(1)} MB`;
