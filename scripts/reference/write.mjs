// Writes the reference: Markdown from what the package exports and from its list of parameters.

import { exportsOf, lookUp, read, resolved } from './read.mjs';

const INTRODUCTION = `# API reference

Written from the package's declarations by \`node scripts/reference.mjs\`; the text of each entry stands in the source. Each heading is
what its functions are imported from, in browsers and in Node alike; \`tracecut/node\` has all of \`tracecut\` too, and
\`tracecut/inline\` all but what Node alone has.
`;

/** What the package is imported by, and the module that has it. */
const ENTRIES = [
  ['tracecut', 'index.js'],
  ['tracecut/draw', 'draw.js'],
  ['tracecut/edit', 'edit.js'],
  ['tracecut/export', 'export.js'],
  ['tracecut/stages', 'stages.js'],
  ['tracecut/node', 'node/frames.js'],
  ['tracecut/selftest', 'selftest.js'],
];

/** In this order in each entry; types have a section of their own. */
const KINDS = { function: functionEntry, class: classEntry, const: typeEntry };

/**
 * @param {string} dist
 * @param {readonly {name: string, doc: string, kind: string, min: number, max: number, default: unlinks, choices?:
 *   string[]}[]} parameters
 * @returns {{text: string, undocumented: string[], names: string[]}} the Markdown, the names that lack a description,
 *   and all names
 */
export function reference(dist, parameters) {
  const entries = ENTRIES.map(([title, module]) => ({ title, items: exportsOf(dist, module) }));
  const api = new Map(entries.flatMap(({ items }) => [...items]));
  const types = typesOf(dist, api);
  const all = [...api.values()];
  const sorted = [...types.values()].sort((a, b) => (a.name < b.name ? -1 : 1));
  const sections = [
    ...entries.map(({ title, items }) => ({
      title,
      items: Object.keys(KINDS).flatMap((kind) => [...items.values()].filter((item) => item.kind === kind)),
    })),
    { title: 'Types', items: sorted },
  ];
  const links = linksTo(sections.flatMap(({ title, items }) => [title, ...items.map(({ name }) => name)]));
  const written = (item) => (KINDS[item.kind] ?? typeEntry)(item, links);
  const parts = sections.map(({ title, items }) => `## ${title}\n\n${items.map(written).join('\n')}`);
  const contents = sections
    .map(({ title, items }) => `- ${links.get(title)}: ${items.map(({ name }) => links.get(name)).join(', ')}\n`)
    .join('');
  const text = [
    INTRODUCTION,
    `${contents}- [Options of a session](#options-of-a-session)\n`,
    ...parts,
    parameterTables(parameters),
  ]
    .join('\n')
    .replace(/\n{3,}/g, '\n\n');
  return { text, undocumented: undocumented([...all, ...types.values()], parameters), names: [...api.keys()] };
}

