// `npm run release -- --dry-run`: builds the crate and the npm package as they would be published, checks both, and
// lists what is in them. Nothing is published and nothing is tagged: a person tags, and .github/workflows/release.yml
// runs `--publish` at the tag, where the registry can be told by whom and from what the package was built (provenance).
// Without an option this only says how.

import { mkdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { parseArgs } from 'node:util';
import { build } from './build.mjs';
import { LICENCES, writeLicences } from './licences.mjs';
import { checkSizes, packed } from './size.mjs';
import { ensureNodeModules, fail, output, root, run } from './tools.mjs';

/** Where each file that names the version names it; of the changelog, the newest version with a date. */
const VERSIONS = {
  'Cargo.toml': /^version = "([^"]+)"$/m,
  'cli/Cargo.toml': /^version = "([^"]+)"$/m,
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

const tagOf = (version) => `v${version}`;

/** What a person types to publish a version: the tag makes the workflow publish it. */
function byHand(version) {
  const tag = tagOf(version);
  return ['npm run release -- --dry-run', `git tag --annotate ${tag} --message ${tag}`, `git push origin ${tag}`];
}

/**
 * What keeps a package from being published with provenance from here, in words: the registry takes the word of a build
 * service that signs for the commit, so it has to be one, at the tag of this very version.
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
    fail(`CHANGELOG.md says nothing of ${version}.`);
  return version;
}

function checkTree() {
  const changed = output('git', ['status', '--porcelain']);
  if (changed === null) fail('This is no git repository.');
  if (changed) fail(`Commit these first:\n${changed}`);
}

function checkTag(version) {
  if (output('git', ['tag', '--list', tagOf(version)])) fail(`The tag ${tagOf(version)} is there already.`);
}

/** Packs the crates, builds them from what was packed, and has cargo say that it would publish the library. */
function packCrates() {
  run('cargo', ['package', '--locked', '--package', 'tracecut', '--package', 'tracecut-cli']);
  run('cargo', ['publish', '--locked', '--package', 'tracecut', '--dry-run', '--no-verify']);
  run('cargo', ['package', '--locked', '--package', 'tracecut', '--list']);
}

/** Builds and packs the npm package, and has both linters look at the very file. @returns {Promise<string>} the file */
async function packNpm(version) {
  await build();
  writeLicences(join(root, 'dist'));
  await checkSizes();
  mkdirSync(packages, { recursive: true });
  const { files } = packed('--pack-destination', packages);
  const missing = absent(files.map(({ path }) => path));
  if (missing.length > 0) fail(`The package lacks ${missing.join(', ')}.`);
  const tarball = join(packages, `tracecut-${version}.tgz`);
  const tool = (script, ...args) => run(process.execPath, [join('node_modules', script), ...args]);
  tool('publint/src/cli.js', 'run', tarball, '--strict');
  tool('@arethetypeswrong/cli/dist/index.js', tarball);
  return tarball;
}

/** Which of the files that a package must not go without are not among these. */
export function absent(paths) {
  const needed = ['LICENSE-MIT', 'LICENSE-APACHE', 'README.md', `dist/${LICENCES}`];
  return needed.filter((path) => !paths.includes(path));
}

/** Makes both packages and checks them. */
async function check() {
  ensureNodeModules();
  const version = checkVersion();
  checkTree();
  const tarball = await packNpm(version);
  packCrates();
  return { version, tarball };
}

async function dryRun() {
  checkTag(checkVersion());
  const { version, tarball } = await check();
  // npm lists what is in the file and looks at the manifest as it does when it publishes; here nobody signs.
  run('npm', ['publish', tarball, '--no-provenance', '--access', 'public', '--dry-run', '--ignore-scripts']);
  console.log(`\n${tarball} and the crates are in order; nothing was published. To publish them:`);
  console.log(byHand(version).slice(1).join('\n'));
}

/** Publishes the files that were checked; only in the workflow. */
async function publish() {
  const manifest = JSON.parse(readFileSync(join(root, 'package.json'), 'utf8'));
  const faults = obstacles(checkVersion(), process.env, manifest);
  if (faults.length > 0) fail(faults.join('\n'));
  const { tarball } = await check();
  run('npm', ['publish', tarball, '--provenance', '--access', 'public']);
  run('cargo', ['publish', '--locked', '--package', 'tracecut']);
  run('cargo', ['publish', '--locked', '--package', 'tracecut-cli']);
}

function options() {
  const flag = { type: 'boolean', default: false };
  try {
    return parseArgs({ options: { 'dry-run': flag, publish: flag } }).values;
  } catch (error) {
    return fail(`${error.message}\nUsage: npm run release -- --dry-run`);
  }
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) {
  const chosen = options();
  if (chosen['dry-run']) await dryRun();
  else if (chosen.publish) await publish();
  else fail(`A release is made by hand:\n  ${byHand(checkVersion()).join('\n  ')}`);
}
