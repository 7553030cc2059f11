// Clips in other ways than segmentVideo: one after the other, previewed, as a strip of pictures.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  masksZip,
  previewMasks,
  segmentEach,
  segmentVideo,
  synthClip,
  videoFrames,
  VideoResult,
  videoStrip,
} from 'tracecut';
import { clipsZip } from 'tracecut/export';
import { unzipSync } from '../../dist/vendor/zip.js';
import { abortAt, collect, each, framesOf, overlapOf, plain, png, rejects } from './support.mjs';

const TINY = { width: 64, height: 48, frames: 5, seed: 3 };

const segmentAll = (clips, options) => collect(segmentEach(clips, options));

test('each clip gives what it gives alone; one that fails, or is taken out, stops no other', async () => {
  const frames = await framesOf(TINY);
  const reports = [];
  const clips = [
    { name: 'a.mp4', source: frames },
    { name: 'empty', source: [] },
    { name: 'out', source: frames, signal: AbortSignal.abort(new Error('taken out')) },
    { name: 'cut', source: [...frames.map((frame) => png(frame)), new Uint8Array(9)] },
  ];
  const outcomes = await segmentAll(clips, {
    onProgress: ({ index, name, stage }) => reports.push(`${index} ${name} ${stage}`),
  });
  const facts = outcomes.map(({ index, name, result }) => `${index} ${name} ${result?.numFrames ?? 'none'}`);
  assert.deepEqual(facts, ['0 a.mp4 5', '1 empty none', '2 out none', '3 cut 5']);
  const expected = await segmentVideo(frames).collect();
  for (let t = 0; t < 5; t += 1) assert.deepEqual(outcomes[0].result.labels(t), expected.labels(t));
  assert.equal(outcomes[1].error.code, 'no-frames');
  assert.match(outcomes[2].error.message, /taken out/);
  assert.deepEqual([outcomes[3].damage.frames, outcomes[3].damage.total], [5, 6]);
  assert.ok(
    reports.includes('0 a.mp4 decode') && reports.some((line) => line.startsWith('3 cut masks')),
    reports.join(),
  );
});

test('a queue grows on the way, is left early, and ends as a whole', async () => {
  const frames = await framesOf(TINY);
  let requests = 0;
  async function* growing() {
    for (;;) {
      requests += 1;
      yield { name: `clip ${requests}`, source: frames };
    }
  }
  for await (const { index } of segmentEach(growing())) if (index === 1) break;
  assert.equal(requests, 2);
  const aborted = segmentAll([{ name: 'a', source: frames }], abortAt({ reason: new Error('enough') }));
  await assert.rejects(aborted, /enough/);
});

test('wrong options and invalid clips are errors of the call', async () => {
  await rejects(segmentAll([{ name: 'a', source: [] }], { window: 1 }), 'param', /window = 1/);
  await rejects(segmentAll([{ source: [] }]), 'data', /clips\[0\]/);
  await rejects(segmentAll([], { onProgress: 1 }), 'param', /onProgress/);
});

