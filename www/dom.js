// Builds elements without markup strings or inline styles, which the content security policy forbids.

/**
 * Creates an element. Properties become attributes, functions listeners for the event of that name; `false` omits one.
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

/** Formats a number in English with `digits` decimals. */
export function number(value, digits = 0) {
  return value.toLocaleString('en', { minimumFractionDigits: digits, maximumFractionDigits: digits });
}
