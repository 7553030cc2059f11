// What of other people's work is in the npm package, from Cargo's and npm's own records: their licences as
// `dist/THIRD-PARTY-LICENSES.txt`, and the bill of materials `dist/sbom.cdx.json` (CycloneDX). No clock and no
// randomness: the same lock files and toolchain give the same bytes. `node scripts/licences.mjs` writes both, and
// `python/THIRD-PARTY-LICENSES.txt` for the wheel, which is committed: whoever builds it has no need of Node.
// `--print-wheel` prints that one instead.

import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { NPM, WHEEL, cargoParts, rustVersion, standardLibrary } from './licences/crates.mjs';
import { licencesText } from './licences/notices.mjs';
import { npmParts } from './licences/packages.mjs';
import { billOfMaterials } from './licences/sbom.mjs';
import { root } from './tools.mjs';

/** The names of the two files, in `dist/` and in the package. */
export const LICENCES = 'THIRD-PARTY-LICENSES.txt';
export const BILL = 'sbom.cdx.json';

/** The libraries whose JavaScript the package carries within, and the files of `dist/` that hold it. */
export const VENDORED = {
  mediabunny: ['vendor/media.js', 'inline.js'],
  fflate: ['vendor/zip.js', 'inline.js', 'node/all.cjs', 'worker.bundle.js'],
};

/**
 * Everything in the package that is not ours, in the order of its identifiers.
 * @returns {{parts: import('./licences/sbom.mjs').Part[], ours: string[]}} `ours`: what our own code uses directly
 */
export function thirdParties() {
  const { parts: crates, direct } = cargoParts(NPM);
  const parts = inOrder([...crates, standardLibrary(NPM, rustVersion()), ...npmParts(VENDORED)]);
  const others = parts.filter(({ purl }) => !purl.startsWith('pkg:cargo/')).map(({ purl }) => purl);
  return { parts, ours: [...direct, ...others].sort() };
}

const inOrder = (parts) => parts.sort((a, b) => (a.purl < b.purl ? -1 : 1));

/** The licences in the Python wheel, which any stable compiler builds. */
export function wheelLicences() {
  return licencesText(inOrder([...cargoParts(WHEEL).parts, standardLibrary(WHEEL, 'stable')]));
}

/** Writes both files of the npm package. @param {string} folder */
export function writeLicences(folder) {
  const { parts, ours } = thirdParties();
  const manifest = JSON.parse(readFileSync(join(root, 'package.json'), 'utf8'));
  writeFileSync(join(folder, LICENCES), licencesText(parts));
  writeFileSync(join(folder, BILL), `${JSON.stringify(billOfMaterials(manifest, parts, ours))}\n`);
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) {
  if (process.argv.includes('--print-wheel')) process.stdout.write(wheelLicences());
  else {
    writeLicences(join(root, 'dist'));
    writeFileSync(join(root, 'python', LICENCES), wheelLicences());
  }
}
