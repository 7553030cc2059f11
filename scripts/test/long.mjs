// The tasks of `npm run test:long`: the slow tests.

import { basename, join } from 'node:path';
import { output, root } from '../tools.mjs';
import { PARTS, RUST_PROGRAMS, hasLongTests, runFile, runProgram, tasksOf, testFiles } from './tasks.mjs';

const node = (...args) => ({ command: process.execPath, args });
const cargo = (...args) => ({ command: 'cargo', args });
/** Sizes of the soak test in every long run; `npm run soak` does more. */
const SOAK = ['sessions=200', 'crowd=5', 'windows=600', 'page=400'];

/**
 * @param {string[]} words parts, all if none are named
 * @returns {import('./pool.mjs').Task[]}
 */
export function longTasks(words) {
  const builds = tasksOf(Object.keys(PARTS)).filter(({ part }) => part === 'build');
  const all = [...ignored(), ...sanitized(), ...scripts(), ...inJavaScript()].map((task) => ({
    cores: 1,
    after: [],
    ...task,
    name: `long: ${task.name}`,
  }));
  const chosen = all.filter(({ part }) => words.length === 0 || words.includes(part));
  const needed = new Set(chosen.flatMap(({ after }) => after));
  const before = builds.filter(({ name }) => needed.has(name));
  for (const { after } of before) after.forEach((name) => needed.add(name));
  return [...builds.filter(({ name }) => needed.has(name)), ...chosen];
}

const PACKAGE = 'build the package';
const RUST = 'compile the Rust tests';

/** Rust tests that are marked `#[ignore]`. */
function ignored() {
  return RUST_PROGRAMS.map((program) => ({
    name: `${program.name}, ignored`,
    part: 'rust',
    cores: 2,
    after: [RUST],
    start: () => runProgram(program, ['--ignored', '--nocapture']),
  }));
}

/** Native tests with the address sanitizer: our code has no `unsafe`, but crates that it calls do. */
function sanitized() {
  if (process.platform !== 'linux' || output('rustc', ['+nightly', '--version']) === null) {
    console.log(
      '!!! SKIPPED: tests with the address sanitizer need Linux and the nightly compiler (rustup toolchain install nightly)',
    );
    return [];
  }
  const target = output('rustc', ['-vV']).match(/host: (.*)/)[1];
  const env = { RUSTFLAGS: '-Zsanitizer=address', CARGO_TARGET_DIR: join('target', 'sanitizer') };
  const named = (crate, features, names) => [
    '--package',
    crate,
    ...features,
    '--lib',
    '--test',
    'integration',
    '--',
    ...names,
  ];
  const tests = {
    // No unit test has one of these names; the command line's tests start their own programs.
    library: named('tracecut', ['--features', 'pnm'], ['--skip', 'crate_files', '--skip', 'examples']),
    readers: named('tracecut-cli', [], ['--skip', 'cli::', '--skip', 'long::']),
    measures: named('tracecut-bench', [], ['--skip', 'bench::', '--skip', 'benchmark::']),
  };
  return Object.entries(tests).map(([name, which]) => ({
    name: `address sanitizer, ${name}`,
    part: 'sanitizer',
    cores: 2,
    start: () => ({ ...cargo('+nightly', 'test', '--locked', '--target', target, ...which), env }),
  }));
}

function scripts() {
  const python = (step) => ({
    part: 'python',
    after: [RUST, 'build the Python module'],
    start: () => ({ command: 'python3', args: ['python/run_tests.py', step] }),
  });
  return [
    { name: 'advisories', part: 'audit', start: () => node('scripts/audit.mjs', '--install') },
    { name: 'licences', part: 'audit', after: [PACKAGE], start: () => node('scripts/licences.mjs') },
    { name: 'soak', part: 'soak', cores: 2, after: [PACKAGE], start: () => node('benches/soak.mjs', ...SOAK) },
    { name: 'the wheel', ...python('--wheel') },
    { name: 'python/tests, long', ...python('--long') },
  ];
}

/** The long test files, and the files of `npm test` with tests that it skips. */
function inJavaScript() {
  const own = ['tests/long', 'tests/engines'].flatMap(testFiles);
  const shared = ['node', 'browser'].flatMap((part) => PARTS[part].flatMap(testFiles)).filter(hasLongTests);
  return [...own, ...shared].map((file) => ({
    name: file,
    part: 'browser',
    cores: basename(file).startsWith('memory') ? 2 : 1,
    after: [PACKAGE, RUST],
    start: () => runFile(file, { TRACECUT_LONG: '1' }),
  }));
}
