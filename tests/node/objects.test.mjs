// The objects of a result: one list of one shape, whatever kind of result it is.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { createSession, Result, segmentVideo, synthClip } from 'tracecut';

const clip = await synthClip({ width: 192, height: 108, frames: 10, seed: 4 });
const frames = Array.from({ length: clip.numFrames }, (_, t) => clip.frame(t));

/** What the masks themselves say. */
function counted({ labels, numFrames }, label) {
  const areas = Array.from({ length: numFrames }, (_, t) => labels(t).filter((other) => other === label).length);
  const there = areas.flatMap((area, t) => (area > 0 ? [t] : []));
  const sum = areas.reduce((a, b) => a + b, 0);
  return {
    label,
    firstFrame: there[0],
    lastFrame: there.at(-1),
    frames: there.length,
    meanArea: sum / there.length,
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
  const session = await createSession();
  for (const frame of frames) await session.push(frame);
  const result = await session.run();
  isCounted(result);
  const [window] = await (async () => {
    const all = [];
    for await (const one of segmentVideo(frames)) all.push(one);
    return all;
  })();
  isCounted(window);
  const whole = await segmentVideo(frames).collect();
  isCounted(whole);
  assert.deepEqual(window.objects, result.objects);
  assert.deepEqual(whole.objects, result.objects);
  assert.deepEqual(Object.keys(whole.objects[0]), Object.keys(result.objects[0]));
  session.close();
});

test('the number of objects counts them, where labels have gaps', async () => {
  const session = await createSession();
  for (const frame of frames) await session.push(frame);
  const result = await session.run();
  const labels = result.objects.map(({ label }) => label);
  assert.ok(labels.length >= 2, `${labels}`);
  const merged = await session.merge(0, 1);
  assert.equal(merged.objects.length, labels.length - 1);
  assert.ok(merged.objects.at(-1).label > merged.objects.length, 'the highest label is no count');
  isCounted(merged);
  assert.ok(!merged.clusters.object.includes(1));
  session.close();
});

test('an object without a pixel is none', async () => {
  const session = await createSession();
  for (const frame of frames) await session.push(frame);
  const result = await session.run();
  const unseen = { label: 200, areas: new Uint32Array(result.numFrames) };
  const again = Result.fromJSON({ ...structuredClone(result), objects: [unseen, ...result.objects] });
  assert.deepEqual(again.objects, result.objects);
  session.close();
});

test('without masks there are none, and clusters have no objects', async () => {
  const session = await createSession({ clip: { dense: false } });
  for (const frame of frames.slice(0, 4)) await session.push(frame);
  const { objects, clusters } = await session.run();
  assert.deepEqual([objects, clusters.object], [null, null]);
  session.close();
});
