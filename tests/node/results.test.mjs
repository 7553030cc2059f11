// What a result tells: its objects, their table, the search report, and what is saved of it.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, test } from 'node:test';
import { createSession, Result, searchReport, segmentVideo, synthClip, VideoResult, WindowResult } from 'tracecut';
import { editMasks } from 'tracecut/edit';
import { objectTable, objectTableCsv } from 'tracecut/export';
import { trajectories } from 'tracecut/stages';
import { each, framesOf, mapPixels, plain, rejects, resultOf, segment } from './support.mjs';

const SCENE = { width: 256, height: 144, frames: 10, seed: 4 };
const frames = await framesOf(SCENE);
const session = await createSession();
for (const frame of frames) await session.push(frame);
const result = await session.run();
after(() => session.close());
const windows = [];
const collected = await segmentVideo(frames, { window: 8, overlap: 3 }).collect((window) => void windows.push(window));

/** Counts an object's areas from its masks. */
function counted({ labels, numFrames }, label) {
  const areas = Array.from({ length: numFrames }, (_, t) => labels(t).filter((value) => value === label).length);
  const presentFrames = areas.flatMap((area, t) => (area > 0 ? [t] : []));
  const sum = areas.reduce((a, b) => a + b, 0);
  return {
    label,
    firstFrame: presentFrames[0],
    lastFrame: presentFrames.at(-1),
    frames: presentFrames.length,
    meanArea: sum / presentFrames.length,
    areas,
  };
}

function isCounted(result) {
  const masks = { numFrames: result.numFrames, labels: (t) => result.labels(t) };
  assert.ok(Array.isArray(result.objects) && result.objects.length > 0);
  for (const { areas, ...facts } of result.objects)
    assert.deepEqual({ ...facts, areas: [...areas] }, counted(masks, facts.label));
}

test('objects are a list of the same facts on results of sessions, windows and clips', async () => {
  const windows = [];
  const video = await segmentVideo(frames).collect((window) => void windows.push(window));
  for (const masks of [result, windows[0], video, collected]) isCounted(masks);
  assert.deepEqual(windows[0].objects, result.objects);
  assert.deepEqual(video.objects, result.objects);
  assert.deepEqual(Object.keys(video.objects[0]), Object.keys(result.objects[0]));
});

test('the number of objects counts them, where labels have gaps', async () => {
  const labels = each(result.objects, 'label');
  assert.ok(labels.length >= 2, `${labels}`);
  const merged = await session.merge(0, 1);
  assert.equal(merged.objects.length, labels.length - 1);
  assert.ok(merged.objects.at(-1).label > merged.objects.length, 'the highest label is no count');
  isCounted(merged);
  assert.ok(!merged.clusters.object.includes(1));
});

test('an object without a pixel is none', () => {
  const unseen = { label: 200, areas: new Uint32Array(result.numFrames) };
  const again = Result.fromJSON({ ...structuredClone(result), objects: [unseen, ...result.objects] });
  assert.deepEqual(again.objects, result.objects);
});

/** All that a result says, besides what only a session can. */
function plainResult(result) {
  const masks = Array.from({ length: result.numFrames }, (_, t) => result.labels(t));
  const edges = result.edges && Array.from({ length: result.numFrames }, (_, t) => result.edges(t));
  return { ...result, masks, edges, tracks: result.toTracksDat(), frames: result.frames && [...result.frames()] };
}

for (const [name, Kind, source] of [
  ['a session', Result, result],
  ['a window', WindowResult, windows[1]],
  ['a clip', VideoResult, collected],
]) {
  test(`the result of ${name} is the same after JSON, to the last bit, and small`, () => {
    const text = JSON.stringify(source);
    const back = Kind.fromJSON(text);
    assert.ok(back instanceof Kind);
    assert.deepEqual(plainResult(back), plainResult(source));
    assert.equal(JSON.stringify(back), text, 'the same text each time');
    assert.deepEqual(plainResult(Kind.fromJSON(JSON.parse(text))), plainResult(source));
    const { trajectories, embedding } = source;
    const raw = Object.values({ ...trajectories, ...embedding }).reduce((sum, list) => sum + (list.byteLength ?? 0), 0);
    const pixels = source.width * source.height * source.numFrames;
    assert.ok(text.length < raw + pixels / 10, `${text.length} for ${raw} bytes and ${pixels} pixels`);
  });

  test(`the result of ${name} keeps its data in a structured clone`, () => {
    const clone = structuredClone(source);
    assert.deepEqual(plainResult(Kind.fromJSON(clone)), plainResult(source));
  });
}

test('a saved result has no session, and says so', async () => {
  const back = Result.fromJSON(JSON.stringify(result));
  await rejects(back.superpixels(0), 'state', /saved has no superpixels; a session keeps them/);
});

test('results with other labels are saved too', async () => {
  const [{ label }] = collected.objects;
  const editor = editMasks(collected);
  await editor.merge(200, label);
  const edited = await editor.toResult();
  assert.deepEqual(plainResult(VideoResult.fromJSON(JSON.stringify(edited))), plainResult(edited));
  assert.ok(edited.labels(0).includes(200) && !collected.labels(0).includes(200));
});

