// Markdown to HTML: headings get the names that GitHub gives them, links to files of ours lead to their pages here, and
// to the repository where they have none.

import { existsSync } from 'node:fs';
import { join, posix } from 'node:path';
import { Marked } from 'marked';
import { root } from '../tools.mjs';

/**
 * @typedef {object} Section what the search looks through
 * @property {string} url below `docs/`
 * @property {string} page the title of its page
 * @property {string} title
 * @property {string} text
 */

const REPOSITORY = 'https://github.com/tracecut/tracecut/';
/** How a page of ours names a file of the repository from outside. */
export const OUTSIDE =
  /^https:\/\/(?:raw\.githubusercontent|github)\.com\/tracecut\/tracecut\/(?:(?:blob|tree)\/)?HEAD\//;

const escaped = (text) =>
  text.replace(/[&<>"]/g, (sign) => ({ '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;' })[sign]);

const markdown = new Marked({
  renderer: {
    heading({ tokens, depth, slug }) {
      const words = this.parser.parseInline(tokens);
      const anchor = `<a class="anchor" href="#${slug}" aria-hidden="true" tabindex="-1">#</a>`;
      return `<h${depth} id="${slug}">${words}${depth > 1 ? anchor : ''}</h${depth}>\n`;
    },
    image({ href, text }) {
      return `<img src="${escaped(href)}" alt="${escaped(text)}" loading="lazy">`;
    },
    table(token) {
      const cell = (tag, { tokens, align }) =>
        `<${tag}${align ? ` class="${align}"` : ''}>${this.parser.parseInline(tokens)}</${tag}>`;
      const row = (tag, cells) => `<tr>${cells.map((one) => cell(tag, one)).join('')}</tr>`;
      // A cell without words heads nothing.
      const head = token.header.map((one) => cell(one.text.trim() ? 'th' : 'td', one)).join('');
      const rows = token.rows.map((cells) => row('td', cells)).join('\n');
      const table = `<table>\n<thead><tr>${head}</tr></thead>\n<tbody>\n${rows}\n</tbody>\n</table>`;
      // Wider than a phone: it is scrolled sideways, by keyboard too.
      return `<div class="table" role="group" aria-label="Table" tabindex="0">\n${table}\n</div>\n`;
    },
    // Text and nothing else: no file of ours has HTML in it.
    html: ({ text }) => escaped(text),
  },
});

/** The parts of a text, each heading with the name by which it is jumped to. @param {string} text */
export function lex(text) {
  const tokens = [...markdown.lexer(text)];
  const seen = new Map();
  for (const token of tokens.filter(({ type }) => type === 'heading')) {
    const name = token.text
      .toLowerCase()
      .replaceAll(' ', '-')
      .replace(/[^\p{L}\p{N}_-]/gu, '');
    const count = seen.get(name) ?? 0;
    seen.set(name, count + 1);
    token.slug = count > 0 ? `${name}-${count}` : name;
  }
  return tokens;
}

const BLOCKS = ['blockquote', 'code', 'heading', 'list', 'paragraph', 'space', 'table'];

/** The words of tokens, without their marks. */
export function plain(tokens) {
  const words = (token) => {
    if (token.type === 'table')
      return [...token.header, ...token.rows.flat()].map(({ tokens: one }) => plain(one)).join(' ');
    if (token.type === 'list') return token.items.map((item) => plain(item.tokens)).join(' ');
    return token.tokens ? plain(token.tokens) : (token.text ?? '');
  };
  const apart = (token) => (BLOCKS.includes(token.type) ? ` ${words(token)} ` : words(token));
  return tokens.map(apart).join('').replace(/\s+/g, ' ').trim();
}

/** The page and place that a link into one of our files has here, or null. */
function placeOf(file, anchor, pages) {
  const parts = pages.filter(({ source }) => source === file);
  const holder = anchor ? parts.find(({ tokens }) => tokens.some(({ slug }) => slug === anchor)) : parts[0];
  return holder ? holder.path + (anchor ? `#${anchor}` : '') : null;
}

/**
 * What a link of a page becomes.
 * @param {string} href as the source has it
 * @param {import('./pages.mjs').Page} page
 * @param {import('./pages.mjs').Page[]} pages
 */
export function linkFrom(href, page, pages) {
  const isOurs = OUTSIDE.test(href);
  if (!isOurs && /^[a-z][a-z+.-]*:/i.test(href)) return href;
  const [path, anchor] = href.replace(OUTSIDE, '').split('#');
  const file = path ? posix.join(isOurs ? '.' : posix.dirname(page.source), path) : page.source;
  const place = placeOf(file.replace(/\/$/, ''), anchor, pages);
  if (place) return hopTo(place, page);
  if (!existsSync(join(root, file))) throw new Error(`${page.source}: the link ${href} leads nowhere.`);
  return `${REPOSITORY}blob/HEAD/${file}${anchor ? `#${anchor}` : ''}`;
}

/** The way from a page to a place below `docs/`. */
export function hopTo(place, { path }) {
  if (place.startsWith(`${path}#`)) return place.slice(path.length);
  return posix.relative(posix.dirname(path), place);
}

/**
 * A page's HTML, what the search is to know of it, and the pictures on it.
 * @param {import('./pages.mjs').Page} page
 * @param {import('./pages.mjs').Page[]} pages
 * @returns {{html: string, sections: Section[], pictures: string[]}}
 */
export function render(page, pages) {
  const pictures = [];
  const sections = sectionsOf(page);
  markdown.walkTokens(page.tokens, (token) => {
    if (token.type === 'link') token.href = linkFrom(token.href, page, pages);
    if (token.type === 'image') token.href = pictureFrom(token.href, page, pictures);
  });
  return { html: markdown.parser(page.tokens), sections, pictures };
}

/** Pictures lie beside the pages. */
function pictureFrom(href, page, pictures) {
  const base = OUTSIDE.test(href) ? '.' : posix.dirname(page.source);
  const file = posix.join(base, href.replace(OUTSIDE, ''));
  if (/^[a-z]+:/.test(file) || !existsSync(join(root, file))) throw new Error(`${page.source}: no picture ${href}`);
  pictures.push(file);
  return hopTo(`pictures/${file}`, page);
}

/** @param {import('./pages.mjs').Page} page @returns {Section[]} */
function sectionsOf({ path, title, tokens }) {
  const sections = [];
  for (const token of tokens) {
    if (token.type === 'heading') {
      const url = token.depth === 1 ? path : `${path}#${token.slug}`;
      sections.push({ url, page: title, title: plain(token.tokens), text: '' });
    } else if (sections.length > 0) sections.at(-1).text += ` ${plain([token])}`;
  }
  return sections.map((section) => ({ ...section, text: section.text.replace(/\s+/g, ' ').trim() }));
}
