// `npm run licences`: writes the licences of third-party code in the npm package and the Python wheel, from cargo-about and
// from the libraries' own files. Releases and the site include them; tests and `npm start` do not need them.

import { appendFileSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { ensureRustTool, root, run } from './tools.mjs';

export const LICENCES = 'THIRD-PARTY-LICENSES.txt';
/** The libraries whose JavaScript is in the package. */
export const LIBRARIES = ['fflate', 'mediabunny'];

const read = (...path) => readFileSync(join(root, ...path), 'utf8');

/** Writes the licences of the npm package. Its second wasm file needs no crates that the library does not. */
export function writeLicences(folder) {
  const file = join(folder, LICENCES);
  writeCrates(file, 'Cargo.toml', ['--features', 'wasm', '--target', 'wasm32-unknown-unknown']);
  for (const name of LIBRARIES) appendFileSync(file, libraryEntry(name));
}

/** Writes the licences of a package and its crates. */
function writeCrates(file, manifest, which = []) {
  ensureRustTool('cargo-about');
  run('cargo', ['fetch', '--locked']);
  const places = ['--manifest-path', manifest, '--config', 'about.toml', '--output-file', file, 'about.hbs'];
  run('cargo-about', ['generate', '--locked', '--offline', '--fail', ...which, ...places]);
}

function libraryEntry(name) {
  const { version, repository } = JSON.parse(read('node_modules', name, 'package.json'));
  const source = `${name} ${version}, unchanged but bundled; its source is in its npm package and at ${repository.url ?? repository}`;
  return `${source}\n\n${read('node_modules', name, 'LICENSE')}\n\n${'-'.repeat(80)}\n\n`;
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) {
  writeLicences(join(root, 'dist'));
  writeCrates(join(root, 'python', LICENCES), 'python/Cargo.toml');
}
