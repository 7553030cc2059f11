// A session's life: progress, abort and going on, closing, repeating; several of one thread; one on a thread of its own.

import assert from 'node:assert/strict';
import { monitorEventLoopDelay } from 'node:perf_hooks';
import { test } from 'node:test';
import { createSession, parameters, segmentVideo, synthClip, version } from 'tracecut';
import { enlargeMask } from 'tracecut/edit';
import { superpixels, trajectories } from 'tracecut/stages';
import {
  abortAt,
  checkTrackFile,
  each,
  fingerprint,
  framesOf,
  open,
  plain,
  printOf,
  ready,
  rejects,
  resultOf,
  runModule,
  segment,
  SMALL,
  STAGES,
  trappingWasm,
  untilCollected,
  watchMemories,
} from './support.mjs';

/** A clip that runs in a moment. */
const TINY = { width: 64, height: 48, frames: 5, seed: 5 };

test('a run reports every stage to its end, in numbers that only grow', async (t) => {
  const session = await ready(t);
  const stageReports = new Map();
  const result = await session.run({
    onProgress({ stage, done, total }) {
      const before = stageReports.get(stage) ?? { done: 0, total };
      assert.ok(done >= before.done && done <= total, `${stage} went from ${before.done} to ${done} of ${total}`);
      // A move of the cut that gains something asks for more of them.
      assert.ok(
        stage === 'cut' ? total >= before.total : total === before.total,
        `${stage}: ${before.total}, ${total}`,
      );
      stageReports.set(stage, { done, total });
    },
  });
  assert.deepEqual([...stageReports.keys()].sort(), [...STAGES].sort());
  for (const [stage, { done, total }] of stageReports) assert.equal(done, total, stage);
  assert.deepEqual(Object.keys(result.seconds).sort(), [...STAGES].sort());
  assert.ok(Object.values(result.seconds).every((s) => s >= 0 && s < 600));
});

test('the same clip gives the same result twice, to the last bit, also if it is run again without new frames', async (t) => {
  const session = await ready(t);
  assert.equal(fingerprint(await session.run()), await printOf());
  assert.equal(fingerprint(await session.run()), await printOf());
});

test('a run that is aborted, or whose onProgress throws, rejects with the reason and continues to the same result', async (t) => {
  const session = await ready(t);
  await assert.rejects(session.run({ signal: AbortSignal.abort('late') }), (reason) => reason === 'late');
  const betweenSteps = new AbortController();
  setImmediate(() => betweenSteps.abort());
  await assert.rejects(session.run({ signal: betweenSteps.signal }), { name: 'AbortError' });
  const error = new RangeError('of the caller');
  const onProgress = () => {
    throw error;
  };
  await assert.rejects(session.run({ onProgress }), error);
  for (const stage of ['flow', 'flow', 'trajectories', 'affinities']) {
    const reason = new Error(`enough of ${stage}`);
    await session.run(abortAt({ reason, isDue: (progress) => progress.stage === stage })).then(
      () => {},
      (error) => assert.equal(error, reason),
    );
  }
  assert.equal(fingerprint(await session.run()), await printOf());
});

test('a cancelled run, cleared and filled again, equals a new one', async (t) => {
  const session = await ready(t);
  const aborted = session.run(abortAt({ isDue: ({ stage }) => stage === 'affinities' }));
  await assert.rejects(aborted, { name: 'AbortError' });
  await session.clear();
  assert.equal(session.numFrames, 0);
  for (const frame of await framesOf()) await session.push(frame);
  assert.equal(fingerprint(await session.run()), await printOf());
});

test('calls that come too early or too late are refused with what to do instead; results outlive their session', async (t) => {
  const session = await ready(t);
  const [frame] = await framesOf();
  const run = session.run();
  await rejects(session.run(), 'busy', /run was called while a run is under way/);
  await rejects(session.push(frame), 'busy');
  await rejects(session.flow(0), 'busy');
  await rejects(session.clear(), 'busy');
  const result = await run;
  await rejects(session.push(frame), 'state', /clear/);
  await session.clear();
  await session.push(frame);
  assert.equal(session.numFrames, 1);
  session.close();
  session.close();
  session[Symbol.dispose]();
  await rejects(session.run(), 'closed', /run was called on a closed session/);
  await rejects(session.push(frame), 'closed');
  await rejects(session.flow(0), 'closed');
  await rejects(session.clear(), 'closed');
  assert.ok(result.trajectories.count > 0 && result.toTracksDat().length > 0);
});

test('closing during a run rejects the run', async (t) => {
  const session = await ready(t);
  const run = session.run();
  setImmediate(() => session.close());
  await rejects(run, 'closed');
});

