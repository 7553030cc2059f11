// The reference of the package, dist/reference.md: Markdown from its declarations and its list of parameters. The build
// writes it into the package, and the site has it as a page.

import { readFileSync } from 'node:fs';
import { dirname, join, posix } from 'node:path';
import { parse as parseComment } from 'comment-parser';
import { parseSync } from 'vite';
import { root } from './tools.mjs';

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
/** @typedef {{words: string, params: [name: string, words: string][], returns: string, throws: string[]}} Doc */

const KINDS = {
  TSDeclareFunction: 'function',
  ClassDeclaration: 'class',
  VariableDeclaration: 'const',
  TSTypeAliasDeclaration: 'type',
  TSInterfaceDeclaration: 'type',
};

/** All that a module exports, by name, in its order. */
function exportsOf(dist, module) {
  const found = new Map();
  for (const item of read(dist, module)) {
    if (item.kind === 'all') exportsOf(dist, item.from).forEach((declaration, name) => found.set(name, declaration));
    else if (item.kind === 'names') for (const name of item.names) found.set(name, lookUp(dist, item.from, name));
    else found.set(item.name, followed(dist, item));
  }
  return found;
}

/** The declaration of `name` in a module, where it is written out. */
function lookUp(dist, module, name) {
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

/** The module that `from` names in `module`. */
const resolved = (module, from) => posix.join(dirname(module), from);

const modules = new Map();

/** The exports that a module writes down. */
function read(dist, module) {
  const file = join(dist, module.replace(/\.js$/, '.d.ts'));
  if (!modules.has(file)) modules.set(file, declarations(readFileSync(file, 'utf8'), module));
  return modules.get(file);
}

function declarations(text, module) {
  const { program, comments } = parseSync('module.d.ts', text);
  const docAt = (/** @type {number} */ start) => {
    const before = comments.filter(({ end }) => end <= start && text.slice(end, start).trim() === '');
    return docOf(before.length > 0 ? text.slice(before.at(-1).start, before.at(-1).end) : '');
  };
  const membersOf = ({ body }) =>
    body.body.flatMap(({ start, end, key }) => {
      const name = text.slice(key.start, key.end);
      if (/^(#|constructor$)/.test(name)) return [];
      return [{ name, text: text.slice(start, end).replace(/;$/, ''), doc: docAt(start) }];
    });
  return program.body.flatMap(({ type, start, source, specifiers, declaration }) => {
    if (type === 'ExportAllDeclaration') return [{ kind: 'all', from: resolved(module, source.value) }];
    if (source && specifiers && type !== 'ImportDeclaration')
      return [
        { kind: 'names', names: specifiers.map(({ exported }) => exported.name), from: resolved(module, source.value) },
      ];
    const kind = KINDS[declaration?.type];
    if (!kind) return [];
    const { name } = (declaration.declarations?.[0] ?? declaration).id;
    const written = text.slice(declaration.start, declaration.end).replace(/^declare /, '');
    return [
      { kind, name, module, text: written, doc: docAt(start), members: kind === 'class' ? membersOf(declaration) : [] },
    ];
  });
}

const oneLine = (text) => text.replace(/\s+/g, ' ').trim();

/** @returns {Doc} */
function docOf(comment) {
  const { description, tags } = parseComment(comment, { spacing: 'preserve' })[0] ?? { description: '', tags: [] };
  const said = (tag) => oneLine(`${tag.optional ? `[${tag.name}]` : tag.name} ${tag.description}`);
  const named = (wanted) => tags.filter(({ tag }) => tag === wanted);
  return {
    words: description.replace(/^ (?=\S)/gm, '').trim(),
    params: named('param').map((tag) => [tag.name, oneLine(tag.description)]),
    returns: named('returns').map(said).join(),
    throws: named('throws').map(said),
  };
}

/** The modules that the package's entries are, by the entries' names; the one in a single file has the same names. */
function entries() {
  const { exports } = JSON.parse(readFileSync(join(root, 'package.json'), 'utf8'));
  const typed = Object.entries(exports).map(([name, { types, default: main }]) => [name, types ?? main?.types]);
  return typed
    .filter(([name, types]) => types && name !== './inline')
    .map(([name, types]) => [posix.join('tracecut', name), types.replace('./dist/', '').replace('.d.ts', '.js')]);
}

/**
 * @param {string} dist
 * @param {readonly any[]} parameters
 * @returns {{text: string, undocumented: string[], names: string[]}} the Markdown, the names that lack a description,
 *   and all names
 */
export function reference(dist, parameters) {
  const [api, sections] = [new Map(), []];
  for (const [title, module] of entries()) {
    // Types of later entries are found where their functions mention them.
    const isOwn = ([name, { kind }]) => !api.has(name) && (title === 'tracecut' || kind !== 'type');
    const own = [...exportsOf(dist, module)].filter(isOwn);
    for (const [name, item] of own) api.set(name, item);
    const items = own.map(([, item]) => item);
    sections.push({ title, items: Object.keys(WRITERS).flatMap((kind) => items.filter((item) => item.kind === kind)) });
  }
  const types = [...typesOf(dist, api).values()].sort((a, b) => (a.name < b.name ? -1 : 1));
  sections.push({ title: 'Types', items: types });
  const full = sections.filter(({ items }) => items.length > 0);
  const links = linksTo(full.flatMap(({ title, items }) => [title, ...items.map(({ name }) => name)]));
  const written = (item) => (WRITERS[item.kind] ?? typeEntry)(item, links);
  const contents = full.map(
    ({ title, items }) => `- ${links.get(title)}: ${items.map(({ name }) => links.get(name)).join(', ')}\n`,
  );
  const parts = full.map(({ title, items }) => `## ${title}\n\n${items.map(written).join('\n')}`);
  const text = [INTRODUCTION, contents.join(''), ...parts, ...parameterTables(parameters)].join('\n');
  return {
    text: text.replace(/\n{3,}/g, '\n\n'),
    undocumented: undocumented([...api.values(), ...types], parameters),
    names: [...api.keys()],
  };
}

const INTRODUCTION = `# API reference

Each heading is what its names are imported from, in browsers and in Node alike; \`tracecut/node\` has all of \`tracecut\` too.
`;

/** What writes an entry, in this order below each heading; types have a heading of their own. */
const WRITERS = { function: functionEntry, class: classEntry, const: typeEntry };

/** The types that exports mention, and those that these mention, unless they are internal to a constructor. */
function typesOf(dist, api) {
  const found = new Map();
  const visit = ({ kind, module, text, members }) => {
    const mentions = kind === 'class' ? members.map((member) => member.text).join('\n') : text;
    const imported = [...mentions.matchAll(/import\(['"]([^'"]+)['"]\)\.(\w+)/g)];
    const near = read(dist, module).filter(
      (one) => one.kind === 'type' && new RegExp(`\\b${one.name}\\b`).test(mentions),
    );
    const places = [
      ...imported.map(([, from, name]) => [resolved(module, from), name]),
      ...near.map(({ name }) => [module, name]),
    ];
    for (const type of places.map((place) => lookUp(dist, ...place))) {
      if (type?.kind !== 'type' || type.name === 'ParameterOptions' || found.get(type.name) === type) continue;
      if (found.has(type.name))
        throw new Error(`two types are called ${type.name}: in ${type.module} and ${found.get(type.name).module}`);
      found.set(type.name, type);
      visit(type);
    }
  };
  for (const item of api.values()) {
    if (item.kind === 'type' && !found.has(item.name)) found.set(item.name, item);
    visit(item);
  }
  return found;
}

/** Names without a description: of all, of members, of parameters, and of the options that an editor shows. */
function undocumented(items, parameters) {
  const types = items.filter(({ kind }) => kind === 'type');
  const isOptions = ({ name }) => name.endsWith('Options');
  // What options are put together of are options too.
  const parts = types.filter(isOptions).flatMap(({ text }) => text.split('{')[0].match(/\w+/g));
  const options = types.filter((type) => isOptions(type) || parts.includes(type.name));
  const fields = options.flatMap(({ name, text }) =>
    (fieldsWithoutWords(text) ?? []).map((field) => `${name}.${field}`),
  );
  const bare = items.filter(
    ({ kind, doc, text }) => !doc.words && !(kind === 'type' && fieldsWithoutWords(text)?.length === 0),
  );
  const members = items.flatMap((item) =>
    item.members.filter(({ doc }) => !doc.words).map(({ name }) => `${item.name}.${name}`),
  );
  const silent = parameters.filter(({ doc }) => !doc.trim());
  return [...new Set([...[...bare, ...silent].map(({ name }) => name), ...members, ...fields])];
}

/** The fields of an object type that have no comment of their own; undefined for a type without fields. */
function fieldsWithoutWords(text) {
  const fields = [...text.matchAll(/(\*\/\s*)?\n {4}(?:readonly )?(\w+)\??:/g)];
  return fields.length > 0 ? fields.filter(([, comment]) => !comment).map(([, , name]) => name) : undefined;
}

/** Links to headings, by their text; of headings that differ in capitals alone the second has a number, as on GitHub. */
function linksTo(headings) {
  const times = new Map();
  return new Map(
    headings.map((heading) => {
      const anchor = heading.toLowerCase().replaceAll(' ', '-').replaceAll('/', '');
      const before = times.get(anchor) ?? 0;
      times.set(anchor, before + 1);
      return [heading, `[${heading}](#${anchor}${before > 0 ? `-${before}` : ''})`];
    }),
  );
}

function functionEntry({ name, text, doc }, links) {
  return `### ${name}\n\n${fence(plainType(text).replace(/^function /, ''))}\n${described(doc, links)}${mentions(text, links, name)}`;
}

function classEntry({ name, text, doc, members }, links) {
  const parent = /^class \w+ extends (\w+)/.exec(text)?.[1];
  const extended = parent ? `Extends ${links.get(parent) ?? `\`${parent}\``}.\n\n` : '';
  const isMethod = (member) => /^(?!get )[^:]*\(/.test(member.text);
  const fields = members
    .filter((member) => !isMethod(member))
    .map((member) => {
      const [, type] = /^(?:get |readonly )*\w+(?:\(\))?: ([^]*)$/.exec(plainType(member.text));
      return `| \`${member.name}\` | ${cell(`\`${oneLine(type)}\``)} | ${cell(linked(oneLine(member.doc.words), links))} |\n`;
    });
  const table = fields.length > 0 ? `| property | type | |\n|---|---|---|\n${fields.join('')}\n` : '';
  const methods = members
    .filter(isMethod)
    .map((member) => `**\`${oneLine(plainType(member.text))}\`**\n\n${described(member.doc, links)}`);
  const used = mentions(members.map((member) => member.text).join('\n'), links, name);
  return `### ${name}\n\n${prose(doc, links)}${extended}${table}${methods.join('')}${used}`;
}

