// What can be done in the studio, without a page: open, run, cancel, go on, change settings, correct, and what is told.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { unzipSync } from 'fflate';
import { version } from 'tracecut';
import { framesOf } from '../../build/model/corrections.js';
import { exportSource } from '../../build/model/export.js';
import { resizedFrames } from '../../build/model/export-size.js';
import { MAIN_EXPORTS, otherExports } from '../../build/model/exports.js';
import { createRecipe } from '../../build/model/recipe.js';
import { showCorrected } from '../../build/model/show-result.js';
import { describeFrame } from '../../build/model/describe.js';
import { CLIP, SAMPLE, openModel, openSampleWork } from './studio.mjs';

/** A file that is no clip. */
const NOTES = new File(['x'], 'notes.txt', { type: 'text/plain' });

/** Every headline that is shown from now on. */
function headlines(store) {
  const all = [];
  store.watch(['headline'], ({ headline }) => all.push(headline));
  return all;
}

const masksOf = ({ analysis }) =>
  Array.from({ length: analysis.segmentation.result.numFrames }, (_, t) => analysis.segmentation.mask(t).join('')).join(
    '|',
  );

test('the sample is opened, run, cancelled, resumed and corrected; other files and settings take its place', async () => {
  const { app, store } = await openModel();
  const said = headlines(store);
  await app.openSample();
  assert.equal(store.state.phase, 'done');
  assert.equal(store.state.headline, '3 moving objects');
  assert.match(store.state.subline, /^16 frames of 192 × 108 · computed in \d/);
  for (const words of ['Reading frames', 'Tracking motion', 'Drawing outlines'])
    assert.ok(said.includes(words), said.join());
  const before = masksOf(store.state);

  // Cancelled at once, it goes on where it was.
  const running = app.rerun();
  await new Promise((resolve) => setTimeout(resolve, 30));
  app.cancel();
  assert.equal(store.state.phase, 'stopped');
  await running;
  await app.resume();
  assert.equal(store.state.phase, 'done');
  assert.equal(masksOf(store.state), before);

  // The session corrects: what it refuses leaves all as it was.
  const { corrections } = store.state.job;
  const change = async (promise) => showCorrected(store, await promise);
  await change(corrections.join(1, [2]));
  assert.equal(store.state.headline, '2 moving objects');
  const joined = masksOf(store.state);
  await change(corrections.split(1));
  assert.notEqual(masksOf(store.state), joined);
  await change(corrections.undo());
  assert.equal(masksOf(store.state), joined);
  await change(corrections.undo());
  assert.equal(masksOf(store.state), before);
  await change(corrections.redo());
  assert.equal(masksOf(store.state), joined);
  assert.equal(corrections.redoCount(), 1);
  assert.equal(store.state.job.isCorrected, true);

  // A file that is none leaves what was corrected; without corrections of the sample it is an error.
  await app.openFiles([NOTES]);
  assert.equal(store.state.phase, 'done');
  assert.equal(masksOf(store.state), joined);
  await change(corrections.undo());
  await app.openFiles([NOTES]);
  assert.equal(store.state.phase, 'error');
  assert.equal(store.state.error.code, 'unknown-file');
  // Another clip is run in its place.
  const first = app.openFiles([CLIP]);
  const second = app.openFiles([new File(['x'], 'other.mp4', { type: 'video/mp4' })]);
  await Promise.all([first, second]);
  assert.equal(store.state.name, 'other.mp4');
  assert.equal(store.state.phase, 'done');

  // Settings that are changed meanwhile begin it anew.
  const again = app.rerun();
  store.set({ changed: new Map([['trajectory.gridStep', 12]]) });
  await again;
  while (store.state.phase !== 'done' || !store.state.job.options.trajectory)
    await new Promise((resolve) => setTimeout(resolve, 50));
  assert.deepEqual(store.state.job.options, { trajectory: { gridStep: 12 } });
});

test('kept work is told, chosen of and painted in, and nothing is segmented for that', async () => {
  const { store, selection } = await openSampleWork();
  const { analysis, timeline } = store.state;
  assert.match(
    store.state.summary,
    /^Object 1 \(orange\) at the upper left moves right; Object 3 \(pink\) at the bottom /,
  );
  assert.match(
    describeFrame(analysis.segmentation.presence, analysis.segmentation.count, 11, timeline.times),
    /^Frame 12 of 16, 0\.7\u00a0s: Object 1 \(orange\) [a-z ]+, [\d.]+%; Object 2/,
  );
  selection.isolate(2);
  assert.deepEqual(selection.objects, { kept: [2], all: 3 });
  selection.isolate(2);
  selection.toggle(3);
  assert.deepEqual(selection.objects, { kept: [1, 2], all: 3 });
  selection.toggleSelected(1);
  selection.toggleSelected(3);
  assert.deepEqual([...store.state.selected], [1, 3]);
  selection.toggleSelected(0);
  assert.equal(store.state.selected.size, 2, 'the background is no object');

  const before = masksOf(store.state);
  const { corrections } = store.state.job;
  assert.equal(corrections.splitsAtPlace, true);
  await assert.rejects(corrections.split(1), { code: 'no-place' });
  await assert.rejects(corrections.joinStrokes([{ t: 0, points: [1, 1], radius: 1 }]), { code: 'param' });
  const stroke = { t: 4, points: [10, 90, 30, 90], radius: 6 };
  const painted = await corrections.paint({ label: corrections.newLabel(), stroke });
  await corrections.carry(painted, new AbortController().signal, () => {});
  showCorrected(store, framesOf(painted));
  assert.equal(store.state.headline, '4 moving objects');
  assert.ok(framesOf(painted).length > 1, 'it is carried');
  await corrections.join(4, [1]);
  showCorrected(store);
  assert.equal(store.state.headline, '3 moving objects');
  for (let step = 0; step < 2; step += 1) showCorrected(store, await corrections.undo());
  assert.equal(masksOf(store.state), before);
  assert.deepEqual([...store.state.hidden], [3], 'what is left out stays so');
});

