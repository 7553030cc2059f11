// Which of the licences that a part offers is taken, its text as the part has it, and all texts as one file. Nearly all
// offer the MIT licence in the same words: these are printed once, with every copyright line.

import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { root } from './tools.mjs';

/** @typedef {{licence: string, text: string}} Notice an SPDX identifier and the licence's text */

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
export const plainMit = (copyright) => ({ licence: 'MIT', text: `${copyright}\n\n${MIT_WORDS}` });

/**
 * The texts that a part's licence asks for, from its own files.
 * @param {string} folder where the part's files are
 * @param {string} expression its licence as SPDX has it: choices of OR, joined by AND
 * @param {string} copyright who holds it, where no file says so
 * @returns {Notice[]}
 */
export function noticesIn(folder, expression, copyright) {
  const names = readdirSync(folder).filter((name) => /^(un)?licen[cs]e|^copying|^notice/i.test(name));
  const texts = names.sort().map((name) => readFileSync(join(folder, name), 'utf8').replaceAll('\r', '').trim());
  const textOf = (licence) =>
    texts.filter((text) => KNOWN[licence].test(flat(text))).sort((a, b) => a.length - b.length)[0];
  return expression.split(' AND ').map((choices) => {
    const offered = choices.replace(/[()]/g, '').split(' OR ');
    const known = Object.keys(KNOWN).filter((licence) => offered.includes(licence));
    const licence = known.find(textOf);
    if (licence) return { licence, text: textOf(licence) };
    if (known[0] === 'MIT') return plainMit(copyright);
    throw new Error(`${folder}: no text for the licence ${expression}`);
  });
}

/** The copyright lines of a text that is the MIT licence and nothing else, or null. */
function mitHolders({ licence, text }) {
  const start = text.search(/Permission\s+is\s+hereby\s+granted/);
  if (licence !== 'MIT' || flat(text.slice(start)).toLowerCase() !== flat(MIT_WORDS).toLowerCase()) return null;
  const lines = text.slice(0, start).split('\n').map(flat);
  return lines.filter((line) => line && !/^(#+ )?(the )?mit licen[cs]e( \(mit\))?$/i.test(line));
}

const title = ({ name, version }) => `${name} ${version}`;

/**
 * All licences as one text: what is within, then each text once with whom it is of.
 * @param {import('./licences.mjs').Part[]} parts in the order of the list
 */
export function licencesText(parts) {
  const notices = parts.flatMap((part) => part.notices.map((notice) => ({ part, ...notice })));
  const sections = [contents(parts), ...parts.filter(isMozilla).map(sourceOf), mitSection(notices)];
  return `${[...sections, ...otherSections(notices)].join(`\n\n${'-'.repeat(80)}\n\n`)}\n`;
}

function contents(parts) {
  const taken = ({ notices }) => notices.map(({ licence }) => licence).join(' AND ');
  const lines = parts.map(
    (part) => `- ${title(part)}, ${taken(part)}, in ${[...part.files].join(', ')}: ${part.source}`,
  );
  return `TraceCut itself is licensed under MIT or Apache-2.0, as you like: see LICENSE-MIT and LICENSE-APACHE.
Its files hold the following work of others. Where these offer several licences, the one that is
named here was taken.

${lines.join('\n')}`;
}

const isMozilla = ({ notices }) => notices.some(({ licence }) => licence === 'MPL-2.0');

/** The Mozilla Public License wants to be told where the source is. */
const sourceOf = (part) =>
  `${title(part)} is covered by the Mozilla Public License 2.0, the rest of this package is not. It is
unchanged, bundled and minified in ${[...part.files].join(', ')}. Its source code is the folder src of the
npm package ${part.name}@${part.version}, and at ${part.source}.`;

function mitSection(notices) {
  const holders = notices
    .filter(mitHolders)
    .map((notice) => [title(notice.part), ...mitHolders(notice).map((line) => `    ${line}`)].join('\n'));
  return `MIT License\n\n${holders.join('\n')}\n\n${MIT_WORDS}`;
}

/** Texts in words of their own, equal ones once. */
function otherSections(notices) {
  const users = new Map();
  for (const { part, ...notice } of notices)
    if (!mitHolders(notice)) users.set(notice.text, [...(users.get(notice.text) ?? []), title(part)]);
  return [...users].map(([text, titles]) => `${titles.join(', ')}\n\n${text}`);
}
