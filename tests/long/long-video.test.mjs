// A clip of 320 frames: bounded memory, and objects that keep their labels from window to window.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { segmentVideo, synthClip } from '../../dist/node/index.js';

const MAX_MEMORY_RATIO = 1.3;

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
      assert.ok(windows.length >= 4, `object ${object} is found in ${windows.length} windows`);
      return new Set(windows);
    });
    // The first and the third object are always visible. The second is occluded twice, and no trajectory survives that.
    assert.deepEqual([labels[0].size, labels[2].size], [1, 1]);
    assert.ok(labels[1].size <= 2, `${labels[1].size} labels`);
    const distinct = labels.flatMap((set) => [...set]);
    assert.equal(new Set(distinct).size, distinct.length, 'two objects have the same label');
  });

/** Runs `segmentLong` in a process of its own, whose peak memory is known. */
function segmentInProcess(numFrames) {
  const args = ['--expose-gc', fileURLToPath(import.meta.url), 'segment', String(numFrames)];
  const { NODE_TEST_CONTEXT, ...env } = process.env;
  return JSON.parse(execFileSync(process.execPath, args, { encoding: 'utf8', env }));
}

/** Segments a synthetic clip frame by frame and keeps only counts. */
async function segmentLong(numFrames) {
  const scene = await synthClip({ width: 320, height: 180, frames: numFrames, seed: 0 });
  async function* stream() {
    for (let t = 0; t < numFrames; t += 1) yield scene.frame(t);
  }
  const outcome = { indices: [], shots: new Set(), memoryBytes: 0, peakBytes: 0, votes: [] };
  for await (const window of segmentVideo(stream())) {
    // votes[object][label]: pixels of the object that have the label.
    const votes = Array.from({ length: scene.numObjects + 1 }, () => ({}));
    for (const { index, labels } of window.frames()) {
      outcome.indices.push(index);
      scene.mask(index).forEach((object, p) => (votes[object][labels[p]] = (votes[object][labels[p]] ?? 0) + 1));
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
