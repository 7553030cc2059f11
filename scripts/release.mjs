// `npm run release -- --dry-run`: builds the crate and the npm package as they would be published, checks both, and
// lists what is in them. Nothing is published and nothing is tagged: that is done by a person, and without `--dry-run`
// this only says how.

import { mkdirSync, readFileSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { parseArgs } from 'node:util';
import { build } from './build.mjs';
import { ensureNodeModules, fail, output, root, run } from './tools.mjs';

/** Where each file that names the version names it; of the changelog, the newest version with a date. */
const VERSIONS = {
  'Cargo.toml': /^version = "([^"]+)"$/m,
  'Cargo.lock': /^name = "tracecut"\nversion = "([^"]+)"$/m,
  'package.json': /^ {2}"version": "([^"]+)",$/m,
  'package-lock.json': /^ {2}"version": "([^"]+)",$/m,
  'CHANGELOG.md': /^## \[(\d[^\]]*)\] - \d{4}-\d\d-\d\d$/m,
  'CITATION.cff': /^version: (\S+)$/m,
};
/** Where the two files that have it name the day of the release. */
const DATES = {
  'CHANGELOG.md': /^## \[\d[^\]]*\] - (\d{4}-\d\d-\d\d)$/m,
  'CITATION.cff': /^date-released: (\S+)$/m,
};
/** The files that name the version. */
export const FILES = Object.keys(VERSIONS);

/** Where the packages are made. */
const packages = join(root, 'target', 'package');

/**
 * The version, and in words where the files disagree or name none.
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

/** What the changelog says of a version, without its heading; empty when it says nothing. */
export function notesOf(changelog, version) {
  const sections = changelog.replaceAll('\r', '').split(/^(?=## |\[[^\]]+\]: )/m);
  const section = sections.find((text) => text.startsWith(`## [${version}]`)) ?? '';
  return section.replace(/^.*\n/, '').trim();
}

/** The name of a version's tag. */
export const tagOf = (version) => `v${version}`;

/** What a person types to publish a version that the dry run found in order. */
export function byHand(version) {
  const tag = tagOf(version);
  return [
    'npm run release -- --dry-run',
    `git tag --annotate ${tag} --message ${tag}`,
    `git push origin ${tag}`,
    'cargo publish --locked',
    `npm publish target/package/tracecut-${version}.tgz`,
  ];
}

/** A list of files with their bytes, largest first, and their sum. */
export function listing(files) {
  const line = (bytes, words) => `${bytes.toLocaleString('en').padStart(12)}  ${words}`;
  const sum = files.reduce((total, { size }) => total + size, 0);
  const largest = [...files].sort((a, b) => b.size - a.size || (a.path < b.path ? -1 : 1));
  return [...largest.map(({ path, size }) => line(size, path)), line(sum, `in ${files.length} files`)].join('\n');
}

function checkVersion() {
  const { version, faults } = versionOf((file) => readFileSync(join(root, file), 'utf8'));
  if (faults.length > 0) fail(faults.join('\n'));
  if (!notesOf(readFileSync(join(root, 'CHANGELOG.md'), 'utf8'), version))
    fail(`CHANGELOG.md says nothing of ${version}.`);
  return version;
}

function checkTree(version) {
  const changed = output('git', ['status', '--porcelain']);
  if (changed === null) fail('This is no git repository.');
  if (changed) fail(`Commit these first:\n${changed}`);
  if (output('git', ['tag', '--list', tagOf(version)])) fail(`The tag ${tagOf(version)} is there already.`);
}

/** Packs the crate, builds it with the command line from what was packed, and has cargo say that it would publish it. */
function packCrate(version) {
  run('cargo', ['package', '--locked', '--package', 'tracecut', '--features', 'cli']);
  run('cargo', ['publish', '--locked', '--package', 'tracecut', '--dry-run', '--no-verify']);
  const list = output('cargo', ['package', '--locked', '--package', 'tracecut', '--list']);
  // Cargo leaves what it built from: the files as they are in the crate.
  const folder = join(packages, `tracecut-${version}`);
  return list.split('\n').map((path) => ({ path, size: statSync(join(folder, path)).size }));
}

/** Builds and packs the npm package, and has both linters look at the very file. */
async function packNpm(version) {
  await build();
  mkdirSync(packages, { recursive: true });
  const printed = output('npm', ['pack', '--json', '--ignore-scripts', '--pack-destination', packages]);
  if (printed === null) fail('npm pack failed.');
  const packed = JSON.parse(printed);
  const { files } = Array.isArray(packed) ? packed[0] : Object.values(packed)[0];
  const tarball = join(packages, `tracecut-${version}.tgz`);
  const tool = (script, ...args) => run(process.execPath, [join('node_modules', script), ...args]);
  tool('publint/src/cli.js', 'run', tarball, '--strict');
  tool('@arethetypeswrong/cli/dist/index.js', tarball);
  return { tarball, files };
}

async function dryRun() {
  ensureNodeModules();
  const version = checkVersion();
  checkTree(version);
  const { tarball, files } = await packNpm(version);
  const crate = packCrate(version);
  console.log(`\nThe crate, ${statSync(join(packages, `tracecut-${version}.crate`)).size} bytes packed:`);
  console.log(listing(crate));
  console.log(`\nThe npm package, ${statSync(tarball).size} bytes packed:`);
  console.log(listing(files));
  console.log(`\nBoth are in order; the tag is ${tagOf(version)}. Nothing was published. By hand:`);
  console.log(byHand(version).slice(1).join('\n'));
}

function options() {
  try {
    return parseArgs({ options: { 'dry-run': { type: 'boolean', default: false } } }).values;
  } catch (error) {
    return fail(`${error.message}\nUsage: npm run release -- --dry-run`);
  }
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) {
  if (options()['dry-run']) await dryRun();
  else fail(`A release is made by hand:\n  ${byHand(checkVersion()).join('\n  ')}`);
}
