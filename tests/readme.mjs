// The README's code, which is tested as it stands.

import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { root } from '../scripts/tools.mjs';

/** Blocks of JavaScript by the heading above them; two below one heading are told apart by a number. */
export function readmeCode() {
  const text = readFileSync(join(root, 'README.md'), 'utf8').replaceAll('\r', '');
  const found = new Map();
  let heading = '';
  for (const [, title, indent, code] of text.matchAll(/^#+ (.+)$|^( *)```js\n([^]*?)^ *```$/gm)) {
    if (title) heading = title;
    else {
      const name = [heading, `${heading} 2`, `${heading} 3`].find((candidate) => !found.has(candidate));
      found.set(name, code.replace(new RegExp(`^${indent}`, 'gm'), ''));
    }
  }
  return found;
}

/** Where each block is run: in Node, in a browser, or by the test of bundlers. */
export const RUN = {
  node: ['In Node', 'Sessions', 'Corrections', 'Edits by hand', 'Single images', 'Errors'],
  browser: ['In the browser', 'Video', 'What comes out'],
  bundlers: ['Bundlers', 'Bundlers 2'],
};
