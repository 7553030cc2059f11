// deploy/shard.sh: a list of clips in shares, with a stand-in for the command that says what it was called with.

import assert from 'node:assert/strict';
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import {
  chmodSync,
  existsSync,
  mkdirSync,
  mkdtempSync,
  readFileSync,
  readdirSync,
  rmSync,
  writeFileSync,
} from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { root } from '../../scripts/tools.mjs';

const script = join(root, 'deploy', 'shard.sh');

/** Clips with "bad" in their names cannot be read, "weak" ones fail once, "slow" ones last until they are ended. */
const STAND_IN = `#!/usr/bin/env bash
echo "$@" >>"$CALLS"
[ "$1" = segment ] && [ "$3" = --out ] && [ "$5" = --resume ] || exit 2
case $2 in
  *bad*) echo 'no clip' >&2; exit 3 ;;
  *weak*) [ -e "$CALLS.weak" ] || { touch "$CALLS.weak"; exit 4; } ;;
  *slow*) if [ ! -e "$CALLS.slow" ]; then
    trap 'echo ended >>"$CALLS"; exit 143' TERM
    touch "$CALLS.slow"
    while :; do sleep 0.05; done
  fi ;;
esac
mkdir "$4"
`;

function cluster(t, clips) {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-shard-'));
  t.after(() => rmSync(folder, { recursive: true }));
  mkdirSync(join(folder, 'bin'));
  const command = join(folder, 'bin', 'tracecut');
  writeFileSync(command, STAND_IN);
  chmodSync(command, 0o755);
  // Without an end of line after the last.
  writeFileSync(join(folder, 'list.txt'), clips.join('\n'));
  const [calls, out] = [join(folder, 'calls'), join(folder, 'out')];
  const { SHARD: _, SHARDS: __, ...others } = process.env;
  const envOf = (own) => ({ ...others, PATH: `${join(folder, 'bin')}:${process.env.PATH}`, CALLS: calls, ...own });
  const args = [script, join(folder, 'list.txt'), out];
  return {
    calls,
    out,
    run: (own, ...options) => spawnSync('bash', [...args, ...options], { env: envOf(own), encoding: 'utf8' }),
    start: (own) => spawn('bash', args, { env: envOf(own), stdio: 'ignore' }),
    called: () => (existsSync(calls) ? readFileSync(calls, 'utf8').trim().split('\n') : []),
    there: () => readdirSync(out).sort(),
  };
}

test('each clip of a list is done once by some share, however many there are', (t) => {
  const clips = ['/a/one.mp4', '/b/one.mp4', 'two words.mp4', '', 'four', 'five.tar.y4m'];
  const done = ['000000-one', '000001-one', '000002-two words', '000004-four', '000005-five.tar'];
  for (const shards of [1, 2, 3, 7]) {
    const { run, called, there } = cluster(t, clips);
    for (let shard = 0; shard < shards; shard += 1) {
      const { status, stderr } = run({ SHARD: String(shard), SHARDS: String(shards) }, '--format', 'rle');
      assert.equal(status, 0, stderr);
    }
    assert.deepEqual(there(), done);
    assert.equal(called().length, 5);
    assert.ok(called().every((line) => line.endsWith('--resume --quiet --format rle')));
  }
});

test('arrays of Slurm and indexed Jobs name their share', (t) => {
  const { run, called, there } = cluster(t, ['0', '1', '2', '3']);
  const slurm = { SLURM_ARRAY_TASK_ID: '6', SLURM_ARRAY_TASK_MIN: '5', SLURM_ARRAY_TASK_COUNT: '4' };
  assert.equal(run(slurm).status, 0);
  assert.deepEqual(there(), ['000001-1']);
  assert.equal(run({ JOB_COMPLETION_INDEX: '3', SHARDS: '4' }).status, 0);
  assert.deepEqual(there(), ['000001-1', '000003-3']);
  assert.equal(called().length, 2);
});

test('what is no clip is written down and tried no more; what failed otherwise is tried again', (t) => {
  const { run, called, there, out } = cluster(t, ['bad.mp4', 'weak.mp4', 'good.mp4']);
  const env = { SHARD: '0', SHARDS: '1' };
  const first = run(env);
  assert.equal(first.status, 1);
  assert.match(first.stderr, /weak\.mp4: exit code 4/);
  assert.deepEqual(there(), ['000000-bad.failed', '000001-weak.log', '000002-good']);
  assert.equal(readFileSync(join(out, '000000-bad.failed'), 'utf8'), 'no clip\n');
  assert.equal(run(env).status, 0);
  assert.deepEqual(there(), ['000000-bad.failed', '000001-weak', '000002-good']);
  assert.equal(run(env).status, 0);
  assert.equal(called().length, 4);
});

test('a signal ends the command and the share, and a second run goes on', async (t) => {
  const { run, start, called, calls, there } = cluster(t, ['good.mp4', 'slow.mp4', 'last.mp4']);
  const share = start({ SHARD: '0', SHARDS: '1' });
  const exited = new Promise((resolve) => share.once('exit', resolve));
  while (!existsSync(`${calls}.slow`)) await new Promise((resolve) => setTimeout(resolve, 20));
  share.kill('SIGTERM');
  assert.equal(await exited, 143);
  assert.equal(called().at(-1), 'ended');
  assert.ok(!there().includes('000002-last'));
  assert.equal(run({ SHARD: '0', SHARDS: '1' }).status, 0);
  assert.deepEqual(there(), ['000000-good', '000001-slow', '000002-last']);
});

test('wrong use is told and nothing is begun', (t) => {
  const { run, called, out } = cluster(t, ['one.mp4']);
  const faults = {
    "SHARD = ''": {},
    "SHARDS = ''": { SHARD: '0' },
    'SHARD = 2 (expected 0 to 1, as SHARDS = 2)': { SHARD: '2', SHARDS: '2' },
    "SHARD = '-1'": { SHARD: '-1', SHARDS: '2' },
  };
  for (const [words, env] of Object.entries(faults)) {
    const { status, stderr } = run(env);
    assert.equal(status, 2, words);
    assert.ok(stderr.includes(words), stderr);
  }
  assert.deepEqual(called(), []);
  assert.ok(!existsSync(out));
});

const hasShellcheck = spawnSync('shellcheck', ['--version']).status === 0;

test('shellcheck has nothing to say', { skip: !hasShellcheck && 'there is no shellcheck' }, () => {
  execFileSync('shellcheck', [script, join(root, 'deploy', 'slurm.sbatch')], { stdio: 'inherit' });
});
