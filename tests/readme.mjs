// Extracts the code of README.md, docs/guide.md and docs/tasks.md, which is tested unchanged.

import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { root } from '../scripts/tools.mjs';

/** Returns blocks of JavaScript, or of another language, by the heading above them; several below one heading are numbered. */
export function codeOf(file, language = 'js') {
  const text = readFileSync(join(root, file), 'utf8').replaceAll('\r', '');
  const found = new Map();
  let heading = '';
  const pattern = new RegExp(`^#+ (.+)$|^( *)\`\`\`${language}\\n([^]*?)^ *\`\`\`$`, 'gm');
  for (const [, title, indent, code] of text.matchAll(pattern)) {
    if (title) heading = title;
    else {
      const name = [heading, `${heading} 2`, `${heading} 3`].find((candidate) => !found.has(candidate));
      found.set(name, code.replace(new RegExp(`^${indent}`, 'gm'), ''));
    }
  }
  return found;
}

/** The blocks of README.md and of docs/guide.md, which continues it. */
export const readmeCode = () => new Map([...codeOf('README.md'), ...codeOf('docs/guide.md')]);

/** Returns the page that the README begins with. */
export const readmePage = () => [...codeOf('README.md', 'html').values()][0];

/** Where each block of docs/tasks.md is run; those for Node in this order. */
export const TASKS = {
  node: [
    'The motion between two pictures',
    'Points followed through a clip',
    'Masks from your own tracker',
    'Why a pixel has its label',
    'Where each object is, how large, how fast',
    'Many single pictures',
    'Video files in Node',
    'Several clips in one stream',
    'Uncompressed video from a stream',
    'A server that stays responsive',
  ],
  browser: ['Effects: blurred, dimmed or other backgrounds'],
  long: ['A video with alpha, by FFmpeg'],
};

/** Where each block of the README and the guide is run: in Node, in a browser, or by the test of bundlers. */
export const RUN = {
  node: ['In Node', 'Sessions', 'Corrections', 'Edits by hand', 'Single images', 'Errors'],
  browser: ['Video', 'What comes out'],
  bundlers: ['Bundlers', 'Bundlers 2'],
};
