// What the studio saves of a result, and the texts of the save dialog.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { version } from 'tracecut';
import { objectColor } from 'tracecut/draw';
import { adjustMask, smoothMasks } from 'tracecut/edit';
import { exportSource, fileStem } from '../../build/model/export.js';
import { exportSizes, resizedFrames } from '../../build/model/export-text.js';
import * as texts from '../../build/model/export-text.js';
import { MAIN_EXPORTS, otherExports } from '../../build/model/exports.js';
import { createRecipe } from '../../build/model/recipe.js';
import { Smoothing } from '../../build/model/smoothing.js';
import { maskEdges } from '../../build/model/view-settings.js';
import { unzipSync } from '../../dist/vendor/zip.js';
import { readPng } from '../png.mjs';
import { SAMPLE, openSampleWork } from './studio.mjs';

const FRAME = 12;

/** The sample with a result, its exports at a size, and its masks without specks. @param {number[]} hidden objects */
async function openExports(side = SAMPLE.width, hidden = [], smallest = 0.02) {
  const { store, selection } = await openSampleWork();
  hidden.forEach((object) => selection.toggle(object));
  store.set({ frame: FRAME, edges: { ...store.state.edges, smallest } });
  const source = exportSource(store.state);
  const { stream, read } = resizedFrames(store.state.job, source.masks, side);
  const edges = maskEdges(store.state.edges, source.masks);
  const subject = {
    ...source,
    ...{ frames: stream, image: read, edges, sound: () => null },
    objects: (object) => object > 0 && selection.has(object),
  };
  const choices = [...MAIN_EXPORTS, ...otherExports({ choices: [] })].flatMap((group) => group.choices);
  const fileName = (id) => choices.find((choice) => choice.id === id).file(subject);
  const save = async (id) => {
    const task = { signal: new AbortController().signal, onProgress() {} };
    const file = await choices.find((choice) => choice.id === id).make(subject, task);
    return new Uint8Array(await new Response(file).arrayBuffer());
  };
  const { width, height } = source.masks;
  const labels = (t) => adjustMask({ labels: source.masks.labels(t), width, height }, edges).labels;
  return { store, choices, source, subject, fileName, save, labels };
}

const text = (bytes) => new TextDecoder().decode(bytes);
const sizeOf = (png) => [16, 20].map((at) => Buffer.from(png).readUInt32BE(at));

test('masks are saved without specks, in the colours of the objects, with their times', async () => {
  // No piece of the sample is smaller than its smallest object.
  const { source, fileName, save, labels } = await openExports(SAMPLE.width, [], 4.5);
  const hasSpecks = Array.from({ length: SAMPLE.frames }, (_, t) => t).some(
    (t) => labels(t).join() !== source.masks.labels(t).join(),
  );
  assert.ok(hasSpecks);
  assert.equal(fileName('png'), 'mask-0013.png');
  const { pixels, palette } = readPng(await save('png'));
  assert.deepEqual(pixels, labels(FRAME));
  assert.equal(`#${Buffer.from(palette.subarray(3, 6)).toString('hex')}`, objectColor(1));
  const files = unzipSync(await save('zip'));
  const names = Object.keys(files).filter((name) => name.endsWith('.png'));
  assert.equal(names.length, SAMPLE.frames);
  names.forEach((name, t) => assert.deepEqual(readPng(files[name]).pixels, labels(t)));
  const info = JSON.parse(text(files['masks.json']));
  assert.equal(info.version, version);
  assert.ok(Math.abs(info.times[3] - 3 / 15) < 1e-6);
});

test('cut-out images for editors have a timeline at a frame rate that editors know', async () => {
  const { choices, fileName, save, labels } = await openExports();
  assert.deepEqual(['cutout-zip', 'cutout-apng', 'alpha-zip', 'alpha-webm'].map(fileName), [
    ...['cutout.zip', 'cutout.png', 'alpha.zip', 'mask.webm'],
  ]);
  // Only these are streamed to disk.
  assert.deepEqual(
    choices.filter(({ type }) => type).map(({ id, type }) => `${id} ${type}`),
    ['cutout-zip application/zip', 'cutout-apng image/png', 'alpha-zip application/zip'],
  );
  const files = unzipSync(await save('cutout-zip'));
  // At 30 frames per second; the clip has 15, and no sound.
  assert.deepEqual(Object.keys(files).length, 2 * SAMPLE.frames + 2);
  assert.match(text(files['timeline.xml']), /<duration>32<\/duration><rate><timebase>30</);
  assert.match(text(files['README.txt']), /192 x 108 pixels/);
  assert.deepEqual(sizeOf(files[`cutout/0000${2 * FRAME + 1}.png`]), [SAMPLE.width, SAMPLE.height]);
  const alpha = readPng(unzipSync(await save('alpha-zip'))['00012.png']);
  assert.deepEqual(
    [...alpha.pixels],
    [...labels(FRAME)].map((label) => (label > 0 ? 255 : 0)),
  );
});

test('all files have the chosen size', async () => {
  const { source, save } = await openExports(SAMPLE.width / 2);
  const half = [SAMPLE.width / 2, SAMPLE.height / 2];
  assert.deepEqual(sizeOf(await save('png')), half);
  for (const id of ['zip', 'zip-objects', 'cutout-zip']) {
    const files = unzipSync(await save(id));
    assert.deepEqual(sizeOf(files[Object.keys(files).find((name) => name.endsWith('.png'))]), half, id);
  }
  const { images } = JSON.parse(text(await save('coco')));
  assert.deepEqual([images.length, images[0].width, images[0].height], [SAMPLE.frames, ...half]);
  const video = { width: 1920, height: 1080 };
  assert.deepEqual(
    exportSizes(video, source.masks).map(({ label }) => label),
    ['Same as source, 1920 × 1080', 'Half, 960 × 540', 'Working size, 192 × 108', 'Other…'],
  );
});

