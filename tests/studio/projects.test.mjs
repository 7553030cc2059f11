// Projects: their files, and the browser's storage with one per clip, saved as they change; and interrupted runs.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { segmentVideo } from 'tracecut';
import * as kit from 'tracecut/edit';
import { clipsZip, cocoRle } from 'tracecut/export';
import { Autosave, listProjects, projectBytes, rememberRuns, saveProject } from '../../build/model/saved-projects.js';
import { framesOf as changedFrames } from '../../build/model/corrections.js';
import { RunMemory } from '../../build/model/interrupted-runs.js';
import { createProjectFile, hashClip, Packer, readProjectFile, reopenProject } from '../../build/model/project-file.js';
import { showCorrected } from '../../build/model/show-result.js';
import { Store } from '../../build/model/store.js';
import { toViewSettings, viewSettingsPatch } from '../../build/model/view-settings.js';
import { each, framesOf, ready, rejects, SMALL } from '../node/support.mjs';
import { CLIP, memoryStorage, openSampleWork, SAMPLE } from './studio.mjs';

/** A record of the storage; `at` is its time, and part of its id. */
const project = (at, more = {}) => ({
  ...{ id: `p${at}`, name: `n${at}`, at, files: [], project: new Uint8Array(3), edits: null },
  ...{ corrected: false, picture: null, earlier: [], ...more },
  about: { name: `n${at}`, trim: { start: 0, frames: 2, step: 1, side: 480 }, changed: [], run: `r${at}` },
});
const ids = async (storage) => (await listProjects(storage)).map(({ id }) => id);

test('the oldest project is removed when there are more than eight', async () => {
  const storage = memoryStorage();
  for (let at = 1; at <= 10; at += 1) assert.equal(await saveProject(storage, project(at)), true);
  assert.deepEqual(await ids(storage), ['p10', 'p9', 'p8', 'p7', 'p6', 'p5', 'p4', 'p3']);
});

test('corrected projects are never removed to make room', async () => {
  const storage = memoryStorage();
  for (let at = 1; at <= 8; at += 1) await saveProject(storage, project(at, { corrected: true }));
  assert.equal(await saveProject(storage, project(9)), false);
  assert.deepEqual(await ids(storage), ['p8', 'p7', 'p6', 'p5', 'p4', 'p3', 'p2', 'p1']);
});

test('a new run of a clip keeps the corrected result of an earlier one', async () => {
  const storage = memoryStorage();
  await saveProject(storage, project(1, { corrected: true, picture: 'small' }));
  await saveProject(storage, { ...project(2), id: 'p1' });
  const [slot] = await listProjects(storage);
  assert.deepEqual([slot.name, slot.corrected, slot.picture, slot.earlier.length], ['n2', false, 'small', 1]);
  assert.equal(projectBytes(slot), 6);
  await saveProject(storage, { ...project(3, { corrected: true }), id: 'p1' });
  const [{ corrected, earlier }, ...others] = await listProjects(storage);
  assert.deepEqual([corrected, earlier.length, others], [true, 1, []]);
  await saveProject(storage, { ...project(1), at: 4, corrected: true });
  const runs = (await listProjects(storage))[0].earlier.map(({ about }) => about.run);
  assert.deepEqual(runs, ['r3'], 'the same run replaces itself');
});

test('older projects are removed if the browser has less room', async () => {
  const storage = memoryStorage();
  const { put } = storage;
  storage.put = async (record) => {
    if (storage.records.size >= 3) throw Object.assign(new Error('full'), { name: 'QuotaExceededError' });
    return put(record);
  };
  for (let at = 1; at <= 4; at += 1) assert.equal(await saveProject(storage, project(at)), true);
  assert.deepEqual(await ids(storage), ['p4', 'p3', 'p2']);
});

/**
 * The sample's project in a page that saves to a storage in memory; `pending` collects calls of `onPending`.
 *
 * @param {import('node:test').TestContext} [t] mocks the timers
 */
async function openAutosave(t) {
  const model = await openSampleWork();
  t?.mock.timers.enable({ apis: ['setTimeout'] });
  const storage = memoryStorage();
  const packer = new Packer();
  const pending = [];
  const autosave = new Autosave(
    model.store,
    async (state) => saveProject(storage, await packer.pack(state, await hashClip(state.source.files))),
    (isPending) => pending.push(isPending),
  );
  return { ...model, storage, pending, autosave };
}

