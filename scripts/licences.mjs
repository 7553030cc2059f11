// What of other people's work is in the npm package, from Cargo's and npm's own records: their licences as
// `dist/THIRD-PARTY-LICENSES.txt`, and the bill of materials `dist/sbom.cdx.json` (CycloneDX). No clock and no
// randomness: the same lock files and toolchain give the same bytes. `node scripts/licences.mjs` writes both, and
// `python/THIRD-PARTY-LICENSES.txt` for the wheel, which is committed: whoever builds it has no need of Node.
// `--print-wheel` prints that one instead.

import { existsSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { homedir } from 'node:os';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { licencesText, noticesIn, plainMit } from './notices.mjs';
import { fail, output, root } from './tools.mjs';

/**
 * @typedef {object} Part
 * @property {string} purl its identifier among all registries
 * @property {string} name
 * @property {string} version
 * @property {string} licence what it offers, as an SPDX expression
 * @property {string} source where its source is
 * @property {{alg: string, content: string}[]} hashes of the archive that the lock file names
 * @property {import('./notices.mjs').Notice[]} notices the licences taken
 * @property {Set<string>} files that hold it
 * @property {Set<string>} uses identifiers of what it is built with
 */

/** The names of the two files, in `dist/` and in the package. */
export const LICENCES = 'THIRD-PARTY-LICENSES.txt';
export const BILL = 'sbom.cdx.json';

/** The libraries whose JavaScript the package carries within, and the files of `dist/` that hold it. */
export const VENDORED = {
  mediabunny: ['vendor/media.js', 'inline.js'],
  fflate: ['vendor/zip.js', 'inline.js', 'node/all.cjs', 'worker.bundle.js'],
};

/** Files with what Cargo builds each from, and those that hold them all. */
const NPM = {
  target: 'wasm32-unknown-unknown',
  files: {
    'tracecut_bg.wasm': ['--package', 'tracecut', '--features', 'wasm'],
    'decoder_bg.wasm': ['--package', 'tracecut-decoder'],
  },
  all: ['inline.js'],
};
const WHEEL = {
  target: 'x86_64-unknown-linux-gnu',
  files: { 'tracecut/_tracecut.abi3.so': ['--package', 'tracecut-python'] },
  all: [],
};
const OURS = ['tracecut', 'tracecut-decoder', 'tracecut-python'];

const read = (...path) => readFileSync(join(root, ...path), 'utf8').replaceAll('\r', '');
const inOrder = (parts) => parts.sort((a, b) => (a.purl < b.purl ? -1 : 1));

/** The crates of all files of a build, without procedural macros, and which of them our own code uses directly. */
function cargoParts({ target, files, all }) {
  const [parts, direct] = [new Map(), new Set()];
  for (const [file, which] of Object.entries(files)) {
    const above = [];
    for (const { depth, ...crate } of treeOf(target, which)) {
      above.length = depth;
      above.push(crate);
      if (OURS.includes(crate.name)) continue;
      if (!parts.has(crate.purl)) parts.set(crate.purl, cratePart(crate));
      for (const holder of [file, ...all]) parts.get(crate.purl).files.add(holder);
      const user = above[depth - 1];
      (OURS.includes(user.name) ? direct : parts.get(user.purl).uses).add(crate.purl);
    }
  }
  return { parts: [...parts.values()], direct: [...direct] };
}

function treeOf(target, which) {
  const args = ['tree', '--locked', '--offline', '--target', target, ...which];
  const shape = ['--edges', 'normal,no-proc-macro', '--prefix', 'depth', '--format', '|{p}|{l}|{r}'];
  const text = output('cargo', [...args, ...shape]) ?? fail(`cargo tree ${which} failed; build the package first.`);
  return text.split('\n').map((line) => {
    const [, depth, name, version, licence, source] =
      /^(\d+)\|(\S+) v([^\s|]+)[^|]*\|([^|]*)\|([^|]*?)(?: \(\*\))?$/.exec(line.trim()) ?? fail(`cargo tree: ${line}`);
    const purl = `pkg:cargo/${name}@${version}`;
    const expression = licence.replace(/\s*\/\s*/g, ' OR ');
    return { depth: Number(depth), purl, name, version, licence: expression, source: source.replace(/\.git$/, '') };
  });
}

function cratePart(crate) {
  const { name, version, licence } = crate;
  const entry = `name = "${name}"\nversion = "${version}"\n`;
  const content = /checksum = "(.*)"/.exec(read('Cargo.lock').split(entry)[1] ?? '')?.[1];
  const folder = sourceFolder(`${name}-${version}`);
  const author = /^authors = \[\s*"([^"<]+?)\s*[<"]/m.exec(readFileSync(join(folder, 'Cargo.toml'), 'utf8'))?.[1];
  const notices = noticesIn(folder, licence, `Copyright (c) ${author ?? `The ${name} developers`}`);
  return { ...crate, hashes: [{ alg: 'SHA-256', content }], notices, files: new Set(), uses: new Set() };
}

/** Where Cargo has unpacked a crate. */
function sourceFolder(crate) {
  const unpacked = join(process.env.CARGO_HOME ?? join(homedir(), '.cargo'), 'registry', 'src');
  const registries = existsSync(unpacked) ? readdirSync(unpacked).sort() : [];
  const folder = registries.map((one) => join(unpacked, one, crate)).find(existsSync);
  return folder ?? fail(`The source of ${crate} is not in ${unpacked}; build the package first.`);
}

/** Rust's standard library, which is in all files too, with the crates that it is built with. @returns {Part} */
function standardLibrary({ files, all }, version) {
  const holders = ['The Rust Project Developers', '2014 Alex Crichton (backtrace, dlmalloc)'];
  return {
    purl: `pkg:generic/rust-std@${version}`,
    name: 'rust-std',
    version,
    licence: 'MIT OR Apache-2.0',
    source: 'https://github.com/rust-lang/rust',
    hashes: [],
    notices: [plainMit(holders.map((one) => `Copyright (c) ${one}`).join('\n'))],
    files: new Set([...Object.keys(files), ...all]),
    uses: new Set(),
  };
}

/** An npm package whose code is bundled into files of ours. @returns {Part} */
function npmPart(name, files) {
  const { version, license, repository } = JSON.parse(read('node_modules', name, 'package.json'));
  const { integrity } = JSON.parse(read('package-lock.json')).packages[`node_modules/${name}`];
  const [, bits, base64] = /^sha(256|384|512)-(.+)$/.exec(integrity);
  return {
    purl: `pkg:npm/${name}@${version}`,
    name,
    version,
    licence: license,
    source: (repository.url ?? repository).replace(/^git\+|\.git$/g, ''),
    hashes: [{ alg: `SHA-${bits}`, content: Buffer.from(base64, 'base64').toString('hex') }],
    notices: noticesIn(join(root, 'node_modules', name), license, `Copyright (c) the ${name} developers`),
    files: new Set(files),
    uses: new Set(),
  };
}

/** A licence as CycloneDX wants it: one by its identifier, several as an expression. */
const licenceOf = (expression) => (/\s/.test(expression) ? { expression } : { license: { id: expression } });

/** The bill of materials, as CycloneDX 1.6 has it. @param {string[]} direct what our own code uses itself */
function billOfMaterials(parts, direct) {
  const { name, version, description, license, repository, homepage, bugs } = JSON.parse(read('package.json'));
  const purl = `pkg:npm/${name}@${version}`;
  const links = { vcs: repository.url, website: homepage, 'issue-tracker': bugs.url };
  return {
    $schema: 'http://cyclonedx.org/schema/bom-1.6.schema.json',
    bomFormat: 'CycloneDX',
    specVersion: '1.6',
    version: 1,
    metadata: {
      lifecycles: [{ phase: 'build' }],
      component: {
        type: 'library',
        'bom-ref': purl,
        name,
        version,
        description,
        licenses: [licenceOf(license)],
        purl,
        externalReferences: Object.entries(links).map(([type, url]) => ({ type, url })),
      },
    },
    components: parts.map((part) => ({
      type: 'library',
      'bom-ref': part.purl,
      name: part.name,
      version: part.version,
      ...(part.hashes.length > 0 && { hashes: part.hashes }),
      licenses: [licenceOf(part.licence)],
      purl: part.purl,
      ...(part.source && { externalReferences: [{ type: 'vcs', url: part.source }] }),
      properties: [...part.files].map((value) => ({ name: 'tracecut:file', value: `dist/${value}` })),
    })),
    dependencies: [
      { ref: purl, dependsOn: direct },
      ...parts.map((part) => ({ ref: part.purl, dependsOn: [...part.uses].sort() })),
    ],
  };
}

/** The licences in the Python wheel, which any stable compiler builds. */
const wheelLicences = () => licencesText(inOrder([...cargoParts(WHEEL).parts, standardLibrary(WHEEL, 'stable')]));

/** Writes both files of the npm package. @param {string} folder */
export function writeLicences(folder) {
  const { parts: crates, direct } = cargoParts(NPM);
  const rust =
    /^rustc (\S+)/.exec(output('rustc', ['--version']) ?? '')?.[1] ?? fail('rustc does not say its version.');
  const vendored = Object.entries(VENDORED).map(([name, files]) => npmPart(name, files));
  const others = [standardLibrary(NPM, rust), ...vendored];
  const parts = inOrder([...crates, ...others]);
  const ours = [...direct, ...others.map(({ purl }) => purl)].sort();
  writeFileSync(join(folder, LICENCES), licencesText(parts));
  writeFileSync(join(folder, BILL), `${JSON.stringify(billOfMaterials(parts, ours))}\n`);
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) {
  if (process.argv.includes('--print-wheel')) process.stdout.write(wheelLicences());
  else {
    writeLicences(join(root, 'dist'));
    writeFileSync(join(root, 'python', LICENCES), wheelLicences());
  }
}
