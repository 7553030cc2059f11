// Finds the tools that the project needs, in the right versions, and installs missing ones: npm packages into
// node_modules/, Rust tools into .tools/ (nothing outside the project except the rustup target).
// `node scripts/tools.mjs NAME ...` installs Rust tools.

import { spawn, spawnSync } from 'node:child_process';
import {
  accessSync,
  constants,
  copyFileSync,
  existsSync,
  mkdirSync,
  readFileSync,
  statSync,
  writeFileSync,
} from 'node:fs';
import { delimiter, join } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

/** The project's root folder. */
export const root = fileURLToPath(new URL('..', import.meta.url));

const toolsBin = join(root, '.tools', 'bin');
/** The end of a program's file name. */
export const exe = process.platform === 'win32' ? '.exe' : '';

const rustTools = {
  'cargo-deny': { crate: 'cargo-deny', version: '0.20.2', options: ['--locked'] },
  'cargo-about': { crate: 'cargo-about', version: '0.9.3', options: ['--locked', '--features', 'cli'] },
  'cargo-fuzz': { crate: 'cargo-fuzz', version: '0.13.2', options: ['--locked'] },
};

/** Returns the exact wasm-bindgen release of Cargo.lock, which the command line tool must match. */
function bindgenVersion() {
  const lock = readFileSync(join(root, 'Cargo.lock'), 'utf8');
  const match = /name = "wasm-bindgen"\nversion = "([^"]+)"/.exec(lock.replaceAll('\r', ''));
  if (!match) fail('Cargo.lock names no wasm-bindgen; restore the file from git.');
  return match[1];
}

/** Ends the script with a message. */
export function fail(message) {
  console.error(`\n${message}`);
  process.exit(1);
}

/** Returns the environment of child processes: the project's own tools come first on PATH. */
export function environment(extra = {}) {
  return { ...process.env, PATH: toolsBin + delimiter + process.env.PATH, ...extra };
}

/** Runs a command in the project's root and shows its output; ends the script if it fails. */
export function run(command, args, { env = {}, hint = '' } = {}) {
  console.log(`$ ${command} ${args.join(' ')}`);
  const result = spawnSync(command, args, visibleOptions(command, env));
  if (result.error) fail(`${command} cannot be started: ${result.error.message}. ${hint}`);
  if (result.status !== 0) fail(`${command} ${args[0] ?? ''} failed (exit code ${result.status}). ${hint}`);
}

/** Does the same while other commands run; their outputs are mixed line by line. */
export function runBeside(command, args, { env = {}, hint = '' } = {}) {
  return new Promise((resolve) => {
    const child = spawn(command, args, visibleOptions(command, env));
    child.on('error', (error) => fail(`${command} cannot be started: ${error.message}. ${hint}`));
    child.on('close', (status) => {
      if (status !== 0) fail(`${command} ${args[0] ?? ''} failed (exit code ${status}). ${hint}`);
      resolve();
    });
  });
}

const scriptStart = Date.now();
/** The reports of the running actions. */
const running = new Map();
const REPORT_INTERVAL_MS = 5000;

/**
 * Runs an action that may take long, and reports it every few seconds. A fast action is not reported.
 *
 * @template T
 * @param {string} what
 * @param {number} seconds expected time on two idle cores
 * @param {() => Promise<T>} action
 * @returns {Promise<T>}
 */
export async function during(what, seconds, action) {
  const since = Date.now();
  const passed = (from) => Math.round((Date.now() - from) / 1000);
  const report = () => console.log(`[${passed(scriptStart)} s] ${what}: ${passed(since)} s of about ${seconds}`);
  running.set(what, report);
  // The oldest action reports for all.
  const isOldest = () => running.keys().next().value === what;
  const timer = setInterval(() => isOldest() && running.forEach((print) => print()), REPORT_INTERVAL_MS);
  try {
    return await action();
  } finally {
    clearInterval(timer);
    running.delete(what);
    if (passed(since) > 1) console.log(`[${passed(scriptStart)} s] ${what}: done in ${passed(since)} s`);
  }
}

/** Returns the options of a command whose output is shown. */
function visibleOptions(command, env) {
  return { cwd: root, stdio: 'inherit', env: environment(env), shell: needsShell(command) };
}

/** Returns a command's output, or null if it fails. */
export function output(command, args) {
  const result = spawnSync(command, args, {
    cwd: root,
    encoding: 'utf8',
    env: environment(),
    shell: needsShell(command),
  });
  return result.status === 0 ? result.stdout.trim() : null;
}

/** Returns the first of these programs that exists, as a path or a name on PATH; null if none does. */
export function findProgram(...names) {
  const folders = process.env.PATH.split(delimiter);
  const paths = names.filter(Boolean).flatMap((name) => [name, ...folders.map((folder) => join(folder, name))]);
  return paths.find((path) => /[\\/]/.test(path) && isExecutable(path)) ?? null;
}

function isExecutable(file) {
  try {
    accessSync(file, constants.X_OK);
    return true;
  } catch {
    return false;
  }
}

/** On Windows npm is a batch file, which needs a shell. */
function needsShell(command) {
  return process.platform === 'win32' && command === 'npm';
}