test('one archive: a folder for each clip, a report that names what failed, the same bytes again', async () => {
  const masks = await segmentVideo(Array.from({ length: 3 }, () => plain(32, 24, 80))).collect();
  const clips = [
    { name: 'my clip.mp4', masks, about: { objects: 0 } },
    { name: 'my-clip.webm', masks },
    { name: 'broken.mp4', masks: null, error: new Error('no frames in it') },
  ];
  const counted = [];
  const zip = await clipsZip(clips, { onProgress: (step) => counted.push(`${step.done}/${step.total}`) });
  const files = unzipSync(zip);
  const names = ['00000.png', '00001.png', '00002.png', 'masks.json'];
  const paths = ['my-clip-2', 'my-clip'].flatMap((folder) => names.map((name) => `${folder}/${name}`));
  assert.deepEqual(Object.keys(files).sort(), [...paths, 'report.json']);
  const expected = unzipSync(await masksZip(masks));
  for (const [name, bytes] of Object.entries(expected)) assert.deepEqual(files[`my-clip/${name}`], bytes);
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

const MOVING = { width: 340, height: 192, frames: 16, seed: 0 };

const masksOf = (result) => Array.from({ length: result.numFrames }, (_, t) => result.labels(t));

test('eight frames, every second one, at the size of the frames, much like the true ones', async () => {
  const clip = await synthClip(MOVING);
  let requests = 0;
  async function* counted() {
    for (let t = 0; t < MOVING.frames; t += 1) {
      requests += 1;
      yield clip.frame(t);
    }
  }
  const coarse = await previewMasks(counted(), { frameRate: 10 });
  assert.ok(coarse instanceof VideoResult);
  const times = [0, 2, 4, 6, 8, 10, 12, 14].map((t) => t / 10);
  assert.deepEqual([...coarse.times], times);
  assert.deepEqual([coarse.width, coarse.height], [MOVING.width, MOVING.height]);
  assert.equal(requests, 15, 'no frame is read that is not needed');
  masksOf(coarse).forEach((mask, k) => {
    const sharedPixels = overlapOf(mask, clip.mask(2 * k));
    assert.ok(sharedPixels > 0.6, `frame ${2 * k}: ${sharedPixels}`);
  });
});

test('is segmentVideo of these frames at this size, and options say which', async () => {
  const frames = (await framesOf(MOVING)).slice(0, 5);
  const options = { step: 2, maxFrames: 2, clip: { maxSide: 160, seed: 4 } };
  const coarse = await previewMasks(frames, options);
  const expected = await segmentVideo(frames, options).collect();
  assert.deepEqual(coarse.times, expected.times);
  assert.deepEqual(masksOf(coarse), masksOf(expected));
  const usual = { step: 2, maxFrames: 8, clip: { maxSide: 320 } };
  const usualMasks = masksOf(await previewMasks(frames, { step: undefined, clip: undefined }));
  assert.deepEqual(usualMasks, masksOf(await segmentVideo(frames, usual).collect()));
});

test('bad options and sources reject as segmentVideo says, and an abort ends it', async () => {
  const frames = await framesOf({ width: 64, height: 48, frames: 16, seed: 3 });
  await rejects(previewMasks(frames, { clip: 320 }), 'param', /clip = 320 .*maxSide/);
  await rejects(previewMasks(frames, { clip: { maxSide: 2 } }), 'param', /clip\.maxSide = 2 .*16/);
  await rejects(previewMasks(frames, { steps: 2 }), 'param', /steps/);
  await rejects(previewMasks(frames, 7), 'param', /options = 7/);
  const still = await previewMasks([plain(16, 16)]);
  assert.deepEqual([still.numFrames, still.objects], [1, []]);
  const stop = new AbortController();
  const ends = previewMasks(frames, { signal: stop.signal });
  stop.abort(new Error('enough'));
  await assert.rejects(ends, /enough/);
});

/** A list of frames whose red says their number. */
const numbered = (count) => Array.from({ length: count }, (_, k) => plain(64, 32, k));

async function stripOf(source, options) {
  const calls = [];
  for await (const { frame, index, time, duration } of videoStrip(source, options))
    calls.push({ number: frame.data[0], index, time, duration, size: `${frame.width}x${frame.height}` });
  return calls;
}

test('frames are the middles of equal parts, in order, with their times', async () => {
  const strip = await stripOf(numbered(40), { count: 4, frameRate: 10 });
  assert.deepEqual(each(strip, 'number'), [5, 15, 25, 35]);
  assert.deepEqual(strip[1], { number: 15, index: 1, time: 1.5, duration: 0.1, size: '64x32' });
});

test('a part of the clip, at a smaller size; a short clip gives each frame once', async () => {
  const part = await stripOf(numbered(40), { count: 2, frameRate: 10, start: 1, end: 2, size: 16 });
  assert.deepEqual(each(part, 'number', 'size').flat(), [12, '16x8', 17, '16x8']);
  const few = await stripOf(numbered(3), {});
  assert.deepEqual(each(few, 'number'), [0, 1, 2]);
});

test('leaving early and aborting end it', async () => {
  for await (const { index } of videoStrip(numbered(40))) if (index === 1) break;
  await assert.rejects(stripOf(numbered(40), { signal: AbortSignal.abort(new Error('enough')) }), /enough/);
});

test('a source without a strip and an unknown option are refused by name', async () => {
  async function* generated() {
    yield* await framesOf({ width: 32, height: 32, frames: 3 });
  }
  await rejects(stripOf(generated()), 'unsupported', /no strip/);
  await rejects(stripOf(numbered(3), { count: 0 }), 'param', /count = 0 .*1/);
  await rejects(stripOf(numbered(3), { step: 2 }), 'param', /step = 2/);
  await rejects(stripOf(numbered(3), { many: 2 }), 'param', /many = 2/);
  await rejects(stripOf(numbered(3), { start: 9 }), 'no-frames', /no frame from 9 s/);
});

test('with onDamage frames before a damaged picture come, in a strip, decoded and segmented; without it that is an error', async () => {
  const files = (await framesOf({ width: 48, height: 32, frames: 6 })).map((frame) => png(frame));
  files[4] = files[4].subarray(0, 70);
  const damages = [];
  const onDamage = ({ frames, total, error }) => damages.push([frames, total, error.code]);
  let count = 0;
  for await (const { index } of videoFrames(files, { onDamage })) count = index + 1;
  assert.equal(count, 4);
  const { numFrames } = await segmentVideo(files, { window: 3, overlap: 1, onDamage }).collect();
  assert.equal(numFrames, 4);
  assert.equal((await stripOf(files, { onDamage })).length, 4);
  assert.deepEqual(damages, Array(3).fill([4, 6, 'decode']));
  await rejects(stripOf(files), 'decode');
  await rejects(segmentVideo(files).collect(), 'decode');
  // One frame is no clip.
  await rejects(segmentVideo([files[0], files[4]], { onDamage }).collect(), 'decode');
  await rejects(stripOf(files, { onDamage: true }), 'param', /onDamage = true/);
});
