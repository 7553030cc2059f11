// segmentEach and clipsZip: one clip after the other, failures that stop nothing, one archive.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { masksZip, segmentEach, segmentVideo } from 'tracecut';
import { clipsZip } from 'tracecut/export';
import { unzipSync } from '../../dist/vendor/zip.js';
import { framesOf, plain, png, rejects } from './support.mjs';

const TINY = { width: 64, height: 48, frames: 5, seed: 3 };

async function all(clips, options) {
  const done = [];
  for await (const clip of segmentEach(clips, options)) done.push(clip);
  return done;
}

test('each clip gives what it gives alone; one that fails, or is taken out, stops no other', async () => {
  const frames = await framesOf(TINY);
  const out = new AbortController();
  out.abort(new Error('taken out'));
  const heard = [];
  const clips = [
    { name: 'a.mp4', source: frames },
    { name: 'empty', source: [] },
    { name: 'out', source: frames, signal: out.signal },
    { name: 'cut', source: [...frames.map((frame) => png(frame)), new Uint8Array(9)] },
  ];
  const done = await all(clips, { onProgress: ({ index, name, stage }) => heard.push(`${index} ${name} ${stage}`) });
  assert.deepEqual(
    done.map(({ index, name, result }) => [index, name, result?.numFrames ?? null]),
    [
      [0, 'a.mp4', 5],
      [1, 'empty', null],
      [2, 'out', null],
      [3, 'cut', 5],
    ],
  );
  const alone = await segmentVideo(frames).collect();
  for (let t = 0; t < 5; t += 1) assert.deepEqual(done[0].result.labels(t), alone.labels(t));
  assert.equal(done[1].error.code, 'no-frames');
  assert.match(done[2].error.message, /taken out/);
  assert.deepEqual([done[3].damage.frames, done[3].damage.total], [5, 6]);
  assert.ok(heard.includes('0 a.mp4 decode') && heard.some((line) => line.startsWith('3 cut masks')), heard.join());
});

test('a queue grows on the way, is left early, and ends as a whole', async () => {
  const frames = await framesOf(TINY);
  let asked = 0;
  async function* growing() {
    for (;;) {
      asked += 1;
      yield { name: `clip ${asked}`, source: frames };
    }
  }
  for await (const { index } of segmentEach(growing())) if (index === 1) break;
  assert.equal(asked, 2);
  const stop = new AbortController();
  const onProgress = () => stop.abort(new Error('enough'));
  await assert.rejects(all([{ name: 'a', source: frames }], { signal: stop.signal, onProgress }), /enough/);
});

test('wrong options and what is no clip are errors of the call', async () => {
  await rejects(all([{ name: 'a', source: [] }], { window: 1 }), 'param', /window = 1/);
  await rejects(all([{ source: [] }]), 'data', /clips\[0\]/);
  await rejects(all([], { onProgress: 1 }), 'param', /onProgress/);
});

test('one archive: a folder for each clip, a report that names what failed, the same bytes again', async () => {
  const masks = await segmentVideo(Array.from({ length: 3 }, () => plain(32, 24, 80))).collect();
  const clips = [
    { name: 'my clip.mp4', masks, about: { objects: 0 } },
    { name: 'my-clip.webm', masks },
    { name: 'broken.mp4', masks: null, error: new Error('no frames in it') },
  ];
  const counted = [];
  const zip = await clipsZip(clips, { onProgress: ({ done, total }) => counted.push(`${done}/${total}`) });
  const files = unzipSync(zip);
  assert.deepEqual(Object.keys(files).sort(), [
    'my-clip-2/00000.png',
    'my-clip-2/00001.png',
    'my-clip-2/00002.png',
    'my-clip-2/masks.json',
    'my-clip/00000.png',
    'my-clip/00001.png',
    'my-clip/00002.png',
    'my-clip/masks.json',
    'report.json',
  ]);
  const alone = unzipSync(await masksZip(masks));
  for (const [name, bytes] of Object.entries(alone)) assert.deepEqual(files[`my-clip/${name}`], bytes);
  assert.deepEqual(JSON.parse(Buffer.from(files['report.json']).toString()).clips, [
    { name: 'my clip.mp4', folder: 'my-clip', width: 32, height: 24, numFrames: 3, objects: 0 },
    { name: 'my-clip.webm', folder: 'my-clip-2', width: 32, height: 24, numFrames: 3 },
    { name: 'broken.mp4', error: 'no frames in it' },
  ]);
  assert.deepEqual(counted, ['1/6', '2/6', '3/6', '4/6', '5/6', '6/6']);
  assert.deepEqual(await clipsZip(clips), zip);
  await rejects(clipsZip(masks), 'data', /clips/);
  await rejects(clipsZip(clips, { objects: [1] }), 'param', /objects/);
});
