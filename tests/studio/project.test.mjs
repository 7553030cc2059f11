// Project files: saved and opened again, with edits and files, and refused when they are none.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { segmentVideo } from 'tracecut';
import { editMasks, encodeRuns, openProject, saveProject } from 'tracecut/edit';
import { clipsZip, cocoRle } from 'tracecut/export';
import { toViewSettings, viewSettingsPatch } from '../../build/model/view-settings.js';
import { framesOf, ready, rejects } from '../node/support.mjs';

test('a result and a video are opened again as they were, with edits, words and files', async (t) => {
  const frames = await framesOf();
  const session = await ready(t, {}, frames);
  const result = await session.run();
  const video = await segmentVideo(frames, { frameRate: 10, window: 6, overlap: 2 }).collect();
  for (const masks of [result, video]) {
    const editor = editMasks(masks);
    const edit = await editor.paint({ label: 7, stroke: { t: 2, points: [20, 20, 40, 30], radius: 5 } });
    editor.extend(edit, 3, encodeRuns(new Uint8Array(masks.width * masks.height).fill(1, 9, 59)), 0.8);
    const film = Uint8Array.from({ length: 3000 }, (_, k) => (k * 7) % 256);
    const saved = await saveProject(masks, { editor, about: { trim: { start: 3 } }, files: { 'clip.mp4': film } });
    assert.deepEqual(
      await saveProject(masks, { editor, about: { trim: { start: 3 } }, files: { 'clip.mp4': film } }),
      saved,
    );
    const opened = await openProject(new Blob([saved]));
    assert.deepEqual(opened.about, { trim: { start: 3 } });
    assert.deepEqual(opened.files['clip.mp4'], film);
    for (let k = 0; k < masks.numFrames; k += 1) assert.deepEqual(opened.masks.labels(k), masks.labels(k));
    assert.deepEqual(opened.masks.trajectories.x, masks.trajectories.x);
    assert.deepEqual(opened.masks.trajectories.offset, masks.trajectories.offset);
    const again = editMasks(opened.masks);
    again.restore(opened.edits);
    for (let k = 0; k < masks.numFrames; k += 1) assert.deepEqual(again.labels(k), editor.labels(k));
    assert.ok((await cocoRle(opened.masks, { frameRate: 5 })).annotations.length > 0);
  }
  assert.deepEqual((await openProject(await saveProject(video))).masks.times, video.times);
  assert.deepEqual((await openProject(await saveProject(video))).masks.shots, video.shots);
});

test('masks of the caller are saved too; times come from the frame rate', async () => {
  const masks = { width: 4, height: 2, numFrames: 3, labels: (t) => Uint8Array.of(0, t, t, 0, 0, 0, 9, 9) };
  const { masks: opened, edits, files } = await openProject(await saveProject(masks, { frameRate: 2 }));
  assert.equal(opened.end, null);
  const timed = { ...masks, times: [0, 1, 5], end: 5.5 };
  assert.equal((await openProject(await saveProject(timed))).masks.end, 5.5);
  assert.deepEqual([...opened.times], [0, 0.5, 1]);
  assert.deepEqual([...opened.labels(2)], [0, 2, 2, 0, 0, 0, 9, 9]);
  assert.deepEqual(
    opened.objects.map(({ label }) => label),
    [1, 2, 9],
  );
  assert.deepEqual([edits, files, opened.trajectories.count], [null, {}, 0]);
});

