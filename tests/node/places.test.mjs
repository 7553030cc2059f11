// Where the package's files and its worker are, and faults around the package (docs/reliability.md): files that are missing or come in
// part, engines that lack classes, threads that are killed, clocks that jump, sources without end.

import assert from 'node:assert/strict';
import { cpSync, mkdtempSync, rmSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { configure, createSession, maskPng, segmentVideo, synthClip } from 'tracecut';
import { enlargeMask } from 'tracecut/edit';
import { boundaries } from 'tracecut/stages';
import { getWorkerStarter, platform, setPlatform } from '../../dist/platform.js';
import { runTask } from '../../dist/worker/aside.js';
import { serve } from '../../scripts/serve.mjs';
import { root } from '../../scripts/tools.mjs';
import {
  compileWasm,
  endless,
  fingerprint,
  framesOf,
  open,
  plain,
  png,
  readWasm,
  ready,
  rejects,
  runModule,
  segment,
} from './support.mjs';

const TINY = { width: 64, height: 48, frames: 5, seed: 5 };
const frames = await framesOf(TINY);
const expected = fingerprint(await segment(frames));
const file = (name) => fileURLToPath(new URL(`../../dist/${name}`, import.meta.url));

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
  await rejects(synthClip(TINY), 'wasm-load', /none\.wasm could not be read/);
  const wasm = await readWasm();
  (await synthClip({ ...TINY, wasm })).close();
  configure({ wasm });
  const session = await open(t);
  await rejects(session.push(png), 'wasm-load', /none\.wasm could not be read/);
  configure({ decoder: file('decoder_bg.wasm') });
  await session.push(png);
  assert.equal(session.width, 2);
  configure({ wasm: undefined });
  (await synthClip(TINY)).close();
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
  (await synthClip(TINY)).close();
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
    const clip = await synthClip({ width: 64, height: 48, frames: 3 });
    const session = await createSession({ threads: 1 });
    for (let t = 0; t < 3; t += 1) await session.push(clip.frame(t));
    const zip = await masksZip(await session.run());
    const text = await createSession({ cut: { 'weißt du': 1 } }).catch(({ message }) => message);
    console.log(zip.length, zip.reduce((sum, byte) => (Math.imul(sum, 31) + byte) >>> 0, 0), text);`;
  const expected = runModule(script([]));
  assert.match(expected, /weißt du/);
  const gone = ['TextDecoder', 'TextEncoder', 'FinalizationRegistry', 'MessageChannel', 'setImmediate'];
  assert.equal(runModule(script(gone)), expected);
});

const wasmFile = new URL('../../dist/tracecut_bg.wasm', import.meta.url);
const wasmBytes = await readWasm();

test('the module needs no relaxed SIMD, which Safari and Node 20 refuse', () => {
  const relaxed = [
    0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 15, 1, 13, 0, 65, 1, 253, 15, 65, 2, 253, 15,
    253, 128, 2, 11,
  ];
  assert.ok(WebAssembly.validate(wasmBytes), 'this Node refuses the module');
  // Where the engine itself knows relaxed SIMD the check above proves nothing; CI runs a Node that does not.
  if (process.version.startsWith('v20.'))
    assert.ok(!WebAssembly.validate(new Uint8Array(relaxed)), 'the probe is no probe');
});

test('wasm can be given as bytes, as a module, as a file URL, as a web URL and as a response', async (t) => {
  const server = await serve();
  t.after(() => server.close());
  const url = `${server.url}dist/tracecut_bg.wasm`;
  const inMemory = [wasmBytes, wasmBytes.buffer, await compileWasm()];
  for (const wasm of [...inMemory, wasmFile, url, new URL(url), await fetch(url)])
    (await createSession({ wasm })).close();
});

test('the decoder is only loaded for files, from its configured address', async (t) => {
  const [broken, image] = [new Uint8Array([0, 97, 115, 109, 9]), plain(8, 8)];
  const session = await open(t, { decoder: broken });
  await session.push(image);
  await rejects(session.push(png(image)), 'wasm-load', /could not be compiled/);
  assert.equal(session.numFrames, 1);
  const second = await open(t, { decoder: new URL('../../dist/decoder_bg.wasm', import.meta.url) });
  await second.push(png(image));
  assert.equal(second.numFrames, 1);
  await rejects(boundaries(png(image), { decoder: 7 }), 'param', /wasm = 7/);
});

test('a missing, broken or wrong wasm file, or a page of HTML in its place, is an error in words', async (t) => {
  const server = await serve();
  t.after(() => server.close());
  const html = '<!doctype html><title>404</title>';
  const responseOf = (type) => new Response(html, { headers: { 'Content-Type': type } });
  for (const [wasm, message] of [
    [new TextEncoder().encode(html), /HTML/],
    [responseOf('text/html'), /HTML/],
    [responseOf('application/wasm'), /HTML/],
    [`${server.url}dist/none.wasm`, /the server answered 404/],
    [new URL('none.wasm', wasmFile), /could not be read/],
    [new Uint8Array([0, 97, 115, 109, 9]), /could not be compiled/],
  ])
    await rejects(createSession({ wasm }), 'wasm-load', message);
  await rejects(createSession({ wasm: 7 }), 'param', /wasm = 7/);
});

/** Returns the threads that start from now on until the test ends, in their order. */
function watchThreads(t) {
  const threads = [];
  const watch = (thread) => threads.push(thread);
  process.on('worker', watch);
  t.after(() => process.off('worker', watch));
  return threads;
}

test('a thread that is killed ends what waits for it with an error, and the next session has another', async (t) => {
  const threads = watchThreads(t);
  const session = await ready(t, { worker: true }, frames);
  const run = session.run({ onProgress: () => void threads[0].terminate() });
  await rejects(run, 'poisoned', /the thread ended with code 1.*Create a new session/);
  await rejects(session.push(frames[0]), 'poisoned');
  session.close();
  assert.equal(fingerprint(await (await ready(t, { worker: true }, frames)).run()), expected);
});

test('a thread that is killed under segmentVideo ends the loop and the source', async (t) => {
  const threads = watchThreads(t);
  const source = endless(frames);
  const video = segmentVideo(source, { worker: true, window: 4, overlap: 2 });
  const windows = [];
  const read = async () => {
    for await (const window of video) {
      windows.push(window);
      if (windows.length === 2) await threads[0].terminate();
    }
  };
  await rejects(read(), 'poisoned');
  await source.ended;
  assert.ok(windows[0].frames().next().value.labels.length > 0, 'what came before stays');
});

for (const file of ['tracecut_bg.wasm', 'node/worker.js', 'decoder_bg.wasm', 'kit/export/masks.js'])
  test(`without ${file} what needs it is a wasm-load error, and the rest works`, async (t) => {
    const folder = mkdtempSync(join(tmpdir(), 'tracecut-missing-'));
    t.after(() => rmSync(folder, { recursive: true, force: true }));
    cpSync(join(root, 'dist'), folder, { recursive: true, filter: (path) => !path.endsWith(`/${file}`) });
    const api = await import(pathToFileURL(join(folder, 'node.js')).href);
    const isOurs = (error) => {
      assert.ok(error instanceof api.TraceCutError, `${error?.stack}`);
      assert.equal(error.code, 'wasm-load', error.message);
      assert.match(error.message, new RegExp(file.replace(/_bg\.wasm|\.js$/, '')));
      return true;
    };
    if (file === 'tracecut_bg.wasm') return assert.rejects(api.createSession(), isOurs);
    if (file === 'node/worker.js') await assert.rejects(api.createSession({ worker: true }), isOurs);
    if (file === 'kit/export/masks.js') await assert.rejects(api.masksZip(null), isOurs);
    const session = await api.createSession();
    t.after(() => session.close());
    if (file === 'decoder_bg.wasm') await assert.rejects(session.push(new Uint8Array([137, 80, 78, 71])), isOurs);
    for (const frame of frames) await session.push(frame);
    assert.equal(fingerprint(await session.run()), expected);
    return undefined;
  });

test('a wasm file whose network goes half-way is a wasm-load error, and comes whole the next time', async (t) => {
  let calls = 0;
  const server = createServer((request, response) => {
    calls += 1;
    response.writeHead(200, { 'content-type': 'application/wasm', 'content-length': wasmBytes.length });
    if (calls > 1) return response.end(wasmBytes);
    return response.write(wasmBytes.subarray(0, wasmBytes.length / 2), () => response.destroy());
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  t.after(() => server.close());
  const wasm = new URL(`http://127.0.0.1:${server.address().port}/tracecut_bg.wasm`);
  await rejects(createSession({ wasm }), 'wasm-load', /tracecut_bg\.wasm came only in part/);
  const consumed = new Response(wasmBytes, { headers: { 'content-type': 'application/wasm' } });
  await consumed.arrayBuffer();
  await rejects(createSession({ wasm: consumed }), 'wasm-load', /the response came only in part/);
  assert.equal(fingerprint(await (await ready(t, { wasm }, frames)).run()), expected);
});

