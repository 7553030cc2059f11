// Builds elements without markup in strings and inline styles, which the page's policy forbids.

/**
 * Creates an element. Properties are attributes; functions are listeners by the event's name, `false` leaves one out.
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, any>} [properties]
 * @param {...(Node | string)} children
 */
export function h(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (typeof value === 'function') element.addEventListener(name, value);
    else if (value !== false) element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children);
  return element;
}

/** Finds an element of index.html. @param {string} id @returns {any} */
export const byId = (id) => document.getElementById(id);

/** Formats a number the English way, with some digits after the point. */
export function number(value, digits = 0) {
  return value.toLocaleString('en', { minimumFractionDigits: digits, maximumFractionDigits: digits });
}