test('what is no project, or is damaged, is refused in words', async () => {
  const masks = { width: 4, height: 2, numFrames: 1, labels: () => new Uint8Array(8) };
  const saved = await saveProject(masks);
  await rejects(openProject('clip'), 'data', /file = "clip"/);
  await rejects(openProject(Uint8Array.of(1, 2, 3)), 'data', /not a project file/);
  await rejects(openProject(saved.subarray(0, saved.length / 2)), 'data', /not a project file/);
  const { unzipSync, zipSync } = await import('../../dist/vendor/zip.js');
  const other = (name, content) => openProject(zipSync({ ...unzipSync(saved), [name]: content }));
  const text = (change) =>
    new TextEncoder().encode(
      JSON.stringify({ ...JSON.parse(new TextDecoder().decode(unzipSync(saved)['project.json'])), ...change }),
    );
  await rejects(other('project.json', Uint8Array.of(1)), 'data', /project.json is damaged/);
  await rejects(other('project.json', text({ width: 0 })), 'data', /width = 0/);
  await rejects(other('project.json', text({ format: 9 })), 'data', /format of the project = 9/);
  await rejects(other('project.json', text({ width: 5 })), 'data', /frame 0 covers 8 pixels \(expected 10\)/);
  await rejects(other('masks.bin', Uint8Array.of(1, 2)), 'data', /masks.bin is cut off/);
  await rejects(other('trajectories.bin', Uint8Array.of(9, 0, 0, 0, 1, 0, 0, 0)), 'data', /trajectories/);
  await rejects(saveProject(masks, { title: 'x' }), 'param', /title/);
});

test('files of a project have names that lead nowhere else, saved and opened', async () => {
  const masks = { width: 4, height: 2, numFrames: 1, labels: () => new Uint8Array(8) };
  const { unzipSync, zipSync } = await import('../../dist/vendor/zip.js');
  const entries = unzipSync(await saveProject(masks));
  for (const name of [
    '../clip.webm',
    'a/../../clip.webm',
    '/etc/clip',
    '..\\..\\clip.webm',
    '\\\\host\\clip',
    'C:\\clip',
    'c:clip',
    'a//b',
    'a/./b',
    '..',
    '',
    'clip\0.webm',
  ]) {
    await rejects(saveProject(masks, { files: { [name]: Uint8Array.of(1) } }), 'data', /the name of a file = "/);
    await rejects(openProject(zipSync({ ...entries, [`files/${name}`]: Uint8Array.of(1) })), 'data', /name of a file/);
  }
  const files = { 'at 10:30.webm': Uint8Array.of(1), 'a/b..c.mp4': Uint8Array.of(2), __proto__x: Uint8Array.of(3) };
  assert.deepEqual((await openProject(await saveProject(masks, { files }))).files, files);
});

test('names of clips become folders of their archive, and no other', async () => {
  const masks = { width: 4, height: 2, numFrames: 1, labels: () => new Uint8Array(8) };
  const { unzipSync } = await import('../../dist/vendor/zip.js');
  const names = ['../../up', '/etc/passwd', '..\\up', 'C:\\up', '..', '', 'nul\0', '<img onerror=x>', 'up'];
  const paths = Object.keys(unzipSync(await clipsZip(names.map((name) => ({ name, masks })))));
  assert.equal(new Set(paths.map((path) => path.split('/')[0].toLowerCase())).size, names.length + 1);
  for (const path of paths) assert.match(path, /^([\w-]+\/[\w-]+\.(png|json)|report\.json)$/);
});

test('what the page keeps of a look is taken as far as it is legal', () => {
  const picture = { name: 'picture', colour: '#010203', picture: {} };
  const edges = { smallest: 0.5, grow: -3, feather: 2, smooth: 1 };
  const state = { edges, hidden: new Set([2, 5]), backdrop: picture };
  const look = JSON.parse(JSON.stringify(toViewSettings(state)));
  const blank = { backdrop: { name: 'dimmed', colour: '#ffffff', picture: null } };
  assert.deepEqual(viewSettingsPatch(look, blank), {
    edges,
    hidden: new Set([2, 5]),
    backdrop: { name: 'transparent', colour: '#010203', picture: null },
  });
  assert.deepEqual(viewSettingsPatch(undefined, blank), {});
  const wrong = {
    edges: { smallest: 2, grow: '3', feather: NaN, smooth: 1e9 },
    hidden: [1, -1, 'x', 256],
    backdrop: { name: 'green', colour: 'url(x)' },
  };
  assert.deepEqual(viewSettingsPatch(wrong, blank), {
    edges: { smallest: 0.02, grow: 0, feather: 0, smooth: 0 },
    hidden: new Set([1]),
    backdrop: { ...blank.backdrop, name: 'green' },
  });
  assert.deepEqual(viewSettingsPatch({ hidden: 7, backdrop: { name: 'picture' } }, blank).backdrop, blank.backdrop);
});
