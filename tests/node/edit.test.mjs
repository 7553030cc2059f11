// Masks changed by hand: painted, erased, carried through the clip, undone, saved.

import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import { maskPng, synthClip } from 'tracecut';
import { editMasks, encodeRuns } from 'tracecut/edit';
import { labelMaps } from 'tracecut/export';
import { createImageEngine } from 'tracecut/stages';
import { abortAt, each, mapPixels, overlapOf, plain, ready, rejects } from './support.mjs';

const engine = await createImageEngine();
after(() => engine.close());

/** Opens masks with pictures and the engine of all tests. */
const editWith = (masks, picture) => editMasks(masks, { picture, engine: async () => engine });

/** Masks of `numFrames` frames that are all background. */
const blank = (width, height, numFrames) => ({
  width,
  height,
  numFrames,
  labels: () => new Uint8Array(width * height),
});

/** Returns the two shots of a clip with a cut before a frame. */
const shotsWithCut = (cut, numFrames) => [
  { first: 0, last: cut - 1 },
  { first: cut, last: numFrames - 1 },
];

test('a brush covers the pixels within its radius of its way, and no more', async () => {
  const [width, height] = [40, 30];
  const stroke = { t: 0, points: [5, 6, 25, 16.5, 25, 40], radius: 3.5 };
  const distance = (x, y, [ax, ay, bx, endY]) => {
    const along = Math.min(
      1,
      Math.max(0, ((x - ax) * (bx - ax) + (y - ay) * (endY - ay)) / ((bx - ax) ** 2 + (endY - ay) ** 2)),
    );
    return Math.hypot(x - ax - along * (bx - ax), y - ay - along * (endY - ay));
  };
  const isInside = (x, y) => Math.min(distance(x, y, [5, 6, 25, 16.5]), distance(x, y, [25, 16.5, 25, 40])) <= 3.5;
  const inside = mapPixels(width, height, isInside);
  const paintAlong = async (way) => {
    const editor = editMasks(blank(width, height, 1));
    await editor.paint({ label: 1, stroke: way });
    return editor.labels(0);
  };
  assert.deepEqual(await paintAlong(stroke), inside);
  const dot = new Uint8Array(width * height).fill(1, 8 * width + 7, 8 * width + 8);
  assert.deepEqual(await paintAlong({ t: 0, points: [7.2, 8.1], radius: 0 }), dot);
  assert.ok((await paintAlong({ t: 0, points: [-50, -50], radius: 9 })).every((label) => label === 0));
  const under = await editMasks({ ...blank(width, height, 1), labels: () => inside }).labelsUnder(stroke);
  assert.deepEqual([under[0], under[1]], [0, inside.filter(Boolean).length]);
});

test('painting, erasing of one object and new labels change the masks, step by step back and forth', async () => {
  const labels = Uint8Array.from([0, 1, 1, 2, 2, 0]);
  const editor = editMasks({ width: 6, height: 1, numFrames: 2, labels: () => labels });
  assert.equal(editor.newLabel(), 3);
  await editor.paint({ label: 3, t: 0, region: encodeRuns([1, 1, 0, 0, 0, 0]) });
  assert.equal(editor.newLabel(), 4);
  await editor.paint({ label: 0, t: 0, region: encodeRuns([0, 1, 1, 1, 1, 0]), over: [2] });
  await editor.merge(9, 1);
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
    assert.ok(await editor.undo());
    assert.deepEqual(now(), state);
  }
  assert.equal(await editor.undo(), null);
  for (const state of states.slice(1)) {
    assert.ok(await editor.redo());
    assert.deepEqual(now(), state);
  }
  assert.equal(await editor.redo(), null);
  await editor.undo();
  await editor.paint({ label: 5, t: 1, region: encodeRuns([0, 0, 0, 0, 0, 1]) });
  assert.deepEqual([editor.undoable, editor.redoable], [3, 0], 'what was undone goes when something else is done');
  assert.deepEqual([...labels], states[0], 'the masks below stay as they are');
});

