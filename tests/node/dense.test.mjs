// Masks, superpixels, boundary maps and discontinuities: of a run, and of single images.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { maskPng, Result, synthClip } from 'tracecut';
import { cocoRle } from 'tracecut/export';
import { boundaries, createImageEngine, EdgeKind, flow, imageDiscontinuities, superpixels } from 'tracecut/stages';
import { createRemoteEngine } from '../../dist/worker/remote.js';
import { compileWasm, JPEG, framesOf, open, plain, png, ready, rejects, resultOf, SMALL, standIn } from './support.mjs';

/** Checks superpixels: numbers in order of first occurrence, borders sorted, edges inside the image. */
function isPartition({ width, height, count, label, borders, edges }) {
  assert.equal(label.length, width * height);
  let next = 0;
  for (const l of label) {
    assert.ok(l <= next, `superpixel ${l} before ${next}`);
    if (l === next) next += 1;
  }
  assert.equal(next, count);
  for (let k = 0; k < borders.a.length; k += 1) {
    const [a, b] = [borders.a[k], borders.b[k]];
    assert.ok(a < b && b < count, `border of ${a} and ${b} of ${count}`);
    const isSorted = k === 0 || borders.a[k - 1] < a || (borders.a[k - 1] === a && borders.b[k - 1] < b);
    assert.ok(isSorted, 'borders are sorted');
    assert.ok(borders.length[k] > 0 && borders.pb[k] >= 0 && borders.pb[k] <= 1);
  }
  const kinds = Object.values(EdgeKind);
  assert.ok(edges.kind.every((kind) => kinds.includes(kind)));
  for (const [name, side] of Object.entries({ x0: width, x1: width, y0: height, y1: height })) {
    assert.equal(edges[name].length, edges.kind.length);
    for (const v of edges[name]) assert.ok(v >= -0.5 && v <= side - 0.5, 'an edge leaves the image');
  }
}

function isBoundaryMap({ width, height, pb, thin }) {
  assert.deepEqual([pb.length, thin.length], [width * height, width * height]);
  assert.ok(pb.every((v, p) => thin[p] >= 0 && thin[p] <= v && v <= 1));
}

test('masks have a byte for each input pixel and hold each object, also after the session is closed', async () => {
  const result = await resultOf();
  const { width, height, numFrames, objects, clusters } = result;
  assert.equal(clusters.object.length, clusters.count);
  const visited = new Set();
  for (let t = 0; t < numFrames; t += 1) {
    const mask = result.labels(t);
    assert.equal(mask.length, width * height);
    mask.forEach((label) => visited.add(label));
  }
  assert.ok(Math.max(...visited) <= objects.length);
  assert.deepEqual(new Set(clusters.object), new Set(Array.from({ length: objects.length + 1 }, (_, k) => k)));
  result.labels(0).fill(77);
  assert.ok(!result.labels(0).includes(77), 'a caller may write into a mask');
});

test('masks of reduced frames are at input size, superpixels and boundaries at working size with their scale', async (t) => {
  const frames = await framesOf({ width: 250, height: 140, frames: 2, seed: 3 });
  const result = await (await ready(t, { clip: { maxSide: 100 } }, frames)).run();
  assert.equal(result.labels(1).length, 250 * 140);
  for (const map of [await result.superpixels(1), await result.boundaries(1)]) {
    assert.deepEqual([map.width, map.height, map.scaleX, map.scaleY], [100, 56, 2.5, 2.5]);
  }
});

test('superpixels and boundaries of a frame are valid, and those of a single image', async (t) => {
  const session = await ready(t);
  isBoundaryMap(await session.boundaries(SMALL.frames - 1));
  await rejects(session.superpixels(0), 'state', /superpixels of frame 0/);
  const result = await session.run();
  const regions = await result.superpixels(2);
  isPartition(regions);
  for (const [name, kind] of Object.entries(EdgeKind))
    assert.ok(regions.edges.kind.includes(kind), `no edge is a ${name}`);
  assert.deepEqual(await result.superpixels(2), await session.superpixels(2));
  assert.deepEqual(await result.boundaries(2), await session.boundaries(2));
  const frames = await framesOf();
  assert.deepEqual(await boundaries(frames[1]), await result.boundaries(1));
  assert.deepEqual(await superpixels(frames[1]), await result.superpixels(1));
});

test('a result asks its session, and says so when that is closed, cleared or busy', async (t) => {
  const session = await ready(t);
  const result = await session.run();
  const again = session.run();
  await rejects(result.superpixels(0), 'busy');
  await again;
  await session.clear();
  for (const frame of await framesOf()) await session.push(frame);
  await session.run();
  await rejects(result.boundaries(0), 'state', /cleared/);
  await rejects(result.superpixels(0), 'state', /cleared/);
  session.close();
  await rejects(result.superpixels(0), 'closed', /request them before closing/);
  await rejects(session.superpixels(0), 'closed', /superpixels was called on a closed session/);
  assert.equal(result.labels(0).length, SMALL.width * SMALL.height);
});