function typeEntry({ name, text, doc }, links) {
  return `### ${name}\n\n${prose(doc, links)}${fence(plainType(text))}\n${mentions(text, links, name)}`;
}

const prose = ({ words }, links) => (words ? `${linked(words, links)}\n\n` : '');

/** What is said of something, its parameters, its value and its errors. */
function described(doc, links) {
  const lines = doc.params.filter(([, words]) => words).map(([name, words]) => `- \`${name}\`: ${words}\n`);
  if (doc.returns) lines.push(`- returns ${doc.returns}\n`);
  for (const error of doc.throws) lines.push(`- throws ${error}\n`);
  return `${prose(doc, links)}${lines.length > 0 ? `${linked(lines.join(''), links)}\n` : ''}`;
}

/** Links to the entries of the types that a text mentions: a block of code can hold none. */
function mentions(text, links, own) {
  const code = plainType(text).replace(/\/\*\*[^]*?\*\//g, '');
  const names = [...new Set(code.match(/\b[A-Z]\w+\b/g) ?? [])].filter((name) => links.has(name) && name !== own);
  return names.length > 0 ? `See ${names.map((name) => links.get(name)).join(', ')}.\n` : '';
}

/** `{@link X}` as a link where X is listed. */
const linked = (words, links) => words.replace(/\{@link (\w+)\}/g, (_, name) => links.get(name) ?? `\`${name}\``);

/** Types without the modules that they come from and without the kind of buffer that every array here has. */
function plainType(text) {
  return text
    .replace(/import\(['"][^'"]+['"]\)\./g, '')
    .replaceAll('<ArrayBuffer>', '')
    .replace(/\/\*\*\s+\*?\s*([^]*?)\s*\*\//g, (_, words) => `/** ${words.replace(/\s*\n\s*\*\s*/g, ' ')} */`);
}

const fence = (code) => `\`\`\`ts\n${code.trim()}\n\`\`\`\n`;
const cell = (text) => text.replaceAll('|', '\\|');

const LEGAL = {
  boolean: () => 'true, false',
  choice: ({ choices }) => choices.join(', '),
  integer: ({ min, max }) => `${min} to ${max}, whole`,
  number: ({ min, max }) => `${min} to ${max}`,
};

/** What most users change, and what only research does. */
function parameterTables(parameters) {
  const [usual, expert] = [false, true].map((is) => parameters.filter((parameter) => Boolean(parameter.expert) === is));
  const about =
    'The parameter tree, such as `{ cut: { spatialWeight: 3 } }`; `parameters()` lists them at run time.\n\n';
  const parts = [`## Options of a session\n\n${about}${tables(usual)}`];
  if (expert.length > 0)
    parts.push(`## Options for experts\n\nOnly research changes these, in the same way.\n\n${tables(expert)}`);
  return parts;
}

function tables(parameters) {
  const row = ({ name, doc, default: initial, ...rest }) =>
    `| \`${name}\` | ${initial} | ${LEGAL[rest.kind](rest)} | ${cell(oneLine(doc))} |\n`;
  const groups = new Set(parameters.map(({ name }) => name.split('.')[0]));
  const parts = [...groups].map((group) => {
    const rows = parameters.filter(({ name }) => name.startsWith(`${group}.`)).map(row);
    return `### ${group}.*\n\n| parameter | default | legal | |\n|---|---|---|---|\n${rows.join('')}`;
  });
  return parts.join('\n');
}
