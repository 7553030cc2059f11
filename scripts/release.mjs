// `npm run release -- --local` makes all packages in `out/` and prints how to install them.
// `npm run release -- --dry-run`: builds the crate and the npm package as they would be published, checks both, and
// lists their files. Nothing is published or tagged: a person tags, and .github/workflows/release.yml runs `--publish` at
// the tag, where the registry can verify who built the package and from what (provenance). Without an option, this prints
// the steps.

import { chmodSync, copyFileSync, mkdirSync, readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { parseArgs } from 'node:util';
import { build } from './build.mjs';
import { LICENCES, writeLicences } from './licences.mjs';
import { checkComplete, readManifest } from './pack.mjs';
import { checkSizes, packed } from './size.mjs';
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
} from './tools.mjs';

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
  await ensureNodeModules();
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

/** True once a version is on the registries: documents then name its packages, else the ones of `--local`. A test compares. */
export const IS_PUBLISHED = false;

/** The version in each file that has one; in the changelog, the newest version with a date. */
const VERSIONS = {
  'Cargo.toml': /^version = "([^"]+)"$/m,
  'cli/Cargo.toml': /^version = "([^"]+)"$/m,
  'Cargo.lock': /^name = "tracecut"\nversion = "([^"]+)"$/m,
  'package.json': /^ {2}"version": "([^"]+)",$/m,
  'package-lock.json': /^ {2}"version": "([^"]+)",$/m,
  'CHANGELOG.md': /^## \[(\d[^\]]*)\] - \d{4}-\d\d-\d\d$/m,
  'README.md': /\/npm\/tracecut@([^/]+)\/dist\/inline\.js/,
  'CITATION.cff': /^version: (\S+)$/m,
};
/** The date of the release in the two files that have it. */
const DATES = {
  'CHANGELOG.md': /^## \[\d[^\]]*\] - (\d{4}-\d\d-\d\d)$/m,
  'CITATION.cff': /^date-released: (\S+)$/m,
};
/** The folder for the packages. */
const packages = join(root, 'target', 'package');

/**
 * Returns the version, and a message for each file that disagrees or has none.
 * @param {(file: string) => string} read a file's text
 * @returns {{version: string | undefined, faults: string[]}}
 */
export function versionOf(read) {
  const found = (patterns) => Object.entries(patterns).map(([file, pattern]) => [file, pattern.exec(text(file))?.[1]]);
  const text = (file) => read(file).replaceAll('\r', '');
  const versions = found(VERSIONS);
  const faults = [...disagreement('version', versions), ...disagreement('date', found(DATES))];
  return { version: versions[0][1], faults };
}

function disagreement(what, found) {
  const missing = found.filter(([, value]) => value === undefined);
  if (missing.length > 0) return missing.map(([file]) => `${file} names no ${what}.`);
  if (new Set(found.map(([, value]) => value)).size === 1) return [];
  return [`The ${what}s differ: ${found.map(([file, value]) => `${value} in ${file}`).join(', ')}.`];
}

