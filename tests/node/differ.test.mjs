// The same random sessions natively, in wasm, and on many threads. `TRACECUT_DIFFER=FIRST..LAST` takes others than the
// usual seeds.

import { test } from 'node:test';
import { alike, recorded } from '../differ.mjs';

const [first, last] = (process.env.TRACECUT_DIFFER ?? '0..20').split('..').map(Number);

test('random sessions are the same natively and in wasm, on one thread and on three', (t) =>
  alike(t, recorded(t, first, last)));
