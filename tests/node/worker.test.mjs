// The worker's protocol and helpers: whatever becomes of messages and threads, the result is the same bits.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Worker } from 'node:worker_threads';
import { createSession } from 'tracecut';
import { platform, setPlatform } from '../../dist/platform.js';
import { Session } from '../../dist/session/session.js';
import { defaultThreads } from '../../dist/worker/helpers.js';
import { createRemoteEngine, openEngine } from '../../dist/worker/remote.js';
import {
  abortAt,
  compileWasm,
  fingerprint,
  framesOf,
  ready,
  rejects,
  segment,
  SMALL,
  STAGES,
  standIn,
  trappingWasm,
} from './support.mjs';

const module = await compileWasm();

const frames = await framesOf();
const expected = fingerprint(await segment(frames, { threads: 1 }));

/** Opens a session in a stand-in for a worker, with these frames. */
async function open(t, pushed = [], wasm = module) {
  const worker = standIn();
  const session = new Session(await createRemoteEngine(() => worker, wasm, {}), () => compileWasm('decoder'));
  t.after(() => session.close());
  for (const frame of pushed) await session.push(frame);
  return { session, worker };
}

test("corrections in a worker give what they give in this thread, and strokes stay the caller's", async (t) => {
  const points = new Float32Array([30, 30, 60, 40]);
  const strokes = [
    { t: 4, points, radius: 5 },
    { t: 4, points: [75, 45], radius: 6 },
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
  const { session, worker } = await open(t, frames);
  assert.deepEqual([session.width, session.height, session.numFrames], [SMALL.width, SMALL.height, SMALL.frames]);
  assert.ok(frames[0].data.length > 0, 'the caller keeps its pixels');
  const stages = new Set();
  const result = await session.run({ onProgress: ({ stage }) => stages.add(stage) });
  assert.deepEqual([...stages].sort(), [...STAGES].sort());
  assert.equal(fingerprint(result), expected);
  assert.equal((await session.flow(0)).u.length, SMALL.width * SMALL.height);
  const local = await ready(t, {}, frames);
  assert.equal(fingerprint(await local.run()), expected);
  assert.deepEqual(await result.superpixels(3), await local.superpixels(3));
  assert.deepEqual(await result.boundaries(3), await local.boundaries(3));
  assert.deepEqual(await result.saliencyMap(3), await local.saliencyMap(3));
  assert.deepEqual(await result.background(3), await local.background(3));
  session.close();
  assert.ok(worker.terminated);
});

test('jobs that a worker does between frames change nothing', async (t) => {
  const { session } = await open(t);
  const otherFrames = await framesOf({ width: 48, height: 36, frames: 3, seed: 2 });
  for (const frame of frames) {
    await session.push(frame);
    // The stand-in is in this thread: it does its jobs in turns with this run.
    await segment(otherFrames);
  }
  assert.equal(fingerprint(await session.run()), expected);
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

test('a worker answers the requests of the table, and nothing else', async () => {
  for (const type of ['foreground', 'toString']) {
    const worker = standIn();
    const answer = new Promise((resolve) => worker.addEventListener('message', ({ data }) => resolve(data)));
    worker.postMessage({ id: 7, type, data: [0] }, []);
    const data = { code: 'state', message: `unknown request "${type}"` };
    assert.deepEqual(await answer, { id: 7, type: 'failed', data });
    worker.terminate();
  }
});

test('an abort reaches the worker between steps and the run continues later', async (t) => {
  const { session } = await open(t, frames);
  let numReports = 0;
  const run = session.run(abortAt({ isDue: () => (numReports += 1) }));
  await assert.rejects(run, { name: 'AbortError' });
  assert.equal(numReports, 1);
  assert.equal(fingerprint(await session.run()), expected);
});

test('an internal error in the worker ends it and rejects everything that waits', async (t) => {
  const { session, worker } = await open(t, frames, await WebAssembly.compile(await trappingWasm()));
  await rejects(session.run(), 'poisoned', /unreachable/);
  assert.ok(worker.terminated);
  await rejects(session.run(), 'poisoned');
  const { session: fresh } = await open(t, frames);
  assert.equal(fingerprint(await fresh.run()), expected);
});

test('a worker that dies rejects the run, and one that never started says what to check', async (t) => {
  const { session, worker } = await open(t, frames);
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
  const { session, worker } = await open(t, frames);
  const run = session.run();
  session.close();
  await rejects(run, 'closed');
  assert.ok(worker.terminated);
});

/** A session in this thread whose helpers `start` makes. */
async function withHelpers(t, threads, startHelper) {
  const usual = platform;
  t.after(() => setPlatform(usual));
  setPlatform({ loadModule: async () => module, startWorker: undefined, startHelper, cores: () => 1 });
  const session = new Session(await openEngine({ threads, parameters: {} }), async () => module);
  t.after(() => session.close());
  for (const frame of frames) await session.push(frame);
  return session;
}

/** A thread of Node that helps. */
function thread(data) {
  const worker = new Worker(new URL('../../dist/node/worker.js', import.meta.url), {
    workerData: data,
    transferList: [data.port],
  });
  worker.unref();
  return worker;
}

const watchWorker = (worker) => ({
  watch: (onLost) => worker.on('exit', onLost),
  end: () => void worker.terminate(),
});

test('any number of threads gives the same bits', async (t) => {
  for (const threads of [2, 3, 6]) {
    const session = await ready(t, { threads }, frames);
    assert.equal(fingerprint(await session.run()), expected, `${threads} threads`);
  }
});

test('an aborted and continued run gives the same bits', async (t) => {
  const session = await ready(t, { threads: 3 }, frames);
  for (const stop of ['flow', 'saliency', 'superpixels']) {
    const aborted = session.run(abortAt({ isDue: ({ stage }) => stage === stop }));
    await assert.rejects(aborted, { name: 'AbortError' });
  }
  assert.equal(fingerprint(await session.run()), expected);
});

test('a cleared session with helpers forgets what they had', async (t) => {
  const session = await ready(t, { threads: 3 }, frames.slice(2));
  await session.clear();
  for (const frame of frames) await session.push(frame);
  assert.equal(fingerprint(await session.run()), expected);
});

test('a helper that dies is replaced, and its work is done again', async (t) => {
  const workers = [];
  let setReplaced;
  const replaced = new Promise((resolve) => (setReplaced = resolve));
  const session = await withHelpers(t, 2, (data) => {
    workers.push(thread(data));
    if (workers.length === 2) setReplaced();
    return watchWorker(workers.at(-1));
  });
  let killed = false;
  const onProgress = () => {
    if (!killed) workers[0].terminate();
    killed = true;
  };
  assert.equal(fingerprint(await session.run({ onProgress })), expected);
  assert.ok(killed);
  await replaced;
  assert.equal(workers.length, 2);
});

test('helpers that die at once, fail at everything or cannot be started are done without', async (t) => {
  let started = 0;
  const dying = (data) => {
    started += 1;
    data.port.close();
    return { watch: (onLost) => setImmediate(onLost), end() {} };
  };
  const failing = ({ port }) => {
    port.on('message', () => port.postMessage(new Uint32Array()));
    port.unref();
    return { watch() {}, end: () => port.close() };
  };
  const absent = () => {
    throw new Error('no threads here');
  };
  for (const start of [dying, failing, absent]) {
    const session = await withHelpers(t, 3, start);
    assert.equal(fingerprint(await session.run()), expected, start.name);
  }
  assert.ok(started >= 2 && started <= 5, `${started} were started, each replaced at most once`);
});

test('helpers of a session in a worker are workers of the page, replaced when they fail and ended with it', async () => {
  const workers = [];
  const start = () => {
    workers.push(standIn());
    return workers.at(-1);
  };
  const session = new Session(await createRemoteEngine(start, module, {}, 3), async () => module);
  assert.equal(workers.length, 1, 'helpers are started when there is something to do');
  for (const frame of frames) await session.push(frame);
  assert.equal(workers.length, 3);
  workers[2].fail('died');
  assert.equal(workers.length, 4);
  assert.ok(workers[2].terminated);
  assert.equal(fingerprint(await session.run()), expected);
  const numAlive = () => workers.filter((worker) => !worker.terminated).length;
  assert.equal(numAlive(), 1, 'after a run nobody is left but the engine');
  await session.clear();
  for (const frame of frames) await session.push(frame);
  assert.equal(numAlive(), 3);
  assert.equal(fingerprint(await session.run()), expected);
  session.close();
  assert.equal(numAlive(), 0);
});

test('the number of threads is checked, and usually all but one of the machine, or both of two', async () => {
  for (const threads of [0, 1.5, 65, '2']) {
    await rejects(createSession({ threads }), 'param', /threads = .* \(expected a whole number, 1\.\.=64\)/);
  }
  const numbers = [undefined, 1, 2, 3, 4, 9, 64].map((cores) => defaultThreads(cores));
  assert.deepEqual(numbers, [1, 1, 2, 2, 3, 8, 8]);
});
