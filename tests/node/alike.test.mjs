// Objects that look like one thing: they touch, and move alike against the background.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { alikeObjects } from '../../studio/model/alike.js';

const [width, height, numFrames] = [96, 64, 12];

/** Boxes `[left, top, width, height]` that move by `[dx, dy]` a frame; the scene moves by `pan`. */
function seen(boxes, pan = 0) {
  const at = ({ box, step }, t) => [box[0] + step[0] * t, box[1] + step[1] * t];
  const labels = (t) => {
    const mask = new Uint8Array(width * height);
    boxes.forEach((one, k) => {
      if (one.until !== undefined && t > one.until) return;
      const [left, top] = at(one, t).map(Math.round);
      for (let y = top; y < top + one.box[3]; y += 1)
        for (let x = left; x < left + one.box[2]; x += 1)
          if (x >= 0 && y >= 0 && x < width && y < height) mask[y * width + x] = k + 1;
    });
    return mask;
  };
  const tracks = boxes.flatMap((one) => [3, 6].map((by) => ({ one, by })));
  const places = tracks.flatMap(({ one, by }) =>
    Array.from({ length: numFrames }, (_, t) => at(one, t).map((v) => v + by)),
  );
  return {
    ...{ width, height, numFrames, labels },
    trajectories: {
      count: tracks.length,
      startFrame: tracks.map(() => 0),
      offset: Array.from({ length: tracks.length + 1 }, (_, k) => k * numFrames),
      x: places.map(([x]) => x),
      y: places.map(([, y]) => y),
    },
    scene: { x: Array.from({ length: numFrames }, (_, t) => pan * t), y: new Array(numFrames).fill(0) },
  };
}

const one = { box: [4, 4, 10, 10], step: [2, 0.5] };

test('parts that touch and move alike are one group, the largest first; a chain is one group', () => {
  const middle = { box: [14, 4, 12, 12], step: [2.1, 0.5] };
  const last = { box: [27, 4, 8, 8], step: [2, 0.6] };
  assert.deepEqual(alikeObjects(seen([one, middle, last])), [[2, 1, 3]]);
});

test('what moves otherwise, or stands apart, is none', () => {
  assert.deepEqual(alikeObjects(seen([one, { box: [14, 4, 12, 12], step: [1, 0.5] }])), []);
  assert.deepEqual(alikeObjects(seen([one, { box: [30, 4, 10, 10], step: [2, 0.5] }])), []);
  assert.deepEqual(alikeObjects(seen([one])), []);
});

test('two that rest in the scene say nothing, also where the camera pans', () => {
  const others = [one, { box: [14, 4, 10, 10], step: [2, 0.5] }].map((part) => ({ ...part, step: [2, 0] }));
  assert.deepEqual(alikeObjects(seen(others, 0)), [[1, 2]]);
  assert.deepEqual(alikeObjects(seen(others, 2)), []);
});

test('only frames in which both are there count', () => {
  assert.deepEqual(alikeObjects(seen([one, { box: [14, 4, 10, 10], step: [2, 0.5], until: 3 }])), [[1, 2]]);
});

test('without trajectories nothing is known', () => {
  const { trajectories, ...rest } = seen([one, { box: [14, 4, 10, 10], step: [2, 0.5] }]);
  assert.deepEqual(alikeObjects({ ...rest, trajectories: { ...trajectories, count: 0 } }), []);
});