test('changes are saved once none came for a while', async (t) => {
  const { store, storage, pending, autosave } = await openAutosave(t);
  t.mock.timers.tick(500);
  store.set({ hidden: new Set([1]) });
  t.mock.timers.tick(500);
  await autosave.saving;
  assert.deepEqual([storage.records.size, autosave.hasUnsaved, pending.at(-1)], [0, true, true]);
  t.mock.timers.tick(200);
  t.mock.timers.reset();
  await autosave.saving;
  assert.deepEqual([autosave.hasUnsaved, pending.at(-1)], [false, false]);
  assert.deepEqual((await listProjects(storage))[0].about.view.hidden, [1]);
});

test('the result of a clip that is left at once is saved too', async () => {
  const { app, store, selection, storage, autosave } = await openAutosave();
  const otherProject = await reopenProject(await new Packer().pack(store.state, 'other'));
  const about = { ...otherProject.about, name: 'other.mp4' };
  const files = [new File(['other'], 'other.mp4', { type: 'video/mp4' })];
  showCorrected(store, await selection.join(1, [2]));
  const mask = store.state.analysis.segmentation.mask(4).join();
  await app.openProject('other.mp4', async () => ({ ...otherProject, about, files }));
  await autosave.saving;
  assert.equal(store.state.name, 'other.mp4');
  const record = (await listProjects(storage)).find(({ name }) => name === 'clip.mp4');
  assert.equal(record.corrected, true);
  await app.openProject('clip.mp4', () => reopenProject(record));
  assert.equal(store.state.analysis.segmentation.mask(4).join(), mask);
  assert.equal(store.state.job.isCorrected, true);
});

test('a project is saved, and opened again from the storage and from a file', async () => {
  const { app, store, storage, autosave } = await openAutosave();
  const { corrections } = store.state.job;
  const stroke = { t: 4, points: [10, 90, 30, 90], radius: 6 };
  showCorrected(store, changedFrames(await corrections.paint({ label: corrections.newLabel(), stroke })));
  store.set({ hidden: new Set([2]), edges: { ...store.state.edges, grow: 1 } });
  autosave.saveSoon();
  await autosave.saving;
  const [record] = await listProjects(storage);
  assert.deepEqual([record.name, record.corrected, record.edits.edits.length], ['clip.mp4', true, 1]);
  const mask = store.state.analysis.segmentation.mask(4).join('');
  const file = await createProjectFile(record);
  for (const project of [await reopenProject(record), await readProjectFile(new File([file], 'a.tracecut'))]) {
    await app.openProject('again', async () => project);
    assert.equal(store.state.phase, 'done');
    const { width, height, images } = store.state.picture;
    assert.deepEqual([width, height, images.length], [SAMPLE.width, SAMPLE.height, SAMPLE.frames]);
    assert.equal(store.state.analysis.segmentation.mask(4).join(''), mask);
    assert.deepEqual([...store.state.hidden], [2]);
    assert.equal(store.state.edges.grow, 1);
    assert.equal(store.state.job.corrections.undoCount(), 1, 'it can be undone');
    assert.equal(project.files[0].name, 'clip.mp4');
  }
  // A damaged file leaves the result on screen.
  await app.openFiles([new File([file.slice(0, 500)], 'work.tracecut')]);
  assert.equal(store.state.notice, 'Couldn’t open work.tracecut. Not a TraceCut project.');
  assert.deepEqual([store.state.phase, store.state.analysis.segmentation.mask(4).join('')], ['done', mask]);
  await assert.rejects(readProjectFile(new File(['x'], 'b.tracecut')), { code: 'no-project' });
  assert.notEqual(await hashClip([CLIP]), await hashClip([new File(['other'], 'clip.mp4')]));
});

/** Locks of a browser: `request` waits until the lock is free, or times out at once. */
function fakeLocks() {
  const locks = new Map();
  return {
    held: locks,
    async request(id, ...rest) {
      if (rest.length > 1 && locks.has(id)) throw new Error('timeout');
      const work = Promise.resolve(rest.at(-1)());
      locks.set(id, work);
      return work.finally(() => locks.delete(id));
    },
  };
}

