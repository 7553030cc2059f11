// Work in the studio is kept as it goes: in one place a clip, with room for eight; runs that were cut off are known.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Autosave, rememberRuns } from '../../build/model/autosave.js';
import { framesOf } from '../../build/model/corrections.js';
import { RunMemory } from '../../build/model/interrupted-runs.js';
import { showCorrected } from '../../build/model/show-result.js';
import { listProjects, projectBytes, saveProject } from '../../build/model/saved-projects.js';
import { Packer, hashClip, createProjectFile, readProjectFile, reopenProject } from '../../build/model/project-file.js';
import { CLIP, SAMPLE, memoryStorage, openModel, openSampleWork } from './studio.mjs';

const work = (at, more = {}) => ({
  ...{ id: `w${at}`, name: `n${at}`, at, files: [], project: new Uint8Array(3), edits: null },
  ...{ corrected: false, picture: null, earlier: [], ...more },
  about: { name: `n${at}`, trim: { start: 0, frames: 2, step: 1, side: 480 }, changed: [], run: `r${at}` },
});
const ids = async (storage) => (await listProjects(storage)).map(({ id }) => id);

test('the oldest goes when there are more than eight', async () => {
  const storage = memoryStorage();
  for (let at = 1; at <= 10; at += 1) assert.equal(await saveProject(storage, work(at)), true);
  assert.deepEqual(await ids(storage), ['w10', 'w9', 'w8', 'w7', 'w6', 'w5', 'w4', 'w3']);
});

test('what was corrected never goes by itself', async () => {
  const storage = memoryStorage();
  for (let at = 1; at <= 8; at += 1) await saveProject(storage, work(at, { corrected: true }));
  assert.equal(await saveProject(storage, work(9)), false);
  assert.deepEqual(await ids(storage), ['w8', 'w7', 'w6', 'w5', 'w4', 'w3', 'w2', 'w1']);
});

test('a new run of a clip leaves what was corrected of another beside it', async () => {
  const storage = memoryStorage();
  await saveProject(storage, work(1, { corrected: true, picture: 'small' }));
  await saveProject(storage, { ...work(2), id: 'w1' });
  const [slot] = await listProjects(storage);
  assert.deepEqual([slot.name, slot.corrected, slot.picture, slot.earlier.length], ['n2', false, 'small', 1]);
  assert.equal(projectBytes(slot), 6);
  await saveProject(storage, { ...work(1), at: 3, corrected: true });
  assert.deepEqual((await listProjects(storage))[0].earlier, [], 'the same run takes its own place');
});

test('where the browser gives less room, others make it', async () => {
  const storage = memoryStorage();
  const { put } = storage;
  storage.put = async (record) => {
    if (storage.records.size >= 3) throw Object.assign(new Error('full'), { name: 'QuotaExceededError' });
    return put(record);
  };
  for (let at = 1; at <= 4; at += 1) assert.equal(await saveProject(storage, work(at)), true);
  assert.deepEqual(await ids(storage), ['w4', 'w3', 'w2']);
});

test('work is packed, kept, reopenProject as it was, and saved as a project file', async () => {
  const { app, store } = await openSampleWork();
  const storage = memoryStorage();
  const packer = new Packer();
  const told = [];
  const autosave = new Autosave(
    store,
    async (state) => saveProject(storage, await packer.pack(state, await hashClip(state.source.files))),
    (isPending) => told.push(isPending),
  );
  const { corrections } = store.state.job;
  const stroke = { t: 4, points: [10, 90, 30, 90], radius: 6 };
  showCorrected(store, framesOf(await corrections.paint({ label: corrections.newLabel(), stroke })));
  store.set({ hidden: new Set([2]), edges: { ...store.state.edges, grow: 1 } });
  assert.equal(autosave.hasUnsaved, true);
  autosave.saveSoon();
  await autosave.saving;
  assert.equal(autosave.hasUnsaved, false);
  assert.equal(told.at(-1), false);
  const [saved] = await listProjects(storage);
  assert.deepEqual([saved.name, saved.corrected, saved.edits.edits.length], ['clip.mp4', true, 1]);
  const mask = store.state.analysis.segmentation.mask(4).join('');

  for (const opened of [
    await reopenProject(saved),
    await readProjectFile(new File([await createProjectFile(saved)], 'a.tracecut')),
  ]) {
    await app.openProject('again', async () => opened);
    assert.equal(store.state.phase, 'done');
    const { width, height, images } = store.state.picture;
    assert.deepEqual(
      [width, height, images.length],
      [SAMPLE.width, SAMPLE.height, SAMPLE.frames],
      'its frames are read',
    );
    assert.equal(store.state.analysis.segmentation.mask(4).join(''), mask);
    assert.deepEqual([...store.state.hidden], [2]);
    assert.equal(store.state.edges.grow, 1);
    assert.equal(store.state.job.corrections.undoCount(), 1, 'it can be undone');
    assert.equal(opened.files[0].name, 'clip.mp4');
  }
  await assert.rejects(readProjectFile(new File(['x'], 'b.tracecut')), { code: 'no-project' });
  assert.notEqual(await hashClip([CLIP]), await hashClip([new File(['other'], 'clip.mp4')]));
});

test('a run that goes on is remembered until it ends; what a page of another tab runs is not offered', async () => {
  const storage = memoryStorage();
  const held = new Map();
  const locks = {
    async request(id, ...rest) {
      const act = rest.at(-1);
      if (rest.length > 1 && held.has(id)) throw new Error('timeout');
      const done = Promise.resolve(act());
      held.set(id, done);
      return done.finally(() => held.delete(id));
    },
  };
  const [own, other] = [new RunMemory(storage, locks), new RunMemory(storage, locks)];
  const { store } = await openModel();
  rememberRuns(store, async () => own);
  store.set({ phase: 'running', name: 'clip.mp4', source: { kind: 'video', files: [CLIP] }, job: {} });
  await new Promise((resolve) => setTimeout(resolve, 1300));
  const [run] = [...storage.records.values()];
  assert.match(run.id, /^run-/);
  assert.equal(run.files[0], CLIP);
  assert.equal((await listProjects(storage)).length, 0, 'it is no work');
  assert.equal(await other.findInterrupted(), undefined);
  held.clear();
  assert.equal((await other.findInterrupted()).id, run.id, 'its page is gone');
  store.set({ phase: 'stopped' });
  await new Promise((resolve) => setTimeout(resolve, 20));
  assert.equal(storage.records.size, 0);
});