test('paint on an object follows it through the clip, both ways', async () => {
  const clip = await synthClip({ width: 160, height: 96, frames: 12, seed: 7 });
  const editor = editMasks(blank(160, 96, 12), { picture: (t) => clip.frame(t) });
  const truth = Array.from({ length: 12 }, (_, t) => clip.mask(t));
  const area = (label) => truth[6].filter((value) => value === label).length;
  const object = [1, 2, 3].reduce((best, label) => (area(label) > area(best) ? label : best));
  const objectMask = (t) => truth[t].map((label) => Number(label === object));
  const edit = await editor.paint({ label: 1, t: 6, region: encodeRuns(objectMask(6)) });
  const reportedFrames = [];
  const carriedFrames = await editor.carry(edit, { onFrame: ({ t }) => reportedFrames.push(t) });
  assert.deepEqual(carriedFrames, { first: 0, last: 11 });
  assert.deepEqual(reportedFrames, [7, 5, 8, 4, 9, 3, 10, 2, 11, 1, 0], 'outward, in turn');
  for (const t of [0, 3, 9, 11]) {
    const share = overlapOf(editor.labels(t), objectMask(t));
    assert.ok(share > 0.85, `${share} of the object in frame ${t}`);
    assert.ok(edit.paints[0].parts.get(t).evidence > 0.6);
  }
  await editor.undo();
  assert.equal(editor.labels(3).some(Boolean), false, 'it is one step');
  await editor.redo();
  assert.ok(editor.labels(3).some(Boolean));
});

test('nothing is carried where the picture changes, beyond a cut, or further than asked', async () => {
  const clip = await synthClip({ width: 96, height: 64, frames: 4, seed: 7 });
  const frames = [0, 1, 2, 3].map((k) => clip.frame(k));
  const region = encodeRuns(mapPixels(96, 64, (x, y) => x > 20 && x < 60 && y >= 16 && y < 48));
  const carryEdit = async (masks, pictures, more) => {
    const editor = editWith(masks, (k) => pictures[k]);
    return editor.carry(await editor.paint({ label: 1, t: 1, region }), more);
  };
  assert.deepEqual(await carryEdit(blank(96, 64, 4), frames), { first: 0, last: 3 });
  const shots = shotsWithCut(2, 4);
  assert.deepEqual(await carryEdit({ ...blank(96, 64, 4), shots }, frames), { first: 0, last: 1 });
  assert.deepEqual(await carryEdit(blank(96, 64, 4), frames, { first: 1, last: 2 }), { first: 1, last: 2 });
  const noise = plain(96, 64, (x, y) => (97 * x + 61 * y + ((x * y) % 13) * 17) % 256);
  assert.deepEqual(await carryEdit(blank(96, 64, 4), [frames[0], frames[1], noise, frames[3]]), { first: 0, last: 1 });
});

test('an edit is trimmed to fewer frames, and carried on to more, as one step', async () => {
  const clip = await synthClip({ width: 96, height: 64, frames: 8, seed: 7 });
  const editor = editWith(blank(96, 64, 8), (k) => clip.frame(k));
  const edit = await editor.paint({ label: 2, stroke: { t: 3, points: [40, 30, 56, 34], radius: 10 } });
  await editor.carry(edit, { minEvidence: 0 });
  const frames = () => [...edit.paints[0].parts.keys()].sort((a, b) => a - b);
  assert.deepEqual(frames(), [0, 1, 2, 3, 4, 5, 6, 7]);
  const labelsBefore = editor.labels(6);
  editor.trim(edit, { first: 2, last: 4 });
  assert.deepEqual(frames(), [2, 3, 4]);
  assert.equal(editor.labels(6).some(Boolean), false);
  await editor.carry(edit, { first: 2, last: 6, minEvidence: 0 });
  assert.deepEqual(frames(), [2, 3, 4, 5, 6]);
  assert.deepEqual(editor.labels(6), labelsBefore, 'the frames before do not matter twice');
  assert.equal(editor.undoable, 1);
  assert.throws(() => editor.trim(edit, { first: 4, last: 6 }), /first = 4 .*0\.\.=3/);
  assert.throws(() => editor.trim(edit, { first: 0, last: 8 }), /last = 8/);
  await editor.undo();
  assert.throws(() => editor.trim(edit, { first: 2, last: 4 }), /in force/);
});