/** Installs node_modules if it is missing or older than the lock file. */
export async function ensureNodeModules() {
  const installed = join(root, 'node_modules', '.package-lock.json');
  if (existsSync(installed) && statSync(installed).mtimeMs >= statSync(join(root, 'package-lock.json')).mtimeMs) return;
  await during('installing npm packages', 15, () =>
    runBeside('npm', ['ci', '--no-audit', '--no-fund'], {
      hint: 'The packages of package-lock.json could not be installed.',
    }),
  );
}

/** Ensures a Rust toolchain that can build for wasm32. */
export function ensureRust() {
  if (output('cargo', ['--version']) === null)
    fail('cargo was not found. Install Rust with rustup, then run this again.');
  const libraries = output('rustc', ['--print', 'target-libdir', '--target', 'wasm32-unknown-unknown']);
  if (libraries !== null && existsSync(libraries)) return;
  run('rustup', ['target', 'add', 'wasm32-unknown-unknown'], { hint: 'The wasm32-unknown-unknown target is needed.' });
}

/** Tools run for a second, so compiling them fast matters more than running them fast. */
const fastCompile = { CARGO_PROFILE_RELEASE_OPT_LEVEL: '0', CARGO_PROFILE_RELEASE_LTO: 'off' };

/** Returns whether a Rust command line tool is installed in the project's exact version. */
export function hasRustTool(name) {
  return output(name + exe, ['--version'])?.includes(rustTools[name].version) ?? false;
}

/** Installs a Rust tool if it is missing. */
export function ensureRustTool(name) {
  const { crate, version, options } = rustTools[name];
  if (hasRustTool(name)) return;
  console.log(`${name} ${version}, for the tests, is missing; building it into .tools (a few minutes, once).`);
  const args = ['install', crate, '--version', version, '--root', join(root, '.tools'), ...options];
  // Its own target folder, as the project's flags and profile are not meant for it.
  run('cargo', args, { env: { CARGO_TARGET_DIR: join(root, '.tools', 'target'), ...fastCompile } });
}

/**
 * Programs around libraries, in `scripts/NAME/main.rs`: the libraries they need, features of libraries below these, and the names under
 * which the programs are installed. wasm-bindgen must be the release that the wasm file is compiled with.
 */
const ownTools = {
  bindgen: {
    crates: { 'wasm-bindgen-cli-support': bindgenVersion() },
    // As the tests' program has them: the crates that depend on these are compiled once for both.
    features: {
      'bitflags@2': ['std'],
      'log@0.4': ['std'],
      'memchr@2': ['use_std'],
      'semver@1': ['serde'],
      'serde_core@1': ['default'],
      'serde_json@1': ['unbounded_depth'],
    },
  },
  // Without the features that download: everything they need is installed.
  'wasm-tests': {
    crates: { 'wasm-bindgen-cli': bindgenVersion(), 'wasm-pack': '0.15.1', clap: '4' },
    names: ['wasm-pack', 'wasm-bindgen', 'wasm-bindgen-test-runner'],
  },
  api: { crates: { 'public-api': '0.52.2' } },
};

/** Returns the path of such a tool. */
export const ownTool = (name) => join(toolsBin, name + exe);

/** Returns the path of its source. */
export const ownToolSource = (name) => join(root, 'scripts', name, 'main.rs');

/** Installs such a tool if it is missing, or its source or its libraries have changed. */
export async function ensureOwnTool(name) {
  const { crates, features = {}, names = [] } = ownTools[name];
  const folder = join(root, '.tools', name);
  const dependencies = Object.entries(crates).map(([crate, version]) =>
    crate === 'clap'
      ? `clap = "${version}"`
      : `${crate} = { version = "=${version}", default-features = ${names.length === 0} }`,
  );
  for (const [crate, wanted] of Object.entries(features)) {
    const [library, version] = crate.split('@');
    dependencies.push(`${library} = { version = "${version}", features = ${JSON.stringify(wanted)} }`);
  }
  const [, version] = Object.entries(crates)[0];
  const files = {
    'src/main.rs': readFileSync(ownToolSource(name), 'utf8'),
    'Cargo.toml': [
      ...[
        '[package]',
        `name = "${name}"`,
        `version = "${version}"`,
        'edition = "2024"',
        '[workspace]',
        '[dependencies]',
      ],
      ...[...dependencies, ''],
    ].join('\n'),
  };
  const isSame = Object.entries(files).every(([file, text]) => {
    const path = join(folder, file);
    return existsSync(path) && readFileSync(path, 'utf8') === text;
  });
  if (isSame && existsSync(ownTool(name))) return;
  mkdirSync(join(folder, 'src'), { recursive: true });
  for (const [file, text] of Object.entries(files)) writeFileSync(join(folder, file), text);
  const args = ['install', '--quiet', '--path', folder, '--root', join(root, '.tools'), '--force'];
  await runBeside('cargo', args, { env: { CARGO_TARGET_DIR: join(root, '.tools', 'target'), ...fastCompile } });
  for (const copy of names) copyFileSync(ownTool(name), ownTool(copy));
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href)
  for (const name of process.argv.slice(2)) await (name in ownTools ? ensureOwnTool(name) : ensureRustTool(name));
