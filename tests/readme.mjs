// Extracts the code of README.md, docs/guide.md and docs/tasks.md, which tests run unchanged.

import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { root } from '../scripts/tools.mjs';

/** Returns blocks of JavaScript, or of another language, by the heading above them; several below one heading are numbered. */
export function codeOf(file, language = 'js') {
  const text = readFileSync(join(root, file), 'utf8').replaceAll('\r', '');
  const blocks = new Map();
  let heading = '';
  const pattern = new RegExp(`^#+ (.+)$|^( *)\`\`\`${language}\\n([^]*?)^ *\`\`\`$`, 'gm');
  for (const [, title, indent, code] of text.matchAll(pattern)) {
    if (title) heading = title;
    else {
      const name = [heading, `${heading} 2`, `${heading} 3`].find((candidate) => !blocks.has(candidate));
      blocks.set(name, code.replace(new RegExp(`^${indent}`, 'gm'), ''));
    }
  }
  return blocks;
}

/** The blocks of README.md and of docs/guide.md, which continues it. */
export const readmeCode = () => new Map([...codeOf('README.md'), ...codeOf('docs/guide.md')]);

/** Returns the page that the README begins with. */
export const readmePage = () => [...codeOf('README.md', 'html').values()][0];

/** Blocks of docs/tasks.md that do not run in Node: in a browser, or by the long tests. */
export const TASKS = {
  browser: ['Effects: blurred, dimmed or other backgrounds'],
  long: ['A video with alpha, by FFmpeg'],
};
