/**
 * Small helpers to build elements without a framework and without inline styles, which the page's policy forbids.
 * @module
 */

/** Whether fingers point here: words say “tap” then. */
export const TOUCH = matchMedia('(pointer: coarse)').matches;

/** Whether there is a decoder for H.264. */
export const PLAYS_MP4 = document.createElement('video').canPlayType('video/mp4; codecs="avc1.42001f"') !== '';

/**
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, string | boolean | number | ((event: never) => void)>} [props] attributes; functions are
 *   listeners under the event's name; `false` leaves an attribute out
 * @param {...(Node | string)} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function h(tag, props = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(props)) {
    if (typeof value === 'function') element.addEventListener(name, /** @type {EventListener} */ (value));
    else if (value === true) element.setAttribute(name, '');
    else if (value !== false) element.setAttribute(name, String(value));
  }
  element.append(...children);
  return element;
}

/**
 * @template {HTMLElement} [T=HTMLElement]
 * @param {string} id
 * @returns {T} the element of index.html with this id
 */
export function byId(id) {
  const element = document.getElementById(id);
  if (!element) throw new Error(`index.html has no element #${id}`);
  return /** @type {T} */ (element);
}

/**
 * @param {string} symbol id of a `<symbol>` in index.html
 * @returns {SVGSVGElement}
 */
export function icon(symbol) {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  const use = document.createElementNS('http://www.w3.org/2000/svg', 'use');
  use.setAttribute('href', `#${symbol}`);
  svg.setAttribute('class', 'icon');
  svg.setAttribute('aria-hidden', 'true');
  svg.append(use);
  return svg;
}

/**
 * One line of a legend: a mark and what it means.
 *
 * @param {'dot' | 'line' | 'thin'} kind
 * @param {string} color
 * @param {string} text
 * @returns {HTMLElement}
 */
export function key(kind, color, text) {
  const mark = h('span', { class: `mark mark-${kind}`, 'aria-hidden': 'true' });
  mark.style.setProperty('--mark', color);
  return h('span', { class: 'key' }, mark, text);
}

/** @param {MouseEvent | KeyboardEvent} event */
export function choosesMore({ shiftKey, ctrlKey, metaKey }) {
  return shiftKey || ctrlKey || metaKey;
}

/**
 * A click beside a dialog closes it.
 *
 * @param {HTMLDialogElement} dialog
 */
export function connectDialog(dialog) {
  dialog.addEventListener('click', (event) => {
    if (event.target !== dialog) return;
    const { left, right, top, bottom } = dialog.getBoundingClientRect();
    const inside = event.clientX >= left && event.clientX <= right && event.clientY >= top && event.clientY <= bottom;
    if (!inside) dialog.close();
  });
}
