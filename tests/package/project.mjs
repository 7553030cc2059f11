// A project with the packed tarball, tools at pinned versions, and an unchanged recipe of docs/recipes.

import { execFile } from 'node:child_process';
import { chmodSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { promisify } from 'node:util';
import { root } from '../../scripts/tools.mjs';
import { installed } from './installed.mjs';

const run = promisify(execFile);

/**
 * Returns the blocks of a recipe that name a file after their language, by this name.
 *
 * @param {string} name of the page in docs/recipes
 * @returns {Map<string, string>}
 */
export function recipe(name) {
  const text = readFileSync(join(root, 'docs', 'recipes', `${name}.md`), 'utf8').replaceAll('\r', '');
  return new Map([...text.matchAll(/^```\w+ (\S+)\n([^]*?)^```$/gm)].map(([, file, code]) => [file, code]));
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
