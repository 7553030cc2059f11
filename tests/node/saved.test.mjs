// Results that are saved as JSON, or copied to another thread: nothing of them is lost without a word.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Result, VideoResult, WindowResult, createSession, segmentVideo, synthClip } from 'tracecut';
import { editMasks } from 'tracecut/edit';

const clip = await synthClip({ width: 320, height: 180, frames: 10, seed: 2 });
const frames = Array.from({ length: clip.numFrames }, (_, t) => clip.frame(t));
const session = await createSession();
for (const frame of frames) await session.push(frame);
const result = await session.run();
const video = segmentVideo(frames, { window: 8, overlap: 3 });
const windows = [];
for await (const window of video) windows.push(window);
const whole = await segmentVideo(frames, { window: 8, overlap: 3 }).collect();
session.close();

const refuses = (code, message) => (error) => {
  assert.equal(error.code, code);
  assert.match(error.message, message);
  return true;
};

/** All that a result says, besides what only a session can. */
function said(one) {
  const masks = Array.from({ length: one.numFrames }, (_, t) => one.labels(t));
  const edges = one.edges && Array.from({ length: one.numFrames }, (_, t) => one.edges(t));
  return { ...one, masks, edges, tracks: one.toTracksDat(), frames: one.frames && [...one.frames()] };
}

for (const [name, Kind, one] of [
  ['a session', Result, result],
  ['a window', WindowResult, windows[1]],
  ['a clip', VideoResult, whole],
]) {
  test(`the result of ${name} is the same after JSON, to the last bit, and small`, () => {
    const text = JSON.stringify(one);
    const back = Kind.fromJSON(text);
    assert.ok(back instanceof Kind);
    assert.deepEqual(said(back), said(one));
    assert.equal(JSON.stringify(back), text, 'the same text each time');
    assert.deepEqual(said(Kind.fromJSON(JSON.parse(text))), said(one));
    const { trajectories, embedding } = one;
    const raw = Object.values({ ...trajectories, ...embedding }).reduce((sum, list) => sum + (list.byteLength ?? 0), 0);
    const pixels = one.width * one.height * one.numFrames;
    assert.ok(text.length < raw + pixels / 10, `${text.length} for ${raw} bytes and ${pixels} pixels`);
  });

  test(`the result of ${name} keeps its data in a structured clone`, () => {
    const clone = structuredClone(one);
    assert.deepEqual(said(Kind.fromJSON(clone)), said(one));
  });
}

test('a saved result has no session, and says so', async () => {
  const back = Result.fromJSON(JSON.stringify(result));
  await assert.rejects(back.superpixels(0), refuses('state', /saved has no superpixels; a session keeps them/));
});

test('results without masks and with other labels are saved too', async () => {
  const bare = await createSession({ clip: { dense: false } });
  for (const frame of frames.slice(0, 4)) await bare.push(frame);
  const none = Result.fromJSON(JSON.stringify(await bare.run()));
  assert.deepEqual([none.masks, none.objects], [null, null]);
  bare.close();
  const [{ label }] = whole.objects;
  const editor = editMasks(whole);
  await editor.merge(200, label);
  const other = await editor.toResult();
  assert.deepEqual(said(VideoResult.fromJSON(JSON.stringify(other))), said(other));
  assert.ok(other.labels(0).includes(200) && !whole.labels(0).includes(200));
});

test('what is damaged, cut off or of another kind is refused', () => {
  const text = JSON.stringify(whole);
  assert.throws(() => VideoResult.fromJSON(text.slice(0, -9)), refuses('data', /no JSON/));
  assert.throws(() => VideoResult.fromJSON(JSON.stringify(result)), refuses('data', /it has no times/));
  assert.throws(() => Result.fromJSON(text), refuses('data', /it has no clusters/));
  assert.throws(() => Result.fromJSON(7), refuses('data', /json = 7/));
  const changed = (field, value) => JSON.stringify({ ...JSON.parse(text), [field]: value });
  assert.throws(() => VideoResult.fromJSON(changed('width', 0)), refuses('data', /width = 0/));
  assert.throws(() => VideoResult.fromJSON(changed('width', 321)), refuses('data', /covers/));
  const { runs } = JSON.parse(text);
  const cut = { ...runs, data: runs.data.slice(0, 8) };
  assert.throws(() => VideoResult.fromJSON(changed('runs', cut)), refuses('data', /cut off|cover/));
  assert.throws(() => VideoResult.fromJSON(changed('runs', { ...runs, data: '§' })), refuses('data', /base64/));
  assert.throws(() => VideoResult.fromJSON(changed('runs', { ...runs, length: 3 })), refuses('data', /length.* = 3/));
});
