// Which of the licences that a part offers is taken, its text as the part has it, and all texts as one file. Nearly all
// offer the MIT licence in the same words: these are printed once, with every copyright line.

import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { root } from '../tools.mjs';

/**
 * @typedef {object} Notice
 * @property {string} licence its SPDX identifier
 * @property {string} text
 */

/** How a licence's text is known, line breaks aside, in the order in which we choose where there is a choice. */
const KNOWN = {
  MIT: /Permission is hereby granted, free of charge, to any person obtaining a copy/,
  'BSD-2-Clause': /Redistribution and use in source and binary forms(?!.*Neither the name)/,
  'BSD-3-Clause': /Redistribution and use in source and binary forms.*Neither the name/,
  Zlib: /misrepresented as being the original software/,
  'Unicode-3.0': /UNICODE LICENSE V3/i,
  'Apache-2.0': /Apache License,? Version 2\.0/,
  'MPL-2.0': /Mozilla Public License,? Version 2\.0/i,
};

/** Words of a text, without its line breaks. */
const flat = (text) => text.replace(/\s+/g, ' ').trim();

const ourMit = readFileSync(join(root, 'LICENSE-MIT'), 'utf8').replaceAll('\r', '');
const MIT_WORDS = ourMit.slice(ourMit.indexOf('Permission is hereby granted')).trim();

/** The MIT licence of who has none in a file. @param {string} copyright @returns {Notice} */
export function plainMit(copyright) {
  return { licence: 'MIT', text: `${copyright}\n\n${MIT_WORDS}` };
}

/**
 * The alternatives that an SPDX expression of AND, OR and brackets allows: one of the lists has to be kept in full.
 * @param {string} expression
 * @returns {string[][]}
 */
export function alternatives(expression) {
  const tokens = expression.match(/\(|\)|[^\s()]+/g) ?? [];
  const any = () => {
    let found = all();
    while (tokens[0] === 'OR' && tokens.shift()) found = found.concat(all());
    return found;
  };
  const all = () => {
    let found = one();
    while (tokens[0] === 'AND' && tokens.shift()) {
      const more = one();
      found = found.flatMap((left) => more.map((right) => [...left, ...right]));
    }
    return found;
  };
  const one = () => {
    const token = tokens.shift();
    if (token !== '(') return [[token]];
    const found = any();
    tokens.shift();
    return found;
  };
  return any();
}

/**
 * The texts that a part's licence asks for, from its own files.
 * @param {string} folder where the part's files are
 * @param {string} expression its licence as SPDX has it
 * @param {string} copyright who holds it, where no file says so
 * @returns {Notice[]}
 */
export function noticesIn(folder, expression, copyright) {
  const names = readdirSync(folder).filter((name) => /^(un)?licen[cs]e|^copying|^notice/i.test(name));
  const texts = names.sort().map((name) => readFileSync(join(folder, name), 'utf8').replaceAll('\r', '').trim());
  const found = (licence) =>
    texts.filter((text) => KNOWN[licence].test(flat(text))).sort((a, b) => a.length - b.length)[0];
  const rank = (list) => Math.max(...list.map((licence) => Object.keys(KNOWN).indexOf(licence)));
  const known = alternatives(expression).filter((list) => list.every((licence) => licence in KNOWN));
  const inOrder = known.sort((a, b) => rank(a) - rank(b));
  const chosen = inOrder.find((list) => list.every(found));
  if (chosen) return chosen.map((licence) => ({ licence, text: found(licence) }));
  if (inOrder[0]?.join() === 'MIT') return [plainMit(copyright)];
  throw new Error(`${folder}: no text for the licence ${expression}`);
}

/** The copyright lines of a text that is the MIT licence and nothing else, or null. @param {string} text */
export function mitHolders(text) {
  const start = text.search(/Permission\s+is\s+hereby\s+granted/);
  if (start < 0 || flat(text.slice(start)).toLowerCase() !== flat(MIT_WORDS).toLowerCase()) return null;
  const lines = text.slice(0, start).split('\n');
  return lines.map(flat).filter((line) => line && !/^(#+ )?(the )?mit licen[cs]e( \(mit\))?$/i.test(line));
}

const RULE = `\n\n${'-'.repeat(80)}\n\n`;

/**
 * All licences as one text: what is within, then each text once with whom it is of.
 * @param {import('./sbom.mjs').Part[]} parts in the order of the list
 */
export function licencesText(parts) {
  return `${[contents(parts), ...sourcesOf(parts), mitSection(parts), ...otherSections(parts)].join(RULE)}\n`;
}

const title = ({ name, version }) => `${name} ${version}`;
const taken = ({ notices }) => notices.map(({ licence }) => licence).join(' AND ');

function contents(parts) {
  const lines = parts.map(
    (part) => `- ${title(part)}, ${taken(part)}, in ${[...part.files].join(', ')}: ${part.source}`,
  );
  const head = [
    'TraceCut itself is licensed under MIT or Apache-2.0, as you like: see LICENSE-MIT and LICENSE-APACHE.',
    'Its files hold the following work of others. Where these offer several licences, the one that is',
    'named here was taken.',
  ];
  return `${head.join('\n')}\n\n${lines.join('\n')}`;
}

/** The Mozilla Public License wants to be told where the source is. */
function sourcesOf(parts) {
  return parts
    .filter(({ notices }) => notices.some(({ licence }) => licence === 'MPL-2.0'))
    .map(
      (part) =>
        `${title(part)} is covered by the Mozilla Public License 2.0, the rest of this package is not. It is\n` +
        `unchanged, bundled and minified in ${[...part.files].join(', ')}. Its source code is the folder src of the\n` +
        `npm package ${part.name}@${part.version}, and at ${part.source}.`,
    );
}

function mitSection(parts) {
  const holders = parts.flatMap((part) =>
    part.notices
      .filter(({ licence, text }) => licence === 'MIT' && mitHolders(text))
      .map(({ text }) =>
        `${title(part)}\n${mitHolders(text)
          .map((line) => `    ${line}`)
          .join('\n')}`.trim(),
      ),
  );
  return `MIT License\n\n${holders.join('\n')}\n\n${MIT_WORDS}`;
}

/** Texts in words of their own, equal ones once. */
function otherSections(parts) {
  const users = new Map();
  for (const part of parts)
    for (const { licence, text } of part.notices) {
      if (licence === 'MIT' && mitHolders(text)) continue;
      users.set(text, [...(users.get(text) ?? []), title(part)]);
    }
  return [...users].map(([text, titles]) => `${titles.join(', ')}\n\n${text}`);
}