test('exports contain the objects that are shown, in files with their own names', async () => {
  const { store, source, subject, fileName, save } = await openExports(SAMPLE.width, [3]);
  assert.deepEqual(source.masks.shots, [{ first: 0, last: 15 }]);
  assert.deepEqual(['transparent', 'green', 'blurred', 'zip'].map(fileName), [
    ...['cutout.webm', 'green.mp4', 'blur.mp4', 'masks.zip'],
  ]);
  // A cut-out on the backdrop of the page is named after that.
  assert.deepEqual(['cutout-webm', 'cutout-mp4'].map(fileName), ['cutout.webm', 'green.mp4']);
  subject.state = { ...source.state, backdrop: { ...source.state.backdrop, name: 'dimmed' } };
  assert.deepEqual(['cutout-webm', 'cutout-mp4', 'green'].map(fileName), [
    ...['spotlight.webm', 'spotlight.mp4', 'green.mp4'],
  ]);
  assert.equal(JSON.parse(text(await save('coco'))).annotations.length, 32);
  const rows = text(await save('table'))
    .trim()
    .split('\n')
    .slice(1);
  assert.deepEqual([...new Set(rows.map((row) => row.split(',')[2]))], ['1', '2']);
  const names = Object.keys(unzipSync(await save('zip-objects')));
  assert.equal(names.filter((name) => name.endsWith('.png')).length, 32);
  assert.match(text(await save('tracks')), /^16\n\d+\n/);
  const { job } = store.state;
  const recipe = JSON.parse(await createRecipe({ version, job, masks: source.masks, corrections: 2 }));
  assert.deepEqual([recipe.tracecut, recipe.corrections, recipe.masks.frames], [version, 2, 16]);
  assert.match(recipe.masks.sha256, /^[0-9a-f]{64}$/);
});

test('file names start with the name of the clip', () => {
  assert.deepEqual(['Sample clip', 'My Film (2).MP4', 'frame000.png … frame169.png', '../.mp4', ''].map(fileStem), [
    'sample-clip',
    'my-film-2',
    'frame000',
    'clip',
    'clip',
  ]);
});

test('smoothed masks equal those of the package, and belong to the newest settings', async (t) => {
  const { store } = await openExports();
  t.mock.timers.enable({ apis: ['setTimeout'] });
  new Smoothing(store);
  const smooth = (reach) => {
    store.set({ edges: { ...store.state.edges, smooth: reach } });
    t.mock.timers.tick(250);
    return store.state.smoothedMasks;
  };
  const overtaken = assert.rejects(smooth(2).complete, { name: 'AbortError' });
  const { complete, total } = smooth(1);
  await overtaken;
  t.mock.timers.reset();
  const masks = await complete;
  assert.deepEqual([store.state.smoothedMasks.done, total], [SAMPLE.frames, SAMPLE.frames]);
  const { analysis, job, timeline } = store.state;
  const unsmoothed = { ...SAMPLE, numFrames: SAMPLE.frames, labels: (k) => analysis.segmentation.mask(k) };
  const times = timeline.times.seconds.slice(0, SAMPLE.frames);
  const expected = await smoothMasks({ ...unsmoothed, times }, { picture: (k) => job.corrections.pixels(k) });
  for (let k = 0; k < SAMPLE.frames; k += 1) {
    assert.deepEqual(masks.labels(k), expected.labels(k));
    assert.deepEqual(store.state.smoothedMasks.labels(k), expected.labels(k));
  }
  assert.notDeepEqual(masks.labels(FRAME), analysis.segmentation.mask(FRAME));
  store.set({ edges: { ...store.state.edges, smooth: 0 } });
  assert.equal(store.state.smoothedMasks, null);
});

test('the dialog tells size, length, sound, kept objects and progress', async () => {
  const { source } = await openExports();
  const size = { width: 500, height: 281 };
  assert.equal(texts.describeImages(size, 6), '500 × 281, 6 frames');
  assert.match(texts.describeVideo(size, source, 'high'), /^500 × 281, 1\.1\u00a0s, about [\d.]+\u00a0[kKM]B$/);
  const sound = (codec, formats, converted = []) => texts.describeSound({ codec, formats, converted });
  assert.equal(sound('opus', ['webm', 'mp4', 'wav']), 'Opus, unchanged.');
  assert.equal(sound('pcm-s16', ['webm', 'mp4'], ['webm']), 'pcm-s16, unchanged; Opus in WebM.');
  assert.equal(sound('aac', ['mp4']), 'AAC, unchanged; no sound in WebM.');
  assert.equal(sound('ac3', []), 'AC-3, unchanged; no sound in WebM and MP4.');
  assert.equal(texts.describeSound(null), '');
  assert.equal(texts.describeKept({ kept: [1, 2], all: 2 }), '');
  assert.equal(texts.describeKept({ kept: [2, 3], all: 3 }), 'Only Object 2, Object 3 will be saved.');
  assert.match(texts.describeKept({ kept: [], all: 2 }), /^Nothing is selected/);
  assert.equal(texts.describeProgress({ done: 0, total: 0 }, null), '');
  assert.equal(texts.describeProgress({ done: 0, total: 1 }, null), '0 of 1 frame');
  assert.equal(texts.describeProgress({ done: 3, total: 1600 }, 33_000), '3 of 1,600 frames, about 35\u00a0s left');
});