/** Returns the changelog's text on a version, without its heading; empty if there is none. */
export function notesOf(changelog, version) {
  const sections = changelog.replaceAll('\r', '').split(/^(?=## |\[[^\]]+\]: )/m);
  const section = sections.find((text) => text.startsWith(`## [${version}]`)) ?? '';
  return section.replace(/^.*\n/, '').trim();
}

const tagOf = (version) => `v${version}`;

/** Returns the commands that a person runs to publish a version: the tag starts the workflow. */
function byHand(version) {
  const tag = tagOf(version);
  return ['npm run release -- --dry-run', `git tag --annotate ${tag} --message ${tag}`, `git push origin ${tag}`];
}

/**
 * Lists what prevents publishing with provenance from here: the registry trusts a build service that signs for the commit,
 * so this must be one, at the tag of this version.
 * @param {string} version
 * @param {Record<string, string | undefined>} env
 * @param {any} manifest of the package
 * @returns {string[]}
 */
export function obstacles(version, env, manifest) {
  const repository = /github\.com\/([^/]+\/[^/.]+)/.exec(manifest.repository?.url ?? '')?.[1];
  const found = [];
  if (!env.GITHUB_ACTIONS) return ['Publishing is for the workflow release.yml: push the tag.'];
  if (!env.ACTIONS_ID_TOKEN_REQUEST_URL) found.push('The workflow has no permission "id-token: write".');
  if (env.GITHUB_REF !== `refs/tags/${tagOf(version)}`)
    found.push(`The workflow runs at ${env.GITHUB_REF} (expected refs/tags/${tagOf(version)}).`);
  if (env.GITHUB_REPOSITORY !== repository)
    found.push(`This is ${env.GITHUB_REPOSITORY}, and package.json names ${repository} as the source.`);
  if (manifest.publishConfig?.provenance !== true) found.push('package.json has no publishConfig.provenance.');
  return found;
}

function checkVersion() {
  const { version, faults } = versionOf((file) => readFileSync(join(root, file), 'utf8'));
  if (faults.length > 0) fail(faults.join('\n'));
  if (!notesOf(readFileSync(join(root, 'CHANGELOG.md'), 'utf8'), version))
    fail(`CHANGELOG.md has no entry for ${version}.`);
  return version;
}

function checkTree() {
  const changed = output('git', ['status', '--porcelain']);
  if (changed === null) fail('This is not a git repository.');
  if (changed) fail(`Commit these first:\n${changed}`);
}

function checkTag(version) {
  if (output('git', ['tag', '--list', tagOf(version)])) fail(`The tag ${tagOf(version)} already exists.`);
}

/** Packs the crates, builds them from the packed files, and does a dry run of publishing the library. */
function checkCrates() {
  run('cargo', ['package', '--locked', '--package', 'tracecut', '--package', 'tracecut-cli']);
  run('cargo', ['publish', '--locked', '--package', 'tracecut', '--dry-run', '--no-verify']);
  run('cargo', ['package', '--locked', '--package', 'tracecut', '--list']);
}

/** Builds and packs the npm package, and runs both linters on the file. @returns {Promise<string>} the file */
async function checkNpm(version) {
  await build();
  writeLicences(join(root, 'dist'));
  await checkSizes();
  mkdirSync(packages, { recursive: true });
  const { files } = packed('--pack-destination', packages);
  const paths = new Set(files.map(({ path }) => path));
  checkComplete((path) => paths.has(path), [`dist/${LICENCES}`]);
  const tarball = join(packages, `tracecut-${version}.tgz`);
  const tool = (script, ...args) => run(process.execPath, [join('node_modules', script), ...args]);
  tool('publint/src/cli.js', 'run', tarball, '--strict');
  tool('@arethetypeswrong/cli/dist/index.js', tarball);
  return tarball;
}

/** Builds both packages and checks them. */
async function check() {
  await ensureNodeModules();
  const version = checkVersion();
  checkTree();
  const tarball = await checkNpm(version);
  checkCrates();
  return { version, tarball };
}

async function dryRun() {
  checkTag(checkVersion());
  const { version, tarball } = await check();
  // npm lists the files and checks the manifest as for publishing; nothing is signed here.
  run('npm', ['publish', tarball, '--no-provenance', '--access', 'public', '--dry-run', '--ignore-scripts']);
  console.log(`\n${tarball} and the crates are in order; nothing was published. To publish them:`);
  console.log(byHand(version).slice(1).join('\n'));
}

/** Publishes the checked files; only in the workflow. */
async function publish() {
  const faults = obstacles(checkVersion(), process.env, readManifest());
  if (!IS_PUBLISHED)
    faults.push('The documents say that nothing is published: set IS_PUBLISHED in scripts/release.mjs.');
  if (faults.length > 0) fail(faults.join('\n'));
  const { tarball } = await check();
  run('npm', ['publish', tarball, '--provenance', '--access', 'public']);
  run('cargo', ['publish', '--locked', '--package', 'tracecut']);
  run('cargo', ['publish', '--locked', '--package', 'tracecut-cli']);
}

function options() {
  const flag = { type: 'boolean', default: false };
  try {
    const options = { local: flag, 'dry-run': flag, publish: flag, notes: flag };
    const { values, positionals } = parseArgs({ options, allowPositionals: true });
    if (positionals.length > 0 && !values.local) throw new Error(`Unexpected argument '${positionals[0]}'`);
    return { ...values, parts: positionals };
  } catch (error) {
    return fail(`${error.message}\nUsage: npm run release -- --local [PART ...] | --dry-run`);
  }
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) {
  const chosen = options();
  if (chosen.local) await makeLocally(chosen.parts, checkVersion());
  else if (chosen['dry-run']) await dryRun();
  else if (chosen.publish) await publish();
  else if (chosen.notes) console.log(notesOf(readFileSync(join(root, 'CHANGELOG.md'), 'utf8'), checkVersion()));
  else fail(`A release is made by hand:\n  ${byHand(checkVersion()).join('\n  ')}`);
}
