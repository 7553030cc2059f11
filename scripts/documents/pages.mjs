// Which pages the documentation has, and what of which Markdown file is on each.

import { readFileSync, readdirSync } from 'node:fs';
import { basename, join } from 'node:path';
import { lex, plain } from './markdown.mjs';
import { root } from '../tools.mjs';

/**
 * @typedef {object} Page
 * @property {string} path below `docs/`
 * @property {string} title
 * @property {string} group the part of the navigation that it stands in
 * @property {string} source the Markdown file, from the root of the repository
 * @property {any[]} tokens its text, each heading with its `slug`
 */

/** The parts of the navigation, in their order. */
export const GROUPS = ['Use', 'Recipes', 'Look up', 'Background'];

/** Files that have a part of their own; other Markdown files of `docs/` stand in the background. */
const PLACES = { 'docs/guide.md': 'Use', 'docs/tasks.md': 'Use', 'docs/cli.md': 'Use' };

/** @returns {Page[]} in the order of the navigation */
export function allPages() {
  const start = { ...fileAt('README.md', 'index.html', 'Use'), title: 'Start' };
  const pages = [start, ...ofFolder('docs'), fileAt('examples/README.md', 'examples.html', 'Use')];
  pages.push(
    fileAt('dist/reference.md', 'reference.html', 'Look up'),
    fileAt('CHANGELOG.md', 'changes.html', 'Look up'),
  );
  return pages.sort((a, b) => GROUPS.indexOf(a.group) - GROUPS.indexOf(b.group));
}

const read = (file) => readFileSync(join(root, file), 'utf8').replaceAll('\r', '');

/** A page for each Markdown file of a folder and the folders in it; those of inner folders are recipes. */
function ofFolder(folder) {
  return readdirSync(join(root, folder), { recursive: true })
    .map((name) => `${folder}/${name.replaceAll('\\', '/')}`)
    .filter((file) => file.endsWith('.md'))
    .sort()
    .map((file) => {
      const inner = file.slice(folder.length + 1);
      const group = PLACES[file] ?? (inner.includes('/') ? 'Recipes' : 'Background');
      const path = inner.replace(/\bREADME\.md$/, 'index.md').replace(/\.md$/, '.html');
      return fileAt(file, path === 'index.html' ? 'overview.html' : path, group);
    });
}

/** @returns {Page} */
function fileAt(source, path, group) {
  const tokens = lex(read(source));
  const heading = tokens.find(({ type, depth }) => type === 'heading' && depth === 1);
  return { path, title: heading ? plain([heading]) : basename(path, '.html'), group, source, tokens };
}
