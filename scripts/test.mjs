// `npm test`: installs what is missing, runs the parts of the tests, and counts. What a part needs and runs is in
// package.json under "wireit", which also runs parts side by side.
//
//   npm test [-- PART ...] [--force]     what changed since it passed, of all parts or these (rust, node, ...); --force runs all
//   npm run test:long [-- PART ...]      the slow tests

import { spawnSync } from 'node:child_process';
import { existsSync, readFileSync, rmSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { parseArgs } from 'node:util';
import { hasPython } from './native.mjs';
import { ensureNodeModules, ensureRust, environment, fail, output, root } from './tools.mjs';

const { wireit } = JSON.parse(readFileSync(join(root, 'package.json'), 'utf8'));
const { mode, parts, force } = readArguments();
await ensureNodeModules();
ensureRust();
const start = Date.now();
const scripts = parts.filter(isPossible).map((part) => `${mode}:${part}`);
if (force) for (const script of scripts) rmSync(wireitFolder(script), { recursive: true, force: true });
const isWhole = parts.length === partsOf(mode).length && scripts.length === parts.length;
const exits = (isWhole ? [`${mode}:all`] : scripts).map(runScript);
report();

function readArguments() {
  try {
    const { values, positionals } = parseArgs({ options: { force: { type: 'boolean' } }, allowPositionals: true });
    const mode = positionals[0] === 'long' ? 'long' : 'test';
    const words = mode === 'long' ? positionals.slice(1) : positionals;
    const unknown = words.find((word) => !partsOf(mode).includes(word));
    if (unknown) throw new Error(`There is no part "${unknown}" (expected ${partsOf(mode).join(', ')}).`);
    return { mode, parts: words.length > 0 ? words : partsOf(mode), force: values.force };
  } catch (error) {
    return fail(`${error.message}\nUsage: npm test -- [PART ...] [--force]`);
  }
}

/** Returns the parts of `npm test` or `npm run test:long`. */
function partsOf(mode) {
  return wireit[`${mode}:all`].dependencies.map((script) => script.slice(mode.length + 1));
}

/** Returns whether the machine has what a part needs, and says what it misses. */
function isPossible(part) {
  const missing = {
    python: () => (hasPython() ? null : 'Python 3.9 or later with venv'),
    sanitizer: () =>
      output('rustc', ['+nightly', '--version']) ? null : 'the nightly compiler (rustup toolchain install nightly)',
  }[part === 'wheel' ? 'python' : part]?.();
  if (missing) console.log(`!!! SKIPPED: the tests of ${part} need ${missing}`);
  return !missing;
}

function wireitFolder(script) {
  return join(root, '.wireit', Buffer.from(script).toString('hex'));
}

/** Runs a script with what it depends on; a failure does not stop the others. */
function runScript(script) {
  // What has changed is built and tested again; nothing is restored from an earlier state.
  const runner = { WIREIT_FAILURES: 'continue', WIREIT_CACHE: 'none' };
  const env = environment({ ...runner, WIREIT_LOGGER: process.env.WIREIT_LOGGER ?? 'simple' });
  const shell = process.platform === 'win32';
  return spawnSync('npm', ['run', '--silent', script], { cwd: root, stdio: 'inherit', env, shell }).status ?? 1;
}

function report() {
  const sum = { passed: 0, failed: 0, skipped: 0 };
  const unchanged = [];
  const failures = new Map();
  const isFailed = exits.some((code) => code !== 0);
  for (const script of scripts) {
    const log = join(root, 'out', 'tests', `${script.replace(':', '-')}.log`);
    if (!existsSync(log)) continue;
    const isOld = statSync(log).mtimeMs < start;
    // After a failure it may also be that the part could not start.
    if (isOld && isFailed) continue;
    if (isOld) unchanged.push(script);
    const text = readFileSync(log, 'utf8');
    const counts = countTests(text);
    for (const key of Object.keys(sum)) sum[key] += counts[key];
    if (counts.failed > 0) failures.set(script, failuresIn(text));
  }
  for (const [script, text] of failures) console.log(`\nFailures of ${script}:\n${text}`);
  if (unchanged.length > 0) console.log(`\nUnchanged since they passed: ${unchanged.join(', ')} (--force runs them)`);
  const failed = Math.max(sum.failed, Number(isFailed));
  const seconds = Math.round((Date.now() - start) / 1000);
  console.log(`\nIn ${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, '0')} minutes:`);
  console.log(`${sum.passed} passed, ${failed} failed, ${sum.skipped} skipped`);
  process.exitCode = Number(failed > 0);
}

/** Counts tests in the output of Cargo, Node's test runner, Playwright or pytest. */
function countTests(log) {
  const count = (word) => {
    const patterns = [
      new RegExp(String.raw`^test result: .*? (\d+) ${{ skipped: 'ignored' }[word] ?? word}`, 'gm'),
      new RegExp(String.raw`^\W* ${{ passed: 'pass', failed: 'fail' }[word] ?? word} (\d+)$`, 'gm'),
      new RegExp(String.raw`^[= ]*(?:\d+ \w+, )*(\d+) ${word}\b`, 'gm'),
    ];
    return patterns.flatMap((pattern) => [...log.matchAll(pattern)]).reduce((total, [, n]) => total + Number(n), 0);
  };
  return { passed: count('passed'), failed: count('failed'), skipped: count('skipped') };
}

/** Returns what a runner wrote about the tests that failed, so that it also stands at the end of a long output. */
function failuresIn(log) {
  const heads = [/^failures:$/m, /^\W* failing tests:$/m, /^ {2}1\) .* › /m, /^=+ FAILURES =+$/m];
  const start = Math.min(...heads.map((head) => log.search(head)).filter((index) => index >= 0));
  return (Number.isFinite(start) ? log.slice(start).split('\n').slice(0, 60) : log.split('\n').slice(-60)).join('\n');
}
