// Pictures with fewer pixels.

/**
 * Each pixel of the answer is the mean of what it covers, so nothing aliases; a canvas would do this differently in
 * each browser.
 * @param {{data: Uint8Array, width: number, height: number}} frame RGBA
 * @param {number} width at most the frame's
 * @param {number} height
 */
export function reduced({ data, width: fromWidth, height: fromHeight }, width, height) {
  const out = new Uint8ClampedArray(4 * width * height);
  const row = new Float32Array(4 * fromWidth);
  const columns = spans(fromWidth, width);
  const rows = spans(fromHeight, height);
  const area = (fromWidth / width) * (fromHeight / height);
  rows.forEach((span, y) => {
    row.fill(0);
    for (let sy = span.first; sy <= span.last; sy += 1) addRow(row, data, 4 * fromWidth * sy, weight(span, sy));
    columns.forEach((column, x) => {
      const at = 4 * (y * width + x);
      let [red, green, blue, alpha] = [0, 0, 0, 0];
      for (let sx = column.first; sx <= column.last; sx += 1) {
        const share = weight(column, sx) / area;
        red += share * /** @type {number} */ (row[4 * sx]);
        green += share * /** @type {number} */ (row[4 * sx + 1]);
        blue += share * /** @type {number} */ (row[4 * sx + 2]);
        alpha += share * /** @type {number} */ (row[4 * sx + 3]);
      }
      out[at] = red;
      out[at + 1] = green;
      out[at + 2] = blue;
      out[at + 3] = alpha;
    });
  });
  return new Uint8Array(out.buffer);
}

/**
 * @param {Float32Array} sums
 * @param {Uint8Array} data
 * @param {number} from
 * @param {number} factor
 */
function addRow(sums, data, from, factor) {
  for (let i = 0; i < sums.length; i += 1) {
    sums[i] = /** @type {number} */ (sums[i]) + factor * /** @type {number} */ (data[from + i]);
  }
}

/** @typedef {{low: number, high: number, first: number, last: number}} Span */

/**
 * What each of `to` pixels covers of `from` pixels.
 * @param {number} from
 * @param {number} to
 * @returns {Span[]}
 */
function spans(from, to) {
  return Array.from({ length: to }, (_, k) => {
    const [low, high] = [(k * from) / to, ((k + 1) * from) / to];
    return { low, high, first: Math.floor(low), last: Math.min(from, Math.ceil(high)) - 1 };
  });
}

/**
 * How much of source pixel `at` the span covers.
 * @param {Span} span
 * @param {number} at
 */
function weight({ low, high }, at) {
  return Math.max(0, Math.min(at + 1, high) - Math.max(at, low));
}
