// Where the package's files and its worker are: finding and compiling the wasm file, and engines that lack what others have.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { configure, createSession, maskPng, synthClip } from 'tracecut';
import { enlargeMask } from 'tracecut/edit';
import { boundaries } from 'tracecut/stages';
import { platform, setPlatform, getWorkerStarter } from '../../dist/platform.js';
import { runTask } from '../../dist/worker/aside.js';
import { serve } from '../../scripts/serve.mjs';
import { plain, png, rejects } from './support.mjs';

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
    [{ wams: 'x' }, /^wams = "x" \(expected a known option, such as wasm; the options are wasm, decoder, worker\)/],
    [{ wasm: 'none', worker: 3 }, /^worker = 3 \(expected true, false, an address or a function that starts one\)/],
  ])
    assert.throws(
      () => configure(where),
      (error) => error.code === 'param' && words.test(error.message),
    );
  (await synthClip(SMALL)).close();
});

test('a worker is an address, a function, true or false; threads of Node have no address', async () => {
  const message = /^worker = .* \(expected true, false or nothing: threads of Node need no address\)/;
  for (const worker of ['/worker.bundle.js', new URL('file:///worker.js')])
    await rejects(createSession({ worker }), 'unsupported', message);
  await rejects(createSession({ worker: () => null }), 'param', /^worker\(\) = null \(expected a Worker\)/);
  const mask = { labels: new Uint8Array(4), width: 2, height: 2 };
  const picture = { data: new Uint8Array(16), width: 2, height: 2 };
  await rejects(enlargeMask(mask, picture, { worker: '/worker.js' }), 'unsupported', message);
  for (const worker of [0, {}, null]) await rejects(createSession({ worker }), 'param', /^worker = /);
  (await createSession({ worker: false })).close();
});

test('where there are workers, what a call says comes before what configure says, and that before the package', (t) => {
  restored(t);
  const [firstWorker, two, ownWorker] = [1, 2, 3].map((name) => () => ({ name, postMessage() {} }));
  setPlatform({ ...platform, startWorker: ownWorker, inProcess: false });
  const started = (worker) => getWorkerStarter(worker)?.().name;
  assert.deepEqual([started(), started(true), started(false), started(firstWorker)], [3, 3, undefined, 1]);
  configure({ worker: two });
  assert.deepEqual([started(), started(true), started(false), started(firstWorker)], [2, 2, undefined, 1]);
  configure({ worker: false });
  assert.deepEqual([started(), started(firstWorker)], [undefined, 1]);
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
      queueMicrotask(() => listeners.message({ data: { id, type: 'failed', data: { code: 'state' } } })),
    terminate() {},
  };
  const task = { kind: 'zip', files: { a: new Uint8Array([1]) }, stored: [] };
  setPlatform({ ...platform, startAside: () => worker });
  const bytes = await runTask(task);
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
  const expected = printed([]);
  assert.match(expected, /weißt du/);
  const gone = ['TextDecoder', 'TextEncoder', 'FinalizationRegistry', 'MessageChannel', 'setImmediate'];
  assert.equal(printed(gone), expected);
});

const wasmFile = new URL('../../dist/tracecut_bg.wasm', import.meta.url);

test('the module needs no relaxed SIMD, which Safari and Node 20 refuse', async () => {
  const bytes = await readFile(wasmFile);
  const relaxed = [
    0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 15, 1, 13, 0, 65, 1, 253, 15, 65, 2, 253, 15,
    253, 128, 2, 11,
  ];
  assert.ok(WebAssembly.validate(bytes), 'this Node refuses the module');
  // Where the engine itself knows relaxed SIMD the check above proves nothing; CI runs a Node that does not.
  if (process.version.startsWith('v20.'))
    assert.ok(!WebAssembly.validate(new Uint8Array(relaxed)), 'the probe is no probe');
});

test('wasm can be given as bytes, as a module, as a file URL, as a web URL and as a response', async (t) => {
  const bytes = await readFile(wasmFile);
  const server = await serve();
  t.after(() => server.close());
  const url = `${server.url}dist/tracecut_bg.wasm`;
  for (const wasm of [
    bytes,
    bytes.buffer,
    await WebAssembly.compile(bytes),
    wasmFile,
    url,
    new URL(url),
    await fetch(url),
  ]) {
    (await createSession({ wasm })).close();
  }
});

test('the decoder is only loaded for files, from its configured address', async (t) => {
  const [broken, image] = [new Uint8Array([0, 97, 115, 109, 9]), plain(8, 8)];
  const session = await createSession({ decoder: broken });
  t.after(() => session.close());
  await session.push(image);
  await rejects(session.push(png(image)), 'wasm-load', /could not be compiled/);
  assert.equal(session.numFrames, 1);
  const second = await createSession({ decoder: new URL('../../dist/decoder_bg.wasm', import.meta.url) });
  t.after(() => second.close());
  await second.push(png(image));
  assert.equal(second.numFrames, 1);
  await rejects(boundaries(png(image), { decoder: 7 }), 'param', /wasm = 7/);
});

test('a page of HTML in place of wasm is called what it is', async () => {
  const html = new TextEncoder().encode('<!doctype html><title>404</title>');
  await rejects(createSession({ wasm: html }), 'wasm-load', /HTML/);
  const response = new Response(html, { headers: { 'Content-Type': 'text/html' } });
  await rejects(createSession({ wasm: response }), 'wasm-load', /HTML/);
  const disguised = new Response(html, { headers: { 'Content-Type': 'application/wasm' } });
  await rejects(createSession({ wasm: disguised }), 'wasm-load', /HTML/);
});

test('a missing, broken or wrong wasm file is a wasm-load error in words', async (t) => {
  const server = await serve();
  t.after(() => server.close());
  await rejects(createSession({ wasm: `${server.url}dist/none.wasm` }), 'wasm-load', /the server answered 404/);
  await rejects(createSession({ wasm: new URL('none.wasm', wasmFile) }), 'wasm-load', /could not be read/);
  await rejects(createSession({ wasm: new Uint8Array([0, 97, 115, 109, 9]) }), 'wasm-load', /could not be compiled/);
  await rejects(createSession({ wasm: 7 }), 'param', /wasm = 7/);
});
