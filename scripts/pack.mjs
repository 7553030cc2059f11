// Runs before `npm pack` and `npm publish`: builds the whole package, and refuses one that lacks a file. `npm start` builds only
// what the page loads, without types and single-file builds.

import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { build } from './build.mjs';
import { fail, root } from './tools.mjs';

const TEXTS = ['LICENSE-MIT', 'LICENSE-APACHE', 'README.md', 'CHANGELOG.md'];

/** Returns the paths of all files that a manifest names: entries and types. */
export function targetsOf({ exports, main, types }) {
  const targets = [];
  const collect = (value) => (typeof value === 'string' ? targets.push(value) : Object.values(value).forEach(collect));
  [exports, main, types].forEach(collect);
  return [...new Set(targets)].map((target) => target.replace(/^\.\//, '')).sort();
}

/**
 * Returns the files that a package needs and lacks.
 * @param {any} manifest
 * @param {(path: string) => boolean} has
 */
export function absentFrom(manifest, has) {
  return [...TEXTS, ...targetsOf(manifest)].filter((path) => !has(path));
}

export const readManifest = () => JSON.parse(readFileSync(join(root, 'package.json'), 'utf8'));

/** Ends the script if the package lacks a file. */
export function checkComplete(has, extra = []) {
  const missing = [...absentFrom(readManifest(), has), ...extra.filter((path) => !has(path))];
  if (missing.length > 0) fail(`The package lacks ${missing.join(', ')}.`);
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) {
  await build();
  checkComplete((path) => existsSync(join(root, path)));
}
