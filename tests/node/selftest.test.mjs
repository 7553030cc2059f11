// The self test: hashes of a fixed program, the same in Node, in browsers (tests/engines) and natively
// (cli/tests/cli.rs). `REGENERATE=1 npm test -- node` rewrites the file of expected hashes after an intended
// change of results, and fails so that the change is reviewed.

import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import * as tracecut from 'tracecut';
import { selftest } from 'tracecut/selftest';
import { root } from '../../scripts/tools.mjs';

const file = join(root, 'cli', 'src', 'selftest', 'expected.json');
const expected = JSON.parse(readFileSync(file, 'utf8'));

test('computes every expected hash with two threads', async () => {
  const names = [];
  const result = await selftest({ onCheck: (check) => names.push(check.name), threads: 2 });
  const hashes = Object.fromEntries(result.checks.map(({ name, hash }) => [name, hash]));
  if (process.env.REGENERATE) {
    writeFileSync(file, `${JSON.stringify({ version: tracecut.version, hashes }, null, 2)}\n`);
    assert.fail(`${file} has the new hashes: review them and build again`);
  }
  assert.deepEqual(hashes, expected.hashes);
  assert.equal(expected.version, tracecut.version);
  assert.equal(result.same, true);
  assert.deepEqual(names, Object.keys(expected.hashes));
  assert.ok(names.length >= 15, `${names.length} hashes`);
});

test('reports an engine that rounds numbers differently', async (t) => {
  t.mock.method(Math, 'round', Math.floor);
  const { same, checks } = await selftest();
  assert.equal(same, false);
  assert.ok(checks.some((check) => check.name === 'discontinuities' && !check.same && check.hash !== check.expected));
});

test('rejects wrong options and stops when aborted', async () => {
  await assert.rejects(
    selftest({ thread: 2 }),
    /thread = 2 \(expected a known option, such as threads; the options are onCheck, signal, /,
  );
  await assert.rejects(selftest(7), /options = 7/);
  await assert.rejects(selftest({ threads: 0 }), /threads = 0 \(expected a whole number, 1\.\.=64\)/);
  await assert.rejects(selftest({ signal: AbortSignal.abort() }), { name: 'AbortError' });
});
