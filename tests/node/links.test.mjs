// Links in the documentation lead somewhere: to a file that is there and, where they name one, to a heading in it.

import assert from 'node:assert/strict';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { dirname, join, relative, resolve } from 'node:path';
import { test } from 'node:test';
import { Marked } from 'marked';
import { OUTSIDE, lex } from '../../scripts/documents/markdown.mjs';
import { root } from '../../scripts/tools.mjs';

const NOT_OURS = ['.git', 'node_modules', 'target', 'dist', 'pkg', 'out', '.tools', '.venv', 'shared'];
const marked = new Marked();

/** All Markdown files below a folder. */
function markdown(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) return NOT_OURS.includes(entry.name) ? [] : markdown(path);
    return entry.isFile() && entry.name.endsWith('.md') ? [path] : [];
  });
}

/** Where the links and pictures of a text lead. */
function targets(text) {
  const found = [];
  marked.walkTokens(marked.lexer(text), ({ type, href }) => {
    if (type === 'link' || type === 'image') found.push(href);
  });
  return found;
}

/** What is wrong with a link of a file, or null. */
function fault(file, target) {
  const [path, anchor] = decodeURI(target).split('#');
  const inside = OUTSIDE.test(path) ? join(root, path.replace(OUTSIDE, '')) : resolve(dirname(file), path);
  const place = path ? inside : file;
  const where = `${relative(root, file)}: ${target}`;
  if (relative(root, place).startsWith('..')) return `${where} leads out of the repository`;
  if (!existsSync(place)) return `${where} leads nowhere`;
  if (!anchor || !place.endsWith('.md')) return null;
  const slugs = lex(readFileSync(place, 'utf8')).map(({ slug }) => slug);
  return slugs.includes(anchor) ? null : `${where} names no heading there`;
}

const isRelative = (target) => !/^[a-z][a-z+.-]*:|^\/\//i.test(target);

test('every link of the documentation to a file of ours leads to a file and a heading that are there', () => {
  const links = markdown(root).flatMap((file) =>
    targets(readFileSync(file, 'utf8'))
      .filter((target) => isRelative(target) || OUTSIDE.test(target))
      .map((target) => ({ file, target })),
  );
  assert.ok(links.length > 50, `${links.length} links`);
  assert.deepEqual(links.map(({ file, target }) => fault(file, target)).filter(Boolean), []);
});

test('the README, which registries show on pages of their own, has no relative link but to its own headings', () => {
  const links = targets(readFileSync(join(root, 'README.md'), 'utf8'));
  assert.deepEqual(
    links.filter((target) => isRelative(target) && !target.startsWith('#')),
    [],
  );
});

test('links that lead nowhere are seen', () => {
  const file = join(root, 'README.md');
  for (const outside of ['', 'https://github.com/tracecut/tracecut/blob/HEAD/']) {
    assert.match(fault(file, `${outside}docs/nothing.md`), /leads nowhere/);
    assert.match(fault(file, `${outside}ARCHITECTURE.md#nothing`), /names no heading/);
    assert.equal(fault(file, `${outside}ARCHITECTURE.md#data-flow`), null);
  }
  assert.match(fault(file, '../elsewhere.md'), /out of the repository/);
  assert.deepEqual(targets('[a](b.md) `[c](d.md)`\n\n![g](<h.png>) [i]\n\n[i]: j.md\n'), ['b.md', 'h.png', 'j.md']);
});
