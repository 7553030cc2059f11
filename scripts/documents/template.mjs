// A page of the documentation around its text: head, navigation, search.

import { hopTo, plain } from './markdown.mjs';
import { GROUPS } from './pages.mjs';

const POLICY =
  "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; base-uri 'none'; form-action 'none'";

const escaped = (text) => text.replaceAll('&', '&amp;').replaceAll('<', '&lt;').replaceAll('"', '&quot;');

/**
 * @param {import('./pages.mjs').Page} page
 * @param {{html: string}} made
 * @param {import('./pages.mjs').Page[]} pages
 */
export function pageOf(page, { html }, pages) {
  const to = (/** @type {string} */ place) => hopTo(place, page);
  return `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="${POLICY}">
<meta name="color-scheme" content="light dark">
<title>${escaped(page.title)} · TraceCut</title>
<link rel="icon" href="${to('../favicon.svg')}" type="image/svg+xml">
<link rel="stylesheet" href="${to('docs.css')}">
<script src="${to('search.js')}" defer></script>
</head>
<body>
<a class="skip" href="#text">To the text</a>
<header class="top">
<p class="brand"><a href="${to('../index.html')}">TraceCut</a> <span>documentation</span></p>
<form class="search" role="search" hidden>
<input type="search" aria-label="Search the documentation" placeholder="Search" autocomplete="off" spellcheck="false">
</form>
<a class="to-pages" href="#pages">All pages</a>
</header>
<section class="results" aria-label="Search results" hidden>
<p role="status"></p>
<ol></ol>
</section>
<div class="columns">
<main id="text">
${html}</main>
<nav id="pages" aria-label="Pages">
${GROUPS.map((group) => groupOf(group, page, pages)).join('')}</nav>
</div>
</body>
</html>
`;
}

function groupOf(group, page, pages) {
  const items = pages.filter((one) => one.group === group).map((one) => itemOf(one, page));
  return items.length > 0 ? `<p class="group">${group}</p>\n<ul>\n${items.join('')}</ul>\n` : '';
}

/** A page in the navigation; below the one that is open, its parts. */
function itemOf(one, page) {
  const link = (/** @type {string} */ place, /** @type {string} */ title, here = '') =>
    `<a href="${hopTo(place, page)}"${here}>${escaped(title)}</a>`;
  if (one !== page) return `<li>${link(one.path, one.title)}</li>\n`;
  const parts = page.tokens.filter(({ type, depth }) => type === 'heading' && depth === 2);
  const inner = parts.map((part) => `<li>${link(`${one.path}#${part.slug}`, plain([part]))}</li>`).join('\n');
  return `<li>${link(one.path, one.title, ' aria-current="page"')}\n<ul>\n${inner}\n</ul>\n</li>\n`;
}
