// `npm run licences`: writes the licences of other people's work that the npm package and the Python wheel hold, from
// cargo-about and from the libraries' own files. A release and a site have them; tests and `npm start` need none.

import { appendFileSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { ensureRustTool, root, run } from './tools.mjs';

export const LICENCES = 'THIRD-PARTY-LICENSES.txt';
/** The libraries whose JavaScript the package holds. */
export const LIBRARIES = ['fflate', 'mediabunny'];

const read = (...path) => readFileSync(join(root, ...path), 'utf8');

/** Writes those of the npm package. Its second wasm file is made of files of the library and needs no other crates. */
export function writeLicences(folder) {
  const file = join(folder, LICENCES);
  writeCrates(file, 'Cargo.toml', ['--features', 'wasm', '--target', 'wasm32-unknown-unknown']);
  for (const name of LIBRARIES) appendFileSync(file, libraryEntry(name));
}

/** Writes those of a package and the crates that it needs. */
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
