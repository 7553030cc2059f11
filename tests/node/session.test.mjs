// A session's life: progress, abort and going on, two at once, closing, repeating.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { createSession, parameters, synthClip, version } from 'tracecut';
import { SMALL, STAGES, fingerprint, framesOf, open, ready, rejects, segment, watchMemories } from './support.mjs';

test('a run reports every stage to its end, in numbers that only grow', async (t) => {
  const session = await ready(t);
  const seen = new Map();
  const result = await session.run({
    onProgress({ stage, done, total }) {
      const before = seen.get(stage) ?? { done: 0, total };
      assert.ok(done >= before.done && done <= total, `${stage} went from ${before.done} to ${done} of ${total}`);
      // A move of the cut that gains something asks for more of them.
      assert.ok(
        stage === 'cut' ? total >= before.total : total === before.total,
        `${stage}: ${before.total}, ${total}`,
      );
      seen.set(stage, { done, total });
    },
  });
  assert.deepEqual([...seen.keys()].sort(), [...STAGES].sort());
  for (const [stage, { done, total }] of seen) assert.equal(done, total, stage);
  assert.deepEqual(Object.keys(result.seconds).sort(), [...STAGES].sort());
  assert.ok(Object.values(result.seconds).every((s) => s >= 0 && s < 600));
});

test('the same clip gives the same result twice in a row, to the last bit', async () => {
  const frames = await framesOf();
  assert.equal(fingerprint(await segment(frames)), fingerprint(await segment(frames)));
});

test('a run that was aborted goes on to the same result', async (t) => {
  const fresh = fingerprint(await (await ready(t)).run());
  const session = await ready(t);
  for (const stage of ['flow', 'flow', 'trajectories', 'affinities']) {
    const controller = new AbortController();
    const reason = new Error(`enough of ${stage}`);
    const run = session.run({
      signal: controller.signal,
      onProgress: (progress) => progress.stage === stage && controller.abort(reason),
    });
    await run.then(
      () => {},
      (error) => assert.equal(error, reason),
    );
  }
  assert.equal(fingerprint(await session.run()), fresh);
});

test('an abort between two steps rejects at once with an AbortError', async (t) => {
  const session = await ready(t);
  const controller = new AbortController();
  setTimeout(() => controller.abort(), 0);
  await assert.rejects(session.run({ signal: controller.signal }), { name: 'AbortError' });
  await assert.rejects(session.run({ signal: AbortSignal.abort('late') }), (reason) => reason === 'late');
  assert.equal((await session.run()).numFrames, SMALL.frames);
});

test('a cancelled run, cleared and filled anew, equals a fresh one', async (t) => {
  const frames = await framesOf();
  const session = await ready(t);
  const controller = new AbortController();
  setTimeout(() => controller.abort(), 20);
  await session.run({ signal: controller.signal }).catch(() => {});
  await session.clear();
  assert.equal(session.numFrames, 0);
  for (const frame of frames) await session.push(frame);
  assert.equal(fingerprint(await session.run()), fingerprint(await segment(frames)));
});

test('an error thrown by onProgress ends the run and is what it rejects with', async (t) => {
  const session = await ready(t);
  const mine = new RangeError('mine');
  const onProgress = () => {
    throw mine;
  };
  await assert.rejects(session.run({ onProgress }), mine);
  assert.equal((await session.run()).numFrames, SMALL.frames);
});

test('two sessions at once do not disturb each other', async (t) => {
  const frames = await framesOf();
  const others = await framesOf({ ...SMALL, seed: 9 });
  const alone = [fingerprint(await segment(frames)), fingerprint(await segment(others))];
  const sessions = await Promise.all([createSession(), createSession()]);
  t.after(() => sessions.forEach((session) => session.close()));
  for (let i = 0; i < frames.length; i += 1)
    await Promise.all([sessions[0].push(frames[i]), sessions[1].push(others[i])]);
  const results = await Promise.all(sessions.map((session) => session.run()));
  assert.deepEqual(results.map(fingerprint), alone);
});

