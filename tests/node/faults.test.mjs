// Faults around the package in Node: threads that are killed, files that are missing or come in part, clocks that jump,
// sources without end. Each with what is kept (docs/reliability.md).

import assert from 'node:assert/strict';
import { cpSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { createSession, segmentVideo } from 'tracecut';
import { root } from '../../scripts/tools.mjs';
import { fingerprint, framesOf, ready, rejects, segment } from './support.mjs';

const SMALL = { width: 64, height: 48, frames: 5, seed: 5 };
const frames = await framesOf(SMALL);
const expected = fingerprint(await segment(frames));

test('a thread that is killed ends what waits for it with an error, and the next session has another', async (t) => {
  const threads = [];
  const watch = (thread) => threads.push(thread);
  process.on('worker', watch);
  t.after(() => process.off('worker', watch));
  const session = await ready(t, { worker: true }, frames);
  const run = session.run({ onProgress: () => void threads[0].terminate() });
  await rejects(run, 'poisoned', /the thread ended with code 1.*Create a new session/);
  await rejects(session.push(frames[0]), 'poisoned');
  session.close();
  assert.equal(fingerprint(await (await ready(t, { worker: true }, frames)).run()), expected);
});

test('a thread that is killed under segmentVideo ends the loop and the source', async (t) => {
  const threads = [];
  const watch = (thread) => threads.push(thread);
  process.on('worker', watch);
  t.after(() => process.off('worker', watch));
  let isClosed = false;
  const source = (async function* () {
    try {
      for (let k = 0; ; k += 1) yield frames[k % frames.length];
    } finally {
      isClosed = true;
    }
  })();
  const video = segmentVideo(source, { worker: true, window: 4, overlap: 2 });
  const windows = [];
  const read = async () => {
    for await (const window of video) {
      windows.push(window);
      if (windows.length === 2) await threads[0].terminate();
    }
  };
  await rejects(read(), 'poisoned');
  assert.ok(isClosed, 'the source was ended');
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
  const wasmBytes = readFileSync(join(root, 'dist', 'tracecut_bg.wasm'));
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
    const windows = await segmentVideo(frames, { window: 3, overlap: 1 }).collect();
    assert.equal(windows.numFrames, frames.length);
  });

test('a source without end is read no further than it is wanted', async () => {
  let yielded = 0;
  let isClosed = false;
  const source = (async function* () {
    try {
      for (;;) {
        yield frames[yielded % frames.length];
        yielded += 1;
      }
    } finally {
      isClosed = true;
    }
  })();
  let windows = 0;
  for await (const window of segmentVideo(source, { window: 4, overlap: 2 })) {
    windows += 1;
    if (windows === 3) {
      assert.ok(window.frames().next().value.labels.length > 0);
      break;
    }
  }
  // The source ends in a task of its own.
  await new Promise(setImmediate);
  assert.ok(isClosed, 'the source was ended');
  // Three windows of four frames that share two, and one that is computed ahead.
  assert.ok(yielded <= 12, `${yielded} frames`);
  const partial = await segmentVideo(
    (async function* () {
      for (;;) yield frames[0];
    })(),
    { maxFrames: 5 },
  ).collect();
  assert.equal(partial.numFrames, 5);
});
