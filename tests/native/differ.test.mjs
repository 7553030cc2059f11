// Random sessions are the same natively, in wasm, and on many threads: the native build records inputs and results, others
// repeat them. By night more of them, natively also with newer vector instructions. `TRACECUT_DIFFER=FIRST..LAST` takes
// others than the usual seeds.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { createSession } from 'tracecut';
import { nativeArguments } from '../../scripts/native.mjs';
import { root } from '../../scripts/tools.mjs';
import { fnv1a } from '../fingerprint.mjs';

const { TRACECUT_DIFFER, TRACECUT_LONG } = process.env;
const [first, last] = (TRACECUT_DIFFER ?? (TRACECUT_LONG ? '1000..2000' : '0..20')).split('..').map(Number);

test('random sessions are the same natively and in wasm, on one thread and on three', (t) =>
  assertSameOutcomes(t, recorded(t, first, last)));

const skip = TRACECUT_LONG && process.arch === 'x64' ? false : 'npm run test:long runs it, on x86-64';

test('random sessions are the same with newer vector instructions', { skip }, (t) => {
  const env = { RUSTFLAGS: '-C target-cpu=x86-64-v3', CARGO_TARGET_DIR: join(root, 'target', 'x86-64-v3') };
  const [usual, newer] = [recorded(t, first, last), recorded(t, first, last, env)];
  for (const [k, { seed, outcome }] of usual.entries()) assert.deepEqual(newer[k].outcome, outcome, `seed ${seed}`);
});

/**
 * The sessions of seeds `first` up to `last`, as the native build has them.
 * @param {import('node:test').TestContext} t
 * @param {Record<string, string>} [env] for a build of another kind
 */
function recorded(t, first, last, env = {}) {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-differ-'));
  t.after(() => rmSync(folder, { recursive: true }));
  const test = ['--ignored', '--exact', 'random::sessions_are_recorded'];
  const result = spawnSync('cargo', nativeArguments('test', '--quiet', '--test', 'integration', '--', ...test), {
    cwd: root,
    encoding: 'utf8',
    env: { ...process.env, ...env, TRACECUT_SESSIONS: folder, TRACECUT_SEEDS: `${first}..${last}` },
  });
  if (result.status !== 0) throw new Error(`${result.stdout}\n${result.stderr}`);
  const names = readdirSync(folder).filter((name) => name.endsWith('.json'));
  if (names.length !== last - first) throw new Error(`${names.length} sessions were written down`);
  return names
    .map((name) => Number.parseInt(name, 10))
    .sort((a, b) => a - b)
    .map((seed) => ({
      seed,
      ...JSON.parse(readFileSync(join(folder, `${seed}.json`), 'utf8')),
      rgba: new Uint8ClampedArray(readFileSync(join(folder, `${seed}.rgba`))),
    }));
}

/** Runs such a session in the package; returns hashes, or the code of the error. */
async function outcomeOf({ params, width, height, frames, rgba }, options = {}) {
  const session = await createSession({ ...params, ...options });
  try {
    const size = 4 * width * height;
    for (let t = 0; t < frames; t += 1)
      await session.push({ data: rgba.slice(t * size, (t + 1) * size), width, height });
    return await hashes(await session.run(), params.clip.dense);
  } catch (error) {
    return { error: error.code };
  } finally {
    session.close();
  }
}

/** `dense` is false where no masks are made. */
async function hashes(result, dense) {
  const hash = (...arrays) =>
    fnv1a(Buffer.concat(arrays.map((a) => Buffer.from(a.buffer, a.byteOffset, a.byteLength))));
  const frames = Array.from({ length: dense ? result.numFrames : 0 }, (_, t) => t);
  const { x, y } = result.trajectories;
  return {
    tracks: hash(x, y),
    labels: hash(result.clusters.label),
    superpixels: await Promise.all(frames.map(async (t) => hash((await result.superpixels(t)).label))),
    masks: frames.map((t) => fnv1a(result.labels(t))),
  };
}

/**
 * Repeats sessions in the package, on one thread and some on three. Tracks and superpixels must equal the native build's,
 * and masks where the labels do. Labels come from the embedding, which may differ in its last digits:
 * where a clip is noise or a parameter at its end, one digit may decide, in one session of twenty at most.
 */
async function assertSameOutcomes(t, sessions, options = {}) {
  let [withMasks, different] = [0, 0];
  for (const session of sessions) {
    const { seed, outcome } = session;
    const repeated = await outcomeOf(session, { ...options, threads: 1 });
    if (repeated.labels !== outcome.labels) different += 1;
    const expected =
      repeated.labels === outcome.labels ? outcome : { ...outcome, labels: repeated.labels, masks: repeated.masks };
    assert.deepEqual(repeated, expected, `seed ${seed}`);
    if (seed % 10 < 3)
      assert.deepEqual(await outcomeOf(session, { ...options, threads: 3 }), repeated, `${seed}, 3 threads`);
    withMasks += outcome.masks?.length > 1;
  }
  t.diagnostic(`${sessions.length} sessions, ${withMasks} with masks, ${different} with labels of their own in wasm`);
  assert.ok(withMasks > sessions.length / 4, `${withMasks} sessions with masks`);
  assert.ok(different <= sessions.length / 20, `${different} sessions with labels of their own in wasm`);
}
