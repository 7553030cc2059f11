// The Rust crates that are compiled into the two wasm files, or into the Python module, as Cargo resolves them, and the
// standard library.

import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { homedir } from 'node:os';
import { join } from 'node:path';
import { fail, output, root } from '../tools.mjs';
import { noticesIn, plainMit } from './notices.mjs';

/**
 * Files with what Cargo builds each from, and those that hold them all.
 * @typedef {{target: string, files: Record<string, string[]>, all: string[]}} Build
 */

/** @type {Build} the npm package: of its builds in one file, one holds both wasm files */
export const NPM = {
  target: 'wasm32-unknown-unknown',
  files: {
    'tracecut_bg.wasm': ['--package', 'tracecut', '--features', 'wasm'],
    'decoder_bg.wasm': ['--package', 'tracecut-decoder'],
  },
  all: ['inline.js'],
};
/** @type {Build} the wheel for Python */
export const WHEEL = {
  target: 'x86_64-unknown-linux-gnu',
  files: { 'tracecut/_tracecut.abi3.so': ['--package', 'tracecut-python'] },
  all: [],
};
const OURS = ['tracecut', 'tracecut-decoder', 'tracecut-python'];

/**
 * Lines of `cargo tree` as packages with their depths. Procedural macros are left out: they run while compiling.
 * @param {string} text
 */
export function treeLines(text) {
  return text.split('\n').map((line) => {
    const found = /^(\d+)\|(\S+) v([^\s|]+)[^|]*\|([^|]*)\|([^|]*?)(?: \(\*\))?$/.exec(line.trim());
    if (!found) throw new Error(`cargo tree says "${line}", which is no package.`);
    const [, depth, name, version, licence, source] = found;
    const expression = licence.replace(/\s*\/\s*/g, ' OR ');
    return { depth: Number(depth), name, version, licence: expression, source: source.replace(/\.git$/, '') };
  });
}

function treeOf(target, which) {
  const args = ['tree', '--locked', '--offline', '--target', target, ...which];
  const shape = ['--edges', 'normal,no-proc-macro', '--prefix', 'depth', '--format', '|{p}|{l}|{r}'];
  const text = output('cargo', [...args, ...shape]);
  if (text === null) fail(`cargo tree ${which.join(' ')} failed; build the package first.`);
  return treeLines(text);
}

/** Identifier of a crate. */
const purlOf = ({ name, version }) => `pkg:cargo/${name}@${version}`;

/**
 * The crates of all files of a build with their licences, and which of them our own code uses directly.
 * @param {Build} build
 * @returns {{parts: import('./sbom.mjs').Part[], direct: string[]}}
 */
export function cargoParts({ target, files, all }) {
  const checksums = checksumsOf(readFileSync(join(root, 'Cargo.lock'), 'utf8'));
  const [parts, direct] = [new Map(), new Set()];
  for (const [file, which] of Object.entries(files)) {
    const above = [];
    for (const line of treeOf(target, which)) {
      above.length = line.depth;
      above.push(line);
      if (OURS.includes(line.name)) continue;
      const purl = purlOf(line);
      if (!parts.has(purl)) parts.set(purl, partOf(line, checksums));
      for (const holder of [file, ...all]) parts.get(purl).files.add(holder);
      const user = above[line.depth - 1];
      (OURS.includes(user.name) ? direct : parts.get(purlOf(user)).uses).add(purl);
    }
  }
  return { parts: [...parts.values()], direct: [...direct] };
}

function partOf({ name, version, licence, source }, checksums) {
  const hash = checksums.get(`${name} ${version}`);
  if (!hash) fail(`Cargo.lock has no checksum of ${name} ${version}.`);
  const folder = sourceFolder(name, version);
  const manifest = readFileSync(join(folder, 'Cargo.toml'), 'utf8');
  const author = /^authors = \[\s*"([^"<]+?)\s*[<"]/m.exec(manifest)?.[1] ?? `The ${name} developers`;
  const notices = noticesIn(folder, licence, `Copyright (c) ${author}`);
  const purl = purlOf({ name, version });
  const hashes = [{ alg: 'SHA-256', content: hash }];
  return { purl, name, version, licence, source, hashes, notices, files: new Set(), uses: new Set() };
}

/** The version of the compiler at hand, whose standard library is built in. */
export function rustVersion() {
  const version = /^rustc (\S+)/.exec(output('rustc', ['--version']) ?? '')?.[1];
  return version ?? fail('rustc does not say its version.');
}

/** The checksums of a lock file, by name and version. @param {string} lock */
export function checksumsOf(lock) {
  const pattern = /name = "([^"]+)"\nversion = "([^"]+)"\nsource = "[^"]+"\nchecksum = "([0-9a-f]{64})"/g;
  const found = [...lock.replaceAll('\r', '').matchAll(pattern)];
  return new Map(found.map(([, name, version, checksum]) => [`${name} ${version}`, checksum]));
}

/** Where Cargo has unpacked a crate. */
function sourceFolder(name, version) {
  const unpacked = join(process.env.CARGO_HOME ?? join(homedir(), '.cargo'), 'registry', 'src');
  const registries = existsSync(unpacked) ? readdirSync(unpacked).sort() : [];
  const folder = registries.map((one) => join(unpacked, one, `${name}-${version}`)).find(existsSync);
  return folder ?? fail(`The source of ${name} ${version} is not in ${unpacked}; build the package first.`);
}

/**
 * Rust's standard library, which is in all files too, with the crates that it is built with.
 * @param {Build} build
 * @param {string} version
 * @returns {import('./sbom.mjs').Part}
 */
export function standardLibrary({ files, all }, version) {
  const holders = ['The Rust Project Developers', '2014 Alex Crichton (backtrace, dlmalloc)'];
  const notices = [plainMit(holders.map((one) => `Copyright (c) ${one}`).join('\n'))];
  return {
    purl: `pkg:generic/rust-std@${version}`,
    name: 'rust-std',
    version,
    licence: 'MIT OR Apache-2.0',
    source: 'https://github.com/rust-lang/rust',
    hashes: [],
    notices,
    files: new Set([...Object.keys(files), ...all]),
    uses: new Set(),
  };
}
