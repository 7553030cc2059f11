// Projects in the browser's storage: one per clip, room for eight, saved as they change; and interrupted runs.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Autosave, rememberRuns } from '../../build/model/saved-projects.js';
import { framesOf } from '../../build/model/corrections.js';
import { RunMemory } from '../../build/model/interrupted-runs.js';
import { showCorrected } from '../../build/model/show-result.js';
import { listProjects, projectBytes, saveProject } from '../../build/model/saved-projects.js';
import { Packer, hashClip, createProjectFile, readProjectFile, reopenProject } from '../../build/model/project-file.js';
import { Store } from '../../build/model/store.js';
import { CLIP, SAMPLE, memoryStorage, openSampleWork } from './studio.mjs';

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
  assert.deepEqual(
    (await listProjects(storage)).map(({ corrected, earlier }) => [corrected, earlier.length]),
    [[true, 1]],
  );
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
  const other = await reopenProject(await new Packer().pack(store.state, 'other'));
  const about = { ...other.about, name: 'other.mp4' };
  const files = [new File(['other'], 'other.mp4', { type: 'video/mp4' })];
  showCorrected(store, await selection.join(1, [2]));
  const mask = store.state.analysis.segmentation.mask(4).join();
  await app.openProject('other.mp4', async () => ({ ...other, about, files }));
  await autosave.saving;
  assert.equal(store.state.name, 'other.mp4');
  const saved = (await listProjects(storage)).find(({ name }) => name === 'clip.mp4');
  assert.equal(saved.corrected, true);
  await app.openProject('clip.mp4', () => reopenProject(saved));
  assert.equal(store.state.analysis.segmentation.mask(4).join(), mask);
  assert.equal(store.state.job.isCorrected, true);
});

test('a project is saved, and opened again from the storage and from a file', async () => {
  const { app, store, storage, autosave } = await openAutosave();
  const { corrections } = store.state.job;
  const stroke = { t: 4, points: [10, 90, 30, 90], radius: 6 };
  showCorrected(store, framesOf(await corrections.paint({ label: corrections.newLabel(), stroke })));
  store.set({ hidden: new Set([2]), edges: { ...store.state.edges, grow: 1 } });
  autosave.saveSoon();
  await autosave.saving;
  const [saved] = await listProjects(storage);
  assert.deepEqual([saved.name, saved.corrected, saved.edits.edits.length], ['clip.mp4', true, 1]);
  const mask = store.state.analysis.segmentation.mask(4).join('');
  const file = await createProjectFile(saved);
  for (const opened of [await reopenProject(saved), await readProjectFile(new File([file], 'a.tracecut'))]) {
    await app.openProject('again', async () => opened);
    assert.equal(store.state.phase, 'done');
    const { width, height, images } = store.state.picture;
    assert.deepEqual([width, height, images.length], [SAMPLE.width, SAMPLE.height, SAMPLE.frames]);
    assert.equal(store.state.analysis.segmentation.mask(4).join(''), mask);
    assert.deepEqual([...store.state.hidden], [2]);
    assert.equal(store.state.edges.grow, 1);
    assert.equal(store.state.job.corrections.undoCount(), 1, 'it can be undone');
    assert.equal(opened.files[0].name, 'clip.mp4');
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
  const held = new Map();
  return {
    held,
    async request(id, ...rest) {
      if (rest.length > 1 && held.has(id)) throw new Error('timeout');
      const done = Promise.resolve(rest.at(-1)());
      held.set(id, done);
      return done.finally(() => held.delete(id));
    },
  };
}

test('a run is remembered until it ends, and offered to other pages only after its page is gone', async (t) => {
  t.mock.timers.enable({ apis: ['setTimeout'] });
  const [storage, locks] = [memoryStorage(), fakeLocks()];
  const [own, other] = [new RunMemory(storage, locks), new RunMemory(storage, locks)];
  const store = new Store();
  const accesses = [];
  const memory = {
    remember: (state) => accesses.push(own.remember(state)),
    forget: () => accesses.push(own.forget()),
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
  assert.equal(await other.findInterrupted(), undefined);
  locks.held.clear();
  assert.equal((await other.findInterrupted()).id, run.id);
  store.set({ phase: 'stopped' });
  await settle(3);
  assert.equal(storage.records.size, 0);
});
