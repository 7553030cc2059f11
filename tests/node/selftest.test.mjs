// The self test: hashes of a fixed program, the same in Node, in browsers (tests/engines) and natively
// (cli/tests/cli.rs). A change of results that is meant is taken over with `REGENERATE=1 npm test -- node`,
// which rewrites the file of expected hashes and fails so that nobody forgets to look.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import * as tracecut from 'tracecut';
import { selftest } from 'tracecut/selftest';
import { root } from '../../scripts/tools.mjs';

const file = join(root, 'cli', 'src', 'selftest', 'expected.json');
const expected = JSON.parse(readFileSync(file, 'utf8'));

const program = (args, options = []) =>
  spawnSync(process.execPath, [...options, join(root, 'dist', 'node', 'program.js'), ...args], { encoding: 'utf8' });

test('every hash is the expected one, in this thread and by helpers', async () => {
  const told = [];
  const found = await selftest({ onCheck: (check) => told.push(check.name), threads: 2 });
  const hashes = Object.fromEntries(found.checks.map(({ name, hash }) => [name, hash]));
  if (process.env.REGENERATE) {
    writeFileSync(file, `${JSON.stringify({ version: tracecut.version, hashes }, null, 2)}\n`);
    assert.fail(`${file} is written anew: look at what changed, and build again`);
  }
  assert.deepEqual(hashes, expected.hashes);
  assert.equal(expected.version, tracecut.version);
  assert.equal(found.same, true);
  assert.deepEqual(told, Object.keys(expected.hashes));
  assert.ok(told.length >= 15, `${told.length} hashes`);
});

test('the program of the package prints them, and fails where one differs', () => {
  const good = program(['selftest']);
  assert.equal(good.status, 0, good.stderr);
  const lines = good.stdout.matchAll(/^([a-z-]+) +([0-9a-f]{16}) {2}same {2}\(/gm);
  assert.deepEqual(Object.fromEntries([...lines].map(([, name, hash]) => [name, hash])), expected.hashes);
  // An engine that rounds otherwise.
  const bad = program(['selftest'], ['--import', 'data:text/javascript,Math.round=Math.floor']);
  assert.equal(bad.status, 1, bad.stdout);
  assert.match(bad.stdout, /^discontinuities +[0-9a-f]{16} {2}DIFFERENT from [0-9a-f]{16} {2}/m);
  assert.match(bad.stderr, /^error: \d+ of 19 hashes differ: please report/);
});

test('the program says what it has, and which version it is', () => {
  assert.equal(program(['--version']).stdout, `${tracecut.version}\n`);
  assert.match(program([]).stdout, /tracecut selftest .*\n[^]*cargo install --locked tracecut-cli/);
  const unknown = program(['segment', 'clip.mp4']);
  assert.equal(unknown.status, 2);
  assert.match(unknown.stderr, /^error: there is no command "segment clip.mp4"/);
});

test('a wrong option is refused, an abort heeded', async () => {
  await assert.rejects(
    selftest({ thread: 2 }),
    /thread = 2 \(expected a known option, such as threads; the options are onCheck, signal, /,
  );
  await assert.rejects(selftest(7), /options = 7/);
  await assert.rejects(selftest({ threads: 0 }), /threads = 0 \(expected a whole number, 1\.\.=64\)/);
  await assert.rejects(selftest({ signal: AbortSignal.abort() }), { name: 'AbortError' });
});