test('calls during a run are refused as busy', async (t) => {
  const session = await ready(t);
  const run = session.run();
  const [frame] = await framesOf();
  await rejects(session.run(), 'busy', /run was called while a run is under way/);
  await rejects(session.push(frame), 'busy');
  await rejects(session.flow(0), 'busy');
  await rejects(session.clear(), 'busy');
  await run;
});

test('pushing after a run has begun says what to do instead', async (t) => {
  const session = await ready(t);
  await session.run();
  const [frame] = await framesOf();
  await rejects(session.push(frame), 'state', /clear/);
  await session.clear();
  await session.push(frame);
  assert.equal(session.numFrames, 1);
});

test('a second run without new frames gives the same result again', async (t) => {
  const session = await ready(t);
  assert.equal(fingerprint(await session.run()), fingerprint(await session.run()));
});

test('a closed session refuses every call, and closing twice is fine', async (t) => {
  const session = await ready(t);
  const result = await session.run();
  session.close();
  session.close();
  session[Symbol.dispose]();
  const [frame] = await framesOf();
  await rejects(session.run(), 'closed', /run was called on a closed session/);
  await rejects(session.push(frame), 'closed');
  await rejects(session.flow(0), 'closed');
  await rejects(session.clear(), 'closed');
  assert.ok(result.trajectories.count > 0 && result.toTracksDat().length > 0, 'results outlive their session');
});

test('closing during a run rejects the run', async (t) => {
  const session = await ready(t);
  const run = session.run();
  setTimeout(() => session.close(), 0);
  await rejects(run, 'closed');
});

test('wrong arguments of run are named', async (t) => {
  const session = await ready(t);
  await rejects(session.run({ onProgress: 3 }), 'param', /onProgress = 3/);
  await rejects(session.run({ signal: 'stop' }), 'param', /signal = "stop" \(expected an AbortSignal\)/);
});

test('the forward flow of a pair has the working size and follows the scene', async (t) => {
  const clip = await synthClip({ width: 200, height: 120, frames: 2, seed: 4 });
  const session = await createSession();
  t.after(() => session.close());
  await session.push(clip.frame(0));
  await session.push(clip.frame(1));
  await session.run();
  const [flow, truth] = [await session.flow(0), clip.flow(0)];
  assert.deepEqual([flow.width, flow.height], [200, 120]);
  const errors = flow.u.map((u, p) => Math.hypot(u - truth.u[p], flow.v[p] - truth.v[p])).sort();
  assert.ok(errors[errors.length >> 1] < 0.3, `median end-point error ${errors[errors.length >> 1]} px`);
});

test('a large frame is processed at maxSide and its results are in input pixels', async () => {
  const frames = await framesOf({ width: 256, height: 144, frames: 4, seed: 3 });
  const result = await segment(frames, { clip: { maxSide: 128 } });
  assert.deepEqual([result.width, result.height], [256, 144]);
  assert.ok(Math.max(...result.trajectories.x) > 140, `largest x ${Math.max(...result.trajectories.x)}`);
});

test('the track file lists every trajectory with its label, points and frames', async () => {
  const result = await segment(await framesOf());
  const lines = result.toTracksDat().trimEnd().split('\n');
  const { count, startFrame, offset, x, y } = result.trajectories;
  assert.deepEqual(lines.slice(0, 2), [`${SMALL.frames}`, `${count}`]);
  let line = 2;
  for (let i = 0; i < count; i += 1) {
    const length = offset[i + 1] - offset[i];
    assert.equal(lines[line], `${result.clusters.label[i]} ${length}`);
    for (let p = 0; p < length; p += 1) {
      const [px, py, frame] = lines[line + 1 + p].split(' ').map(Number);
      assert.ok(Math.abs(px - x[offset[i] + p]) <= 0.0006 && Math.abs(py - y[offset[i] + p]) <= 0.0006);
      assert.equal(frame, startFrame[i] + p);
    }
    line += 1 + length;
  }
  assert.equal(line, lines.length);
});

test('the edges of a frame join trajectories that are alive in it', async () => {
  const result = await segment(await framesOf());
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
  const frames = await framesOf();
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
  const frames = await framesOf();
  assert.equal(fingerprint(await segment(frames, options)), fingerprint(await segment(frames)));
});
