// `npm run size`: the size of each entry of the built package, and its limit. The tests and the release enforce the limits.

import { readFileSync } from 'node:fs';
import { basename, join, relative } from 'node:path';
import { pathToFileURL } from 'node:url';
import { gzipSync } from 'node:zlib';
import { fail, output, root } from './tools.mjs';

/**
 * Maximum bytes, minified and zipped, of what a page loads first and in its worker, and of what it loads on demand.
 */
export const MOST_ZIPPED = {
  'index.js': 56 * 1024,
  'worker.js': 10.5 * 1024,
  'vendor/media.js': 150 * 1024,
  'vendor/zip.js': 8 * 1024,
  // The whole file.
  'worker.bundle.js': 18 * 1024,
  'inline.js': 775 * 1024,
};

/**
 * Maximum bytes of the zipped wasm files: every visitor of a page fetches the first; pushing PNG or JPEG files, enlarging
 * masks, run lengths and tables also need the second.
 */
export const MOST_WASM = { 'tracecut_bg.wasm': 374 * 1024, 'decoder_bg.wasm': 156.5 * 1024 };

/** Maximum bytes of the single-file builds, and of the installed package without them. */
export const MOST_OF_FILES = {
  'inline.js': 1488 * 1024,
  'worker.bundle.js': 52 * 1024,
  'node/all.cjs': 264 * 1024,
};
export const MOST_UNPACKED = 2.8 * 1024 * 1024;

/**
 * @typedef {object} Size in bytes
 * @property {string} name of a file of `dist/`, or of the package
 * @property {number} unpacked as it is installed, with all that it imports statically
 * @property {number} [minified] the same as a bundler makes it
 * @property {number} [zipped] the same, zipped file by file as a host sends it; for the package, the whole as npm sends it
 * @property {number} most the limit
 * @property {boolean} fits
 */

/**
 * @param {ReturnType<typeof packed>} [published]
 * @returns {Promise<Size[]>} one row for each entry and file with a limit, the package last
 */
export async function sizes(published = packed()) {
  const entries = await Promise.all(Object.entries(MOST_ZIPPED).map(([name, most]) => sizeOfEntry(name, most)));
  const files = Object.entries(MOST_WASM).map(([name, most]) => sizeOfFile(name, most));
  return [...entries, ...files, ...sizesOfPackage(published)];
}

/** Returns the sizes of the single-file builds, then of the package without them. */
function sizesOfPackage({ unpackedSize, size: zipped, files }) {
  const single = Object.entries(MOST_OF_FILES).map(([name, most]) => {
    const unpacked = files.find(({ path }) => path === `dist/${name}`)?.size ?? Infinity;
    return { name: `${name}, as a file`, unpacked, most, fits: unpacked <= most };
  });
  const rest = unpackedSize - sum(single.map(({ unpacked }) => unpacked));
  const most = Math.floor(MOST_UNPACKED);
  return [...single, { name: 'package, without these', unpacked: rest, zipped, most, fits: rest <= most }];
}

/** Measures a module of dist/ with everything it imports statically. */
async function sizeOfEntry(name, most) {
  const { metafile, outputFiles } = await bundled(name);
  const chunks = new Set([`out/${basename(name)}`]);
  for (const chunk of chunks) {
    for (const { path, kind } of metafile.outputs[chunk].imports) if (kind === 'import-statement') chunks.add(path);
  }
  const loaded = outputFiles.filter(({ path }) => chunks.has(relative(root, path).replaceAll('\\', '/')));
  if (loaded.length !== chunks.size) throw new Error(`${name}: ${loaded.length} of ${chunks.size} chunks found`);
  const sources = new Set([...chunks].flatMap((chunk) => Object.keys(metafile.outputs[chunk].inputs)));
  const zipped = sum(loaded.map(({ contents }) => zip(contents)));
  return {
    name,
    unpacked: sum([...sources].map((source) => metafile.inputs[source].bytes)),
    minified: sum(loaded.map(({ contents }) => contents.length)),
    zipped,
    most,
    fits: zipped <= most,
  };
}

async function bundled(name) {
  const { build } = await import('esbuild');
  return build({
    entryPoints: [`dist/${name}`],
    absWorkingDir: root,
    outdir: 'out',
    bundle: true,
    minify: true,
    splitting: true,
    format: 'esm',
    write: false,
    metafile: true,
    logLevel: 'warning',
  });
}

function sizeOfFile(name, most) {
  const bytes = readFileSync(join(root, 'dist', name));
  const zipped = zip(bytes);
  return { name, unpacked: bytes.length, zipped, most, fits: zipped <= most };
}

/** Returns what npm would publish: the files with their sizes, and the sums. */
export function packed(...args) {
  const text = output('npm', ['pack', '--json', '--ignore-scripts', ...(args.length > 0 ? args : ['--dry-run'])]);
  if (text === null) fail('npm pack failed.');
  const parsed = JSON.parse(text);
  return Array.isArray(parsed) ? parsed[0] : Object.values(parsed)[0];
}

const zip = (bytes) => gzipSync(bytes, { level: 9 }).length;
const sum = (numbers) => numbers.reduce((total, value) => total + value, 0);

/** Prints the table, and ends the script if something is too large. */
export async function checkSizes() {
  const rows = await sizes();
  console.table(rows);
  console.log('Bytes. The limit is on unpacked bytes in the last rows, on zipped bytes in all others.');
  const large = rows.filter(({ fits }) => !fits).map(({ name }) => name);
  if (large.length > 0) fail(`Too large: ${large.join(', ')}.`);
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) await checkSizes();