test('damaged, truncated and other files are refused', () => {
  const text = JSON.stringify(collected);
  const refused = (json, message, Kind = VideoResult) =>
    assert.throws(() => Kind.fromJSON(json), { name: 'TraceCutError', code: 'data', message });
  refused(text.slice(0, -9), /no JSON/);
  refused(JSON.stringify(result), /it has no times/);
  refused(text, /it has no clusters/, Result);
  refused(7, /json = 7/, Result);
  const changed = (field, value) => JSON.stringify({ ...JSON.parse(text), [field]: value });
  refused(changed('width', 0), /width = 0/);
  refused(changed('width', SCENE.width + 1), /covers/);
  const { runs } = JSON.parse(text);
  refused(changed('runs', { ...runs, data: runs.data.slice(0, 8) }), /cut off|cover/);
  refused(changed('runs', { ...runs, data: '§' }), /base64/);
  refused(changed('runs', { ...runs, length: 3 }), /length.* = 3/);
});

const [width, height] = [12, 8];

/** The synthetic clip of the Rust test of the same table. */
const handmade = {
  width,
  height,
  numFrames: 3,
  labels: (t) =>
    mapPixels(width, height, (x, y) => {
      if (x >= 1 + t && x < 5 + 2 * t && y >= 2 && y < 5) return 1;
      return t !== 1 && x + y > 16 ? 7 : 0;
    }),
  doubts: [{ from: 1, to: 2 }],
  trajectories: {
    startFrame: [0, 0, 1, 0],
    offset: [0, 3, 5, 7, 9],
    x: Float32Array.of(1.25, 2.5, 4, 4.49, 5, 6, 5.75, 11.5, 11),
    y: Float32Array.of(2, 2.0625, 2.5, 4.49, 4, 4.5, 4.25, 7.5, 7),
  },
};

test('the table of a synthetic clip equals the one that native code writes', async () => {
  const expected = readFileSync(new URL('../data/objects.csv', import.meta.url), 'utf8');
  assert.equal(await objectTableCsv(await objectTable(handmade)), expected.replaceAll('\r', ''));
});

test('rows have times where there are any, and objects can be chosen', async () => {
  const rows = await objectTable(handmade, { frameRate: 10, objects: [7] });
  assert.deepEqual(each(rows, 'frame', 'time', 'object'), [
    [0, 0, 7],
    [2, 0.2, 7],
  ]);
  const [still] = await objectTable({ ...handmade, trajectories: undefined, doubts: undefined });
  assert.deepEqual([still.dx, still.dy, still.trajectories, still.doubt], [null, null, 0, null]);
  assert.match(await objectTableCsv(rows), /\n2,0\.2,7,10,6,2,2,3,10\.667,6\.667,,,0,0\n$/);
  assert.deepEqual(JSON.parse(JSON.stringify(rows)), rows);
  await assert.rejects(objectTable(handmade, { trajectories: {} }), { code: 'data' });
  await assert.rejects(objectTable(handmade, { motion: true }), { code: 'param' });
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
  const rows = await objectTable(collected);
  assert.ok(collected.objects.length > 0 && rows.some(({ trajectories: count }) => count > 0));
  for (const { label, areas } of collected.objects) {
    const objectRows = rows.filter(({ object }) => object === label);
    const present = [...areas].filter((area) => area > 0);
    assert.deepEqual(each(objectRows, 'area'), present);
    for (const { time, frame, doubt } of objectRows) {
      assert.equal(time, collected.times[frame]);
      assert.equal(
        doubt,
        collected.doubts.some(({ from, to }) => from <= frame && frame < to),
      );
    }
  }
});

/** Two trajectories over three frames of 32 x 16: one rests, one goes 3 right and 4 down a frame. */
const two = {
  width: 32,
  height: 16,
  numFrames: 3,
  trajectories: { count: 2, offset: [0, 3, 6], x: [4, 4, 4, 20, 23, 26], y: [2, 2, 2, 3, 7, 11] },
  clusters: { count: 2, label: [1, 0] },
};

test('coverage, speed and motions come from the points', () => {
  assert.deepEqual(searchReport(two), {
    numFrames: 3,
    trajectories: 2,
    // One square for the point that rests, three for the other, of 16 by 8.
    coverage: 4 / 128,
    speed: 5,
    cameraMoves: true,
    motions: [0.5, 0.5],
  });
  const { motions, ...rest } = searchReport({ ...two, clusters: undefined });
  assert.equal(motions, null);
  assert.equal(rest.speed, 5);
});

test('a clip without texture has nothing that could be followed', async () => {
  const result = await segment(Array.from({ length: 5 }, () => plain(64, 48, 90)));
  assert.deepEqual(searchReport(result), {
    numFrames: 5,
    trajectories: 0,
    coverage: 0,
    speed: 0,
    cameraMoves: false,
    motions: [],
  });
});

test('a panning camera is distinguished from a still one, in one window and in many', async () => {
  const scene = { width: 96, height: 54, frames: 8, seed: 5 };
  const frames = await framesOf(scene);
  assert.equal(searchReport(await resultOf(scene)).cameraMoves, true);
  const still = Array.from({ length: 5 }, () => frames[0]);
  const report = searchReport(await segment(still));
  assert.equal(report.cameraMoves, false);
  assert.ok(report.coverage > 0.5, `${report.coverage}`);
  const collected = await segmentVideo(frames, { window: 6, overlap: 2 }).collect();
  assert.equal(searchReport(collected).motions, null);
  assert.equal(searchReport(collected).cameraMoves, true);
});

test('invalid results are refused', () => {
  assert.throws(() => searchReport(null), { code: 'data', message: /result = null/ });
  assert.throws(() => searchReport({ ...two, trajectories: { ...two.trajectories, offset: [0] } }), {
    code: 'data',
    message: /1 entries \(expected 3\)/,
  });
});
