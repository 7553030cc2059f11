// The same random sessions natively, in wasm, and on many threads; by night more of them, natively also with newer vector
// instructions. `TRACECUT_DIFFER=FIRST..LAST` takes others than the usual seeds.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { root } from '../../scripts/tools.mjs';
import { assertSameOutcomes, recorded } from '../differ.mjs';

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
