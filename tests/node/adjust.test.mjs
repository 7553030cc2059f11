// Specks, growing, shrinking and soft edges of masks, against what is plainly so.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { adjustMask, masksAtSize } from 'tracecut/edit';
import { plain } from './support.mjs';

const [WIDTH, HEIGHT] = [37, 23];

/** Labels as a function says. */
const maskOf = (label, width = WIDTH, height = HEIGHT) => ({
  width,
  height,
  labels: Uint8Array.from({ length: width * height }, (_, p) => label(p % width, Math.floor(p / width))),
});

/** Blobs of three labels, some of them specks, the same in each run. */
function blobs(seed) {
  let state = seed;
  const random = (below) => {
    state = (Math.imul(state, 1103515245) + 12345) >>> 0;
    return (state >>> 8) % below;
  };
  const discs = Array.from({ length: 12 }, () => [random(WIDTH), random(HEIGHT), 0.5 + random(5), 1 + random(3)]);
  return maskOf((x, y) => discs.reduce((now, [cx, cy, r, l]) => (Math.hypot(x - cx, y - cy) <= r ? l : now), 0));
}

const distance = (a, b, width) => Math.hypot((a % width) - (b % width), Math.floor(a / width) - Math.floor(b / width));

test('nothing is done where nothing is asked', () => {
  const mask = blobs(3);
  const { labels, alpha, width, height } = adjustMask(mask);
  assert.deepEqual([width, height], [WIDTH, HEIGHT]);
  assert.deepEqual(labels, mask.labels);
  assert.notEqual(labels, mask.labels);
  assert.deepEqual(
    alpha,
    mask.labels.map((label) => (label > 0 ? 255 : 0)),
  );
  const only = adjustMask(mask, { objects: [2] });
  assert.deepEqual(
    only.alpha,
    mask.labels.map((label) => (label === 2 ? 255 : 0)),
  );
});

test('pieces that are too small become background, those of other objects stay', () => {
  // A piece of 4 pixels that touch at corners, one of 3, one of 3 of another label.
  const mask = maskOf((x, y) => {
    if (x === y && x < 4) return 1;
    if (y === 10 && x > 20 && x < 24) return 1;
    return y === 15 && x > 20 && x < 24 ? 2 : 0;
  });
  const count = (labels, wanted) => labels.filter((label) => label === wanted).length;
  const { labels } = adjustMask(mask, { smallest: 4 });
  assert.deepEqual([count(labels, 1), count(labels, 2)], [4, 0]);
  const chosen = adjustMask(mask, { smallest: 4, objects: [1] });
  assert.deepEqual([count(chosen.labels, 1), count(chosen.labels, 2)], [4, 3]);
  assert.deepEqual(adjustMask(mask, { smallest: 3 }).labels, mask.labels);
});

test('objects grow and shrink by exact distances', () => {
  for (const seed of [1, 2, 5, 9]) {
    const mask = blobs(seed);
    const { labels: before } = mask;
    for (const grow of [1, 1.5, 2.9, 7, -1, -1.5, -3, -40]) {
      const { labels: after } = adjustMask(mask, { grow });
      for (let p = 0; p < before.length; p += 1) {
        const others = [...before.keys()].filter((q) => (grow > 0 ? before[q] > 0 : before[q] === 0));
        const nearest = Math.min(Infinity, ...others.map((q) => distance(p, q, WIDTH)));
        const where = `pixel ${p}, seed ${seed}, grow ${grow}`;
        if (grow < 0) assert.equal(after[p], before[p] > 0 && nearest <= -grow ? 0 : before[p], where);
        else if (before[p] > 0) assert.equal(after[p], before[p], where);
        else if (nearest > grow) assert.equal(after[p], 0, where);
        else {
          const labels = others.filter((q) => distance(p, q, WIDTH) <= nearest + 1e-9).map((q) => before[q]);
          assert.ok(labels.includes(after[p]), where);
        }
      }
    }
  }
});

test('only chosen objects grow, and not over others', () => {
  const mask = maskOf((x) => (x < 5 ? 1 : x < 10 ? 2 : 0));
  const { labels } = adjustMask(mask, { grow: 3, objects: [1] });
  assert.deepEqual(labels, mask.labels);
  assert.equal(adjustMask(mask, { grow: 3, objects: [2] }).labels[12], 2);
  assert.equal(adjustMask(mask, { grow: 3, objects: [2] }).labels[13], 0);
});

test('edges fade within the feather, evenly on both sides, and nowhere else', () => {
  const mask = maskOf((x) => (x < 18 ? 1 : 0));
  for (const feather of [1, 2, 3, 5, 8, 11]) {
    const { alpha, labels } = adjustMask(mask, { feather });
    assert.deepEqual(labels, mask.labels);
    const row = [...alpha.subarray(5 * WIDTH, 6 * WIDTH)];
    row.forEach((value, x) => {
      assert.ok(x === 0 || value <= row[x - 1], `feather ${feather} rises at ${x}`);
      if (x < 18 - feather) assert.equal(value, 255, `feather ${feather} at ${x}`);
      if (x >= 18 + feather) assert.equal(value, 0, `feather ${feather} at ${x}`);
    });
    assert.ok(row[17] > 127 && row[18] < 128 && Math.abs(row[17] + row[18] - 255) <= 4, `${row[17]} ${row[18]}`);
    assert.ok(row[18 + feather - 1] > 0 || feather > 5, `feather ${feather} ends early`);
  }
});

test('values that are not legal are refused', () => {
  const mask = blobs(1);
  const refused = (given, options, message) => assert.throws(() => adjustMask(given, options), { message });
  refused(mask, { grow: 101 }, /grow = 101 \(expected a number, -100\.\.=100/);
  refused(mask, { feather: -1 }, /feather = -1 \(expected a number, 0\.\.=100/);
  refused(mask, { smallest: NaN }, /smallest = NaN/);
  refused(mask, { blur: 1 }, /blur = 1 \(expected no such option/);
  refused({ ...mask, width: 3 }, {}, /mask\.labels has 851 labels \(expected 69\)/);
  refused(null, {}, /mask = null/);
});

test('exports at another size grow as much as is seen, and leave specks out', async () => {
  const mask = maskOf((x, y) => (x >= 10 && x < 20 && y >= 8 && y < 16 ? 1 : x === 2 && y === 2 ? 2 : 0));
  const masks = { width: WIDTH, height: HEIGHT, numFrames: 1, labels: () => mask.labels };
  const edges = { smallest: 4, grow: 2 };
  const inside = (x, y) => x >= 30 && x < 60 && y >= 24 && y < 48;
  const picture = plain(3 * WIDTH, 3 * HEIGHT, (x, y) => (inside(x, y) ? 200 : 60));
  const large = await masksAtSize(masks, [picture], { edges });
  const labels = large.labels(0);
  assert.ok(!labels.includes(2));
  const row = [...labels.subarray(3 * 11 * 3 * WIDTH, (3 * 11 + 1) * 3 * WIDTH)];
  assert.deepEqual([row.indexOf(1), row.lastIndexOf(1)], [30 - 6, 59 + 6]);
});
