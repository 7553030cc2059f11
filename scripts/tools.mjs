// Finds the tools that the project needs, of the right version, and installs what is missing: npm packages into
// node_modules/, Rust tools into .tools/ (nothing outside the project but the rustup target). A second call finds
// everything in place. `node scripts/tools.mjs NAME ...` makes sure of Rust tools.

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
const exe = process.platform === 'win32' ? '.exe' : '';

// `--locked` asks wasm-bindgen-cli's own lock file for a release that not every registry has; its requirements alone
// resolve.
const rustTools = {
  'wasm-bindgen': { crate: 'wasm-bindgen-cli', version: bindgenVersion(), options: [] },
  // Without what it downloads with: it has to find all that it needs.
  'wasm-pack': { crate: 'wasm-pack', version: '0.15.1', options: ['--locked', '--no-default-features'] },
  'cargo-deny': { crate: 'cargo-deny', version: '0.20.2', options: ['--locked'] },
  'cargo-about': { crate: 'cargo-about', version: '0.9.3', options: ['--locked', '--features', 'cli'] },
  'cargo-fuzz': { crate: 'cargo-fuzz', version: '0.13.2', options: ['--locked'] },
};

/** The exact wasm-bindgen release of Cargo.lock: the command line tool must be the same one. */
function bindgenVersion() {
  const lock = readFileSync(join(root, 'Cargo.lock'), 'utf8');
  const match = /name = "wasm-bindgen"\nversion = "([^"]+)"/.exec(lock.replaceAll('\r', ''));
  if (!match) fail('Cargo.lock names no wasm-bindgen; restore the file from git.');
  return match[1];
}

/** Ends the script with a message in words. */
export function fail(message) {
  console.error(`\n${message}`);
  process.exit(1);
}

/** Environment of every child: the project's own tools first on PATH. */
export function environment(extra = {}) {
  return { ...process.env, PATH: toolsBin + delimiter + process.env.PATH, ...extra };
}

/** Runs a command in the project's root with its output shown; ends the script when it fails. */
export function run(command, args, { env = {}, hint = '' } = {}) {
  console.log(`$ ${command} ${args.join(' ')}`);
  const result = spawnSync(command, args, shown(command, env));
  if (result.error) fail(`${command} cannot be started: ${result.error.message}. ${hint}`);
  if (result.status !== 0) fail(`${command} ${args[0] ?? ''} failed (exit code ${result.status}). ${hint}`);
}

/** The same while other commands run; their outputs mix line by line. */
export function runBeside(command, args, { env = {}, hint = '' } = {}) {
  return new Promise((resolve) => {
    const child = spawn(command, args, shown(command, env));
    child.on('error', (error) => fail(`${command} cannot be started: ${error.message}. ${hint}`));
    child.on('close', (status) => {
      if (status !== 0) fail(`${command} ${args[0] ?? ''} failed (exit code ${status}). ${hint}`);
      resolve();
    });
  });
}

const begun = Date.now();
/** What is done now, and since when. */
const work = new Map();
const PAUSE_MS = 5000;

/**
 * Does something that may take long: says what and for how long, every few seconds. Nothing is said of what is done at once.
 *
 * @template T
 * @param {string} what
 * @param {number} seconds what it takes on two idle cores
 * @param {() => Promise<T>} action
 * @returns {Promise<T>}
 */
export async function during(what, seconds, action) {
  const since = Date.now();
  const passed = (from) => Math.round((Date.now() - from) / 1000);
  const tell = () => console.log(`[${passed(begun)} s] ${what}: ${passed(since)} s of about ${seconds}`);
  work.set(what, tell);
  // The first of all that is done speaks for the others.
  const timer = setInterval(() => work.keys().next().value === what && work.forEach((say) => say()), PAUSE_MS);
  try {
    return await action();
  } finally {
    clearInterval(timer);
    work.delete(what);
    if (passed(since) > 1) console.log(`[${passed(begun)} s] ${what}: done in ${passed(since)} s`);
  }
}

/** How a command is run whose output is shown. */
function shown(command, env) {
  return { cwd: root, stdio: 'inherit', env: environment(env), shell: needsShell(command) };
}

/** What a command prints, or null when it cannot run. */
export function output(command, args) {
  const result = spawnSync(command, args, {
    cwd: root,
    encoding: 'utf8',
    env: environment(),
    shell: needsShell(command),
  });
  return result.status === 0 ? result.stdout.trim() : null;
}