test('without clip.dense a run ends with the clusters, and what masks need is refused', async (t) => {
  const session = await ready(t, { clip: { dense: false } });
  const result = await session.run();
  assert.ok(!('cut' in result.seconds), Object.keys(result.seconds).join());
  const { objects, doubts, masks } = result;
  assert.deepEqual([objects, doubts, masks.length], [[], [], 0]);
  assert.throws(() => result.labels(0), { code: 'state', message: /no masks .*clip\.dense/ });
  await rejects(result.superpixels(0), 'state', /no superpixels .*clip\.dense/);
  await rejects(result.explain(0, 0, 0), 'state', /explanations.*clip\.dense/);
  await rejects(result.background(0), 'state', /no backgrounds/);
  await rejects(session.merge(0, 1), 'state', /need masks/);
  isBoundaryMap(await result.boundaries(0));
  const { clusters } = await resultOf();
  assert.deepEqual(result.clusters, { ...clusters, object: new Uint8Array(0) });
  const again = Result.fromJSON(JSON.stringify(result));
  assert.deepEqual([again.masks.length, again.objects], [0, []]);
});

test('trajectories from outside have no pixels, no saliency and no components', async (t) => {
  const session = await open(t);
  const tracks = { startFrame: [0], offset: [0, 3], x: [1, 2, 3], y: [1, 1, 1] };
  await session.setTrajectories({ numFrames: 3, width: 64, height: 48, ...tracks });
  const result = await session.run();
  const { objects, saliency, components } = result;
  assert.deepEqual([objects, saliency.ofPoints.length, components.count.length], [[], 0, 0]);
  assert.throws(() => result.labels(0), { code: 'state', message: /trajectories alone/ });
  await rejects(result.superpixels(0), 'state');
  await rejects(result.boundaries(0), 'state');
  await rejects(result.saliencyMap(0), 'state', /no saliency maps/);
  await rejects(maskPng(result, 0), 'state', /no masks/);
  await rejects(cocoRle(result), 'state', /no masks/);
});

test('a single image may be a file, and is never reduced', async () => {
  const [frame] = await framesOf({ width: 700, height: 20, frames: 1 });
  const map = await boundaries(png(frame));
  assert.deepEqual([map.width, map.height, map.scaleX, map.scaleY], [700, 20, 1, 1]);
  assert.deepEqual(map, await boundaries(frame));
  const regions = await superpixels(new Blob([JPEG]));
  assert.deepEqual([regions.width, regions.height], [24, 16]);
  isPartition(regions);
});

test('the number of superpixels can be set, and parameters change them', async () => {
  const [image] = await framesOf({ width: 160, height: 90, frames: 1, seed: 2 });
  const { count } = await superpixels(image);
  assert.ok(count > 20, `${count} superpixels`);
  const ten = await superpixels(image, { count: 10 });
  isPartition(ten);
  assert.equal(ten.count, 10);
  const coarse = await superpixels(image, { superpixel: { mergeThreshold: 100 } });
  isPartition(coarse);
  assert.ok(coarse.count < count, `${coarse.count} of ${count}`);
});

test('a flat image has no boundaries', async () => {
  const map = await boundaries(plain(40, 30, 128));
  isBoundaryMap(map);
  assert.ok(Math.max(...map.pb) < 0.01, `largest ${Math.max(...map.pb)}`);
  isPartition(await superpixels(plain(40, 30, 128)));
});

