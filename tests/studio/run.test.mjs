// Runs in the studio's model: opened, cancelled, continued, restarted, corrected and saved.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { searchReport } from 'tracecut';
import { SETTINGS_DELAY_MS } from '../../build/model/app.js';
import { sortClipFiles } from '../../build/model/source.js';
import { framesOf } from '../../build/model/corrections.js';
import { describeFrame } from '../../build/model/describe.js';
import { exportSource } from '../../build/model/export.js';
import { CLIP_STAGES } from '../../build/model/library.js';
import { PageError, explain, stageName } from '../../build/model/messages.js';
import { showCorrected } from '../../build/model/show-result.js';
import { describeSearch, suggestChanges } from '../../build/model/suggestions.js';
import { movingFrames, plainFrame, shiftingFrames } from '../moving.mjs';
import { CLIP, frameGate, maskText, openModel, openSampleWork, waitForState } from './studio.mjs';

const TEXT_FILE = new File(['x'], 'notes.txt', { type: 'text/plain' });
const OTHER_CLIP = new File(['x'], 'other.mp4', { type: 'video/mp4' });

/** A clip that is segmented at once. */
const SHORT_CLIP = movingFrames(6, [64, 48]);

test('runs the sample, cancels a second run and continues to the same result', async () => {
  const { app, store } = await openModel();
  const headlines = new Set();
  store.watch(['headline'], ({ headline }) => headlines.add(headline));
  await app.openSample();
  assert.equal(store.state.phase, 'done');
  assert.equal(store.state.headline, '3 moving objects');
  assert.match(store.state.subline, /^16 frames of 192 × 108 · computed in \d/);
  for (const headline of ['Reading frames', 'Tracking motion', 'Drawing outlines'])
    assert.ok(headlines.has(headline), [...headlines].join());
  assert.equal(stageName('embedding'), 'Grouping motion');
  // Names of the method's steps are for those who know it.
  for (const headline of [...headlines, ...CLIP_STAGES.map(({ id }) => stageName(id))])
    assert.doesNotMatch(headline, /window|flow|trajector|affinit|embedding|discontin|saliency|superpixel|cut/i);
  const masks = maskText(store.state);

  const running = app.rerun();
  await waitForState(store, ({ job, phase }) => phase === 'running' && job.stages[1].done >= 2);
  app.cancel();
  assert.deepEqual([store.state.phase, store.state.headline], ['stopped', 'Cancelled']);
  const { job } = store.state;
  await running;
  await app.resume();
  assert.equal(store.state.phase, 'done');
  assert.equal(store.state.job, job, 'the same run goes on');
  assert.equal(maskText(store.state), masks);
});

test('cancels while frames are read, and runs again', async () => {
  const gate = frameGate(4);
  const { app, store } = await openModel(SHORT_CLIP, { gate });
  const opening = app.openFiles([CLIP]);
  await waitForState(store, ({ job }) => job?.images.length === 4);
  app.cancel();
  assert.equal(store.state.phase, 'stopped');
  await opening;
  gate.open();
  await app.rerun();
  assert.deepEqual([store.state.phase, store.state.timeline.numFrames], ['done', 6]);
});

test('opens another clip during a run, and of two opened at once the last', async () => {
  const { app, store } = await openModel(SHORT_CLIP);
  const openings = [app.openSample()];
  await waitForState(store, ({ phase }) => phase === 'running');
  openings.push(app.openFiles([CLIP]), app.openFiles([OTHER_CLIP]));
  await Promise.all(openings);
  assert.deepEqual([store.state.name, store.state.phase], ['other.mp4', 'done']);
  assert.match(store.state.subline, /^6 frames of 64 × 48/);
});

test('restarts a run whose settings change, even if it has ended meanwhile', async (t) => {
  // The delay of restarts ends when the test calls `endDelay`.
  let endDelay;
  const { setTimeout } = globalThis;
  t.mock.method(globalThis, 'setTimeout', (callback, ms, ...args) => {
    if (ms !== SETTINGS_DELAY_MS) return setTimeout(callback, ms, ...args);
    endDelay = callback;
  });
  const gate = frameGate(4);
  const { app, store } = await openModel(SHORT_CLIP, { gate });
  app.openFiles([CLIP]);
  await waitForState(store, ({ job }) => job?.images.length === 4);
  store.set({ changed: new Map([['trajectory.gridStep', 12]]) });
  endDelay();
  gate.open();
  await waitForState(store, ({ phase }) => phase === 'done');
  assert.deepEqual(store.state.job.options, { trajectory: { gridStep: 12 } });

  const { visit } = store.state;
  const rerun = app.rerun();
  store.set({ trim: { ...store.state.trim, start: 2, frames: 2 } });
  await rerun;
  assert.deepEqual([store.state.visit, store.state.timeline.numFrames], [visit + 1, 6]);
  endDelay();
  await waitForState(store, ({ phase, timeline }) => phase === 'done' && timeline.numFrames === 2);
  endDelay();
  assert.equal(store.state.visit, visit + 2, 'settings of the last run start no other');
});

