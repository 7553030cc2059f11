// Helpers that build elements without inline styles, which the page's policy forbids.

/** True on touch screens. */
export const TOUCH = matchMedia('(pointer: coarse)').matches;

/** True if the browser can decode H.264. */
export const PLAYS_MP4 = document.createElement('video').canPlayType('video/mp4; codecs="avc1.42001f"') !== '';

/**
 * Creates an element.
 * @param props attributes; functions are listeners under the event's name; `false` omits an attribute
 */
export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  props: Record<string, string | boolean | number | ((event: never) => void)> = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(props)) {
    if (typeof value === 'function') element.addEventListener(name, value as EventListener);
    else if (value === true) element.setAttribute(name, '');
    else if (value !== false) element.setAttribute(name, String(value));
  }
  element.append(...children);
  return element;
}

/** Returns the element of index.html with this id. */
export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (!element) throw new Error(`index.html has no element #${id}`);
  return element as T;
}

export function icon(symbol: string): SVGSVGElement {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  const use = document.createElementNS('http://www.w3.org/2000/svg', 'use');
  use.setAttribute('href', `#${symbol}`);
  svg.setAttribute('class', 'icon');
  svg.setAttribute('aria-hidden', 'true');
  svg.append(use);
  return svg;
}

export function isMultiSelect({ shiftKey, ctrlKey, metaKey }: MouseEvent | KeyboardEvent) {
  return shiftKey || ctrlKey || metaKey;
}

/** Closes a dialog on a click outside. */
export function connectDialog(dialog: HTMLDialogElement) {
  dialog.addEventListener('click', (event) => {
    if (event.target !== dialog) return;
    const { left, right, top, bottom } = dialog.getBoundingClientRect();
    const inside = event.clientX >= left && event.clientX <= right && event.clientY >= top && event.clientY <= bottom;
    if (!inside) dialog.close();
  });
}
