// Several sessions of one thread: what they have of each other (nothing), and how each ends.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { createSession, synthClip } from 'tracecut';
import {
  fingerprint,
  framesOf,
  open,
  plain,
  ready,
  rejects,
  segment,
  trappingWasm,
  untilCollected,
  watchMemories,
} from './support.mjs';

test('two sessions with different parameters, in turn, give what each gives alone', async (t) => {
  const frames = await framesOf();
  const settings = [{ trajectory: { gridStep: 5 } }, { clip: { maxSide: 96 }, refine: { band: 0 } }];
  const alone = [];
  for (const options of settings) alone.push(fingerprint(await segment(frames, options)));
  assert.notEqual(alone[0], alone[1]);

  const sessions = await Promise.all(settings.map((options) => open(t, options)));
  for (const frame of frames) for (const session of sessions) await session.push(frame);
  const results = await Promise.all(sessions.map((session) => session.run()));
  assert.deepEqual(results.map(fingerprint), alone);
});

test('a session that refuses a frame or an option goes on, and so do the others', async (t) => {
  const frames = await framesOf();
  const [first, second] = [await open(t), await open(t)];
  for (const [k, frame] of frames.entries()) {
    await first.push(frame);
    await second.push(frame);
    if (k === 3) await rejects(first.push(plain(8, 8)), 'frame-size-changed');
    if (k === 4) await rejects(first.push(new Uint8Array(9)), 'decode');
    if (k === 5) await rejects(createSession({ clip: { maxSide: -1 } }), 'param');
  }
  const expected = fingerprint(await segment(frames));
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
  const expected = fingerprint(await segment(frames));
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
  const kept = [await createSession(), await createSession(), await synthClip({ frames: 2 })];
  kept[0].close();
  kept[2].close();
  assert.ok(await untilCollected(() => !memories[0].deref() && !memories[2].deref()), 'the closed ones are gone');
  assert.ok(memories[1].deref(), 'the open one is there');
  kept[1].close();
});

test('a result keeps the session that it asks', async () => {
  const frames = await framesOf();
  const resultOf = async () => {
    const session = await createSession();
    for (const frame of frames) await session.push(frame);
    return session.run();
  };
  const result = await resultOf();
  assert.equal(await untilCollected(() => false), false);
  assert.ok((await result.superpixels(0)).count > 0);
});