test('wrong arguments of run are named', async (t) => {
  const session = await ready(t);
  await rejects(session.run({ onProgress: 3 }), 'param', /onProgress = 3/);
  await rejects(session.run({ signal: 'stop' }), 'param', /signal = "stop" \(expected an AbortSignal\)/);
});

test('the forward flow of a pair has the working size and follows the scene', async (t) => {
  const clip = await synthClip({ width: 120, height: 72, frames: 2, seed: 4 });
  const session = await open(t);
  await session.push(clip.frame(0));
  await session.push(clip.frame(1));
  await session.run();
  const [flow, truth] = [await session.flow(0), clip.flow(0)];
  assert.deepEqual([flow.width, flow.height], [120, 72]);
  const errors = flow.u.map((u, p) => Math.hypot(u - truth.u[p], flow.v[p] - truth.v[p])).sort();
  assert.ok(errors[errors.length >> 1] < 0.3, `median end-point error ${errors[errors.length >> 1]} px`);
});

test('a large frame is processed at maxSide and its results are in input pixels', async () => {
  const result = await segment(await framesOf(), { clip: { maxSide: 48 } });
  assert.deepEqual([result.width, result.height], [SMALL.width, SMALL.height]);
  assert.ok(Math.max(...result.trajectories.x) > 60, `largest x ${Math.max(...result.trajectories.x)}`);
});

test('the track file lists every trajectory with its label, points and frames', async () => {
  checkTrackFile(await resultOf());
});

test('the edges of a frame join trajectories that are alive in it', async () => {
  const result = await resultOf();
  const { startFrame, offset } = result.trajectories;
  const alive = (i, t) => startFrame[i] <= t && t < startFrame[i] + offset[i + 1] - offset[i];
  for (let t = 0; t < result.numFrames; t += 1) {
    const { i, j, d } = result.edges(t);
    assert.ok(i.length > 0 && i.length === j.length && i.length === d.length);
    i.forEach((a, e) => assert.ok(alive(a, t) && alive(j[e], t) && a !== j[e]));
    assert.ok(d.every((value) => value >= 0 && value <= 1));
  }
});

test('memory stays flat over repeated runs', async (t) => {
  const memories = watchMemories(t);
  const session = await open(t);
  const [memory] = memories;
  const frames = await framesOf(TINY);
  const sizes = [];
  for (let i = 0; i < 7; i += 1) {
    for (const frame of frames) await session.push(frame);
    await session.run();
    await session.clear();
    sizes.push(memory.deref().buffer.byteLength);
  }
  assert.equal(sizes.at(-1), sizes[2], `bytes after each run: ${sizes}`);
});

test('the listed parameters are those that options accept, at their defaults', async () => {
  assert.match(version, /^\d+\.\d+\.\d+/);
  const options = {};
  for (const { name, default: value } of parameters()) {
    const [section, field] = name.split('.');
    (options[section] ??= {})[field] = value;
  }
  assert.equal(fingerprint(await segment(await framesOf(), options)), await printOf());
});

test('two sessions with different clips and parameters, in turn, give what each gives alone', async (t) => {
  const clips = [await framesOf(), await framesOf({ ...SMALL, seed: 9 })];
  const settings = [{ trajectory: { gridStep: 5 } }, { clip: { maxSide: 64 }, refine: { band: 0 } }];
  const expected = [];
  for (const k of [0, 1]) expected.push(fingerprint(await segment(clips[k], settings[k])));
  const sessions = await Promise.all(settings.map((options) => open(t, options)));
  for (let k = 0; k < SMALL.frames; k += 1)
    await Promise.all(sessions.map((session, which) => session.push(clips[which][k])));
  const results = await Promise.all(sessions.map((session) => session.run()));
  assert.deepEqual(results.map(fingerprint), expected);
});

test('a session that refuses a frame or an option stays usable, and so do the others', async (t) => {
  const frames = await framesOf();
  const [first, second] = [await open(t), await open(t)];
  for (const [k, frame] of frames.entries()) {
    await first.push(frame);
    await second.push(frame);
    if (k === 3) await rejects(first.push(plain(8, 8)), 'frame-size-changed');
    if (k === 4) await rejects(first.push(new Uint8Array(9)), 'decode');
    if (k === 5) await rejects(createSession({ clip: { maxSide: -1 } }), 'param');
  }
  const expected = await printOf();
  assert.deepEqual([fingerprint(await first.run()), fingerprint(await second.run())], [expected, expected]);
});

