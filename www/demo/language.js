/**
 * The language of the page. English stands where it is shown and is the key to the tables of the other languages, one
 * file each in words/. What a table does not have stays English.
 * @module
 */

/** The languages there are, each by its own name. */
export const LANGUAGES = /** @type {const} */ ({ en: 'English', de: 'Deutsch' });

/** @typedef {keyof typeof LANGUAGES} Language */

/** Under which it is kept that a visitor chose a language. */
const KEPT = 'tracecut-language';

/** Attributes that are read, by eye or aloud. */
const READ = ['title', 'aria-label', 'alt', 'placeholder'];

/** @type {ReadonlyMap<string, string>} */
let table = new Map();

/** @type {Language} */
let language = 'en';

/**
 * A sentence in the language of the page: `say('Save')`, or as a tag, say`Saved ${file}, ${size}.`; the key of the
 * latter is `Saved {0}, {1}.`
 *
 * @param {string | TemplateStringsArray} text in English
 * @param {...unknown} values what comes between the parts of a template, in the language of the page
 * @returns {string}
 */
export function say(text, ...values) {
  const key = typeof text === 'string' ? text : text.reduce((before, part, k) => `${before}{${k - 1}}${part}`);
  const words = table.get(key) ?? key;
  // What is put in may itself look like a place to fill.
  return values.length === 0 ? words : words.replace(/\{(\d+)\}/g, (_, k) => String(values[Number(k)]));
}

/** @returns {Language} that is shown */
export function shownLanguage() {
  return language;
}

/**
 * What the address asks for, else what was chosen before, else what the browser prefers, else English.
 *
 * @returns {Language}
 */
export function wantedLanguage() {
  const wishes = [new URLSearchParams(location.search).get('lang'), keptChoice(), navigator.language?.slice(0, 2)];
  return wishes.find(isLanguage) ?? 'en';
}

/**
 * Fetches the table of a language and puts the words of index.html into it. To be called before anything else is
 * written into the page.
 *
 * @param {Language} code
 */
export async function chooseLanguage(code) {
  if (code === 'en') return;
  const { default: words } = await import(`./words/${code}.js`);
  table = new Map(Object.entries(words));
  language = code;
  document.documentElement.lang = code;
  document.title = say(document.title);
  translate(document.body);
}

/**
 * Keeps the choice and loads the page anew: whoever has work that is not kept is asked before.
 *
 * @param {Language} code
 */
export function changeLanguage(code) {
  try {
    localStorage.setItem(KEPT, code);
  } catch {
    // Nothing is kept here: the address says it.
  }
  const address = new URL(location.href);
  if (!address.searchParams.has('lang') && keptChoice() === code) return location.reload();
  address.searchParams.set('lang', code);
  location.assign(address);
}

/** @returns {string | null} a browser may refuse to keep anything */
function keptChoice() {
  try {
    return localStorage.getItem(KEPT);
  } catch {
    return null;
  }
}

/**
 * @param {unknown} code
 * @returns {code is Language}
 */
function isLanguage(code) {
  return typeof code === 'string' && Object.hasOwn(LANGUAGES, code);
}

/**
 * Texts and attributes of an element and of all within it.
 *
 * @param {Element} root
 */
function translate(root) {
  if (root.matches('noscript, svg, script')) return;
  for (const name of READ) {
    const text = root.getAttribute(name);
    if (text) root.setAttribute(name, say(text));
  }
  for (const node of root.childNodes) {
    if (node instanceof Element) translate(node);
    if (node instanceof Text) translateText(node);
  }
}

/** @param {Text} node the room around the words stays, unless nothing is said */
function translateText(node) {
  const words = node.data.trim();
  const said = say(words);
  if (said !== words) node.data = said && node.data.replace(words, () => said);
}
