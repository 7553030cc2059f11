// Links in the documentation lead somewhere: to a file that is there and, where they name one, to a heading in it.

import assert from 'node:assert/strict';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { dirname, join, relative, resolve } from 'node:path';
import { test } from 'node:test';
import { root } from '../../scripts/tools.mjs';

const NOT_OURS = ['.git', 'node_modules', 'target', 'dist', 'pkg', 'out', '.tools', '.venv', 'shared'];

/** All Markdown files below a folder. */
function markdown(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) return NOT_OURS.includes(entry.name) ? [] : markdown(path);
    return entry.isFile() && entry.name.endsWith('.md') ? [path] : [];
  });
}

/** Where the links of a text lead, code left out. */
function targets(text) {
  const prose = text.replace(/^( *)```[^]*?^\1```/gm, '').replace(/`[^`\n]*`/g, 'code');
  const patterns = [/\]\(<?([^)\s>]+)/g, /^\[[^\]]+\]: *(\S+)/gm, /\b(?:href|src)="([^"]+)"/g];
  return patterns.flatMap((pattern) => [...prose.matchAll(pattern)].map(([, target]) => target));
}

/** The names that headings have as places to jump to. */
function anchors(text) {
  const titles = [...text.replace(/^```[^]*?^```/gm, '').matchAll(/^#+ (.+)$/gm)].map(([, title]) => title);
  const names = titles.map((title) =>
    title
      .toLowerCase()
      .replaceAll(' ', '-')
      .replace(/[^\p{L}\p{N}_-]/gu, ''),
  );
  return names.map((name, k) => {
    const before = names.slice(0, k).filter((other) => other === name).length;
    return before > 0 ? `${name}-${before}` : name;
  });
}

/** Where files of ours are outside of the repository: links from pages of registries have to name them so. */
const OUTSIDE = /^https:\/\/(?:raw\.githubusercontent|github)\.com\/tracecut\/tracecut\/(?:(?:blob|tree)\/)?HEAD\//;

/** What is wrong with a link of a file, or null. */
function fault(file, target) {
  const [path, anchor] = decodeURI(target).split('#');
  const inside = OUTSIDE.test(path) ? join(root, path.replace(OUTSIDE, '')) : resolve(dirname(file), path);
  const place = path ? inside : file;
  const where = `${relative(root, file)}: ${target}`;
  if (relative(root, place).startsWith('..')) return `${where} leads out of the repository`;
  if (!existsSync(place)) return `${where} leads nowhere`;
  if (!anchor || !place.endsWith('.md')) return null;
  return anchors(readFileSync(place, 'utf8')).includes(anchor) ? null : `${where} names no heading there`;
}

const isRelative = (target) => !/^[a-z][a-z+.-]*:|^\/\//i.test(target);
const isOurs = (target) => isRelative(target) || OUTSIDE.test(target);

test('every link of the documentation to a file of ours leads to a file and a heading that are there', () => {
  const files = markdown(root);
  assert.ok(files.includes(join(root, 'README.md')) && files.includes(join(root, 'docs', 'reference.md')));
  const links = files.flatMap((file) =>
    targets(readFileSync(file, 'utf8'))
      .filter(isOurs)
      .map((target) => ({ file, target })),
  );
  assert.ok(
    links.some(({ target }) => target === 'ARCHITECTURE.md') && links.some(({ target }) => OUTSIDE.test(target)),
  );
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
  assert.match(fault(file, 'docs/nothing.md'), /leads nowhere/);
  assert.match(fault(file, 'ARCHITECTURE.md#nothing'), /names no heading/);
  assert.match(fault(file, '../elsewhere.md'), /out of the repository/);
  assert.equal(fault(file, 'ARCHITECTURE.md#data-flow'), null);
  const outside = 'https://github.com/tracecut/tracecut/blob/HEAD/';
  assert.match(fault(file, `${outside}docs/nothing.md`), /leads nowhere/);
  assert.match(fault(file, `${outside}ARCHITECTURE.md#nothing`), /names no heading/);
  assert.equal(fault(file, `${outside}ARCHITECTURE.md#data-flow`), null);
  assert.deepEqual(targets('[a](b.md) `[c](d.md)`\n```\n[e](f.md)\n```\n![g](<h.png>)\n[i]: j.md\n<img src="k.png">'), [
    'b.md',
    'h.png',
    'j.md',
    'k.png',
  ]);
});
