// The search box of the documentation's pages: fetches the index when the box is first used, and lists what it finds.

import { excerpt, find } from './find.mjs';

const here = /** @type {HTMLScriptElement} */ (document.currentScript).src;
const form = document.querySelector('form.search');
const box = form.querySelector('input');
const results = document.querySelector('.results');
const list = results.querySelector('ol');
const status = results.querySelector('[role="status"]');

let coming;

/** The index, from beside this script. */
function index() {
  coming ??= new Promise((done, failed) => {
    const script = document.createElement('script');
    script.src = new URL('search-index.js', here).href;
    script.onload = () => done(globalThis.tracecutDocs);
    script.onerror = () => {
      coming = undefined;
      failed(new Error('The index is not there.'));
    };
    document.head.append(script);
  });
  return coming;
}

async function search() {
  const query = box.value;
  results.hidden = query.trim() === '';
  if (results.hidden) return;
  try {
    const found = find(await index(), query);
    if (query === box.value) show(found, query);
  } catch {
    list.replaceChildren();
    status.textContent = 'The index does not come: there is no network.';
  }
}

function show(found, query) {
  list.replaceChildren(...found.map((section) => item(section, query)));
  status.textContent = found.length === 0 ? `Nothing has “${query.trim()}” in it.` : `${found.length} found`;
}

function item({ url, page, title, text }, query) {
  const link = document.createElement('a');
  link.href = new URL(url, here).href;
  link.append(title);
  const about = document.createElement('span');
  about.append(title === page ? '' : `${page}: `, excerpt(text, query));
  const entry = document.createElement('li');
  entry.append(link, about);
  return entry;
}

function close() {
  box.value = '';
  results.hidden = true;
}

form.hidden = false;
box.addEventListener('focus', () => index().catch(() => {}));
box.addEventListener('input', search);
form.addEventListener('submit', (event) => {
  event.preventDefault();
  list.querySelector('a')?.click();
});
// A result may be on this very page.
list.addEventListener('click', (event) => event.target instanceof HTMLAnchorElement && close());
addEventListener('keydown', (event) => {
  if (event.key === 'Escape' && !results.hidden) {
    close();
    box.focus();
  } else if (event.key === '/' && document.activeElement !== box) {
    event.preventDefault();
    box.focus();
  }
});