test('the session corrects a result, with undo and redo', async () => {
  const { app, store } = await openModel();
  await app.openSample();
  const masks = maskText(store.state);
  const { corrections } = store.state.job;
  const apply = async (correction) => showCorrected(store, await correction);
  await apply(corrections.join(1, [2]));
  assert.equal(store.state.headline, '2 moving objects');
  const joinedMasks = maskText(store.state);
  await apply(corrections.split(1));
  assert.notEqual(maskText(store.state), joinedMasks);
  await apply(corrections.undo());
  assert.equal(maskText(store.state), joinedMasks);
  await apply(corrections.undo());
  assert.equal(maskText(store.state), masks);
  await apply(corrections.redo());
  assert.equal(maskText(store.state), joinedMasks);
  assert.equal(corrections.redoCount(), 1);
  assert.equal(store.state.job.isCorrected, true);

  // An unknown file leaves a corrected sample on screen, but not an uncorrected one.
  await app.openFiles([TEXT_FILE]);
  assert.equal(store.state.phase, 'done');
  assert.equal(maskText(store.state), joinedMasks);
  await apply(corrections.undo());
  await app.openFiles([TEXT_FILE]);
  assert.deepEqual([store.state.phase, store.state.error.code], ['error', 'unknown-file']);
  const opening = app.openSample();
  await waitForState(store, ({ phase }) => phase === 'running');
  assert.equal(store.state.error, null);
  app.cancel();
  await opening;
});

test('describes, selects and paints in a saved project without a run', async () => {
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
  assert.equal(store.state.selected.size, 2, 'the background is not an object');

  const masks = maskText(store.state);
  const { corrections } = store.state.job;
  assert.equal(corrections.splitsAtPlace, true);
  await assert.rejects(corrections.split(1), { code: 'no-place' });
  await assert.rejects(corrections.joinStrokes([{ t: 0, points: [1, 1], radius: 1 }]), { code: 'param' });
  const stroke = { t: 4, points: [10, 90, 30, 90], radius: 6 };
  const edit = await corrections.paint({ label: corrections.newLabel(), stroke });
  await corrections.carry(edit, new AbortController().signal, () => {});
  showCorrected(store, framesOf(edit));
  assert.equal(store.state.headline, '4 moving objects');
  assert.ok(framesOf(edit).length > 1, 'it is carried to other frames');
  await corrections.join(4, [1]);
  showCorrected(store);
  assert.equal(store.state.headline, '3 moving objects');
  for (let step = 0; step < 2; step += 1) showCorrected(store, await corrections.undo());
  assert.equal(maskText(store.state), masks);
  assert.deepEqual([...store.state.hidden], [3], 'hidden objects stay hidden');
});

test('a finished result stays until another clip is open', async () => {
  const { app, store, selection } = await openSampleWork();
  selection.toggle(3);
  const { visit, job, headline } = store.state;
  const masks = maskText(store.state);
  const opening = app.openFiles([TEXT_FILE]);
  assert.equal(store.state.isOpening, true);
  assert.equal(maskText(store.state), masks);
  await opening;
  const { phase, isOpening, notice, announcement } = store.state;
  assert.deepEqual([phase, isOpening, store.state.headline], ['done', false, headline]);
  assert.equal(notice, 'Couldn’t open notes.txt. Not a video or an image.');
  assert.equal(announcement, notice);
  assert.deepEqual([store.state.visit, store.state.job, [...store.state.hidden]], [visit, job, [3]]);
  // It can be corrected and saved as before.
  showCorrected(store, await job.corrections.join(1, [2]));
  assert.deepEqual([exportSource(store.state).name, store.state.notice], ['clip.mp4', '']);

  // The last of two files wins, even if the first is open later.
  let openFirst;
  const source = { ...store.state.source, name: 'first.mp4', close: () => (source.isClosed = true) };
  const first = app.open('first.mp4', () => new Promise((resolve) => (openFirst = () => resolve(source))));
  await app.openFiles([TEXT_FILE]);
  openFirst();
  await first;
  assert.deepEqual([store.state.visit, store.state.phase, source.isClosed], [visit, 'done', true]);

  const second = app.openFiles([OTHER_CLIP]);
  await waitForState(store, ({ phase }) => phase === 'running');
  assert.deepEqual([store.state.name, store.state.isOpening, store.state.notice], ['other.mp4', false, '']);
  app.cancel();
  await second;
});

