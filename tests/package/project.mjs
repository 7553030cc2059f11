// The packed tarball in a project outside of this one, as a user has it, with tools at pinned versions and an unchanged recipe
// of docs/recipes.md, and a server for such projects.

import { execFile, execFileSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import {
  chmodSync,
  cpSync,
  existsSync,
  mkdirSync,
  mkdtempSync,
  readFileSync,
  readdirSync,
  realpathSync,
  renameSync,
  rmSync,
  statSync,
  writeFileSync,
} from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { dirname, extname, join, resolve, sep } from 'node:path';
import { promisify } from 'node:util';
import { root } from '../../scripts/tools.mjs';

const windows = process.platform === 'win32';
const types = {
  '.html': 'text/html',
  '.js': 'text/javascript',
  '.mjs': 'text/javascript',
  '.wasm': 'application/wasm',
  '.json': 'application/json',
};

/**
 * Copies `source`, if given, into a new folder and installs the tarball there, without network.
 *
 * @param {{after: (clean: () => void) => void}} t
 * @param {string} [source] a folder of this project
 * @returns {string} the folder
 */
export function installed(t, source) {
  const folder = realpathSync(mkdtempSync(join(tmpdir(), 'tracecut-')));
  t.after(() => rmSync(folder, { recursive: true, force: true }));
  if (source) cpSync(join(root, source), folder, { recursive: true });
  // Only the tarball is installed: an example's other dependencies, such as a bundler, come from this project.
  const manifest = JSON.parse(source ? readOr(join(folder, 'package.json'), '{}') : '{}');
  cpSync(packedAndInstalled(), folder, { recursive: true, verbatimSymlinks: true });
  const installedManifest = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'));
  writeFileSync(
    join(folder, 'package.json'),
    JSON.stringify({ ...installedManifest, type: manifest.type ?? 'module' }),
  );
  return folder;
}

/** Returns a folder in which npm has installed the tarball, shared by all tests of a build. */
function packedAndInstalled() {
  const built = readdirSync(join(root, 'dist'), { recursive: true }).map((name) => join(root, 'dist', name));
  const shipped = ['package.json', 'README.md', 'CHANGELOG.md'].map((name) => join(root, name));
  const hash = createHash('sha256');
  for (const file of [...built, ...shipped]) {
    const { size, mtimeMs } = statSync(file);
    hash.update(`${file} ${size} ${mtimeMs}\n`);
  }
  const folder = join(root, 'out', 'installed', hash.digest('hex').slice(0, 16));
  if (existsSync(folder)) return folder;
  mkdirSync(join(root, 'out', 'installed'), { recursive: true });
  const draft = mkdtempSync(join(root, 'out', 'installed', 'draft-'));
  npm(root, 'pack', '--silent', '--ignore-scripts', '--pack-destination', draft);
  const [tarball] = readdirSync(draft).filter((name) => name.endsWith('.tgz'));
  writeFileSync(join(draft, 'package.json'), JSON.stringify({ private: true }));
  npm(draft, 'install', '--offline', '--no-audit', '--no-fund', `./${tarball}`);
  try {
    renameSync(draft, folder);
  } catch {
    rmSync(draft, { recursive: true }); // Another process was first.
  }
  return folder;
}

/**
 * Serves a folder.
 *
 * @param {{after: (clean: () => void) => void}} t
 * @param {string} folder
 * @param {{headers?: Record<string, string>}} [options] headers of each response
 * @returns {Promise<string>} the server's address
 */
export async function served(t, folder, { headers = {} } = {}) {
  const server = createServer((request, response) => {
    const path = decodeURIComponent(request.url.split('?')[0]);
    const file = resolve(folder, `.${path.endsWith('/') ? `${path}index.html` : path}`);
    if (!file.startsWith(folder + sep) || !statSync(file, { throwIfNoEntry: false })?.isFile())
      return response.writeHead(404).end();
    const type = types[extname(file)] ?? 'application/octet-stream';
    response.writeHead(200, { 'Content-Type': type, ...headers });
    response.end(readFileSync(file));
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  t.after(() => {
    server.close();
    server.closeAllConnections();
  });
  return `http://127.0.0.1:${server.address().port}/`;
}

function npm(folder, ...args) {
  execFileSync('npm', args, { cwd: folder, encoding: 'utf8', shell: windows, stdio: ['ignore', 'pipe', 'pipe'] });
}

function readOr(file, otherwise) {
  return statSync(file, { throwIfNoEntry: false }) ? readFileSync(file, 'utf8') : otherwise;
}

const run = promisify(execFile);

/**
 * Returns the blocks of a recipe that name a file after their language, by this name.
 *
 * @param {string} name the heading of its section in docs/recipes.md
 * @returns {Map<string, string>}
 */
export function recipe(name) {
  const text = readFileSync(join(root, 'docs', 'recipes.md'), 'utf8').replaceAll('\r', '');
  const section = text.split(/^## /m).find((part) => part.startsWith(`${name}\n`));
  return new Map([...section.matchAll(/^```\w+ (\S+)\n([^]*?)^```$/gm)].map(([, file, code]) => [file, code]));
}

/**
 * Creates a folder with the application of tests/package, the tarball, tools, and more files.
 *
 * @param {{after: (clean: () => void) => void}} t
 * @param {{tools?: Record<string, string>, recipe?: string, files?: Record<string, string>}} options
 * @returns {Promise<string>} the folder
 */
export async function project(t, { tools = {}, recipe: name, files = {} }) {
  const folder = installed(t, 'tests/package/app');
  const versions = Object.entries(tools).map(([tool, version]) => `${tool}@${version}`);
  if (versions.length > 0)
    await execute(folder, 'npm', ['install', '--no-audit', '--no-fund', '--prefer-offline', ...versions]);
  for (const [file, text] of [...(name ? recipe(name) : []), ...Object.entries(files)]) {
    mkdirSync(dirname(join(folder, file)), { recursive: true });
    writeFileSync(join(folder, file), text);
  }
  return folder;
}

/** Runs a program in a folder and returns its output; the error of a failure has the output too. */
export async function execute(folder, program, args, env = {}) {
  const options = { cwd: folder, maxBuffer: 2 ** 26, env: { ...process.env, CI: '1', NO_COLOR: '1', ...env } };
  try {
    const { stdout } = await run(program, args, options);
    return stdout;
  } catch (error) {
    throw new Error(`${program} ${args.join(' ')}\n${error.stdout}\n${error.stderr}`, { cause: error });
  }
}

/** Installs another version of Node for this machine and returns its path. */
export async function nodeOf(t, version) {
  const name = `node-${process.platform}-${process.arch}`;
  const folder = await project(t, { tools: { [name]: version } });
  const program = join(folder, 'node_modules', name, 'bin', 'node');
  chmodSync(program, 0o755);
  return program;
}

/** An entry of the application that imports the setup of a recipe first. */
export const MAIN = `import './setup.js';
import { outcome, throughVideo } from './segment.js';

globalThis.outcome = Promise.all([outcome(), throughVideo()]);
`;

/** Returns a port of this machine that is free. */
export async function freePort() {
  const server = createServer();
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  const { port } = server.address();
  await new Promise((resolve) => server.close(resolve));
  return port;
}
