// The English texts of the page, as its sources have them: what a table of another language is to translate.

import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { parseAst } from 'vite';
import { root } from '../scripts/tools.mjs';

/** Attributes of index.html that are read, by eye or aloud. */
const READ = ['title', 'aria-label', 'alt', 'placeholder'];

/** Properties whose strings are words, wherever they stand; `name` is one too where things are listed for people. */
const NAMED = ['about', 'label', 'says', 'title', 'headline', 'remark'];
const LISTS = /^(layers|run)\//;

/** Constants whose strings are words, all of them. */
const TABLES = [
  'ADVICE',
  'GROUNDS',
  'LONG',
  'NOISE_REMARK',
  'NOTHING',
  'PHRASES',
  'REGIONS',
  'PREVIEW',
  'BRUSH_HELP',
  'DOING',
  'KEYS',
  'TOUCHES',
];

/** Constants of rows, and which entries of a row are words. */
const ROWS = { KINDS: [1, 2], NAMED: [0], named: [1] };

/** Every module of the page: its path in www/demo, and its syntax tree. */
export function modules() {
  const folder = join(root, 'www', 'demo');
  return readdirSync(folder, { recursive: true })
    .map((name) => name.replaceAll('\\', '/'))
    .filter((name) => name.endsWith('.js') && !name.startsWith('words/'))
    .map((name) => ({ name, tree: parseAst(readFileSync(join(folder, name), 'utf8')) }));
}

/** All nodes of a tree, those within others too. */
function* nodesOf(tree) {
  if (Array.isArray(tree)) for (const one of tree) yield* nodesOf(one);
  if (!tree || typeof tree.type !== 'string') return;
  yield tree;
  for (const value of Object.values(tree)) if (value && typeof value === 'object') yield* nodesOf(value);
}

/** The strings that an expression may be. */
function stringsOf(node) {
  if (node?.type === 'Literal' && typeof node.value === 'string') return [node.value];
  if (node?.type === 'ConditionalExpression') return [node.consequent, node.alternate].flatMap(stringsOf);
  return [];
}

/** The key of a template, with {0}, {1}, … in the place of values. */
export function keyOf({ quasis }) {
  return quasis.map(({ value }) => value.cooked).reduce((before, part, k) => `${before}{${k - 1}}${part}`);
}

/** Words that are said where they stand, and those that constants hold. */
export function textsOf({ name, tree }) {
  return [...nodesOf(tree)].flatMap((node) => {
    const called = node.type === 'CallExpression' ? node.callee.name : '';
    if (called === 'say') return stringsOf(node.arguments[0]);
    if (called === 'plural') {
      const [one] = stringsOf(node.arguments[1]);
      return one ? [one, stringsOf(node.arguments[2])[0] ?? `${one}s`] : [];
    }
    if (called === 'h') return [...node.arguments.slice(2).flatMap(stringsOf), ...attributesOf(node.arguments[1])];
    if (called === 'stream' && name.startsWith('result/')) return stringsOf(node.arguments[1]);
    if (called === 'key') return stringsOf(node.arguments[2]);
    if (called === 'toggle' && name.startsWith('layers/')) return stringsOf(node.arguments[0]);
    if (node.type === 'TaggedTemplateExpression' && node.tag.name === 'say') return [keyOf(node.quasi)];
    if (node.type === 'VariableDeclarator' && TABLES.includes(node.id.name)) return wordsIn(node.init);
    if (node.type === 'VariableDeclarator' && Object.hasOwn(ROWS, node.id.name))
      return entriesOf(node.init, ROWS[node.id.name]);
    if (node.type === 'Property' && isWords(node.key, name)) return stringsOf(node.value);
    return [];
  });
}

function isWords({ name: key, value }, file) {
  return NAMED.includes(key ?? value) || (key === 'name' && LISTS.test(file)) || key === 'unit';
}

/** Titles and labels of an element that is built. */
function attributesOf(node) {
  const read = (node?.properties ?? []).filter(({ key }) => READ.includes(key?.value ?? key?.name));
  return read.flatMap(({ value }) => stringsOf(value));
}

/** All strings in a constant but the names of its properties. */
function wordsIn(node) {
  if (node.type === 'ObjectExpression') return node.properties.flatMap(({ value }) => wordsIn(value));
  if (node.type === 'ArrayExpression') return node.elements.flatMap(wordsIn);
  return stringsOf(node);
}

/** Some of the entries of each row. */
function entriesOf(node, places) {
  const rows = node?.type === 'ArrayExpression' ? node.elements : [];
  return rows.flatMap(({ elements = [] }) => places.flatMap((k) => stringsOf(elements[k])));
}

/** The texts of index.html that the page translates when it starts. */
export function textsOfPage() {
  const html = readFileSync(join(root, 'www', 'index.html'), 'utf8');
  const [title] = html.match(/(?<=<title>)[^<]*/);
  const body = html
    .slice(html.indexOf('<body'))
    .replace(/<(noscript|svg)\b.*?<\/\1>/gs, '')
    .replaceAll('&nbsp;', ' ');
  const texts = [...body.matchAll(/>([^<>]+)(?=<)/g)].map(([, text]) => text);
  const attributes = [...body.matchAll(/ ([a-z-]+)="([^"]*)"/g)].filter(([, name]) => READ.includes(name));
  const all = [title, ...texts, ...attributes.map(([, , value]) => value)].map((text) => text.trim());
  return all.filter((text) => /\p{L}/u.test(text));
}
