// The order of files by their names.

/**
 * Orders names of files as a person would: digits by their value, letters whatever their case (`IMG_2` before `img_10`),
 * then by the exact name; the same everywhere, whatever the language of the machine. For `sort`.
 * @param {string} a
 * @param {string} b
 * @returns {number} below 0 where `a` comes first, above 0 where `b` does
 */
export function compareNames(a, b) {
  const [first, second] = [partsOf(a), partsOf(b)];
  for (let k = 0; k < Math.min(first.length, second.length); k += 1) {
    const found = compared(String(first[k]), String(second[k]));
    if (found !== 0) return found;
  }
  return first.length - second.length || order(a, b);
}

/** Numbers, and the other letters one by one. @param {string} name */
const partsOf = (name) => name.toLowerCase().match(/\d+|\D/gu) ?? [];

/**
 * @param {string} a
 * @param {string} b
 */
function compared(a, b) {
  if (!/^\d/.test(a) || !/^\d/.test(b)) return order(a, b);
  const [first, second] = [a, b].map((digits) => digits.replace(/^0+(?=\d)/, ''));
  return Number(first?.length) - Number(second?.length) || order(String(first), String(second));
}

/**
 * @param {string} a
 * @param {string} b
 */
const order = (a, b) => (a < b ? -1 : Number(a > b));
