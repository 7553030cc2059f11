// Pieces of objects, and objects divided among strokes.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { divideRegions, pieceRegion } from 'tracecut/edit';

const [WIDTH, HEIGHT] = [20, 10];
const maskOf = (label) => ({
  width: WIDTH,
  height: HEIGHT,
  labels: Uint8Array.from({ length: WIDTH * HEIGHT }, (_, p) => label(p % WIDTH, Math.floor(p / WIDTH))),
});
const placesOf = (region) => {
  const places = [];
  for (let k = 0; k < region.length; k += 2)
    for (let p = region[k]; p < region[k] + region[k + 1]; p += 1) places.push([p % WIDTH, Math.floor(p / WIDTH)]);
  return places;
};

test('a piece is what hangs together, corners and all, and of one label', () => {
  const mask = maskOf((x, y) => (x < 4 && y < 3 ? 2 : x === 4 && y === 3 ? 2 : x > 10 && y < 3 ? 2 : x === 5 ? 1 : 0));
  const piece = placesOf(pieceRegion(mask, { x: 1.2, y: 0.8 }));
  assert.equal(piece.length, 13);
  assert.ok(piece.every(([x]) => x <= 4));
  assert.equal(placesOf(pieceRegion(mask, { x: 12, y: 1 })).length, 27);
  assert.throws(() => pieceRegion(mask, { x: 20, y: 1 }), { code: 'param', message: /x = 20/ });
});

test('an object is divided by what is nearest, and nothing else is touched', () => {
  const mask = maskOf((x, y) => (y >= 2 && y < 8 && x >= 2 && x < 18 ? 3 : x === 0 ? 1 : 0));
  const stroke = (x) => ({ t: 0, points: [x, 3, x, 6], radius: 1 });
  const { label, regions } = divideRegions(mask, [stroke(4), stroke(13)]);
  assert.equal(label, 3);
  const [left, right] = regions.map(placesOf);
  assert.equal(left.length + right.length, 6 * 16);
  assert.ok(left.every(([x]) => x <= 8) && right.every(([x]) => x >= 9));
  assert.throws(() => divideRegions(mask, [stroke(4)]), { code: 'param', message: /two or more/ });
  const beside = { t: 0, points: [10, 0], radius: 0.5 };
  assert.throws(() => divideRegions(mask, [beside, beside]), { code: 'param', message: /on an object/ });
});
