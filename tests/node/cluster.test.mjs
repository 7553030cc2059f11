// The scripts in `deploy`, run as a machine of a cluster does: with nothing in the environment but PATH and the share.
// Tests of the script alone have a stand-in for the command that writes down its calls; the others run the command itself.

import assert from 'node:assert/strict';
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import {
  chmodSync,
  copyFileSync,
  existsSync,
  mkdirSync,
  mkdtempSync,
  readFileSync,
  readdirSync,
  rmSync,
  statSync,
  symlinkSync,
  utimesSync,
  writeFileSync,
} from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { root } from '../../scripts/tools.mjs';
import { hasFfmpeg } from '../intake/clips.mjs';
import { commandLine } from '../programs.mjs';

const shardScript = join(root, 'deploy', 'shard.sh');
const slurmScript = join(root, 'deploy', 'slurm.sbatch');
const ONE_SHARE = { SHARD: '0', SHARDS: '1' };

/** Programs that shard.sh calls, or that the stand-in calls. A machine of the tests has no others. */
const SYSTEM_TOOLS = ['bash', 'cat', 'dirname', 'grep', 'mkdir', 'mv', 'rm', 'sleep', 'touch'];

/**
 * Stands in for `tracecut`. The clip's name says how it ends: "bad" cannot be read, "cut" leaves results that end early,
 * "weak" fails the first time, "begun" lies there by other options, "slow" lasts until a signal the first time.
 */
const STAND_IN = `#!/usr/bin/env bash
calls=$(dirname "$0")/../calls
echo "$@" >>"$calls"
[ "$1" = segment ] && [ "$3" = --out ] && [ "$5" = --resume ] || exit 2
case " $* " in *' --wrong '*) echo 'error: unexpected argument' >&2; exit 2 ;; esac
case $2 in
  *bad*) echo 'error: is not a video' >&2; exit 3 ;;
  *cut*) mkdir -p "$4"; echo '{"truncated": {}}' >"$4/result.json"; echo 'error: damaged at frame 9' >&2; exit 3 ;;
  *weak*) [ -e "$calls.weak" ] || { touch "$calls.weak"; exit 4; } ;;
  *begun*) mkdir -p "$4.partial"; echo 'error: was made with other options' >&2; exit 2 ;;
  *slow*) if [ ! -e "$calls.slow" ]; then
    trap 'echo ended >>"$calls"; exit 143' TERM
    touch "$calls.slow"
    while :; do sleep 0.05; done
  fi ;;
esac
mkdir -p "$4"
`;

const pathOf = (name) => execFileSync('bash', ['-c', `command -v ${name}`], { encoding: 'utf8' }).trim();

/** Makes a machine with a list of clips and a folder `bin` of all the programs that it has. */
function machine(t, clips, tools = {}) {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-shard-'));
  t.after(() => rmSync(folder, { recursive: true }));
  const [bin, list, out, calls] = ['bin', 'list.txt', 'out', 'calls'].map((name) => join(folder, name));
  mkdirSync(bin);
  for (const name of SYSTEM_TOOLS) symlinkSync(pathOf(name), join(bin, name));
  for (const [name, path] of Object.entries(tools)) symlinkSync(path, join(bin, name));
  // Without an end of line after the last.
  writeFileSync(list, clips.join('\n'));
  const options = (env) => ({ cwd: folder, env: { PATH: bin, ...env }, encoding: 'utf8' });
  const bash = pathOf('bash');
  return {
    folder,
    bin,
    list,
    out,
    calls,
    run: (env, ...words) => spawnSync(bash, [shardScript, list, out, ...words], options(env)),
    slurm: (env, ...words) => spawnSync(bash, [slurmScript, list, out, ...words], options(env)),
    start: (env, ...words) =>
      spawn(bash, [shardScript, list, out, ...words], { ...options(env), stdio: 'ignore', detached: true }),
    startSlurm: (env, ...words) =>
      spawn(bash, [slurmScript, list, out, ...words], { ...options(env), stdio: 'ignore', detached: true }),
    there: () => readdirSync(out).sort(),
    read: (name) => readFileSync(join(out, name), 'utf8'),
  };
}

