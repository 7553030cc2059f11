// Reads the declarations that the build writes: a small part of TypeScript's grammar, as the compiler prints it.

import { readFileSync } from 'node:fs';
import { dirname, join, posix } from 'node:path';
import { withoutType } from '../declarations.mjs';

/**
 * What a module declares.
 * @typedef {object} Declaration
 * @property {'function' | 'class' | 'const' | 'type'} kind
 * @property {string} name
 * @property {string} module its path below dist, `video/segment.js`
 * @property {string} text without `export declare` and the description
 * @property {Doc} doc
 * @property {Member[]} members of a class
 */
/** @typedef {{name: string, text: string, doc: Doc}} Member */
/** @typedef {{words: string, params: Map<string, string>, returns: string, throws: string[]}} Doc */

/** All that `entry` exports, by name, in the order in which it does. */
export function exportsOf(dist, entry) {
  const found = new Map();
  for (const item of read(dist, entry)) {
    if (item.kind === 'all') for (const [name, declaration] of exportsOf(dist, item.from)) found.set(name, declaration);
    else if (item.kind === 'names') for (const name of item.names) found.set(name, lookUp(dist, item.from, name));
    else found.set(item.name, followed(dist, item));
  }
  return found;
}

/** The declaration of `name` in a module, where it is written out. */
export function lookUp(dist, module, name) {
  for (const item of read(dist, module)) {
    if (item.name === name) return followed(dist, item);
    if (item.kind === 'names' && item.names.includes(name)) return lookUp(dist, item.from, name);
  }
  return undefined;
}

/** A type that is only another name for one elsewhere stands for that one, unless it says more itself. */
function followed(dist, item) {
  const alias = /^type (\w+) = import\('([^']+)'\)\.\1;$/.exec(item.text);
  return alias && !item.doc.words ? lookUp(dist, resolved(item.module, alias[2]), alias[1]) : item;
}

const modules = new Map();

/** The statements of a module. */
export function read(dist, module) {
  const file = join(dist, module.replace(/\.js$/, '.d.ts'));
  if (!modules.has(file)) modules.set(file, parse(readFileSync(file, 'utf8'), module));
  return modules.get(file);
}

/** Statements of a declaration file's text. */
export function parse(text, module) {
  return statements(text).flatMap(({ comment, body }) => {
    const all = /^export \* from '([^']+)';/.exec(body);
    if (all) return [{ kind: 'all', from: resolved(module, all[1]) }];
    const names = /^export (?:type )?\{([^}]*)\} from '([^']+)';/.exec(body);
    if (names) return [{ kind: 'names', names: names[1].match(/\w+/g), from: resolved(module, names[2]) }];
    const declared = /^export (?:declare )?(?:abstract )?(function|class|const|type|interface) (\w+)/.exec(body);
    if (!declared) return [];
    const [, word, name] = declared;
    const kind = word === 'interface' ? 'type' : word;
    const inner = kind === 'class' ? members(body) : [];
    return [{ kind, name, module, text: body.replace(/^export (declare )?/, ''), doc: docOf(comment), members: inner }];
  });
}

function members(text) {
  const begin = text.indexOf('{') + 1;
  return statements(text.slice(begin, text.lastIndexOf('}'))).flatMap(({ comment, body }) => {
    const name = /^(?:get |readonly |static )*(\[Symbol\.\w+\]|\w+)/.exec(body)?.[1];
    return !name || name === 'constructor' ? [] : [{ name, text: body.replace(/;$/, ''), doc: docOf(comment) }];
  });
}

/** The statements of a text at its outermost level, each with the comment before it. */
function statements(text) {
  const found = [];
  let [comment, begin, depth] = ['', -1, 0];
  const end = (at) => {
    found.push({ comment, body: text.slice(begin, at) });
    [comment, begin] = ['', -1];
  };
  for (let at = 0; at < text.length; at += 1) {
    const skipped = skip(text, at);
    if (skipped > at) {
      const token = text.slice(at, skipped);
      if (begin < 0 && token.startsWith('/**')) comment = token;
      else if (begin < 0 && !token.startsWith('/')) begin = at;
      at = skipped - 1;
      continue;
    }
    const letter = text[at];
    if (begin < 0 && /\s/.test(letter)) continue;
    if (begin < 0) begin = at;
    if ('([{'.includes(letter)) depth += 1;
    if (')]}'.includes(letter)) depth -= 1;
    if (depth > 0) continue;
    const block =
      letter === '}' && /^(export )?(declare )?(abstract )?(class|interface)\b/.test(text.slice(begin, begin + 40));
    if (letter === ';' || block) end(at + 1);
  }
  return found;
}

/** Where the comment or the string that begins here ends; here, if none does. */
function skip(text, at) {
  if (text.startsWith('/*', at)) return text.indexOf('*/', at) + 2;
  if (text.startsWith('//', at)) return text.indexOf('\n', at);
  if (!'\'"`'.includes(text[at])) return at;
  return text.indexOf(text[at], at + 1) + 1;
}

/** @returns {Doc} */
export function docOf(comment) {
  const lines = comment
    .replace(/^\/\*\*|\*\/$/g, '')
    .split('\n')
    .map((line) => line.replace(/^\s*\* ?/, '').trimEnd());
  const [words, ...tags] = lines
    .join('\n')
    .trim()
    .split(/(?:^|\n)(?=@\w)/);
  const doc = { words: words.startsWith('@') ? '' : words, params: new Map(), returns: '', throws: [] };
  for (const tag of words.startsWith('@') ? [words, ...tags] : tags) {
    const [, name, rest] = /^@(\w+)\s*([^]*)$/.exec(tag);
    const said = withoutType(rest);
    if (name === 'param') {
      const [, parameter, meaning] = /^\[?(\w+)(?:=[^\]]*)?\]?\s*([^]*)$/.exec(said) ?? [];
      if (parameter && meaning) doc.params.set(parameter, joined(meaning));
    }
    if (name === 'returns') doc.returns = joined(said);
    if (name === 'throws') doc.throws.push(joined(said));
  }
  return doc;
}

const joined = (text) => text.replace(/\s+/g, ' ').trim();

/** The module that `from` names in `module`. */
export function resolved(module, from) {
  return posix.normalize(posix.join(dirname(module).replaceAll('\\', '/'), from));
}
