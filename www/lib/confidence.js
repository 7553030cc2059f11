// How likely labels are right: a logistic function of what the session tells, as `src/mask/confidence.rs` has it, which
// says what it is made from.

/** @typedef {import('./result.js').Result} Result */
/** @typedef {import('./requests.js').AskMap} AskMap */

/** Deeper in its label than this many pixels, a pixel is no surer. */
const DEEP = 12;
const MOST_MARGIN = 20;
/** No label is held to be less likely. */
const LEAST = 0.3;
/** Mask labels that there can be. */
const LABELS = 256;

/**
 * @param {Result} result
 * @param {number} t
 * @param {AskMap} askMap
 * @returns {Promise<import('./result.js').ConfidenceMap>}
 */
export async function confidenceOf(result, t, askMap) {
  const { numbers, ...grid } = await askMap('sureness', t);
  const { label: superpixel } = await askMap('superpixels', t);
  const mask = workingMask(result, t, grid);
  const deep = depth(mask, grid.width, grid.height);
  const share = Math.sqrt(mask.reduce((sum, label) => sum + Number(label > 0), 0) / Math.max(1, mask.length));
  const confidence = new Float32Array(mask.length);
  for (const [k, label] of mask.entries()) {
    const place = LABELS + 2 * Number(superpixel[k]);
    const inside = Math.sqrt(Number(deep[k]) / DEEP);
    const margin = numbers[place] === label ? Number(numbers[place + 1]) : 0;
    const odds =
      label === 0
        ? -0.27 + 1.11 * logarithm(1 + within(margin, 0, MOST_MARGIN)) + 1.15 * inside
        : 0.48 + 0.72 * within(Number(numbers[label]), -1, 3) + 0.82 * inside - 2.96 * share;
    confidence[k] = Math.max(LEAST, 1 / (1 + exponential(-odds)));
  }
  return { ...grid, confidence };
}

/**
 * @param {Result} result
 * @param {AskMap} askMap
 * @returns {Promise<Float32Array<ArrayBuffer>>}
 */
export async function meanConfidences(result, askMap) {
  const sums = new Float64Array(LABELS);
  const counts = new Float64Array(LABELS);
  for (let t = 0; t < result.numFrames; t += 1) {
    const { confidence, ...grid } = await confidenceOf(result, t, askMap);
    for (const [k, label] of workingMask(result, t, grid).entries()) {
      sums[label] = Number(sums[label]) + Number(confidence[k]);
      counts[label] = Number(counts[label]) + 1;
    }
  }
  const highest = Math.max(0, ...(result.objects ?? []).map(({ label }) => label), ...(result.clusters.object ?? []));
  return Float32Array.from(
    { length: highest + 1 },
    (_, label) => Number(sums[label]) / Math.max(1, Number(counts[label])),
  );
}

/**
 * The mask of a frame at the size that frames are processed at: each of its pixels covers at least one of the input, the
 * one at its middle.
 * @param {Result} result
 * @param {number} t
 * @param {import('./image.js').Grid} grid
 */
function workingMask(result, t, { width, height, scaleX, scaleY }) {
  const mask = result.labels(t);
  const small = new Uint8Array(width * height);
  const middle = (/** @type {number} */ k, /** @type {number} */ scale) => Math.round((k + 0.5) * scale - 0.5);
  for (let y = 0; y < height; y += 1) {
    const row = middle(y, scaleY) * result.width;
    for (let x = 0; x < width; x += 1) small[y * width + x] = Number(mask[row + middle(x, scaleX)]);
  }
  return small;
}

/**
 * Steps from each pixel to the nearest that has a neighbour of another label, along rows and columns, up to `DEEP`.
 * @param {Uint8Array} mask
 * @param {number} width
 * @param {number} height
 */
function depth(mask, width, height) {
  const found = new Uint8Array(mask.length);
  const at = (/** @type {number} */ k) => Number(found[k]);
  const differs = (/** @type {number} */ k, /** @type {number} */ x) =>
    (x > 0 && mask[k - 1] !== mask[k]) ||
    (x + 1 < width && mask[k + 1] !== mask[k]) ||
    (k >= width && mask[k - width] !== mask[k]) ||
    (k + width < mask.length && mask[k + width] !== mask[k]);
  for (let k = 0; k < mask.length; k += 1) {
    const x = k % width;
    const before = Math.min(x > 0 ? at(k - 1) : DEEP, k >= width ? at(k - width) : DEEP);
    found[k] = differs(k, x) ? 0 : Math.min(DEEP, before + 1);
  }
  for (let k = mask.length - 1; k >= 0; k -= 1) {
    const x = k % width;
    const after = Math.min(x + 1 < width ? at(k + 1) : DEEP, k + width < mask.length ? at(k + width) : DEEP);
    found[k] = Math.min(at(k), after + 1);
  }
  return found;
}

/**
 * @param {number} value
 * @param {number} least
 * @param {number} most
 */
function within(value, least, most) {
  return Math.min(most, Math.max(least, value));
}

// By operations that are the same bits in any engine, which `Math.exp` and `Math.log` are not.

/** @param {number} x from -30 to 30 */
function exponential(x) {
  const twos = Math.round(x / Math.LN2);
  const rest = x - twos * Math.LN2;
  let sum = 1;
  for (let n = 16; n > 0; n -= 1) sum = 1 + (sum * rest) / n;
  return twos < 0 ? sum / 2 ** -twos : sum * 2 ** twos;
}

/** @param {number} x 1 and more */
function logarithm(x) {
  let [rest, twos] = [x, 0];
  while (rest > 1.5) [rest, twos] = [rest / 2, twos + 1];
  const ratio = (rest - 1) / (rest + 1);
  let sum = 0;
  for (let n = 25; n > 0; n -= 2) sum = sum * ratio * ratio + 1 / n;
  return 2 * ratio * sum + twos * Math.LN2;
}