test('carried paint stays on its object before a background of similar colours', async () => {
  // A grey block on a grey field of the same kind that stands still, while the block moves by two pixels a frame.
  const [width, height, numFrames] = [96, 64, 7];
  const noise = (x, y) => ((x * 374761393 + y * 668265263) >>> 7) % 64;
  const isBlock = (k, x, y) => x >= 20 + 2 * k && x < 44 + 2 * k && y >= 20 && y < 44;
  const pictures = Array.from({ length: numFrames }, (_, k) =>
    plain(width, height, (x, y) => (isBlock(k, x, y) ? 120 + noise(x - 2 * k, y + 999) : 90 + noise(x, y))),
  );
  const editor = editWith(blank(width, height, numFrames), (k) => pictures[k]);
  const inside = mapPixels(width, height, (x, y) => isBlock(0, x, y));
  const edit = await editor.paint({ label: 1, t: 0, region: encodeRuns(inside) });
  await editor.carry(edit, { minEvidence: 0 });
  for (let k = 1; k < numFrames; k += 1) {
    const wrong = editor.labels(k).filter((label, p) => {
      const [x, y] = [p % width, Math.floor(p / width)];
      return label > 0 && (x < 16 + 2 * k || x >= 48 + 2 * k || y < 16 || y >= 48);
    });
    assert.equal(wrong.length, 0, `${wrong.length} pixels apart from the block in frame ${k}`);
  }
});

test('masks of a range come from the frames beside it, moved along the flow, as one step', async () => {
  const clip = await synthClip({ width: 160, height: 96, frames: 12, seed: 7 });
  // In three frames the masks are lost, and in one there is nothing but an object.
  const labels = (k) =>
    k === 6 ? new Uint8Array(160 * 96).fill(9) : k > 3 && k < 8 ? new Uint8Array(160 * 96) : clip.mask(k);
  const masks = { ...blank(160, 96, 12), labels };
  const open = (more) => editWith({ ...masks, ...more }, (k) => clip.frame(k));
  const editor = open();
  const reports = [];
  const edit = await editor.interpolate({ from: 4, to: 8 }, { onFrame: ({ t: k }) => reports.push(k) });
  assert.equal(edit.kind, 'interpolate');
  assert.deepEqual(reports.sort(), [4, 5, 6, 7]);
  for (const k of [4, 5, 6, 7]) {
    const truth = clip.mask(k);
    const right = editor.labels(k).filter((label, p) => label === truth[p]).length / truth.length;
    assert.ok(right > 0.95, `${right} of the pixels of frame ${k}`);
  }
  assert.deepEqual(editor.labels(3), clip.mask(3));
  const json = JSON.parse(JSON.stringify(editor.toJSON()));
  const restored = open();
  restored.restore(json);
  assert.deepEqual(restored.labels(6), editor.labels(6));
  await editor.undo();
  assert.deepEqual(editor.labels(6), labels(6));
  const forward = await editor.interpolate({ from: 4, to: 12 }, { sides: 'before' });
  assert.ok(forward.paints[0].parts.has(4));
  const cut = open({ shots: shotsWithCut(4, 12) });
  await rejects(cut.interpolate({ from: 4, to: 8 }), 'param', /from = 4/);
  await rejects(editor.interpolate({ from: 0, to: 8 }), 'param', /from = 0 .*1\.\.=11/);
  await rejects(editor.interpolate({ from: 8, to: 12 }), 'param', /to = 12/);
  await rejects(editor.interpolate({ from: 4, to: 8 }, { sides: 'after' }), 'param', /sides = /);
  await rejects(editMasks(masks).interpolate({ from: 4, to: 8 }), 'state', /pictures/);
});

test('a carrying that is stopped keeps the frames that it reached', async () => {
  const clip = await synthClip({ width: 96, height: 64, frames: 6, seed: 7 });
  const editor = editMasks(blank(96, 64, 6), { picture: (t) => clip.frame(t) });
  const edit = await editor.paint({ label: 2, stroke: { t: 0, points: [48, 32], radius: 12 } });
  const stopped = editor.carry(edit, abortAt({ callback: 'onFrame', isDue: ({ t }) => t === 2 }));
  await assert.rejects(stopped, { name: 'AbortError' });
  assert.deepEqual([...edit.paints[0].parts.keys()], [0, 1, 2]);
});

