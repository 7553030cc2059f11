// `npm run release -- --local [PART ...]`: makes what a release publishes, in `out/`, and prints how to install each part.

import { chmodSync, copyFileSync, mkdirSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { build } from '../build.mjs';
import { checkComplete } from '../pack.mjs';
import { packed } from '../size.mjs';
import {
  during,
  ensureNodeModules,
  ensureRust,
  exe,
  fail,
  findProgram,
  output,
  root,
  run,
  runBeside,
} from '../tools.mjs';

const out = join(root, 'out');

/** The parts: each makes a file or folder of `out`, and returns it with the command that installs it. */
export const PARTS = { npm: packNpm, python: buildWheel, cli: buildProgram, crate: packCrates, docs: writeReference };

/** The oldest Python with a wheel. */
const PYTHON = '3.9';

/**
 * @param {string[]} names of parts; all without any
 * @param {string} version
 */
export async function makeLocally(names, version) {
  const unknown = names.find((name) => !Object.hasOwn(PARTS, name));
  if (unknown) fail(`There is no part "${unknown}" (expected ${Object.keys(PARTS).join(', ')}).`);
  ensureNodeModules();
  ensureRust();
  mkdirSync(out, { recursive: true });
  const made = [];
  for (const name of names.length > 0 ? names : Object.keys(PARTS)) made.push(await PARTS[name](version, names));
  console.log(`\nMade in ${out}:\n`);
  for (const { files, install } of made.filter(Boolean)) console.log(`  ${files.join(', ')}\n      ${install}\n`);
}

async function packNpm() {
  await build();
  const { filename, files } = packed('--pack-destination', out);
  const paths = new Set(files.map(({ path }) => path));
  checkComplete((path) => paths.has(path));
  return { files: [filename], install: `npm install ${join(out, filename)}` };
}

/** Builds the wheel; without Python, only if it was asked for by name. */
async function buildWheel(version, names) {
  const python = findProgram('python3', 'python');
  const [major, minor] = PYTHON.split('.');
  const check = `import sys, pip; sys.exit(sys.version_info < (${major}, ${minor}))`;
  if (python === null || output(python, ['-c', check]) === null) {
    const reason = `The wheel needs Python ${PYTHON} or newer with pip.`;
    if (names.includes('python')) fail(reason);
    console.log(`!!! SKIPPED: ${reason}`);
    return null;
  }
  const args = ['-m', 'pip', 'wheel', '--quiet', '--no-deps', '--wheel-dir', out, join(root, 'python')];
  await during('building the wheel', 240, () => runBeside(python, args));
  const wheels = readdirSync(out).filter((name) => name.startsWith(`tracecut-${version}-`) && name.endsWith('.whl'));
  return { files: wheels, install: `pip install ${join(out, wheels[0])}` };
}

async function buildProgram() {
  const args = ['build', '--quiet', '--locked', '--release', '--package', 'tracecut-cli'];
  await during('building the program', 180, () => runBeside('cargo', args));
  const file = `tracecut${exe}`;
  copyFileSync(join(root, 'target', 'release', file), join(out, file));
  chmodSync(join(out, file), 0o755);
  return { files: [file], install: 'copy it to a folder on the PATH' };
}

async function packCrates(version) {
  const packages = ['tracecut', 'tracecut-cli'];
  const names = packages.flatMap((name) => ['--package', name]);
  run('cargo', ['package', '--quiet', '--locked', '--no-verify', '--allow-dirty', ...names]);
  const files = packages.map((name) => `${name}-${version}.crate`);
  for (const file of files) copyFileSync(join(root, 'target', 'package', file), join(out, file));
  return { files, install: `cargo add tracecut --path ${root}` };
}

async function writeReference() {
  await build();
  run('npm', ['run', '--silent', 'docs']);
  return { files: ['docs/'], install: `open ${join(out, 'docs', 'index.html')}` };
}