test('an image that is none, and options that do nothing, are refused', async () => {
  const image = plain(8, 8);
  await rejects(boundaries('image.png'), 'data', /frame = "image\.png"/);
  await rejects(superpixels(new Uint8Array(7)), 'decode');
  await rejects(superpixels({ data: new Uint8Array(8), width: 1, height: 1 }), 'frame-bytes');
  await rejects(
    boundaries(image, { flow: {} }),
    'param',
    /flow = an Object \(expected a known option; the options are wasm, decoder, worker, contour/,
  );
  await rejects(boundaries(image, { contour: { lwo: 0.1 } }), 'param', /contour\.lwo = 0\.1/);
  await rejects(boundaries(image, { count: 9 }), 'param', /count = 9 /);
  await rejects(superpixels(image, { count: 0 }), 'param', /count = 0 \(expected a whole number/);
  await rejects(superpixels(image, 3), 'param', /options = 3/);
});

const MAPS = ['pb', 'discontinuity', 'spectral', 'combined'];

function isComplete(map, width, height) {
  assert.deepEqual([map.width, map.height], [width, height]);
  for (const name of MAPS) {
    assert.equal(map[name].length, width * height, name);
    for (const v of map[name]) assert.ok(v >= 0 && v <= 1, `${name} is outside of 0..1`);
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
  const [image] = await framesOf({ width: 60, height: 40, frames: 1, seed: 4 });
  const map = await imageDiscontinuities(image);
  isComplete(map, 60, 40);
  assert.deepEqual(await imageDiscontinuities(png(image)), map);
  assert.deepEqual(map.pb, (await boundaries(image)).pb);
  assert.deepEqual([map.scaleX, map.scaleY], [1, 1]);
});

test('parameters change the result, and large images are scaled down', async () => {
  const [image] = await framesOf({ width: 60, height: 40, frames: 1, seed: 4 });
  const map = await imageDiscontinuities(image);
  const joint = await imageDiscontinuities(image, { still: { grouping: 'joint', weight: 0 } });
  assert.notDeepEqual(joint.discontinuity, map.discontinuity);
  assert.deepEqual(joint.combined, joint.pb);
  assert.deepEqual(joint.spectral, map.spectral);
  const small = await imageDiscontinuities(image, { still: { maxSide: 30 } });
  isComplete(small, 30, 20);
  assert.deepEqual([small.scaleX, small.scaleY], [2, 2]);
});

for (const size of ['1x1', '1x40', '40x1', '2x2', '17x3']) {
  test(`an image of ${size} pixels is a valid partition and has maps of its size`, async () => {
    const [width, height] = size.split('x').map(Number);
    const image = plain(width, height, (x, y) => (((x >> 2) + y) % 2) * 255);
    isPartition(await superpixels(image));
    isBoundaryMap(await boundaries(image));
    isComplete(await imageDiscontinuities(image), width, height);
    const flat = await imageDiscontinuities(plain(width, height, 90));
    isComplete(flat, width, height);
    assert.ok(MAPS.slice(1, 3).every((name) => flat[name].every((v) => v === 0)));
  });
}

test('a worker finds what this thread finds', async (t) => {
  const worker = standIn();
  t.after(() => worker.terminate());
  const engine = await createRemoteEngine(() => worker, await compileWasm(), { still: { dimensions: 6 } });
  const image = () => plain(50, 40, (x, y) => (x + y < 40 ? 40 : 200));
  const discontinuities = await engine.request('discontinuitiesOf', { ...image(), kind: 'pixels' });
  assert.deepEqual(discontinuities, await imageDiscontinuities(image(), { still: { dimensions: 6 } }));
});

test('what cannot be used is refused', async () => {
  const image = plain(8, 8);
  await rejects(imageDiscontinuities('image.png'), 'data');
  await rejects(
    imageDiscontinuities(image, { superpixel: {} }),
    'param',
    /superpixel = .* \(expected a known option; the options are wasm, decoder, worker, still/,
  );
  await rejects(imageDiscontinuities(image, { still: { radius: 0 } }), 'param', /still\.radius = 0/);
  await rejects(imageDiscontinuities(image, { still: { grouping: 'both' } }), 'param', /one of joint, single/);
});

test('the flow of a synthetic clip equals the generator’s, from pixels or files, in one engine or alone', async (t) => {
  const clip = await synthClip({ width: 96, height: 64, frames: 3, seed: 4 });
  const [first, second] = [clip.frame(0), clip.frame(1)];
  const truth = clip.flow(0);
  const engine = await createImageEngine();
  t.after(() => engine.close());
  const flowField = await engine.flow(first, second);
  assert.deepEqual([flowField.width, flowField.height, flowField.u.length], [96, 64, 96 * 64]);
  const errors = Array.from(flowField.u, (u, p) => Math.hypot(u - truth.u[p], flowField.v[p] - truth.v[p]));
  const mean = errors.reduce((sum, error) => sum + error, 0) / errors.length;
  assert.ok(mean < 0.5, `mean error of ${mean} pixels`);
  assert.deepEqual(await engine.flow(png(first), second), flowField);
  assert.deepEqual(await flow(first, second), flowField);
  const session = await ready(t, {}, [first, second, clip.frame(2)]);
  await session.run();
  const inSession = await session.flow(0);
  // A session's is rounded to a 64th of a pixel.
  assert.ok(inSession.u.every((u, p) => Math.abs(u - flowField.u[p]) <= 1 / 128 + 1e-6));
});

test('an image engine processes many images like the single functions, and stays usable after an error', async (t) => {
  const clip = await synthClip({ width: 60, height: 40, frames: 2, seed: 4 });
  const image = clip.frame(0);
  const engine = await createImageEngine({ still: { maxSide: 30 } });
  t.after(() => engine.close());
  assert.deepEqual(await engine.boundaries(image), await boundaries(image));
  await rejects(engine.flow(image, plain(64, 64)), 'frame-size-changed', /64 × 64 \(expected 60 × 40\)/);
  await rejects(engine.superpixels(image, { count: 0 }), 'param', /count = 0/);
  assert.deepEqual(await engine.superpixels(image, { count: 9 }), await superpixels(image, { count: 9 }));
  const expected = await imageDiscontinuities(image, { still: { maxSide: 30 } });
  assert.deepEqual(await engine.imageDiscontinuities(image), expected);
  engine.close();
  await rejects(engine.boundaries(image), 'closed');
  await rejects(createImageEngine({ cut: {} }), 'param', /^cut = /);
});