test('pieces and halves of an object become objects, and objects one, by pixels alone', async () => {
  const labels = mapPixels(20, 10, (x, y) => {
    return y >= 2 && y < 8 && x >= 2 && x < 18 ? 3 : x === 0 && y < 3 ? 1 : x === 0 && y > 4 ? 1 : 0;
  });
  const editor = editMasks({ width: 20, height: 10, numFrames: 1, labels: () => labels });
  assert.equal(editor.usesSession, false);
  const columns = (label) => [...editor.labels(0)].flatMap((value, p) => (value === label ? [p % 20] : []));
  await editor.split(1, { t: 0, x: 0.2, y: 0.8 });
  assert.equal(columns(2).length, 3);
  const stroke = (x) => ({ t: 0, points: [x, 3, x, 6], radius: 1 });
  const { kind, paints } = await editor.apart([stroke(4), stroke(13)]);
  assert.deepEqual([kind, paints[0].label, paints[0].over], ['apart', 4, [3]]);
  assert.ok(columns(3).length + columns(4).length === 6 * 16);
  assert.ok(columns(3).every((x) => x <= 8) && columns(4).every((x) => x >= 9));
  await editor.together([stroke(4), { ...stroke(13), points: new Float32Array([13, 3, 13, 6]) }]);
  assert.equal(columns(3).length, 6 * 16);
  assert.deepEqual([editor.labelOf(4), editor.labelOf(1)], [3, 1]);
  const again = editMasks(editor.masks);
  again.restore(JSON.parse(JSON.stringify(editor)));
  assert.deepEqual(again.labels(0), editor.labels(0));
  assert.deepEqual((await editor.toResult()).labels(0), editor.labels(0));
  const refused = (promise, message) => rejects(promise, 'param', message);
  await refused(editor.split(1, { t: 0, x: 20, y: 1 }), /at/);
  await refused(editor.split(3, { t: 0, x: 0, y: 0 }), /a place of object 3/);
  await refused(editor.split(0, { t: 0, x: 10, y: 0 }), /split needs an object/);
  await refused(editor.split(3), /split needs an object/);
  await refused(editor.apart([stroke(4)]), /2\.\.255 strokes/);
  const beside = { t: 0, points: [10, 0], radius: 0.5 };
  await refused(editor.apart([beside, beside]), /on no object/);
  await refused(editor.together([stroke(4)]), /fewer than two objects/);
  await refused(editor.merge(3, []), /others/);
  assert.equal(editor.undoable, 3);
});

test('a session decides until something is changed on its masks, and is asked to take it back', async (t) => {
  const clip = await synthClip({ width: 192, height: 120, frames: 8, seed: 3 });
  const frames = Array.from({ length: 8 }, (_, k) => clip.frame(k));
  const session = await ready(t, {}, frames);
  const result = await session.run();
  const secondEditor = editMasks(result);
  const editor = editMasks(result, { session });
  const allLabels = (masks) => Array.from({ length: 8 }, (_, k) => masks.labels(k));
  const [first, second] = each(result.objects, 'label');
  const { corrections } = await editor.merge(0, [first, second]);
  await secondEditor.merge(0, [first, second]);
  assert.equal(corrections, 2);
  assert.deepEqual(allLabels(editor), allLabels(secondEditor), 'both have the same masks');
  assert.deepEqual(editor.trajectories.label, secondEditor.trajectories.label);
  await rejects(editor.merge(3, [second, 250]), 'param', /labels in use/);
  assert.equal(session.corrections, 2, 'what was refused left nothing');
  await editor.undo();
  assert.equal(session.corrections, 0);
  assert.deepEqual(allLabels(editor), allLabels(result));
  await editor.redo();
  assert.deepEqual(allLabels(editor), allLabels(secondEditor));
  assert.ok(editor.usesSession);
  assert.deepEqual(editor.toJSON().edits, [], 'its masks have them');
  await editor.paint({ label: first, stroke: { t: 2, points: [10, 10], radius: 4 } });
  await editor.merge(second, first);
  assert.deepEqual([editor.usesSession, session.corrections, editor.undoable], [false, 2, 3]);
  assert.equal(editor.labels(2)[10 * 192 + 10], second);
});

