// Discontinuities of the pixel embedding of single images.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { synthClip } from 'tracecut';
import { superpixels, boundaries, createImageEngine, flow, imageDiscontinuities } from 'tracecut/stages';
import { createRemoteEngine } from '../../dist/worker/remote.js';
import { plain, png, ready, rejects, standIn } from './support.mjs';

const MAPS = ['pb', 'discontinuity', 'spectral', 'combined'];

function isComplete(map, width, height) {
  assert.deepEqual([map.width, map.height], [width, height]);
  for (const name of MAPS) {
    assert.equal(map[name].length, width * height, name);
    assert.ok(
      map[name].every((v) => v >= 0 && v <= 1),
      `${name} is outside of 0..1`,
    );
  }
}

test('the discontinuities of two halves lie between them', async () => {
  const map = await imageDiscontinuities(plain(64, 48, (x) => (x < 32 ? 40 : 210)));
  isComplete(map, 64, 48);
  const row = map.discontinuity.subarray(24 * 64, 25 * 64);
  const between = Math.max(...row.subarray(30, 34));
  assert.ok(between > 0.6, `${between} between the halves`);
  row.forEach((d, x) => assert.ok(Math.abs(x - 31.5) < 4 || d < 0.3, `${d} at ${x}`));
});

test('an image has the same discontinuities again, as pixels or as a file, and Pb as boundaries has it', async () => {
  const clip = await synthClip({ width: 96, height: 64, frames: 1, seed: 4 });
  const image = clip.frame(0);
  const map = await imageDiscontinuities(image);
  isComplete(map, 96, 64);
  assert.deepEqual(await imageDiscontinuities(png(image)), map);
  assert.deepEqual(map.pb, (await boundaries(image)).pb);
  assert.deepEqual([map.scaleX, map.scaleY], [1, 1]);
});

test('parameters change what is found, and large images are reduced', async () => {
  const clip = await synthClip({ width: 96, height: 64, frames: 1, seed: 4 });
  const image = clip.frame(0);
  const map = await imageDiscontinuities(image);
  const joint = await imageDiscontinuities(image, { still: { grouping: 'joint', weight: 0 } });
  assert.notDeepEqual(joint.discontinuity, map.discontinuity);
  assert.deepEqual(joint.combined, joint.pb);
  assert.deepEqual(joint.spectral, map.spectral);
  const small = await imageDiscontinuities(image, { still: { maxSide: 48 } });
  isComplete(small, 48, 32);
  assert.deepEqual([small.scaleX, small.scaleY], [2, 2]);
});

for (const [width, height] of [
  [1, 1],
  [1, 40],
  [40, 1],
  [2, 2],
  [17, 3],
]) {
  test(`an image of ${width}x${height} pixels has maps of its size`, async () => {
    isComplete(await imageDiscontinuities(plain(width, height, (x, y) => (((x >> 2) + y) % 2) * 255)), width, height);
    const flat = await imageDiscontinuities(plain(width, height, 90));
    isComplete(flat, width, height);
    assert.ok(MAPS.slice(1, 3).every((name) => flat[name].every((v) => v === 0)));
  });
}

test('a worker finds what this thread finds', async (t) => {
  const worker = standIn();
  t.after(() => worker.terminate());
  const module = await WebAssembly.compile(await readFile(new URL('../../dist/tracecut_bg.wasm', import.meta.url)));
  const engine = await createRemoteEngine(() => worker, module, { still: { dimensions: 6 } });
  const image = () => plain(50, 40, (x, y) => (x + y < 40 ? 40 : 200));
  const found = await engine.request('discontinuitiesOf', { ...image(), kind: 'pixels' });
  assert.deepEqual(found, await imageDiscontinuities(image(), { still: { dimensions: 6 } }));
});

test('what cannot be used is refused', async () => {
  const image = plain(8, 8);
  await rejects(imageDiscontinuities('image.png'), 'data');
  await rejects(imageDiscontinuities(image, { superpixel: {} }), 'param', /superpixel = .* \(expected still/);
  await rejects(imageDiscontinuities(image, { still: { radius: 0 } }), 'param', /still\.radius = 0/);
  await rejects(imageDiscontinuities(image, { still: { grouping: 'both' } }), 'param', /one of joint, single/);
});

test('the flow of a made clip is what its generator says, as pixels or as files, in one engine or alone', async (t) => {
  const clip = await synthClip({ width: 96, height: 64, frames: 3, seed: 4 });
  const [first, second] = [clip.frame(0), clip.frame(1)];
  const truth = clip.flow(0);
  const engine = await createImageEngine();
  t.after(() => engine.close());
  const found = await engine.flow(first, second);
  assert.deepEqual([found.width, found.height, found.u.length], [96, 64, 96 * 64]);
  const errors = Array.from(found.u, (u, p) => Math.hypot(u - truth.u[p], found.v[p] - truth.v[p]));
  const mean = errors.reduce((sum, error) => sum + error, 0) / errors.length;
  assert.ok(mean < 0.5, `mean error of ${mean} pixels`);
  assert.deepEqual(await engine.flow(png(first), second), found);
  assert.deepEqual(await flow(first, second), found);
  const session = await ready(t, {}, [first, second, clip.frame(2)]);
  await session.run();
  const inSession = await session.flow(0);
  // A session's is rounded to a 64th of a pixel.
  assert.ok(inSession.u.every((u, p) => Math.abs(u - found.u[p]) <= 1 / 128 + 1e-6));
});

test('an image engine does many images, gives what the functions of one give, and goes on after an error', async (t) => {
  const clip = await synthClip({ width: 96, height: 64, frames: 2, seed: 4 });
  const image = clip.frame(0);
  const engine = await createImageEngine({ still: { maxSide: 48 } });
  t.after(() => engine.close());
  assert.deepEqual(await engine.boundaries(image), await boundaries(image));
  await rejects(engine.flow(image, plain(64, 64)), 'frame-size-changed', /64 × 64 \(expected 96 × 64\)/);
  await rejects(engine.superpixels(image, { count: 0 }), 'param', /count = 0/);
  assert.deepEqual(await engine.superpixels(image, { count: 9 }), await superpixels(image, { count: 9 }));
  assert.deepEqual(
    await engine.imageDiscontinuities(image),
    await imageDiscontinuities(image, { still: { maxSide: 48 } }),
  );
  engine.close();
  await rejects(engine.boundaries(image), 'closed');
  await rejects(createImageEngine({ cut: {} }), 'param', /^cut = /);
});
