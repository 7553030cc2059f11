// Lists the test tasks: one per test file, and the builds they need.

import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { output, root } from '../tools.mjs';
import { execute } from './pool.mjs';

/** @typedef {import('./pool.mjs').Task} Task */

/** The parts of `npm test`, and the folders of the JavaScript parts. */
export const PARTS = {
  rust: [],
  wasm: [],
  node: ['tests/node'],
  browser: ['tests/package', 'tests/browser'],
  python: [],
};

/** If Python is installed, its module is compiled with them: alone, most of its crates would be compiled again. */
const CRATES = ['tracecut', 'tracecut-cli', 'tracecut-bench', ...(hasPython() ? ['tracecut-python'] : [])];
const FEATURES = [...CRATES.flatMap((name) => ['--package', name]), '--features', 'tracecut/pnm'];
const TARGETS = ['--lib', '--bins', '--tests', '--examples'];
const node = (...args) => ({ command: process.execPath, args });

/** A page often waits for its workers, frames and network: more than two fit on two cores. */
const CORES_PER_PAGE = 0.5;
/** These use a service worker, and one of them changes the page's files: they run one at a time. */
const WITH_SERVICE_WORKER = ['offline', 'service-worker'].map((name) => `tests/browser/${name}.test.mjs`);
/** Tests that run programs built by Cargo. */
const WITH_NATIVE = ['differ', 'intake'].map((name) => `tests/node/${name}.test.mjs`);

/**
 * The tasks of these parts.
 *
 * @param {string[]} parts
 * @param {{fast?: boolean}} options `fast` builds the package for `npm run test:fast`
 * @returns {Task[]}
 */
export function tasksOf(parts, { fast = false } = {}) {
  const made = {
    rust: rustTasks,
    wasm: wasmTasks,
    node: () => files('node'),
    browser: () => files('browser', { cores: CORES_PER_PAGE }),
    python: pythonTasks,
  };
  const needs = parts.some((part) => ['node', 'browser'].includes(part)) ? [packageTask(fast)] : [];
  return [...needs, ...parts.flatMap((part) => made[part]())].map((task) => ({
    cores: 1,
    after: [],
    ...task,
  }));
}

/** Lists the test files of a folder. */
export function testFiles(folder) {
  if (!existsSync(join(root, folder))) throw new Error(`${folder} is missing.`);
  return readdirSync(join(root, folder))
    .filter((name) => /\.test\.m?js$/.test(name))
    .sort()
    .map((name) => `${folder}/${name}`);
}

/** Runs a test file in its own process, its tests one after the other. */
export function runFile(file, env = {}) {
  return { ...node('--test-reporter=spec', file), env };
}

const packageTask = (fast) => ({
  name: 'build the package',
  part: 'build',
  start: () => node('scripts/build.mjs', ...(fast ? ['--fast'] : [])),
});

function files(part, { cores = 1 } = {}) {
  return PARTS[part].flatMap(testFiles).map((file) => ({
    name: file,
    part,
    cores,
    lock: WITH_SERVICE_WORKER.includes(file) ? 'service worker' : undefined,
    after: ['build the package', ...(WITH_NATIVE.includes(file) ? ['compile the Rust tests'] : [])],
    start: () => runFile(file, WITH_NATIVE.includes(file) ? built() : {}),
  }));
}

/** Paths of Cargo's test programs, by `package target`, and of the Python module. */
let programs = new Map();
/** For tests that run programs built by Cargo: the program of the integration tests. */
const built = () => ({ TRACECUT_BUILT: programs.get('tracecut integration') });

/** The test programs of the crates; the tests of a program run in parallel. */
export const RUST_PROGRAMS = [
  { name: 'src, unit tests', crate: 'tracecut', target: 'tracecut' },
  { name: 'tests/rust', crate: 'tracecut', target: 'integration' },
  { name: 'cli/src, unit tests', crate: 'tracecut-cli', target: 'tracecut_cli' },
  { name: 'cli/tests', crate: 'tracecut-cli', target: 'integration' },
  { name: 'bench/src, unit tests', crate: 'tracecut-bench', target: 'tracecut_bench' },
  { name: 'bench/tests', crate: 'tracecut-bench', target: 'integration' },
];

/** Folders of the crates. */
const CRATE_FOLDERS = { tracecut: '.', 'tracecut-cli': 'cli', 'tracecut-bench': 'bench' };

