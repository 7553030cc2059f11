// The Rust crates that are compiled into the two wasm files, as Cargo resolves them, and the standard library.

import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { homedir } from 'node:os';
import { join } from 'node:path';
import { fail, output, root } from '../tools.mjs';
import { noticesIn, plainMit } from './notices.mjs';

/** Each wasm file with what Cargo builds it from. */
const BUILDS = {
  'tracecut_bg.wasm': ['--package', 'tracecut', '--features', 'wasm'],
  'decoder_bg.wasm': ['--package', 'tracecut-decoder'],
};
/** The build in one file holds both. */
const INLINE = 'inline.js';
const OURS = ['tracecut', 'tracecut-decoder'];

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

function treeOf(which) {
  const args = ['tree', '--locked', '--offline', '--target', 'wasm32-unknown-unknown', ...which];
  const shape = ['--edges', 'normal,no-proc-macro', '--prefix', 'depth', '--format', '|{p}|{l}|{r}'];
  const text = output('cargo', [...args, ...shape]);
  if (text === null) fail(`cargo tree ${which.join(' ')} failed; build the wasm files first.`);
  return treeLines(text);
}

/** Identifier of a crate. */
const purlOf = ({ name, version }) => `pkg:cargo/${name}@${version}`;

/**
 * The crates of both files with their licences, and which of them our own code uses directly.
 * @returns {{parts: import('./sbom.mjs').Part[], direct: string[]}}
 */
export function cargoParts() {
  const checksums = checksumsOf(readFileSync(join(root, 'Cargo.lock'), 'utf8'));
  const [parts, direct] = [new Map(), new Set()];
  for (const [file, which] of Object.entries(BUILDS)) {
    const above = [];
    for (const line of treeOf(which)) {
      above.length = line.depth;
      above.push(line);
      if (OURS.includes(line.name)) continue;
      const purl = purlOf(line);
      if (!parts.has(purl)) parts.set(purl, partOf(line, checksums));
      parts.get(purl).files.add(file).add(INLINE);
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
  return folder ?? fail(`The source of ${name} ${version} is not in ${unpacked}; build the wasm files first.`);
}

/**
 * Rust's standard library, which is in both files too, with the crates that it is built with.
 * @returns {import('./sbom.mjs').Part}
 */
export function standardLibrary() {
  const version = /^rustc (\S+)/.exec(output('rustc', ['--version']) ?? '')?.[1];
  if (!version) fail('rustc does not say its version.');
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
    files: new Set([...Object.keys(BUILDS), INLINE]),
    uses: new Set(),
  };
}
