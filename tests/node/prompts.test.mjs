// Prompts for models that follow an object from a hint.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { fromCocoRle, prompts } from 'tracecut/export';

const [width, height] = [60, 40];

/** Object 3 is largest in frame 1, object 7 in frame 2; both lie in other places in each frame. */
const made = {
  width,
  height,
  numFrames: 3,
  labels: (t) =>
    Uint8Array.from({ length: width * height }, (_, p) => {
      const [x, y] = [p % width, Math.floor(p / width)];
      if (x >= 10 + t && x < [15, 31, 18][t] && y >= 10 && y < [15, 21, 16][t]) return 3;
      return x >= 45 && x < 48 + 3 * t && y >= 20 + t && y < 30 ? 7 : 0;
    }),
};

test('each object has its best frame, its box, three points on it and three beside it, and its mask', async () => {
  const { prompts: found, ...rest } = await prompts(made);
  assert.deepEqual([rest.width, rest.height, rest.times], [width, height, undefined]);
  assert.deepEqual((await prompts({ ...made, times: [1, 2, 4] })).times, [1, 2, 4]);
  assert.deepEqual(
    found.map(({ obj_id, frame_idx, box }) => [obj_id, frame_idx, box]),
    [
      [3, 1, [11, 10, 30, 20]],
      [7, 2, [45, 22, 53, 29]],
    ],
  );
  for (const { obj_id, frame_idx, points, labels, mask } of found) {
    const truth = made.labels(frame_idx);
    assert.deepEqual(labels, [1, 1, 1, 0, 0, 0]);
    points.forEach(([x, y], k) => assert.equal(truth[y * width + x] === obj_id, labels[k] === 1));
    const pixels = await fromCocoRle(mask);
    assert.deepEqual(
      pixels,
      truth.map((label) => Number(label === obj_id)),
    );
  }
  assert.equal(found[0].points[0][1], 15, 'the first lies on the middle line');
});

test('of windows, frames have the numbers of the clip, and objects can be chosen', async () => {
  const { prompts: found } = await prompts({ ...made, firstFrame: 50 }, { objects: [7] });
  assert.deepEqual(
    found.map(({ obj_id, frame_idx }) => [obj_id, frame_idx]),
    [[7, 52]],
  );
  assert.deepEqual((await prompts({ ...made, labels: () => new Uint8Array(width * height) })).prompts, []);
  await assert.rejects(prompts({ ...made, numFrames: 0 }), { code: 'data' });
  await assert.rejects(prompts(made, { object: 7 }), { code: 'param' });
});