/** Runs a compiled test program. */
export function runProgram({ name, crate, target }, args = []) {
  const command = programs.get(`${crate} ${target}`);
  if (!command) throw new Error(`Cargo made no test program for ${name}.`);
  return { command, args, cwd: join(root, CRATE_FOLDERS[crate]), env: built() };
}

function rustTasks() {
  const compile = {
    name: 'compile the Rust tests',
    part: 'build',
    start: async () => {
      const outcome = await execute({
        command: 'cargo',
        args: ['build', '--locked', ...TARGETS, '--message-format=json-render-diagnostics', ...FEATURES],
      });
      if (outcome.failed) throw new Error(outcome.output);
      programs = programsIn(outcome.output);
    },
  };
  const tests = RUST_PROGRAMS.map((program) => ({
    name: program.name,
    part: 'rust',
    cores: 2,
    after: [compile.name],
    start: () => runProgram(program),
  }));
  const examples = {
    name: 'src, examples in comments',
    part: 'rust',
    after: [compile.name],
    start: () => ({
      command: 'cargo',
      // With the same features as the others: otherwise all dependencies would be compiled again.
      args: ['test', '--locked', '--doc', ...FEATURES],
    }),
  };
  return [compile, ...tests, examples];
}

/** Returns the crate for Cargo's package ID. */
function crateOf(id) {
  const folder = /\/(cli|bench)[#@]/.exec(id)?.[1];
  return folder ? `tracecut-${folder}` : 'tracecut';
}

/** Finds the test programs and the Python module in Cargo's messages. */
function programsIn(messages) {
  const artifacts = messages
    .split('\n')
    .filter((line) => line.startsWith('{"reason":"compiler-artifact"'))
    .map((line) => JSON.parse(line));
  const tests = artifacts.filter(({ executable, profile }) => executable && profile.test);
  const modules = artifacts.filter(({ target }) => target.kind.includes('cdylib') && target.name === '_tracecut');
  return new Map([
    ...tests.map(({ package_id, target, executable }) => [`${crateOf(package_id)} ${target.name}`, executable]),
    ...modules.map(({ filenames }) => ['tracecut-python', filenames.find((name) => /\.(so|dylib|dll)$/.test(name))]),
  ]);
}

function wasmTasks() {
  const tools = {
    name: 'build the tools of the wasm tests',
    part: 'build',
    start: () => node('scripts/tools.mjs', 'wasm-bindgen', 'wasm-pack'),
  };
  // wasm-pack uses the wasm-bindgen test runner on PATH and downloads nothing.
  // Compiling takes longer than running, so these are optimised less than other tests.
  const env = { CARGO_PROFILE_DEV_OPT_LEVEL: '1', CARGO_PROFILE_DEV_DEBUG: 'false' };
  const start = () => ({ command: 'wasm-pack', args: ['test', '--node', '--mode', 'no-install', 'tests/wasm'], env });
  return [tools, { name: 'tests/wasm', part: 'wasm', after: [tools.name], start }];
}

/** Returns whether Python 3.9 or later with venv is installed. */
function hasPython() {
  return output('python3', ['-c', 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 9))']) !== null;
}

/** The tasks of the Python package, if Python is installed. */
function pythonTasks() {
  if (!CRATES.includes('tracecut-python')) {
    console.log('!!! SKIPPED: the Python package and its tests need python3 (3.9 or later) with venv');
    return [];
  }
  const python = (...args) => ({ command: 'python3', args: ['python/run_tests.py', ...args] });
  const prepare = {
    name: 'set up the Python environment',
    part: 'build',
    start: () => python('--prepare'),
  };
  // The tests compare masks with the command line's, so it must be built; and Cargo locks its folder.
  const build = {
    name: 'build the Python module',
    part: 'build',
    after: [prepare.name, 'compile the Rust tests'],
    start: () => ({ ...python('--build'), env: { TRACECUT_MODULE: programs.get('tracecut-python') } }),
  };
  const tests = readdirSync(join(root, 'python', 'tests'))
    .filter((name) => /^test_.*\.py$/.test(name))
    .map((name) => ({
      name: `python/tests/${name}`,
      part: 'python',
      after: [build.name],
      start: () => python('--test', `python/tests/${name}`),
    }));
  return [prepare, build, ...tests];
}

/** Returns whether a file has tests that `npm test` skips or shortens. */
export function hasLongTests(file) {
  return /onlyLong|TRACECUT_LONG/.test(readFileSync(join(root, file), 'utf8'));
}
