// The documentation's search: every word of the query has to be in a section, and those come first whose title it is.

/** @typedef {import('./markdown.mjs').Section} Section */

/** What is looked for: words in small letters, parts of names too. @param {string} query */
export const wordsOf = (query) => query.toLowerCase().match(/[\p{L}\p{N}_.]+/gu) ?? [];

/**
 * @param {Section[]} index
 * @param {string} query
 * @param {number} [most] sections, at least 1
 * @returns {Section[]} best first; those that are equally good in the order of the pages
 */
export function find(index, query, most = 20) {
  const words = wordsOf(query);
  if (words.length === 0) return [];
  return index
    .map((section) => ({ section, score: scoreOf(section, words) }))
    .filter(({ score }) => score > 0)
    .sort((a, b) => b.score - a.score)
    .slice(0, most)
    .map(({ section }) => section);
}

/** 0 where a word is missing. @param {Section} section @param {string[]} words */
function scoreOf({ title, text }, words) {
  const [head, body] = [title.toLowerCase(), text.toLowerCase()];
  let sum = 0;
  for (const word of words) {
    const score = inTitle(head, word) + Math.min(body.split(word).length - 1, 5);
    if (score === 0) return 0;
    sum += score;
  }
  return sum;
}

function inTitle(title, word) {
  if (title === word) return 100;
  if (title.startsWith(word)) return 40;
  return title.includes(word) ? 20 : 0;
}

/**
 * A piece of a text around the first of some words.
 * @param {string} text
 * @param {string} query
 * @param {number} [length] in characters
 */
export function excerpt(text, query, length = 140) {
  const small = text.toLowerCase();
  const places = wordsOf(query).map((word) => small.indexOf(word));
  const first = Math.min(...places.filter((at) => at >= 0), text.length);
  const from = first === text.length ? 0 : Math.max(0, first - length / 3);
  const piece = text.slice(from, from + length);
  return `${from > 0 ? '…' : ''}${piece}${from + length < text.length ? '…' : ''}`;
}
