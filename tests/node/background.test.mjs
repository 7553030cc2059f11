// The scene without the objects.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { synthClip } from 'tracecut';
import { framesOf, open, ready, rejects } from './support.mjs';

const SCENE = { width: 256, height: 144, frames: 8, seed: 5 };

test('a background has the pixels of the frame where no object is near, and others or holes behind objects', async (t) => {
  const [clip, frames] = [await synthClip(SCENE), await framesOf(SCENE)];
  const session = await ready(t, {}, frames);
  await rejects(session.background(0), 'state', /background of frame 0/);
  const result = await session.run();
  assert.ok(result.objects.length > 0);
  const [frame, labels, plate] = [clip.frame(3).data, result.labels(3), await result.background(3)];
  assert.deepEqual([plate.width, plate.height, plate.scaleX, plate.scaleY], [256, 144, 1, 1]);
  assert.ok(plate.data instanceof Uint8ClampedArray);
  assert.deepEqual(await session.background(3), plate);
  const near = (p) => {
    for (let y = -2; y <= 2; y += 1) for (let x = -2; x <= 2; x += 1) if (labels[p + 256 * y + x]) return true;
    return false;
  };
  let [own, other, holes] = [0, 0, 0];
  for (let y = 2; y < 142; y += 1) {
    for (let x = 2; x < 254; x += 1) {
      const p = 256 * y + x;
      const [seen, there] = [plate.data.subarray(4 * p, 4 * p + 4), frame.subarray(4 * p, 4 * p + 4)];
      if (!near(p)) {
        assert.deepEqual([...seen], [...there]);
        own += 1;
      } else if (seen[3] === 0) holes += 1;
      else {
        assert.equal(seen[3], 255);
        other += Number(seen.some((value, c) => value !== there[c]));
      }
    }
  }
  assert.ok(own > 10_000 && other > 1000 && holes > 0, `${own} ${other} ${holes}`);
  await rejects(result.background(8), 'param', /t = 8/);
});

test('the background has the smaller size at which frames are processed', async (t) => {
  const session = await ready(t, { clip: { maxSide: 128 } }, await framesOf(SCENE));
  const { width, height, scaleX, scaleY, data } = await (await session.run()).background(7);
  assert.deepEqual([width, height, scaleX, scaleY, data.length], [128, 72, 2, 2, 4 * 128 * 72]);
});

test('without masks there is no background', async (t) => {
  const session = await ready(t, { clip: { dense: false } });
  await rejects((await session.run()).background(0), 'state', /no backgrounds/);
  const closed = await open(t);
  closed.close();
  await rejects(closed.background(0), 'closed');
});