test('joined objects stay shown if one of them was', async () => {
  const { store, selection } = await openSampleWork();
  const join = async ([into, ...others]) => showCorrected(store, await selection.join(into, others));
  selection.isolate(1);
  selection.toggleSelected(2);
  selection.toggleSelected(3);
  assert.deepEqual([...store.state.selected], [1, 2, 3], 'the isolated object is the first');
  await join(store.state.selected);
  assert.deepEqual(selection.objects, { kept: [1], all: 1 });
  showCorrected(store, await store.state.job.corrections.undo());

  selection.reset();
  selection.isolate(3);
  await join([2, 3]);
  assert.deepEqual(selection.objects, { kept: [2], all: 2 });
  assert.deepEqual([...store.state.selected], []);

  store.set({ hidden: new Set([1, 2]) });
  await join([1, 2]);
  assert.deepEqual(selection.objects, { kept: [], all: 1 });
});

test('takes images in the order of their numbers, and rejects files that make no clip', async () => {
  const PNG = '\x89PNG\r\n\x1a\n';
  const MP4 = '\0\0\0\x10ftypisom';
  const file = (name, head) => new File([Buffer.from(head, 'latin1')], name);
  const images = await sortClipFiles([10, 9, 2].map((k) => file(`frame${k}.png`, PNG)));
  assert.deepEqual([images.kind, images.type], ['images', 'image/png']);
  assert.deepEqual(
    images.files.map(({ name }) => name),
    ['frame2.png', 'frame9.png', 'frame10.png'],
  );
  assert.deepEqual(await sortClipFiles([CLIP]).catch(({ code }) => code), 'unknown-file', 'its content decides');
  const video = await sortClipFiles([file('a.jpg', MP4), file('._a.jpg', 'Mac OS X')]);
  assert.deepEqual([video.kind, video.type, video.files.length], ['video', 'video/mp4', 1]);

  for (const [files, code, detail] of [
    [[TEXT_FILE], 'unknown-file', 'notes.txt'],
    [[file('empty.webm', '')], 'unknown-file', 'empty.webm is empty'],
    [[file('a.png', PNG), TEXT_FILE], 'unknown-file', 'notes.txt'],
    [[file('a.mp4', MP4), file('b.mp4', MP4)], 'many-videos', '2 files'],
    [[file('a.mp4', MP4), file('b.png', PNG)], 'mixed-files', '2 files'],
  ]) {
    const error = await sortClipFiles(files).catch((thrown) => thrown);
    assert.ok(error instanceof PageError);
    const { title, advice, ...message } = explain(error);
    assert.deepEqual(message, { code, detail });
    assert.ok(title.length > 10);
    assert.match(advice, /^(Use|Open) /);
  }
});

test('clips without motion have a result that says so', async () => {
  const still = movingFrames(1, [64, 48])[0];
  const repeat = (frame) => Array.from({ length: 9 }, () => frame);
  for (const [frames, headline, notice] of [
    [SHORT_CLIP.slice(0, 2), /^(1 moving object|No moving objects|Nothing to track)$/, /^/],
    [repeat(still), /^No moving objects$/, /^Everything moves together, or nothing moves\.$/],
    [repeat(plainFrame(64, 48)), /^Nothing to track$/, /^The frames have too little texture to track\.$/],
    [repeat(plainFrame(1, 1)), /^Nothing to track$/, /too little texture/],
    [movingFrames(9, [17, 3]), /^(No moving objects|Nothing to track)$/, /./],
  ]) {
    const { app, store } = await openModel(frames);
    await app.openFiles([CLIP]);
    assert.equal(store.state.phase, 'done', explain(store.state.error).detail);
    assert.match(store.state.headline, headline);
    assert.match(store.state.notice, notice);
    assert.equal(store.state.notice === '', /\d/.test(store.state.headline));
  }
});

test('suggests to skip frames where everything moves together slowly', async () => {
  const { app, store } = await openModel(shiftingFrames(30, 2, [80, 54]));
  await app.openFiles([CLIP]);
  assert.equal(store.state.headline, 'No moving objects');
  const report = searchReport(store.state.analysis.segmentation.result);
  assert.match(
    describeSearch(report),
    /^Tracked \d+ points over [89]\d% of the picture in 30 frames; the camera moves about 2\.0 px\/frame\. .* nothing stands out\.$/,
  );
  const suggestions = suggestChanges(store.state, report);
  assert.deepEqual(
    suggestions.map(({ id }) => id),
    ['step'],
  );
  store.set(suggestions[0].patch);
  await app.rerun();
  assert.equal(store.state.phase, 'done');
  assert.deepEqual(store.state.job.trim, { start: 0, frames: 15, step: 2, side: 480 });
});
