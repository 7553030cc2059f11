// The npm packages whose code is bundled into files of ours.

import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { root } from '../tools.mjs';
import { noticesIn } from './notices.mjs';

/**
 * @param {Record<string, string[]>} vendored names of packages, and the files of `dist/` that hold each
 * @returns {import('./sbom.mjs').Part[]}
 */
export function npmParts(vendored) {
  const { packages } = JSON.parse(readFileSync(join(root, 'package-lock.json'), 'utf8'));
  return Object.entries(vendored).map(([name, files]) => {
    const folder = join(root, 'node_modules', name);
    const { version, license, repository } = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'));
    return {
      purl: `pkg:npm/${name}@${version}`,
      name,
      version,
      licence: license,
      source: (repository.url ?? repository).replace(/^git\+|\.git$/g, ''),
      hashes: [hashOf(packages[`node_modules/${name}`].integrity)],
      notices: noticesIn(folder, license, `Copyright (c) the ${name} developers`),
      files: new Set(files),
      uses: new Set(),
    };
  });
}

/** A checksum as npm writes it, as CycloneDX does. @param {string} integrity */
export function hashOf(integrity) {
  const found = /^sha(256|384|512)-([A-Za-z0-9+/=]+)$/.exec(integrity);
  if (!found) throw new Error(`integrity = "${integrity}" (expected sha256, sha384 or sha512 in base 64)`);
  return { alg: `SHA-${found[1]}`, content: Buffer.from(found[2], 'base64').toString('hex') };
}
