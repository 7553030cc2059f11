// Masks changed by hand: painted, erased, carried through the clip, undone, saved.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { maskPng, synthClip } from 'tracecut';
import { carryEdit, editMasks, regionOf, strokeRegion } from 'tracecut/edit';
import { labelMaps } from 'tracecut/export';
import { createImageEngine } from 'tracecut/stages';
import { plain, rejects } from './support.mjs';

/** Masks of `numFrames` frames that are all background. */
const blank = (width, height, numFrames) => ({
  width,
  height,
  numFrames,
  labels: () => new Uint8Array(width * height),
});

/** Intersection over union of the pixels that have a label. */
function overlap(a, b, label) {
  let [both, either] = [0, 0];
  a.forEach((value, p) => {
    both += value === label && b[p] ? 1 : 0;
    either += value === label || b[p] ? 1 : 0;
  });
  return both / either;
}

test('a brush covers the pixels within its radius of its way, and no more', () => {
  const [width, height] = [40, 30];
  const stroke = { t: 0, points: [5, 6, 25, 16.5, 25, 40], radius: 3.5 };
  const distance = (x, y, [ax, ay, bx, by]) => {
    const along = Math.min(
      1,
      Math.max(0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2)),
    );
    return Math.hypot(x - ax - along * (bx - ax), y - ay - along * (by - ay));
  };
  const inside = new Uint8Array(width * height).map((_, p) => {
    const [x, y] = [p % width, Math.floor(p / width)];
    return Number(Math.min(distance(x, y, [5, 6, 25, 16.5]), distance(x, y, [25, 16.5, 25, 40])) <= 3.5);
  });
  assert.deepEqual(strokeRegion(stroke, width, height), regionOf(inside));
  const dot = strokeRegion({ t: 0, points: [7.2, 8.1], radius: 0 }, width, height);
  assert.deepEqual(dot, Uint32Array.of(8 * width + 7, 1));
  assert.equal(strokeRegion({ t: 0, points: [-50, -50], radius: 9 }, width, height).length, 0);
});

test('painting, erasing of one object and new labels change the masks, step by step back and forth', () => {
  const labels = Uint8Array.from([0, 1, 1, 2, 2, 0]);
  const editor = editMasks({ width: 6, height: 1, numFrames: 2, labels: () => labels });
  assert.equal(editor.newLabel(), 3);
  editor.paint({ label: 3, t: 0, region: Uint32Array.of(0, 2) });
  assert.equal(editor.newLabel(), 4);
  editor.paint({ label: 0, t: 0, region: Uint32Array.of(1, 4), over: [2] });
  editor.relabel({ 1: 9 });
  const states = [
    [0, 1, 1, 2, 2, 0],
    [3, 3, 1, 2, 2, 0],
    [3, 3, 1, 0, 0, 0],
    [3, 3, 9, 0, 0, 0],
  ];
  const now = () => [...editor.labels(0)];
  assert.deepEqual(now(), states[3]);
  assert.deepEqual([...editor.labels(1)], [0, 9, 9, 2, 2, 0]);
  for (const state of states.slice(0, 3).reverse()) {
    assert.ok(editor.undo());
    assert.deepEqual(now(), state);
  }
  assert.equal(editor.undo(), null);
  for (const state of states.slice(1)) {
    assert.ok(editor.redo());
    assert.deepEqual(now(), state);
  }
  assert.equal(editor.redo(), null);
  editor.undo();
  editor.paint({ label: 5, t: 1, region: Uint32Array.of(5, 1) });
  assert.deepEqual([editor.undoable, editor.redoable], [3, 0], 'what was undone goes when something else is done');
  assert.deepEqual([...labels], states[0], 'the masks below stay as they are');
});

test('what is painted on an object goes with it through the clip, both ways', async () => {
  const clip = await synthClip({ width: 160, height: 96, frames: 12, seed: 7 });
  const editor = editMasks(blank(160, 96, 12));
  const truth = Array.from({ length: 12 }, (_, t) => clip.mask(t));
  const area = (label) => truth[6].filter((value) => value === label).length;
  const object = [1, 2, 3].reduce((best, label) => (area(label) > area(best) ? label : best));
  const of = (t) => truth[t].map((label) => Number(label === object));
  const edit = editor.paint({ label: 1, t: 6, region: regionOf(of(6)) });
  const heard = [];
  const reached = await carryEdit(editor, edit, { picture: (t) => clip.frame(t), onFrame: ({ t }) => heard.push(t) });
  assert.deepEqual(reached, { first: 0, last: 11 });
  assert.deepEqual(heard, [7, 8, 9, 10, 11, 5, 4, 3, 2, 1, 0]);
  for (const t of [0, 3, 9, 11]) {
    const share = overlap(editor.labels(t), of(t), 1);
    assert.ok(share > 0.85, `${share} of the object in frame ${t}`);
    assert.ok(edit.parts.get(t).evidence > 0.6);
  }
  editor.undo();
  assert.equal(editor.labels(3).some(Boolean), false, 'it is one step');
  editor.redo();
  assert.ok(editor.labels(3).some(Boolean));
});