test('an internal error ends its own session alone, also while another runs', async (t) => {
  const frames = await framesOf();
  const hurt = await ready(t, { wasm: await trappingWasm() }, frames);
  const [bystander, idle] = [await ready(t, {}, frames), await ready(t, {}, frames)];
  const running = bystander.run();
  await rejects(hurt.run(), 'poisoned', /internal error: .*unreachable.*Create a new session/);
  await rejects(hurt.run(), 'poisoned');
  await rejects(hurt.push(frames[0]), 'poisoned');
  const expected = await printOf();
  assert.deepEqual([fingerprint(await running), fingerprint(await idle.run())], [expected, expected]);
  hurt.close();
});

test('close, free and the end of a using block are the same, and may come twice', async () => {
  for (const way of ['close', 'free', Symbol.dispose ?? 'free']) {
    const session = await createSession();
    session[way]();
    session[way]();
    await rejects(session.push(plain(8, 8)), 'closed', /create a new one/);
    const clip = await synthClip({ width: 32, height: 32, frames: 2 });
    clip[way]();
    clip[way]();
    assert.throws(() => clip.frame(0), { name: 'TraceCutError', code: 'closed' });
  }
});

test('a closed session holds no memory, though it is kept itself, and so with a clip', async (t) => {
  const memories = watchMemories(t);
  const instances = [await createSession(), await createSession(), await synthClip({ frames: 2 })];
  instances[0].close();
  instances[2].close();
  assert.ok(await untilCollected(() => !memories[0].deref() && !memories[2].deref()), 'the closed ones are gone');
  assert.ok(memories[1].deref(), 'the open one is there');
  instances[1].close();
});

test('a result keeps the session that it asks', async () => {
  const resultOfForgotten = async () => {
    const session = await createSession();
    for (const frame of await framesOf(TINY)) await session.push(frame);
    return session.run();
  };
  const result = await resultOfForgotten();
  assert.equal(await untilCollected(() => false), false);
  assert.ok((await result.superpixels(0)).count > 0);
});

test('no instance is in the calling thread, and results are the same', async (t) => {
  const frames = await framesOf();
  const expected = await printOf();
  const memories = watchMemories(t);
  const gaps = monitorEventLoopDelay({ resolution: 5 });
  gaps.enable();
  const session = await ready(t, { worker: true }, frames);
  const stages = new Set();
  const result = await session.run({ onProgress: ({ stage }) => stages.add(stage) });
  gaps.disable();
  t.diagnostic(`longest gap of the event loop: ${(gaps.max / 1e6).toFixed(1)} ms`);
  assert.equal(fingerprint(result), expected);
  assert.ok(stages.has('masks'));
  assert.equal((await result.superpixels(2)).width, SMALL.width);
  assert.ok(!each((await session.merge(0, 1)).objects, 'label').includes(1));
  assert.equal(memories.length, 0);
});

test('videos, trajectories, single pictures and larger masks too', async (t) => {
  const frames = await framesOf();
  const result = await resultOf();
  const plain = await superpixels(frames[0]);
  const { width } = SMALL;
  const small = {
    labels: result.labels(0).filter((_, p) => p % 2 === 0 && Math.floor(p / width) % 2 === 0),
    width: width / 2,
    height: SMALL.height / 2,
  };
  const large = await enlargeMask(small, frames[0]);
  const memories = watchMemories(t);
  assert.deepEqual((await segmentVideo(frames, { worker: true, threads: 2 }).collect()).labels(4), result.labels(4));
  assert.deepEqual((await superpixels(frames[0], { worker: true })).label, plain.label);
  assert.ok((await trajectories(frames, { worker: true })).count > 50);
  assert.deepEqual(await enlargeMask(small, frames[0], { worker: true }), large);
  assert.equal(memories.length, 0);
  await superpixels(frames[0]);
  assert.equal(memories.length, 1, 'an instance in this thread is seen');
});

test('errors come through: options, a trap, a session that is closed', async (t) => {
  await rejects(open(t, { worker: true, flow: { patchStride: -1 } }), 'param', /flow\.patchStride = -1/);
  const session = await ready(t, { worker: true, wasm: await trappingWasm() }, await framesOf(TINY));
  await rejects(session.run(), 'poisoned');
  const workerSession = await ready(t, { worker: true });
  const running = workerSession.run();
  workerSession.close();
  await rejects(running, 'closed');
});

test('sessions that nobody closed keep no process alive, and one at work does', () => {
  const script = `
    import { createSession, synthClip } from 'tracecut';
    const clip = await synthClip(${JSON.stringify(TINY)});
    const ready = async (options) => {
      const session = await createSession(options);
      for (let t = 0; t < clip.numFrames; t += 1) await session.push(clip.frame(t));
      return session;
    };
    await (await ready({ threads: 3 })).run();
    (await ready({ worker: true })).run().then(({ numFrames }) => console.log(numFrames));`;
  assert.equal(runModule(script), `${TINY.frames}\n`);
});
