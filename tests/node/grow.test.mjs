// What a click may mean: regions that grow from a place.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { decodeRuns, grownRegions } from 'tracecut/edit';
import { createImageEngine } from 'tracecut/stages';

const [WIDTH, HEIGHT] = [160, 120];

/** A disc of two colours that moves by three pixels over a textured ground. */
const inDisc = (x, y, shift) => Math.hypot(x - 70 - shift, y - 60) < 28;

function picture(shift) {
  const data = new Uint8Array(4 * WIDTH * HEIGHT);
  for (let p = 0; p < WIDTH * HEIGHT; p += 1) {
    const [x, y] = [p % WIDTH, Math.floor(p / WIDTH)];
    const inside = inDisc(x, y, shift);
    const u = inside ? x - shift : x;
    const texture = ((Math.floor(u / 4) * 7 + Math.floor(y / 4) * 13) % 5) * 9;
    const half = inside && u < 70;
    data.set(inside ? [half ? 190 : 150, 90 + texture, half ? 60 : 130, 255] : [60 + texture, 110, 100, 255], 4 * p);
  }
  return { data, width: WIDTH, height: HEIGHT };
}

const truth = Uint8Array.from({ length: WIDTH * HEIGHT }, (_, p) =>
  Number(inDisc(p % WIDTH, Math.floor(p / WIDTH), 0)),
);

function overlap(a, b) {
  let [both, any] = [0, 0];
  a.forEach((one, p) => ([both, any] = [both + (one & b[p]), any + (one | b[p])]));
  return both / any;
}

let grounds;
before(async () => {
  const engine = await createImageEngine();
  after(() => engine.close());
  const [now, next] = [picture(0), picture(3)];
  grounds = {
    superpixels: await engine.superpixels(now),
    flow: await engine.flow(now, next),
    picture: now,
  };
});

test('a click on a part of what moves gives the whole of it first', async () => {
  for (const place of [
    { x: 60, y: 60 },
    { x: 84, y: 70 },
  ]) {
    const [first] = await grownRegions(grounds, place);
    const found = overlap(decodeRuns(first), truth);
    assert.ok(found > 0.85, `${found.toFixed(2)} at ${place.x}, ${place.y}`);
    const { label } = grounds.superpixels;
    const piece = label.map((one) => Number(one === label[place.y * WIDTH + place.x]));
    assert.ok(overlap(piece, truth) < 0.6, 'one superpixel is less');
  }
});

test('regions hold the place, differ in size, and are the same each time', async () => {
  const place = { x: 60.4, y: 59.6 };
  const all = await grownRegions(grounds, place);
  assert.ok(all.length >= 2 && all.length <= 3, `${all.length} regions`);
  const areas = all.map((region) => decodeRuns(region).reduce((sum, one) => sum + one, 0));
  for (const [k, region] of all.entries()) {
    assert.equal(decodeRuns(region)[60 * WIDTH + 60], 1);
    for (const other of areas.slice(0, k))
      assert.ok(Math.min(other, areas[k]) < 0.7 * Math.max(other, areas[k]), areas.join(' '));
  }
  assert.deepEqual(await grownRegions(grounds, place), all);
});

test('what is wrong is named', async () => {
  const rejects = (given, place, message) => assert.rejects(grownRegions(given, place), message);
  await rejects(grounds, { x: 160, y: 3 }, /x = 160 \(expected .*0\.\.=159/);
  await rejects({ ...grounds, flow: { ...grounds.flow, width: 80 } }, { x: 1, y: 1 }, /flow = .*80 × 120.*160 × 120/);
  await rejects({ ...grounds, picture: { ...grounds.picture, data: new Uint8Array(4) } }, { x: 1, y: 1 }, /4 bytes/);
});
