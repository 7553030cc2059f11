// Expected results: labels and masks of two scenes, and the hashes of the self test, the same in Node, in browsers (tests/engines)
// and natively (cli/tests/cli.rs). After an intended change of results, `REGENERATE=1 npm test -- node` rewrites the files, and fails so that the
// change is reviewed.

import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { segmentVideo, synthClip } from 'tracecut';
import * as tracecut from 'tracecut';
import { selftest } from 'tracecut/selftest';
import { root } from '../../scripts/tools.mjs';
import { fnv1a, segment } from './support.mjs';

const scenes = {
  'golden-sample': { width: 240, height: 135, frames: 10, seed: 1 },
  'golden-odd': { width: 201, height: 151, frames: 8, seed: 5 },
};

for (const [name, scene] of Object.entries(scenes)) {
  test(`${name} is labelled as before`, async () => {
    const clip = await synthClip(scene);
    const frames = Array.from({ length: scene.frames }, (_, t) => clip.frame(t));
    isAsBefore(name, scene, summary(frames, await segment(frames)));
  });
}

test('golden-windows is labelled as before, window by window', async () => {
  // A cut in the middle of a window, and one right after a full window.
  const shots = [
    { width: 160, height: 90, frames: 27, seed: 1 },
    { width: 160, height: 90, frames: 12, seed: 7 },
    { width: 160, height: 90, frames: 8, seed: 3 },
  ];
  const clips = await Promise.all(shots.map((shot) => synthClip(shot)));
  const source = (async function* () {
    for (const [k, shot] of shots.entries()) for (let t = 0; t < shot.frames; t += 1) yield clips[k].frame(t);
  })();
  const windows = [];
  for await (const window of segmentVideo(source, { window: 12, overlap: 5 })) {
    const { index, shot, firstFrame } = window;
    const { from, to } = window.settled;
    const masks = [...window.frames()].map(({ labels }) => fnv1a(labels));
    windows.push({ index, shot, firstFrame, from, to, masks });
  }
  isAsBefore('golden-windows', { shots, window: 12, overlap: 5 }, { windows });
});

function isAsBefore(name, scene, actual) {
  const file = new URL(`../data/${name}.json`, import.meta.url);
  if (process.env.REGENERATE) {
    writeFileSync(
      file,
      `${JSON.stringify({ scene, ...actual }, null, 1).replace(/\[[^\][{}]*\]/g, (list) => list.replace(/\s+/g, ' '))}\n`,
    );
    assert.fail(`${name}.json was rewritten: look at the difference, then run again without REGENERATE`);
  }
  assert.ok(existsSync(file), `${name}.json is missing; make it with REGENERATE=1`);
  const { scene: expectedScene, ...expected } = JSON.parse(readFileSync(file, 'utf8'));
  assert.deepEqual(expectedScene, scene);
  assert.deepEqual(actual, expected);
}

function summary(frames, result) {
  const { trajectories, clusters, objects } = result;
  const mean = (values) => Number((values.reduce((sum, value) => sum + value, 0) / values.length).toFixed(3));
  const masks = frames.map((_, t) => result.labels(t));
  const pixels = createHash('sha256');
  for (const { data } of frames) pixels.update(data);
  return {
    pixels: pixels.digest('hex').slice(0, 16),
    trajectories: trajectories.count,
    points: trajectories.x.length,
    meanX: mean(trajectories.x),
    meanY: mean(trajectories.y),
    clusters: clusters.count,
    label: [...clusters.label],
    objects: [...clusters.object],
    // Pixels of each label in the whole clip tell how much has changed where the hashes only tell that it has.
    area: areas(masks, objects.at(-1)?.label ?? 0),
    masks: masks.map(fnv1a),
  };
}

function areas(masks, objects) {
  const area = new Array(objects + 1).fill(0);
  for (const mask of masks) for (const label of mask) area[label] += 1;
  return area;
}

const file = join(root, 'cli', 'src', 'selftest', 'expected.json');
const expected = JSON.parse(readFileSync(file, 'utf8'));

test('computes every expected hash with two threads', async () => {
  const names = [];
  const result = await selftest({ onCheck: (check) => names.push(check.name), threads: 2 });
  const hashes = Object.fromEntries(result.checks.map(({ name, hash }) => [name, hash]));
  if (process.env.REGENERATE) {
    writeFileSync(file, `${JSON.stringify({ version: tracecut.version, hashes }, null, 2)}\n`);
    assert.fail(`${file} has the new hashes: review them and build again`);
  }
  assert.deepEqual(hashes, expected.hashes);
  assert.equal(expected.version, tracecut.version);
  assert.equal(result.same, true);
  assert.deepEqual(names, Object.keys(expected.hashes));
  assert.ok(names.length >= 15, `${names.length} hashes`);
});

test('reports an engine that rounds numbers differently', async (t) => {
  t.mock.method(Math, 'round', Math.floor);
  const result = await selftest();
  assert.equal(result.same, false);
  assert.ok(
    result.checks.some((check) => check.name === 'discontinuities' && !check.same && check.hash !== check.expected),
  );
});

test('rejects wrong options and stops when aborted', async () => {
  await assert.rejects(
    selftest({ thread: 2 }),
    /thread = 2 \(expected a known option, such as threads; the options are onCheck, signal, /,
  );
  await assert.rejects(selftest(7), /options = 7/);
  await assert.rejects(selftest({ threads: 0 }), /threads = 0 \(expected a whole number, 1\.\.=64\)/);
  await assert.rejects(selftest({ signal: AbortSignal.abort() }), { name: 'AbortError' });
});