/** Clocks that go wrong, by the time that the real one says. */
const CLOCKS = {
  'stands still': () => () => 1000,
  'is put back by an hour at every look': () => {
    let now = 1e9;
    return () => (now -= 3_600_000);
  },
  'leaps a day ahead at every look': () => {
    let now = 0;
    return () => (now += 86_400_000);
  },
  'goes to and fro': () => {
    let k = 0;
    return () => ((k += 1) % 2 ? 1e9 : -1e9);
  },
};

for (const [words, make] of Object.entries(CLOCKS))
  test(`where the clock ${words} results are the same, and the thread answers in between`, async (t) => {
    const session = await ready(t, {}, frames);
    const { now } = performance;
    const dateNow = Date.now;
    const clock = make();
    t.after(() => Object.assign(Date, { now: dateNow }) && Object.assign(performance, { now }));
    performance.now = clock;
    Date.now = clock;
    let between = 0;
    let over = false;
    const count = () => {
      between += 1;
      if (!over) setImmediate(count);
    };
    setImmediate(count);
    const result = await session.run();
    over = true;
    assert.equal(fingerprint(result), expected);
    assert.ok(between >= 2, `${between} chances for others`);
    for (const [stage, seconds] of Object.entries(result.seconds)) assert.ok(seconds >= 0, `${stage}: ${seconds} s`);
    const windows = await segmentVideo(frames, { window: 3, overlap: 1, threads: 1 }).collect();
    assert.equal(windows.numFrames, frames.length);
  });

test('a source without end is read no further than it is wanted', async () => {
  const source = endless(frames);
  let windows = 0;
  for await (const window of segmentVideo(source, { window: 4, overlap: 2 })) {
    windows += 1;
    if (windows === 3) {
      assert.ok(window.frames().next().value.labels.length > 0);
      break;
    }
  }
  await source.ended;
  // Three windows of four frames that share two, and one that is computed ahead.
  assert.ok(source.numTaken <= 13, `${source.numTaken} frames`);
  const partial = await segmentVideo(endless(frames), { maxFrames: 5 }).collect();
  assert.equal(partial.numFrames, 5);
});