/** The types that exports mention, and those that these mention, unless they are internal to a constructor. */
function typesOf(dist, api) {
  const found = new Map();
  const visit = (item) => {
    const text =
      item.kind === 'class'
        ? item.members.map((member) => member.text).join('\n') +
          (item.text.match(/^class \w+ extends (\w+)/)?.[0] ?? '')
        : item.text;
    const mentioned = [...text.matchAll(/import\(['"]([^'"]+)['"]\)\.(\w+)/g)].map(([, from, name]) =>
      lookUp(dist, resolved(item.module, from), name),
    );
    const near = read(dist, item.module).filter(
      ({ kind, name }) => kind === 'type' && new RegExp(`\\b${name}\\b`).test(text),
    );
    for (const type of [...mentioned, ...near.map(({ name }) => lookUp(dist, item.module, name))]) {
      if (!type || type.kind !== 'type' || type.name === 'ParameterOptions' || found.get(type.name) === type) continue;
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

function undocumented(items, parameters) {
  const lacking = items.flatMap((item) => {
    const missing = item.members.filter(({ doc }) => !doc.words).map(({ name }) => `${item.name}.${name}`);
    const described = item.doc.words || (item.kind === 'type' && fieldsWithoutWords(item.text)?.length === 0);
    return described ? missing : [item.name, ...missing];
  });
  lacking.push(...undescribedOptions(items.filter(({ kind }) => kind === 'type')));
  return [...new Set(lacking), ...parameters.filter(({ doc }) => !doc.trim()).map(({ name }) => name)];
}

/** The fields of an object type that have no comment of their own; undefined for a type without fields. */
function fieldsWithoutWords(text) {
  const fields = [...text.matchAll(/(\*\/\s*)?\n {4}(?:readonly )?(\w+)\??:/g)];
  return fields.length > 0 ? fields.filter(([, comment]) => !comment).map(([, , name]) => name) : undefined;
}

/** Options that an editor would show no words for: of types called so, and of the types that these are put together of. */
function undescribedOptions(types) {
  const options = types.filter(({ name }) => name.endsWith('Options'));
  const parts = options.flatMap(({ text }) => text.split('{')[0].match(/\w+/g));
  return types
    .filter(({ name }) => name.endsWith('Options') || parts.includes(name))
    .flatMap(({ name, text }) => (fieldsWithoutWords(text) ?? []).map((field) => `${name}.${field}`));
}

/**
 * Links to headings, by their text. A second heading that differs in its capitals alone has a number at its anchor, as
 * on GitHub.
 * @param {string[]} headings in the order of the page
 */
function linksTo(headings) {
  const times = new Map([['api-reference', 1]]);
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
  return `### ${name}\n\n${fence(plainType(text).replace(/^function /, ''))}\n${prose(doc, links)}${details(doc, links)}${mentions(text, links, name)}`;
}

function classEntry({ name, text, doc, members }, links) {
  const parent = /^class \w+ extends (\w+)/.exec(text)?.[1];
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
    .map(
      (member) =>
        `**\`${oneLine(plainType(member.text))}\`**\n\n${prose(member.doc, links)}${details(member.doc, links)}`,
    );
  const extended = parent ? `Extends ${links.get(parent) ?? `\`${parent}\``}.\n\n` : '';
  return `### ${name}\n\n${prose(doc, links)}${extended}${table}${methods.join('')}${mentions(members.map((member) => member.text).join('\n'), links, name)}`;
}

function typeEntry({ name, text, doc }, links) {
  return `### ${name}\n\n${prose(doc, links)}${fence(plainType(text))}\n${mentions(text, links, name)}`;
}

function prose({ words }, links) {
  return words ? `${linked(words, links)}\n\n` : '';
}

/** What is said of parameters, the value and errors. */
function details({ params, returns, throws }, links) {
  const lines = [...params].map(([name, meaning]) => `- \`${name}\`: ${linked(meaning, links)}\n`);
  if (returns) lines.push(`- returns ${linked(returns, links)}\n`);
  for (const error of throws) lines.push(`- throws ${linked(error, links)}\n`);
  return lines.length > 0 ? `${lines.join('')}\n` : '';
}

/** Links to the entries of the types that a text mentions: a block of code can hold none. */
function mentions(text, links, own) {
  const code = plainType(text).replace(/\/\*\*[^]*?\*\//g, '');
  const names = [...new Set(code.match(/\b[A-Z]\w+\b/g) ?? [])].filter((name) => links.has(name) && name !== own);
  return names.length > 0 ? `See ${names.map((name) => links.get(name)).join(', ')}.\n` : '';
}

/** `{@link X}` as a link where X is listed. */
function linked(words, links) {
  return words.replace(/\{@link (\w+)\}/g, (_, name) => links.get(name) ?? `\`${name}\``);
}

/** Types without the modules that they come from and without the kind of buffer that every array here has. */
function plainType(text) {
  return text
    .replace(/import\(['"][^'"]+['"]\)\./g, '')
    .replaceAll('<ArrayBuffer>', '')
    .replace(/\/\*\*\s+\*?\s*([^]*?)\s*\*\//g, (_, words) => `/** ${words.replace(/\s*\n\s*\*\s*/g, ' ')} */`);
}

const fence = (code) => `\`\`\`ts\n${code.trim()}\n\`\`\`\n`;
const oneLine = (text) => text.replace(/\s+/g, ' ').trim();
const cell = (text) => text.replaceAll('|', '\\|');

function parameterTables(parameters) {
  const groups = new Map();
  for (const parameter of parameters) {
    const [group] = parameter.name.split('.');
    groups.set(group, [...(groups.get(group) ?? []), parameter]);
  }
  const tables = [...groups].map(([group, list]) => {
    const rows = list.map(({ name, doc, kind, min, max, choices, default: initial }) => {
      const legal =
        kind === 'boolean'
          ? 'true, false'
          : kind === 'choice'
            ? choices.join(', ')
            : `${min} to ${max}${kind === 'integer' ? ', whole' : ''}`;
      return `| \`${name}\` | ${initial} | ${legal} | ${cell(oneLine(doc))} |\n`;
    });
    return `### ${group}.*\n\n| parameter | default | legal | |\n|---|---|---|---|\n${rows.join('')}`;
  });
  return `## Options of a session\n\nThe parameter tree, such as \`{ cut: { spatialWeight: 3 } }\`; \`parameters()\` lists them at run time.\n\n${tables.join('\n')}`;
}
