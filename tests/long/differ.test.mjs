// A night's random sessions by several builds: native with the oldest and with newer vector instructions, wasm with and
// without them, on one thread and on three. `TRACECUT_DIFFER=FIRST..LAST` takes others than the usual seeds.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { environment, root } from '../../scripts/tools.mjs';
import { alike, outcomeOf, recorded } from '../differ.mjs';

const [first, last] = (process.env.TRACECUT_DIFFER ?? '1000..2000').split('..').map(Number);

test('random sessions are the same natively and in wasm, on one thread and on three', (t) =>
  alike(t, recorded(t, first, last)));

test('random sessions are the same with newer vector instructions', { skip: process.arch !== 'x64' }, (t) => {
  const env = { RUSTFLAGS: '-C target-cpu=x86-64-v3', CARGO_TARGET_DIR: join(root, 'target', 'x86-64-v3') };
  const [usual, newer] = [recorded(t, first, last), recorded(t, first, last, env)];
  for (const [k, { seed, outcome }] of usual.entries()) assert.deepEqual(newer[k].outcome, outcome, `seed ${seed}`);
});

test('random sessions are the same in wasm without vector instructions', async (t) => {
  const wasm = scalarWasm();
  for (const session of recorded(t, first, last)) {
    const usual = await outcomeOf(session, { threads: 1 });
    assert.deepEqual(await outcomeOf(session, { wasm, threads: 1 }), usual, `seed ${session.seed}`);
  }
});

/** The package's wasm file compiled anew, with numbers one by one. */
function scalarWasm() {
  const [target, folder] = ['wasm32-unknown-unknown', join(root, 'target', 'scalar')];
  const args = [
    'build',
    '--lib',
    '--features',
    'wasm',
    '--profile',
    'wasm',
    '--target',
    target,
    '--target-dir',
    folder,
  ];
  // In place of those of .cargo/config.toml.
  execute('cargo', args, { RUSTFLAGS: '-C target-feature=-simd128' });
  const compiled = join(folder, target, 'wasm', 'tracecut.wasm');
  const tells = (file) => readFileSync(file).includes('simd128');
  assert.ok(!tells(compiled) && tells(join(root, 'target', target, 'wasm', 'tracecut.wasm')), 'features in the file');
  const out = join(folder, 'glue');
  mkdirSync(out, { recursive: true });
  execute('bindgen', [compiled, out, 'tracecut']);
  return readFileSync(join(out, 'tracecut_bg.wasm'));
}

function execute(command, args, env) {
  const result = spawnSync(command, args, { cwd: root, encoding: 'utf8', env: environment(env) });
  assert.equal(result.status, 0, result.stderr ?? String(result.error));
}
