// Where the package's files and its worker are, and engines that lack what others have.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { configure, createSession, maskPng, synthClip } from 'tracecut';
import { enlargeMask } from 'tracecut/edit';
import { aside } from '../../dist/worker/aside.js';
import { platform, setPlatform, workerStarter } from '../../dist/platform.js';
import { rejects } from './support.mjs';

const file = (name) => fileURLToPath(new URL(`../../dist/${name}`, import.meta.url));
const SMALL = { width: 64, height: 48, frames: 2 };

/** Puts the places back when the test ends. */
function restored(t) {
  const usual = platform;
  t.after(() => {
    configure({ wasm: undefined, decoder: undefined, worker: undefined });
    setPlatform(usual);
  });
}

test('configure says for all calls where the wasm files are, until it says otherwise', async (t) => {
  restored(t);
  const png = await maskPng({ width: 2, height: 1, numFrames: 1, labels: () => new Uint8Array(2) }, 0);
  configure({ wasm: file('none.wasm'), decoder: file('none.wasm') });
  await rejects(synthClip(SMALL), 'wasm-load', /none\.wasm could not be read/);
  const wasm = await readFile(file('tracecut_bg.wasm'));
  (await synthClip({ ...SMALL, wasm })).close();
  configure({ wasm });
  const session = await createSession();
  t.after(() => session.close());
  await rejects(session.push(png), 'wasm-load', /none\.wasm could not be read/);
  configure({ decoder: file('decoder_bg.wasm') });
  await session.push(png);
  assert.equal(session.width, 2);
  configure({ wasm: undefined });
  (await synthClip(SMALL)).close();
});

test('a place that is none is refused, and nothing of what came with it is kept', async (t) => {
  restored(t);
  for (const [where, words] of [
    [undefined, /^options = undefined \(expected an object with wasm, decoder, worker\)/],
    [{ wams: 'x' }, /^wams = "x" \(expected no such option; there are wasm, decoder, worker\)/],
    [{ wasm: 'none', worker: 3 }, /^worker = 3 \(expected true, false, an address or a function that starts one\)/],
  ])
    assert.throws(
      () => configure(where),
      (error) => error.code === 'param' && words.test(error.message),
    );
  (await synthClip(SMALL)).close();
});

test('a worker is an address, a function, true or false; threads of Node have no address', async () => {
  const words = /^worker = .* \(expected true, false or nothing: threads of Node need no address\)/;
  for (const worker of ['/worker.bundle.js', new URL('file:///worker.js')])
    await rejects(createSession({ worker }), 'unsupported', words);
  await rejects(createSession({ worker: () => null }), 'param', /^worker\(\) = null \(expected a Worker\)/);
  const mask = { labels: new Uint8Array(4), width: 2, height: 2 };
  const picture = { data: new Uint8Array(16), width: 2, height: 2 };
  await rejects(enlargeMask(mask, picture, { worker: '/worker.js' }), 'unsupported', words);
  for (const worker of [0, {}, null]) await rejects(createSession({ worker }), 'param', /^worker = /);
  (await createSession({ worker: false })).close();
});

test('where there are workers, what a call says comes before what configure says, and that before the package', (t) => {
  restored(t);
  const [one, two, own] = [1, 2, 3].map((name) => () => ({ name, postMessage() {} }));
  setPlatform({ ...platform, startWorker: own, inProcess: false });
  const started = (worker) => workerStarter(worker)?.().name;
  assert.deepEqual([started(), started(true), started(false), started(one)], [3, 3, undefined, 1]);
  configure({ worker: two });
  assert.deepEqual([started(), started(true), started(false), started(one)], [2, 2, undefined, 1]);
  configure({ worker: false });
  assert.deepEqual([started(), started(one)], [undefined, 1]);
  assert.throws(
    () => started(() => 'no worker'),
    (error) => error.code === 'param' && error.message === 'worker() = "no worker" (expected a Worker)',
  );
});

test('what a worker of sessions alone refuses to do aside is done in this thread', async (t) => {
  restored(t);
  const listeners = {};
  const worker = {
    addEventListener: (type, listener) => (listeners[type] = listener),
    postMessage: ({ id }) =>
      setTimeout(() => listeners.message({ data: { id, type: 'failed', data: { code: 'state' } } })),
    terminate() {},
  };
  const task = { kind: 'zip', files: { a: new Uint8Array([1]) }, stored: [] };
  setPlatform({ ...platform, startAside: () => worker });
  const bytes = await aside(task);
  assert.deepEqual([...bytes.subarray(0, 2)], [80, 75]);
});

test('an engine without classes for text, messages or garbage gives the same result', async () => {
  const script = (gone) => `
    for (const name of ${JSON.stringify(gone)}) delete globalThis[name];
    const { createSession, masksZip, synthClip } = await import('./dist/node.js');
    const clip = await synthClip({ width: 128, height: 72, frames: 4 });
    const session = await createSession({ threads: 1 });
    for (let t = 0; t < 4; t += 1) await session.push(clip.frame(t));
    const zip = await masksZip(await session.run());
    const words = await createSession({ cut: { 'weißt du': 1 } }).catch(({ message }) => message);
    console.log(zip.length, zip.reduce((sum, byte) => (Math.imul(sum, 31) + byte) >>> 0, 0), words);`;
  const printed = (gone) =>
    execFileSync(process.execPath, ['--input-type=module', '--eval', script(gone)], {
      cwd: fileURLToPath(new URL('../..', import.meta.url)),
      encoding: 'utf8',
    });
  const whole = printed([]);
  assert.match(whole, /weißt du/);
  const gone = ['TextDecoder', 'TextEncoder', 'FinalizationRegistry', 'MessageChannel', 'setImmediate'];
  assert.equal(printed(gone), whole);
});
