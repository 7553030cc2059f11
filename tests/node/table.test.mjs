// Objects frame by frame in numbers.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { segmentVideo, synthClip } from 'tracecut';
import { objectTable, objectTableCsv } from 'tracecut/export';
import { trajectories } from 'tracecut/stages';
import { framesOf } from './support.mjs';

const [width, height] = [12, 8];

/** The made clip of the Rust test of the same table. */
const made = {
  width,
  height,
  numFrames: 3,
  labels: (t) =>
    Uint8Array.from({ length: width * height }, (_, p) => {
      const [x, y] = [p % width, Math.floor(p / width)];
      if (x >= 1 + t && x < 5 + 2 * t && y >= 2 && y < 5) return 1;
      return t !== 1 && x + y > 16 ? 7 : 0;
    }),
  trajectories: {
    startFrame: [0, 0, 1, 0],
    offset: [0, 3, 5, 7, 9],
    x: Float32Array.of(1.25, 2.5, 4, 4.49, 5, 6, 5.75, 11.5, 11),
    y: Float32Array.of(2, 2.0625, 2.5, 4.49, 4, 4.5, 4.25, 7.5, 7),
  },
};

test('the table of a made clip is the one that native code writes', async () => {
  const expected = readFileSync(new URL('../data/objects.csv', import.meta.url), 'utf8');
  assert.equal(await objectTableCsv(await objectTable(made)), expected.replaceAll('\r', ''));
});

test('rows have times where there are any, and objects can be chosen', async () => {
  const rows = await objectTable(made, { frameRate: 10, objects: [7] });
  assert.deepEqual(
    rows.map(({ frame, time, object }) => [frame, time, object]),
    [
      [0, 0, 7],
      [2, 0.2, 7],
    ],
  );
  const [still] = await objectTable({ ...made, trajectories: undefined });
  assert.deepEqual([still.dx, still.dy, still.trajectories], [null, null, 0]);
  assert.match(await objectTableCsv(rows), /\n2,0\.2,7,10,6,2,2,3,10\.667,6\.667,,,0\n$/);
  assert.deepEqual(JSON.parse(JSON.stringify(rows)), rows);
  await assert.rejects(objectTable(made, { trajectories: {} }), { code: 'data' });
  await assert.rejects(objectTable(made, { motion: true }), { code: 'param' });
  await assert.rejects(objectTableCsv('rows'), { code: 'data' });
});

test('objects move as their trajectories say', async () => {
  const size = { width: 256, height: 144, numFrames: 8 };
  const clip = await synthClip({ width: 256, height: 144, frames: 8, seed: 1 });
  const tracks = await trajectories(Array.from({ length: 8 }, (_, t) => clip.frame(t)));
  const rows = await objectTable({ ...size, labels: (t) => clip.mask(t) }, { trajectories: tracks });
  const next = ({ frame, object }) => rows.find((row) => row.frame === frame + 1 && row.object === object);
  // The balloon and the van, which keep their shape; the walker does not.
  const moving = rows.filter((row) => row.object < 3 && next(row));
  assert.equal(moving.length, 14);
  for (const row of moving) {
    const { x, y } = next(row);
    assert.ok(row.trajectories > 30 && Math.hypot(row.dx, row.dy) > 1);
    assert.ok(Math.hypot(x - row.x - row.dx, y - row.y - row.dy) < 0.5, JSON.stringify(row));
  }
});

test("a segmented clip's rows have the areas and trajectories of its result", async () => {
  const result = await segmentVideo(await framesOf()).collect();
  const rows = await objectTable(result);
  assert.ok(result.objects.length > 0 && rows.some(({ trajectories: count }) => count > 0));
  for (const { label, areas } of result.objects) {
    const own = rows.filter(({ object }) => object === label);
    const present = [...areas].filter((area) => area > 0);
    assert.deepEqual(
      own.map(({ area }) => area),
      present,
    );
    assert.ok(own.every(({ time, frame }) => time === result.times[frame]));
  }
});