test('edits are saved as JSON and done again over the same masks; exports take the editor as masks', async () => {
  const masks = { ...blank(12, 8, 3), times: [0, 0.1, 0.25] };
  const editor = editMasks(masks);
  const edit = await editor.paint({ label: 4, stroke: { t: 1, points: [3, 3, 9, 3], radius: 1.5 }, over: [0] });
  editor.extend(edit, 2, encodeRuns(new Uint8Array(96).fill(1, 5, 8)), 0.75);
  await editor.merge(6, 4);
  const again = editMasks(masks);
  again.restore(JSON.parse(JSON.stringify(editor)));
  for (const t of [0, 1, 2]) assert.deepEqual(again.labels(t), editor.labels(t));
  assert.equal(again.edits[0].paints[0].parts.get(2).evidence, 0.75);
  assert.deepEqual(await maskPng(again, 1), await maskPng({ ...masks, labels: (t) => editor.labels(t) }, 1));
  assert.deepEqual(labelMaps(again).data.slice(96, 192), editor.labels(1));
  const restoreOther = async () => editMasks(blank(5, 5, 3)).restore(editor.toJSON());
  await rejects(restoreOther, 'data', /12 × 8 × 3 \(expected 5 × 5 × 3\)/);
  const json = JSON.parse(JSON.stringify(editor));
  const damaged = [{}, { table: {}, paints: 5 }, { table: {}, paints: [{ label: 1, parts: [{ t: 0 }] }] }];
  const before = again.edits.length;
  for (const edits of [undefined, ...damaged.map((edit) => [edit])])
    await rejects(async () => again.restore({ ...json, edits }), 'data');
  assert.equal(again.edits.length, before);
});

test('what cannot be meant is refused, and the editor stays usable', async () => {
  const editor = editMasks(blank(8, 8, 2));
  const stroke = { t: 0, points: [1, 1], radius: 2 };
  const refused = (call, code, message) => rejects((async () => call())(), code, message);
  await refused(() => editMasks({ width: 8 }), 'data', /^masks/);
  await refused(() => editor.paint({ label: 256, stroke }), 'param', /label = 256/);
  const refusedStroke = (part, message) =>
    refused(() => editor.paint({ label: 1, stroke: { ...stroke, ...part } }), 'param', message);
  await refusedStroke({ t: 2 }, /stroke\.t = 2/);
  await refusedStroke({ radius: -1 }, /stroke\.radius = -1/);
  await refusedStroke({ points: [1] }, /^stroke = .* x0, y0/);
  await refusedStroke({ points: [1, NaN] }, /stroke\.points\[1\] = NaN/);
  await refusedStroke({ points: [] }, /points = a list of 0/);
  await refused(() => editor.paint({ label: 1, t: 0, region: encodeRuns([1, 1]) }), 'data', /region covers 2 pixels/);
  await refused(() => editor.merge(1, 300), 'param', /300/);
  await refused(() => editor.extend({ paints: [] }, 0, encodeRuns(new Uint8Array(64)), 1), 'state', /in force/);
  const edit = await editor.paint({ label: 1, stroke });
  await refused(() => editor.carry(edit), 'state', /pictures/);
  const editorWith = (picture) => editMasks(blank(8, 8, 2), { picture });
  const paintAndCarry = async (editor, options) => editor.carry(await editor.paint({ label: 1, stroke }), options);
  await refused(() => paintAndCarry(editorWith(() => null)), 'data', /picture\(0\)/);
  const editorOfPlain = () => editorWith(() => plain(8, 8));
  await refused(() => paintAndCarry(editorOfPlain(), { first: 1 }), 'param', /first = 1/);
  await editor.undo();
  await refused(() => editorOfPlain().carry(edit), 'state', /in force/);
  assert.equal(editor.labels(0).some(Boolean), false);
  let total = 0;
  while (total < 255) await editor.paint({ label: (total += 1), stroke });
  await refused(() => editor.newLabel(), 'state', /255 labels/);
});