function withStandIn(t, clips) {
  const made = machine(t, clips);
  const command = join(made.bin, 'tracecut');
  writeFileSync(command, STAND_IN);
  chmodSync(command, 0o755);
  const called = () => (existsSync(made.calls) ? readFileSync(made.calls, 'utf8').trim().split('\n') : []);
  /** The clips that were asked for since the last look. */
  const asked = () => {
    const clipsAsked = called().map((line) => line.split(' ')[1]);
    rmSync(made.calls, { force: true });
    return clipsAsked.filter(Boolean);
  };
  return { ...made, called, asked };
}

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

async function waitFor(file, process) {
  while (!existsSync(file)) {
    assert.equal(process.exitCode, null, `ended before ${file} was there`);
    await pause(10);
  }
}

function assertCode({ status, stderr, stdout }, code) {
  assert.equal(status, code, stderr + stdout);
}

test('each clip of a list is done once by some share, however many there are', (t) => {
  const clips = ['/a/one.mp4', '/b/one.mp4', 'two words.mp4', '', 'four', 'five.tar.y4m', 'six/'];
  const done = ['000000-one', '000001-one', '000002-two words', '000004-four', '000005-five.tar', '000006-six'];
  for (const shards of [1, 2, 3, 9]) {
    const { run, called, there } = withStandIn(t, clips);
    for (let shard = 0; shard < shards; shard += 1) {
      assertCode(run({ SHARD: String(shard), SHARDS: String(shards) }, '--format', 'rle'), 0);
    }
    assert.deepEqual(there(), done);
    assert.equal(called().length, 6);
    assert.ok(called().every((line) => line.endsWith('--resume --quiet --format rle')));
  }
});

test('a list may have comments, the line ends of Windows, and names that begin with a dash', (t) => {
  const clips = ['\uFEFFone.mp4', '# a comment', '-.mp4', 'three.mp4', '  ', '--quiet', ''];
  const { run, asked, there, list } = withStandIn(t, []);
  writeFileSync(list, clips.join('\r\n'));
  const { stdout, ...ended } = run(ONE_SHARE);
  assertCode({ stdout, ...ended }, 0);
  assert.match(stdout, /share 0 of 1: 4 done, 0 truncated, 0 cannot be read, 0 failed/);
  assert.deepEqual(asked(), ['one.mp4', './-.mp4', 'three.mp4', './--quiet']);
  assert.deepEqual(there(), ['000000-one', '000002--', '000003-three', '000005---quiet']);
});