/** The first of these programs that is there, paths or names on PATH; null where none is. */
export function findProgram(...names) {
  const folders = process.env.PATH.split(delimiter);
  const places = names.filter(Boolean).flatMap((name) => [name, ...folders.map((folder) => join(folder, name))]);
  return places.find((place) => /[\\/]/.test(place) && isExecutable(place)) ?? null;
}

function isExecutable(file) {
  try {
    accessSync(file, constants.X_OK);
    return true;
  } catch {
    return false;
  }
}

/** On Windows npm is a batch file, which only a shell can start. */
function needsShell(command) {
  return process.platform === 'win32' && command === 'npm';
}

/** Installs node_modules when it is missing or older than the lock file. */
export function ensureNodeModules() {
  const installed = join(root, 'node_modules', '.package-lock.json');
  if (existsSync(installed) && statSync(installed).mtimeMs >= statSync(join(root, 'package-lock.json')).mtimeMs) return;
  run('npm', ['ci', '--no-audit', '--no-fund'], { hint: 'The packages of package-lock.json could not be installed.' });
}

/** Makes sure of a Rust toolchain that can build for wasm32. */
export function ensureRust() {
  if (output('cargo', ['--version']) === null)
    fail('cargo was not found. Install Rust with rustup, then run this again.');
  const libraries = output('rustc', ['--print', 'target-libdir', '--target', 'wasm32-unknown-unknown']);
  if (libraries !== null && existsSync(libraries)) return;
  run('rustup', ['target', 'add', 'wasm32-unknown-unknown'], { hint: 'The wasm32-unknown-unknown target is needed.' });
}

/** Tools run for a second: compiling them fast matters more than running them fast. */
const quickly = { CARGO_PROFILE_RELEASE_OPT_LEVEL: '0', CARGO_PROFILE_RELEASE_LTO: 'off' };

/** Whether a Rust command line tool is there, in exactly the version the project was built with. */
export function hasRustTool(name) {
  return output(name + exe, ['--version'])?.includes(rustTools[name].version) ?? false;
}

/** Makes sure of such a tool. */
export function ensureRustTool(name) {
  const { crate, version, options } = rustTools[name];
  if (hasRustTool(name)) return;
  console.log(`${name} ${version}, for the tests, is not there yet; building it into .tools (some minutes, once).`);
  const args = ['install', crate, '--version', version, '--root', join(root, '.tools'), ...options];
  // Its own target folder: the project's flags and profile are not meant for it.
  run('cargo', args, { env: { CARGO_TARGET_DIR: join(root, '.tools', 'target'), ...quickly } });
}

/**
 * Tools of a few lines around a library, in `scripts/NAME/main.rs`: the library, and its version, which is the tool's too.
 * wasm-bindgen has to be the very release that the wasm file is compiled with.
 */
const ownTools = {
  bindgen: ['wasm-bindgen-cli-support', bindgenVersion()],
  api: ['public-api', '0.52.2'],
};

/** Where such a tool is, once it is there. */
export const ownTool = (name) => join(toolsBin, name + exe);

/** What it is compiled from. */
export const ownToolSource = (name) => join(root, 'scripts', name, 'main.rs');

/** Makes sure of such a tool. */
export async function ensureOwnTool(name) {
  const [library, version] = ownTools[name];
  const folder = join(root, '.tools', name);
  const [source, copy] = [ownToolSource(name), join(folder, 'src', 'main.rs')];
  const isSame = existsSync(copy) && readFileSync(copy).equals(readFileSync(source));
  if (isSame && output(ownTool(name), ['--version']) === `${name} ${version}`) return;
  mkdirSync(join(folder, 'src'), { recursive: true });
  copyFileSync(source, copy);
  const manifest = `[package]
name = "${name}"
version = "${version}"
edition = "2024"
[workspace]
[dependencies]
${library} = "=${version}"
`;
  writeFileSync(join(folder, 'Cargo.toml'), manifest);
  const args = ['install', '--quiet', '--path', folder, '--root', join(root, '.tools'), '--force'];
  await runBeside('cargo', args, { env: { CARGO_TARGET_DIR: join(root, '.tools', 'target'), ...quickly } });
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) process.argv.slice(2).forEach(ensureRustTool);
