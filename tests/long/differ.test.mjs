// A night's random sessions by several builds: native with the oldest and with newer vector instructions, and wasm, on one
// thread and on three. `TRACECUT_DIFFER=FIRST..LAST` takes others than the usual seeds.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { root } from '../../scripts/tools.mjs';
import { alike, recorded } from '../differ.mjs';

const [first, last] = (process.env.TRACECUT_DIFFER ?? '1000..2000').split('..').map(Number);

test('random sessions are the same natively and in wasm, on one thread and on three', (t) =>
  alike(t, recorded(t, first, last)));

test('random sessions are the same with newer vector instructions', { skip: process.arch !== 'x64' }, (t) => {
  const env = { RUSTFLAGS: '-C target-cpu=x86-64-v3', CARGO_TARGET_DIR: join(root, 'target', 'x86-64-v3') };
  const [usual, newer] = [recorded(t, first, last), recorded(t, first, last, env)];
  for (const [k, { seed, outcome }] of usual.entries()) assert.deepEqual(newer[k].outcome, outcome, `seed ${seed}`);
});