test('a task of a Slurm array does the share of its number, whichever tasks run with it', (t) => {
  const { slurm, called, there } = withStandIn(t, ['0', '1', '2', '3', '4', '5', '6', '7']);
  // As `sbatch --array=3,1` has them. The number of shares stays.
  const array = { SLURM_ARRAY_TASK_MIN: '1', SLURM_ARRAY_TASK_MAX: '3', SLURM_ARRAY_TASK_COUNT: '2' };
  const env = { ...array, SLURM_SUBMIT_DIR: root, SLURM_CPUS_PER_TASK: '2' };
  // A share that the user tried in a shell does not count.
  assertCode(slurm({ ...env, SLURM_ARRAY_TASK_ID: '3', SHARDS: '4', SHARD: '0' }), 0);
  assert.deepEqual(there(), ['000003-3', '000007-7']);
  assertCode(slurm({ ...env, SLURM_ARRAY_TASK_ID: '1' }), 0);
  assert.deepEqual(there(), ['000001-1', '000003-3', '000007-7']);
  assert.ok(called().every((line) => line.endsWith('--threads 2')));
  const outside = slurm({ ...env, SLURM_ARRAY_TASK_ID: '100' });
  assertCode(outside, 2);
  assert.match(outside.stderr, /SHARD = 100 \(expected 0 to 99, as SHARDS = 100\)/);
  assert.match(readFileSync(slurmScript, 'utf8'), /^#SBATCH --array=0-99$/m);
});

const slurmTask = { SLURM_ARRAY_JOB_ID: '77', SLURM_ARRAY_TASK_ID: '0', SHARDS: '1', SLURM_SUBMIT_DIR: root };
for (const [fault, signal, env, isRequeued] of [
  ['reaches its time limit goes back into the queue, and goes on there', 'SIGUSR1', {}, true],
  ['was requeued often enough ends', 'SIGUSR1', { SLURM_RESTART_COUNT: '3', REQUEUES: '3' }, false],
  ['is cancelled ends', 'SIGTERM', {}, false],
])
  test(`a Slurm task that ${fault}`, async (t) => {
    const { startSlurm, slurm, bin, calls, called, there } = withStandIn(t, ['good.mp4', 'slow.mp4']);
    writeFileSync(join(bin, 'scontrol'), `#!/usr/bin/env bash\necho "$@" >>"${calls}.queue"\n`, { mode: 0o755 });
    const task = startSlurm({ ...slurmTask, ...env });
    const exited = new Promise((resolve) => task.once('exit', resolve));
    await waitFor(`${calls}.slow`, task);
    task.kill(signal);
    assert.equal(await exited, 143);
    assert.equal(called().at(-1), 'ended');
    const queued = existsSync(`${calls}.queue`) ? readFileSync(`${calls}.queue`, 'utf8') : '';
    assert.equal(queued, isRequeued ? 'requeue 77_0\n' : '');
    assertCode(slurm({ ...slurmTask, SLURM_RESTART_COUNT: '1' }), 0);
    assert.deepEqual(there(), ['000000-good', '000001-slow']);
    assert.match(readFileSync(slurmScript, 'utf8'), /^#SBATCH --signal=B:USR1@60$/m);
  });

test('a Job of Kubernetes has as many shares as completions, and only wrong use ends it at once', (t) => {
  const { run, there } = withStandIn(t, ['0', '1', '2', '3']);
  assertCode(run({ JOB_COMPLETION_INDEX: '3', SHARDS: '4' }), 0);
  assert.deepEqual(there(), ['000003-3']);
  const job = readFileSync(join(root, 'deploy', 'kubernetes.yaml'), 'utf8');
  const completions = /completions: (\d+)/.exec(job)[1];
  assert.ok(job.includes(`- name: SHARDS\n              value: '${completions}'`));
  assert.match(job, /action: FailJob\s+onExitCodes:\s+containerName: tracecut\s+operator: In\s+values: \[2\]/);
  // A signal from outside is no fault of the share.
  assert.match(job, /action: Ignore\s+onExitCodes:\s+containerName: tracecut\s+operator: In\s+values: \[130, 143\]/);
  assert.match(job, /workingDir: \/clips/);
});

test('the image is built with its own compiler, which is new enough, from files that are there', () => {
  const containerfile = readFileSync(join(root, 'deploy', 'Containerfile'), 'utf8');
  const ignored = readFileSync(join(root, '.dockerignore'), 'utf8').split('\n');
  assert.ok(ignored.includes('rust-toolchain.toml'), 'rustup would download a second compiler');
  const [, image] = /^FROM rust:1\.(\d+)-/m.exec(containerfile);
  const [, needed] = /^rust-version = "1\.(\d+)"/m.exec(readFileSync(join(root, 'cli', 'Cargo.toml'), 'utf8'));
  assert.ok(Number(image) >= Number(needed), `1.${image} (expected 1.${needed} or newer)`);
  for (const [, file] of containerfile.matchAll(/^COPY (?:--chmod=\d+ )?(deploy\/\S+)/gm))
    assert.ok(existsSync(join(root, file)) && !ignored.includes(file), file);
  for (const file of ['Cargo.lock', 'Cargo.toml', 'cli', 'src', 'python', 'bench', 'decoder', 'tests'])
    assert.ok(existsSync(join(root, file)) && !ignored.includes(file), `${file}, which the workspace needs`);
  const version = JSON.parse(readFileSync(join(root, 'package.json'), 'utf8')).version;
  for (const file of ['deploy/Containerfile', 'deploy/kubernetes.yaml', 'docs/cluster.md'])
    assert.ok(readFileSync(join(root, file), 'utf8').includes(`tracecut:${version}`), file);
});

const hasHadolint = spawnSync('hadolint', ['--version']).status === 0;

test('hadolint has nothing to say', { skip: !hasHadolint && 'there is no hadolint' }, () => {
  execFileSync('hadolint', [join(root, 'deploy', 'Containerfile')], { stdio: 'inherit' });
});

test('what cannot be read is noted and not tried again; what failed otherwise is tried again, after the others', (t) => {
  const { run, asked, there, read } = withStandIn(t, ['bad.mp4', 'weak.mp4', 'cut.mp4', 'good.mp4']);
  const first = run(ONE_SHARE);
  assertCode(first, 1);
  assert.match(first.stderr, /line 2: weak\.mp4: exit code 4/);
  assert.match(first.stdout, /1 done, 1 truncated, 1 cannot be read, 1 failed/);
  const results = ['000002-cut', '000002-cut.truncated', '000003-good'];
  assert.deepEqual(there(), ['000000-bad.failed', '000001-weak.log', ...results]);
  assert.equal(read('000000-bad.failed'), 'tracecut segment bad.mp4\nerror: is not a video\n');
  assert.equal(read('000002-cut.truncated'), 'tracecut segment cut.mp4\nerror: damaged at frame 9\n');
  assert.deepEqual(asked(), ['bad.mp4', 'weak.mp4', 'cut.mp4', 'good.mp4']);
  for (let again = 0; again < 2; again += 1) {
    assertCode(run(ONE_SHARE), 0);
    assert.deepEqual(there(), ['000000-bad.failed', '000001-weak', ...results]);
  }
  // The command itself says that results are complete.
  assert.deepEqual(asked().slice(0, 3), ['cut.mp4', 'good.mp4', 'weak.mp4']);
});

test('a note counts for its command and its clip as they were', (t) => {
  const { run, asked, folder, out, list } = withStandIn(t, ['bad.mp4']);
  const clip = join(folder, 'bad.mp4');
  writeFileSync(clip, '');
  const isTried = (...words) => {
    assertCode(run(ONE_SHARE, ...words), 0);
    return asked().length === 1;
  };
  assert.ok(isTried());
  assert.ok(!isTried());
  assert.ok(isTried('--frames', '9'));
  assert.ok(!isTried('--frames', '9'));
  const later = statSync(join(out, '000000-bad.failed')).mtimeMs / 1000 + 5;
  utimesSync(clip, later, later);
  assert.ok(isTried('--frames', '9'));
  writeFileSync(list, 'other/bad.mp4');
  assert.ok(isTried('--frames', '9'));
});

test('options that do not fit what a clip has fail that clip; options that are wrong end the share', (t) => {
  const { run, asked, there } = withStandIn(t, ['begun.mp4', 'good.mp4']);
  const { status, stderr } = run(ONE_SHARE);
  assert.equal(status, 1);
  assert.match(stderr, /other options\n.*line 1: begun\.mp4: exit code 2/);
  assert.deepEqual(there(), ['000000-begun.log', '000000-begun.partial', '000001-good']);
  asked();
  const wrong = withStandIn(t, ['one.mp4', 'two.mp4']);
  const ended = wrong.run(ONE_SHARE, '--wrong');
  assertCode(ended, 2);
  assert.match(ended.stderr, /unexpected argument/);
  assert.deepEqual([wrong.asked(), wrong.there()], [['one.mp4'], []]);
});

for (const [signal, code] of [
  ['SIGTERM', 143],
  ['SIGINT', 130],
]) {
  test(`${signal} ends the command and the share, and a second run goes on`, async (t) => {
    const { run, start, called, calls, there } = withStandIn(t, ['good.mp4', 'slow.mp4', 'last.mp4']);
    const share = start(ONE_SHARE);
    const exited = new Promise((resolve) => share.once('exit', resolve));
    await waitFor(`${calls}.slow`, share);
    share.kill(signal);
    assert.equal(await exited, code);
    assert.equal(called().at(-1), 'ended');
    assert.ok(!there().includes('000002-last'));
    assertCode(run(ONE_SHARE), 0);
    assert.deepEqual(there(), ['000000-good', '000001-slow', '000002-last']);
  });
}

test('wrong use is reported and nothing starts', (t) => {
  const { run, called, out } = withStandIn(t, ['one.mp4']);
  const faults = {
    "SHARD = ''": {},
    "SHARDS = ''": { SHARD: '0' },
    'SHARD = 2 (expected 0 to 1, as SHARDS = 2)': { SHARD: '2', SHARDS: '2' },
    "SHARD = '-1'": { SHARD: '-1', SHARDS: '2' },
  };
  for (const [words, env] of Object.entries(faults)) {
    const ended = run(env);
    assertCode(ended, 2);
    assert.ok(ended.stderr.includes(words), ended.stderr);
  }
  assert.deepEqual(called(), []);
  assert.ok(!existsSync(out));
});

test('a machine that lacks the command or the list does nothing and says so, and may be tried again', (t) => {
  const { run, out, list } = machine(t, ['one.mp4']);
  const without = run(ONE_SHARE);
  assertCode(without, 1);
  assert.match(without.stderr, /there is no tracecut on the PATH/);
  rmSync(list);
  const unlisted = run(ONE_SHARE);
  assertCode(unlisted, 1);
  assert.match(unlisted.stderr, /the list .*list\.txt cannot be read/);
  assert.ok(!existsSync(out));
});

const hasShellcheck = spawnSync('shellcheck', ['--version']).status === 0;

test('shellcheck has nothing to say', { skip: !hasShellcheck && 'there is no shellcheck' }, () => {
  execFileSync('shellcheck', [shardScript, slurmScript], { stdio: 'inherit' });
});

const command = commandLine();
const missing = command
  ? !hasFfmpeg() && 'there is no ffmpeg'
  : 'no command line was built: cargo build -p tracecut-cli';
if (missing) console.log(`!!! SKIPPED: shares by the command line: ${missing}`);
const byCommand = (name, body) => test(`by the command line: ${name}`, { skip: missing }, body);

/** Arguments of ffmpeg before the number of frames. With its index at the end nothing could be read of a file that is cut off. */
const MAKE_VIDEO = '-v error -y -f lavfi -i testsrc2=size=96x64:rate=25 -movflags +faststart -frames:v'.split(' ');

/** Makes a machine with the command and ffmpeg. */
function withCommand(t, clips, tools = { ffmpeg: pathOf('ffmpeg') }) {
  const made = machine(t, clips, { tracecut: command, ...tools });
  /** Makes a small video, of as many frames. */
  const film = (name, frames = 6) => {
    const file = join(made.folder, name);
    execFileSync('ffmpeg', [...MAKE_VIDEO, frames, file]);
    return file;
  };
  const share = (...words) => made.run(ONE_SHARE, '--format', 'rle', '--threads', '1', ...words);
  return { ...made, film, share, report: (name) => JSON.parse(made.read(`${name}/result.json`)) };
}

byCommand('a file that is missing fails, is not marked, and is done once it is there', (t) => {
  const { film, share, there } = withCommand(t, ['absent.mp4', 'there.mp4']);
  film('there.mp4');
  const first = share();
  assertCode(first, 1);
  assert.match(first.stderr, /absent\.mp4/);
  assert.deepEqual(there(), ['000000-absent.log', '000001-there']);
  film('absent.mp4');
  assertCode(share(), 0);
  assert.deepEqual(there(), ['000000-absent', '000001-there']);
});

byCommand('without ffmpeg videos fail and are not marked, and are done once it is there', (t) => {
  const { film, share, there, bin } = withCommand(t, ['a.mp4', 'b.mp4'], {});
  film('a.mp4');
  film('b.mp4');
  const first = share();
  assertCode(first, 1);
  assert.match(first.stderr, /ffmpeg/);
  assert.deepEqual(there(), ['000000-a.log', '000001-b.log']);
  symlinkSync(pathOf('ffmpeg'), join(bin, 'ffmpeg'));
  assertCode(share(), 0);
  assert.deepEqual(there(), ['000000-a', '000001-b']);
});

byCommand('what is no video is marked, and done once it is one', (t) => {
  const { film, share, there, folder, read } = withCommand(t, ['text.mp4', 'video.mp4']);
  writeFileSync(join(folder, 'text.mp4'), 'This is no video.\n'.repeat(50));
  film('video.mp4');
  assertCode(share(), 0);
  assert.deepEqual(there(), ['000000-text.failed', '000001-video']);
  assert.match(read('000000-text.failed'), /^tracecut segment text\.mp4 --format rle --threads 1\nerror: text\.mp4/);
  const later = Date.now() / 1000 + 5;
  utimesSync(film('text.mp4'), later, later);
  assertCode(share(), 0);
  assert.deepEqual(there(), ['000000-text', '000001-video']);
});

byCommand('options that differ after a kill fail that clip alone, and it goes on with its own', async (t) => {
  const { film, share, start, there, out } = withCommand(t, ['long.mp4', 'short.mp4']);
  film('long.mp4', 300);
  film('short.mp4');
  const words = ['--format', 'rle', '--threads', '1', '--window', '12'];
  const killed = start(ONE_SHARE, ...words);
  const exited = new Promise((resolve) => killed.once('exit', resolve));
  const checkpoint = join(out, '000000-long.partial', '.tracecut', 'checkpoint');
  await waitFor(checkpoint, killed);
  // The script, the command and ffmpeg, as when the power goes.
  process.kill(-killed.pid, 'SIGKILL');
  await exited;
  const other = share('--window', '20');
  assertCode(other, 1);
  assert.match(other.stderr, /options\.window was 12 and is 20/);
  assert.match(other.stderr, /line 1: long\.mp4: exit code 2/);
  assert.deepEqual(there(), ['000000-long.log', '000000-long.partial', '000001-short']);
  assert.ok(existsSync(checkpoint));
  rmSync(join(out, '000001-short'), { recursive: true });
  assertCode(share('--window', '12'), 0);
  assert.deepEqual(there(), ['000000-long', '000001-short']);
});

byCommand('of a clip that is cut off the results before stay, with a note, and are not made again', (t) => {
  const { film, share, there, read, report, out, folder } = withCommand(t, ['cut.mp4', 'whole.mp4']);
  const whole = readFileSync(film('full.mp4', 40));
  writeFileSync(join(folder, 'cut.mp4'), whole.subarray(0, 0.7 * whole.length));
  film('whole.mp4');
  assertCode(share(), 0);
  assert.deepEqual(there(), ['000000-cut', '000000-cut.truncated', '000001-whole']);
  assert.ok(report('000000-cut').truncated.frames > 1);
  assert.match(read('000000-cut.truncated'), /^tracecut segment cut\.mp4 .*\nerror: cut\.mp4/);
  const time = statSync(join(out, '000000-cut', 'result.json')).mtimeMs;
  assertCode(share(), 0);
  assert.deepEqual(there(), ['000000-cut', '000000-cut.truncated', '000001-whole']);
  assert.equal(statSync(join(out, '000000-cut', 'result.json')).mtimeMs, time);
});

byCommand('results that lie there of another clip or in other formats are an error, and stay', (t) => {
  const { film, share, run, there, report, read, list, folder } = withCommand(t, ['a/one.mp4', 'two.mp4']);
  for (const name of ['a', 'b']) mkdirSync(join(folder, name));
  film('a/one.mp4', 6);
  film('b/one.mp4', 8);
  film('two.mp4');
  assertCode(share(), 0);
  const masks = read('000000-one/masks.json');
  writeFileSync(list, 'b/one.mp4\ntwo.mp4');
  const other = share();
  assertCode(other, 1);
  assert.match(other.stderr, /was not made from this input/);
  assert.match(other.stdout, /1 done, 0 truncated, 0 cannot be read, 1 failed/);
  assert.deepEqual(there(), ['000000-one', '000000-one.log', '000001-two']);
  assert.deepEqual([report('000000-one').frames, read('000000-one/masks.json')], [6, masks]);
  writeFileSync(list, 'a/one.mp4\ntwo.mp4');
  assertCode(run(ONE_SHARE, '--format', 'npz', '--threads', '1'), 1);
  assertCode(share(), 0);
  copyFileSync(join(folder, 'b/one.mp4'), join(folder, 'a/one.mp4'));
  assertCode(share(), 1);
});

byCommand('an ffmpeg that cannot run, or is killed, is no fault of the clip', (t) => {
  const { film, share, there, bin } = withCommand(t, ['clip.mp4'], {});
  film('clip.mp4', 300);
  const real = pathOf('ffmpeg');
  const faults = {
    'cannot be loaded': 'echo "ffmpeg: error while loading shared libraries: libavcodec.so" >&2; exit 127',
    'is killed when it lists': 'kill -9 $$',
    // As the system does where memory runs out.
    'is killed when it decodes': `case "$*" in
      *rawvideo*) ${real} "$@" & sleep 0.3; kill -9 $! $$ ;;
      *) exec ${real} "$@" ;;
    esac`,
  };
  for (const [fault, body] of Object.entries(faults)) {
    writeFileSync(join(bin, 'ffmpeg'), `#!/usr/bin/env bash\n${body}\n`, { mode: 0o755 });
    assertCode(share(), 1);
    // A part that the next run goes on with may lie there.
    const found = there().filter((name) => name !== '000000-clip.partial');
    assert.deepEqual(found, ['000000-clip.log'], fault);
  }
  rmSync(join(bin, 'ffmpeg'));
  symlinkSync(real, join(bin, 'ffmpeg'));
  assertCode(share(), 0);
  assert.deepEqual(there(), ['000000-clip']);
});