test('a run is remembered until it ends, and offered to other pages only after its page is gone', async (t) => {
  t.mock.timers.enable({ apis: ['setTimeout'] });
  const [storage, locks] = [memoryStorage(), fakeLocks()];
  const [ownMemory, otherMemory] = [new RunMemory(storage, locks), new RunMemory(storage, locks)];
  const store = new Store();
  const accesses = [];
  const memory = {
    remember: (state) => accesses.push(ownMemory.remember(state)),
    forget: () => accesses.push(ownMemory.forget()),
  };
  rememberRuns(store, async () => memory);
  /** Waits until the memory was called `count` times in all. */
  const settle = async (count) => {
    while (accesses.length < count) await new Promise((resolve) => setImmediate(resolve));
    await Promise.all(accesses);
  };
  const trim = { start: 0, frames: 9, step: 1, side: 480 };
  store.set({ phase: 'running', name: 'clip.mp4', source: { kind: 'video', files: [CLIP] }, job: {}, trim });
  t.mock.timers.tick(999);
  // Settings are changed: the run starts again.
  store.set({ trim: { ...trim, step: 3 }, job: {} });
  t.mock.timers.tick(999);
  assert.equal(storage.records.size, 0, 'short runs are not remembered');
  t.mock.timers.tick(1);
  await settle(1);
  const [run] = [...storage.records.values()];
  assert.match(run.id, /^run-/);
  assert.deepEqual([run.files[0], run.about.trim.step], [CLIP, 3]);
  store.set({ trim: { ...trim, step: 2 }, job: {} });
  t.mock.timers.tick(1000);
  await settle(2);
  assert.deepEqual(
    [...storage.records.values()].map(({ id, about }) => [id, about.trim.step]),
    [[run.id, 2]],
  );
  assert.equal((await listProjects(storage)).length, 0, 'it is no project');
  assert.equal(await otherMemory.findInterrupted(), undefined);
  locks.held.clear();
  assert.equal((await otherMemory.findInterrupted()).id, run.id);
  store.set({ phase: 'stopped' });
  await settle(3);
  assert.equal(storage.records.size, 0);
});

test('a result and a video are opened again as they were, with edits, words and files', async (t) => {
  const frames = await framesOf({ ...SMALL, width: 128, height: 72 });
  const session = await ready(t, {}, frames);
  const result = await session.run();
  const video = await segmentVideo(frames, { frameRate: 10, window: 6, overlap: 2 }).collect();
  for (const masks of [result, video]) {
    const editor = kit.editMasks(masks);
    const edit = await editor.paint({ label: 7, stroke: { t: 2, points: [20, 20, 40, 30], radius: 5 } });
    editor.extend(edit, 3, kit.encodeRuns(new Uint8Array(masks.width * masks.height).fill(1, 9, 59)), 0.8);
    const clip = Uint8Array.from({ length: 3000 }, (_, k) => (k * 7) % 256);
    const options = { editor, about: { trim: { start: 3 } }, files: { 'clip.mp4': clip } };
    const bytes = await kit.saveProject(masks, options);
    assert.deepEqual(await kit.saveProject(masks, options), bytes);
    const reopened = await kit.openProject(new Blob([bytes]));
    assert.deepEqual(reopened.about, { trim: { start: 3 } });
    assert.deepEqual(reopened.files['clip.mp4'], clip);
    for (let k = 0; k < masks.numFrames; k += 1) assert.deepEqual(reopened.masks.labels(k), masks.labels(k));
    assert.deepEqual(reopened.masks.trajectories.x, masks.trajectories.x);
    assert.deepEqual(reopened.masks.trajectories.offset, masks.trajectories.offset);
    const again = kit.editMasks(reopened.masks);
    again.restore(reopened.edits);
    for (let k = 0; k < masks.numFrames; k += 1) assert.deepEqual(again.labels(k), editor.labels(k));
    assert.ok((await cocoRle(reopened.masks, { frameRate: 5 })).annotations.length > 0);
  }
  assert.deepEqual((await kit.openProject(await kit.saveProject(video))).masks.times, video.times);
  assert.deepEqual((await kit.openProject(await kit.saveProject(video))).masks.shots, video.shots);
});