test('nothing is carried where the picture changes, beyond a cut, or further than asked', async (t) => {
  const clip = await synthClip({ width: 96, height: 64, frames: 4, seed: 7 });
  const frames = [0, 1, 2, 3].map((k) => clip.frame(k));
  const engine = await createImageEngine();
  t.after(() => engine.close());
  const region = regionOf(
    new Uint8Array(96 * 64).map((_, p) => Number(p % 96 > 20 && p % 96 < 60 && p > 96 * 16 && p < 96 * 48)),
  );
  const carried = (masks, pictures, more) => {
    const editor = editMasks(masks);
    const edit = editor.paint({ label: 1, t: 1, region });
    return carryEdit(editor, edit, { picture: (k) => pictures[k], engine, ...more });
  };
  assert.deepEqual(await carried(blank(96, 64, 4), frames), { first: 0, last: 3 });
  const shots = [
    { first: 0, last: 1 },
    { first: 2, last: 3 },
  ];
  assert.deepEqual(await carried({ ...blank(96, 64, 4), shots }, frames), { first: 0, last: 1 });
  assert.deepEqual(await carried(blank(96, 64, 4), frames, { first: 1, last: 2 }), { first: 1, last: 2 });
  const noise = plain(96, 64, (x, y) => (97 * x + 61 * y + ((x * y) % 13) * 17) % 256);
  assert.deepEqual(await carried(blank(96, 64, 4), [frames[0], frames[1], noise, frames[3]]), { first: 0, last: 1 });
});

test('a carrying that is stopped keeps the frames that it reached', async () => {
  const clip = await synthClip({ width: 96, height: 64, frames: 6, seed: 7 });
  const editor = editMasks(blank(96, 64, 6));
  const edit = editor.paint({ label: 2, stroke: { t: 0, points: [48, 32], radius: 12 } });
  const controller = new AbortController();
  const stopped = carryEdit(editor, edit, {
    picture: (t) => clip.frame(t),
    signal: controller.signal,
    onFrame: ({ t }) => t === 2 && controller.abort(),
  });
  await assert.rejects(stopped, { name: 'AbortError' });
  assert.deepEqual([...edit.parts.keys()], [0, 1, 2]);
});

test('edits are saved as JSON and done again over the same masks; exports take the editor as masks', async () => {
  const masks = { ...blank(12, 8, 3), times: [0, 0.1, 0.25] };
  const editor = editMasks(masks);
  const edit = editor.paint({ label: 4, stroke: { t: 1, points: [3, 3, 9, 3], radius: 1.5 }, over: [0] });
  editor.extend(edit, 2, Uint32Array.of(5, 3), 0.75);
  editor.relabel({ 4: 6 });
  const again = editMasks(masks);
  again.restore(JSON.parse(JSON.stringify(editor)));
  for (const t of [0, 1, 2]) assert.deepEqual(again.labels(t), editor.labels(t));
  assert.equal(again.edits[0].parts.get(2).evidence, 0.75);
  assert.deepEqual(await maskPng(again, 1), await maskPng({ ...masks, labels: (t) => editor.labels(t) }, 1));
  assert.deepEqual(labelMaps(again).data.slice(96, 192), editor.labels(1));
  await rejects(
    async () => editMasks(blank(5, 5, 3)).restore(editor.toJSON()),
    'data',
    /12 × 8 × 3 \(expected 5 × 5 × 3\)/,
  );
});

test('what cannot be meant is refused, and the editor stays usable', async () => {
  const editor = editMasks(blank(8, 8, 2));
  const stroke = { t: 0, points: [1, 1], radius: 2 };
  const refused = (call, code, message) => rejects((async () => call())(), code, message);
  await refused(() => editMasks({ width: 8 }), 'data', /^masks/);
  await refused(() => editor.paint({ label: 256, stroke }), 'param', /label = 256/);
  await refused(() => editor.paint({ label: 1, stroke: { ...stroke, t: 2 } }), 'param', /stroke\.t = 2/);
  await refused(() => editor.paint({ label: 1, stroke: { ...stroke, radius: -1 } }), 'param', /stroke\.radius = -1/);
  await refused(() => editor.paint({ label: 1, stroke: { ...stroke, points: [1] } }), 'param', /1 numbers/);
  await refused(
    () => editor.paint({ label: 1, stroke: { ...stroke, points: [1, NaN] } }),
    'param',
    /points\[1\] = NaN/,
  );
  await refused(() => editor.paint({ label: 1, t: 0, region: Uint32Array.of(60, 5) }), 'data', /region\[1\] = 5/);
  await refused(() => editor.relabel({ 300: 1 }), 'param', /300/);
  await refused(() => editor.extend({ table: {} }, 0, Uint32Array.of(), 1), 'state', /in force/);
  const edit = editor.paint({ label: 1, stroke });
  await refused(() => carryEdit(editor, edit, {}), 'param', /picture/);
  await refused(() => carryEdit(editor, edit, { picture: () => null }), 'data', /picture\(0\)/);
  await refused(() => carryEdit(editor, edit, { picture: () => plain(8, 8), first: 1 }), 'param', /first = 1/);
  editor.undo();
  await refused(() => carryEdit(editor, edit, { picture: () => plain(8, 8) }), 'state', /in force/);
  assert.equal(editor.labels(0).some(Boolean), false);
  let all = 0;
  while (all < 255) editor.paint({ label: (all += 1), stroke });
  await refused(() => editor.newLabel(), 'state', /255 labels/);
});