test('finished work stays until another clip is open, and where none can be opened', async () => {
  const { app, store, selection } = await openSampleWork();
  selection.toggle(3);
  const { visit, job, headline } = store.state;
  const before = masksOf(store.state);
  const opening = app.openFiles([NOTES]);
  assert.equal(store.state.isOpening, true);
  assert.equal(masksOf(store.state), before);
  await opening;
  const { phase, isOpening, notice, announcement } = store.state;
  assert.deepEqual([phase, isOpening, store.state.headline], ['done', false, headline]);
  assert.equal(notice, 'Couldn’t open notes.txt. Not a video or an image.');
  assert.equal(announcement, notice);
  assert.deepEqual([store.state.visit, store.state.job, [...store.state.hidden]], [visit, job, [3]]);
  // It can be corrected and saved as before.
  showCorrected(store, await job.corrections.join(1, [2]));
  assert.deepEqual([exportSource(store.state).name, store.state.notice], ['clip.mp4', '']);

  // Of two files the last one counts, also if the first is opened later.
  let openFirst;
  const source = { ...store.state.source, name: 'first.mp4', close: () => (source.isClosed = true) };
  const first = app.open('first.mp4', () => new Promise((resolve) => (openFirst = () => resolve(source))));
  await app.openFiles([NOTES]);
  openFirst();
  await first;
  assert.deepEqual([store.state.visit, store.state.phase, source.isClosed], [visit, 'done', true]);

  // Another clip takes its place.
  const second = app.openFiles([new File(['x'], 'other.mp4', { type: 'video/mp4' })]);
  while (store.state.phase !== 'running') await new Promise((resolve) => setTimeout(resolve));
  assert.deepEqual([store.state.name, store.state.isOpening, store.state.notice], ['other.mp4', false, '']);
  app.cancel();
  await second;
});

test('an object shown alone is the first of those that are selected, and what they are joined to is kept', async () => {
  const { store, selection } = await openSampleWork();
  const join = async ([into, ...others]) => showCorrected(store, await selection.join(into, others));
  selection.isolate(1);
  selection.toggleSelected(2);
  selection.toggleSelected(3);
  assert.deepEqual([...store.state.selected], [1, 2, 3]);
  await join(store.state.selected);
  assert.deepEqual(selection.objects, { kept: [1], all: 1 });
  showCorrected(store, await store.state.job.corrections.undo());

  // A hidden object takes in the one that is shown.
  selection.reset();
  selection.isolate(3);
  await join([2, 3]);
  assert.deepEqual(selection.objects, { kept: [2], all: 2 });
  assert.deepEqual([...store.state.selected], []);

  // Where nothing was kept, nothing is.
  store.set({ hidden: new Set([1, 2]) });
  await join([1, 2]);
  assert.deepEqual(selection.objects, { kept: [], all: 1 });
});

test('what is saved has the objects that are kept', async () => {
  const { store, selection } = await openSampleWork();
  selection.toggle(3);
  const { job } = store.state;
  const known = exportSource(store.state);
  assert.deepEqual(known.masks.shots, [{ first: 0, last: 15 }]);
  const read = resizedFrames(job, known.masks, SAMPLE.width);
  const subject = {
    ...known,
    ...{ frames: read.stream, image: read.read, edges: { smallest: 0, grow: 0, feather: 0 } },
    objects: (object) => object > 0 && selection.has(object),
  };
  const none = { title: '', about: '', choices: [] };
  const choices = [...MAIN_EXPORTS, ...otherExports(none)].flatMap((one) => one.choices);
  // Each file has a name of its own; a cut-out on the backdrop of the page is named by that.
  const name = (id) => choices.find((one) => one.id === id).file(subject);
  assert.deepEqual(['transparent', 'green', 'blurred', 'zip'].map(name), [
    ...['cutout.webm', 'green.mp4', 'blur.mp4', 'masks.zip'],
  ]);
  assert.deepEqual(['cutout-webm', 'cutout-mp4'].map(name), ['cutout.webm', 'green.mp4']);
  subject.state = { ...known.state, backdrop: { ...known.state.backdrop, name: 'dimmed' } };
  assert.deepEqual(['cutout-webm', 'cutout-mp4', 'green'].map(name), ['spotlight.webm', 'spotlight.mp4', 'green.mp4']);
  const make = async (id) => {
    const blob = await choices
      .find((one) => one.id === id)
      .make(subject, { signal: new AbortController().signal, onProgress() {} });
    return new Uint8Array(await blob.arrayBuffer());
  };
  const text = async (id) => new TextDecoder().decode(await make(id));
  const coco = JSON.parse(await text('coco'));
  assert.equal(coco.annotations.length, 32);
  const rows = (await text('table')).trim().split('\n').slice(1);
  assert.deepEqual([...new Set(rows.map((row) => row.split(',')[2]))], ['1', '2']);
  const files = Object.keys(unzipSync(await make('zip-objects')));
  assert.equal(files.filter((name) => name.endsWith('.png')).length, 32);
  assert.match(await text('tracks'), /^16\n\d+\n/);
  assert.match(new TextDecoder('latin1').decode((await make('png')).subarray(0, 4)), /PNG/);
  const recipe = JSON.parse(await createRecipe({ version, job, masks: known.masks, corrections: 2 }));
  assert.deepEqual([recipe.tracecut, recipe.corrections, recipe.masks.frames], [version, 2, 16]);
  assert.match(recipe.masks.sha256, /^[0-9a-f]{64}$/);
});