test('masks of the caller are bytes too; times come from the frame rate', async () => {
  const masks = { width: 4, height: 2, numFrames: 3, labels: (t) => Uint8Array.of(0, t, t, 0, 0, 0, 9, 9) };
  const { masks: reopened, edits, files } = await kit.openProject(await kit.saveProject(masks, { frameRate: 2 }));
  assert.equal(reopened.end, null);
  const timed = { ...masks, times: [0, 1, 5], end: 5.5 };
  assert.equal((await kit.openProject(await kit.saveProject(timed))).masks.end, 5.5);
  assert.deepEqual([...reopened.times], [0, 0.5, 1]);
  assert.deepEqual([...reopened.labels(2)], [0, 2, 2, 0, 0, 0, 9, 9]);
  assert.deepEqual(each(reopened.objects, 'label'), [1, 2, 9]);
  assert.deepEqual([edits, files, reopened.trajectories.count], [null, {}, 0]);
});

test('what is no project, or is damaged, is refused in words', async () => {
  const masks = { width: 4, height: 2, numFrames: 1, labels: () => new Uint8Array(8) };
  const bytes = await kit.saveProject(masks);
  await rejects(kit.openProject('clip'), 'data', /file = "clip"/);
  await rejects(kit.openProject(Uint8Array.of(1, 2, 3)), 'data', /not a project file/);
  await rejects(kit.openProject(bytes.subarray(0, bytes.length / 2)), 'data', /not a project file/);
  const { unzipSync, zipSync } = await import('../../dist/vendor/zip.js');
  const openWith = (name, content) => kit.openProject(zipSync({ ...unzipSync(bytes), [name]: content }));
  const text = (change) =>
    new TextEncoder().encode(
      JSON.stringify({ ...JSON.parse(new TextDecoder().decode(unzipSync(bytes)['project.json'])), ...change }),
    );
  await rejects(openWith('project.json', Uint8Array.of(1)), 'data', /project.json is damaged/);
  await rejects(openWith('project.json', text({ width: 0 })), 'data', /width = 0/);
  await rejects(openWith('project.json', text({ format: 9 })), 'data', /format of the project = 9/);
  await rejects(openWith('project.json', text({ width: 5 })), 'data', /frame 0 covers 8 pixels \(expected 10\)/);
  await rejects(openWith('masks.bin', Uint8Array.of(1, 2)), 'data', /masks.bin is cut off/);
  await rejects(openWith('trajectories.bin', Uint8Array.of(9, 0, 0, 0, 1, 0, 0, 0)), 'data', /trajectories/);
  await rejects(kit.saveProject(masks, { title: 'x' }), 'param', /title/);
});

test('files of a project have names that lead nowhere else, saved and opened', async () => {
  const masks = { width: 4, height: 2, numFrames: 1, labels: () => new Uint8Array(8) };
  const { unzipSync, zipSync } = await import('../../dist/vendor/zip.js');
  const entries = unzipSync(await kit.saveProject(masks));
  const upward = ['../clip.webm', 'a/../../clip.webm', '..\\..\\clip.webm', '..'];
  const absolute = ['/etc/clip', '\\\\host\\clip', 'C:\\clip', 'c:clip'];
  for (const name of [...upward, ...absolute, 'a//b', 'a/./b', '', 'clip\0.webm']) {
    await rejects(kit.saveProject(masks, { files: { [name]: Uint8Array.of(1) } }), 'data', /the name of a file = "/);
    const project = zipSync({ ...entries, [`files/${name}`]: Uint8Array.of(1) });
    await rejects(kit.openProject(project), 'data', /name of a file/);
  }
  const files = { 'at 10:30.webm': Uint8Array.of(1), 'a/b..c.mp4': Uint8Array.of(2), __proto__x: Uint8Array.of(3) };
  assert.deepEqual((await kit.openProject(await kit.saveProject(masks, { files }))).files, files);
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
  const settings = JSON.parse(JSON.stringify(toViewSettings(state)));
  const blank = { backdrop: { name: 'dimmed', colour: '#ffffff', picture: null } };
  assert.deepEqual(viewSettingsPatch(settings, blank), {
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
