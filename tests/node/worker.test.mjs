// The worker's protocol, over a channel of messages in this thread: what a browser does, without the browser.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { createRemoteEngine } from '../../dist/worker/remote.js';
import { Session } from '../../dist/session/session.js';
import { SMALL, STAGES, fingerprint, framesOf, ready, rejects, segment, standIn, trappingWasm } from './support.mjs';

const compiled = async (name) =>
  WebAssembly.compile(await readFile(new URL(`../../dist/${name}_bg.wasm`, import.meta.url)));
const module = await compiled('tracecut');

async function open(t, parameters = {}, wasm = module) {
  const worker = standIn();
  const session = new Session(await createRemoteEngine(() => worker, wasm, parameters), () => compiled('decoder'));
  t.after(() => session.close());
  return { session, worker };
}

test("corrections in a worker give what they give in this thread, and strokes stay the caller's", async (t) => {
  const frames = await framesOf();
  const points = new Float32Array([30, 30, 60, 40]);
  const strokes = [
    { t: 4, points, radius: 5 },
    { t: 4, points: [100, 60], radius: 8 },
  ];
  const prints = [];
  for (const session of [(await open(t)).session, await ready(t, undefined, [])]) {
    for (const frame of frames) await session.push(frame);
    await session.run();
    const results = [
      await session.apart(strokes),
      await session.split(0, { t: 2, x: 10, y: 10 }),
      await session.merge(0, 1),
      await session.undo(),
    ];
    prints.push(results.map(fingerprint));
    assert.equal(session.corrections, 2);
    await rejects(session.merge(0, 99), 'param', /labels in use/);
  }
  assert.deepEqual(prints[0], prints[1]);
  assert.deepEqual([...points], [30, 30, 60, 40]);
});

test('a session in a worker gives the same result as one in this thread', async (t) => {
  const { session, worker } = await open(t);
  const frames = await framesOf();
  for (const frame of frames) await session.push(frame);
  assert.deepEqual([session.width, session.height, session.numFrames], [SMALL.width, SMALL.height, SMALL.frames]);
  assert.ok(frames[0].data.length > 0, 'the caller keeps its pixels');
  const stages = new Set();
  const result = await session.run({ onProgress: ({ stage }) => stages.add(stage) });
  assert.deepEqual([...stages].sort(), [...STAGES].sort());
  assert.equal(fingerprint(result), fingerprint(await segment(frames)));
  assert.equal((await session.flow(0)).u.length, SMALL.width * SMALL.height);
  const local = await ready(t);
  await local.run();
  assert.deepEqual(await result.superpixels(3), await local.superpixels(3));
  assert.deepEqual(await result.boundaries(3), await local.boundaries(3));
  assert.deepEqual(await result.saliencyMap(3), await local.saliencyMap(3));
  assert.deepEqual(await result.background(3), await local.background(3));
  session.close();
  assert.ok(worker.terminated);
});

test('errors cross with code and message', async (t) => {
  await rejects(
    createRemoteEngine(() => standIn(), module, { clip: { maxSize: 1 } }),
    'param',
    /clip\.maxSize/,
  );
  const { session } = await open(t);
  await rejects(session.run(), 'too-few-frames');
  await rejects(session.push(new Uint8Array(5)), 'decode');
});

test('a worker answers what is in the table, and nothing else', async () => {
  for (const type of ['foreground', 'toString']) {
    const worker = standIn();
    const answered = new Promise((resolve) => worker.addEventListener('message', ({ data }) => resolve(data)));
    worker.postMessage({ id: 7, type, data: [0] }, []);
    assert.deepEqual(await answered, {
      id: 7,
      type: 'failed',
      data: { code: 'state', message: `unknown request "${type}"` },
    });
    worker.terminate();
  }
});

test('an abort reaches the worker between steps and the run goes on later', async (t) => {
  const { session } = await open(t);
  const frames = await framesOf();
  for (const frame of frames) await session.push(frame);
  const controller = new AbortController();
  let heard = 0;
  const run = session.run({
    signal: controller.signal,
    onProgress() {
      heard += 1;
      controller.abort();
    },
  });
  await assert.rejects(run, { name: 'AbortError' });
  assert.equal(heard, 1);
  assert.equal(fingerprint(await session.run()), fingerprint(await segment(frames)));
});

test('an internal error in the worker ends it and rejects everything that waits', async (t) => {
  const { session, worker } = await open(t, {}, await WebAssembly.compile(await trappingWasm()));
  for (const frame of await framesOf()) await session.push(frame);
  await rejects(session.run(), 'poisoned', /unreachable/);
  assert.ok(worker.terminated);
  await rejects(session.run(), 'poisoned');
  const { session: fresh } = await open(t);
  for (const frame of await framesOf()) await fresh.push(frame);
  assert.equal((await fresh.run()).numFrames, SMALL.frames);
});

test('a worker that dies rejects the run, and one that never started says what to check', async (t) => {
  const { session, worker } = await open(t);
  for (const frame of await framesOf()) await session.push(frame);
  const run = session.run();
  worker.fail('out of memory');
  await rejects(run, 'memory', /out of memory/);
  const silent = standIn(() => {});
  const opening = createRemoteEngine(() => silent, module, {});
  silent.fail('');
  await rejects(opening, 'wasm-load', /worker\.js/);
  assert.ok(silent.terminated);
});

test('closing rejects what waits and ends the worker', async (t) => {
  const { session, worker } = await open(t);
  for (const frame of await framesOf()) await session.push(frame);
  const run = session.run();
  session.close();
  await rejects(run, 'closed');
  assert.ok(worker.terminated);
});
