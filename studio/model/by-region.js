/**
 * Corrections that look at regions of a frame: what is parted or put together by strokes, and what grows from a click.
 * Fetched when one is first made.
 * @module
 */

import { createImageEngine, divideRegions, grownRegions, pieceRegion, strokeRegion } from './library.js';
import { PageError } from './words.js';

/** @typedef {import('./corrections.js').Corrections} Corrections */
/** @typedef {import('./library.js').Edit} Edit */
/** @typedef {import('./library.js').Region} Region */
/** @typedef {import('./corrections.js').Stroke} Stroke */

/**
 * What may be meant by a click, the smallest first.
 *
 * @param {Corrections} corrections
 * @param {number} t
 * @param {{x: number, y: number}} place in pixels of the masks
 * @returns {Promise<{regions: Region[], likeliest: number}>}
 */
export async function grown(corrections, t, place) {
  corrections.engine ??= createImageEngine();
  const engine = await corrections.engine;
  const { numFrames } = corrections.opened;
  // Motion to the frame after, or the one before where that is another shot or none.
  const isLast = t + 1 >= numFrames || corrections.of.cuts.includes(t + 1);
  const beside = isLast && t > 0 && !corrections.of.cuts.includes(t) ? t - 1 : Math.min(t + 1, numFrames - 1);
  const [picture, other] = [await corrections.pixels(t), await corrections.pixels(beside)];
  const [superpixels, flow] = [await engine.superpixels(picture), await engine.flow(picture, other)];
  const found = await grownRegions({ superpixels, picture, flow }, place);
  const area = (/** @type {Region} */ region) => region.reduce((sum, number, k) => sum + (k % 2) * number, 0);
  const regions = [...found].sort((a, b) => area(a) - area(b));
  return { regions, likeliest: regions.indexOf(found[0]) };
}

/**
 * An object is parted; by hand, the piece at a place becomes an object of its own.
 *
 * @param {Corrections} corrections
 * @param {number} label
 * @param {{t: number, x: number, y: number}} [at]
 */
export async function split(corrections, label, at) {
  const { session } = corrections.of;
  if (session) return corrections.asked(session, { ask: 'split', label, at }, (one) => one.split(label, at));
  // The background hangs together everywhere.
  if (!at || label === 0) throw new PageError('no-place');
  const { width, height } = corrections.opened;
  const mask = { width, height, labels: corrections.opened.labels(at.t) };
  if (mask.labels[Math.round(at.y) * width + Math.round(at.x)] !== label) throw new PageError('no-place');
  const region = pieceRegion(mask, at);
  return divided(corrections, at.t, label, [region]);
}

/**
 * Each stroke is a thing of its own; by hand, all but the first become objects.
 *
 * @param {Corrections} corrections
 * @param {Stroke[]} strokes
 */
export async function apart(corrections, strokes) {
  const { session } = corrections.of;
  if (session) return corrections.asked(session, { ask: 'apart', strokes }, (one) => one.apart(strokes));
  const [{ t }] = strokes;
  if (strokes.some((stroke) => stroke.t !== t)) throw new PageError('other-frame');
  const { width, height } = corrections.opened;
  const mask = { width, height, labels: corrections.opened.labels(t) };
  const { label, regions } = divideRegions(mask, strokes);
  return divided(corrections, t, label, regions.slice(1));
}

/**
 * The objects that strokes lie on become one.
 *
 * @param {Corrections} corrections
 * @param {Stroke[]} strokes
 */
export async function together(corrections, strokes) {
  const { session } = corrections.of;
  if (session) return corrections.asked(session, { ask: 'together', strokes }, (one) => one.together(strokes));
  const { width, height } = corrections.opened;
  /** @type {Set<number>} */
  const covered = new Set();
  for (const stroke of strokes) {
    const labels = corrections.opened.labels(stroke.t);
    const region = strokeRegion(stroke, width, height);
    for (let k = 0; k < region.length; k += 2)
      for (let p = region[k]; p < region[k] + region[k + 1]; p++) if (labels[p] > 0) covered.add(labels[p]);
  }
  const [into, ...others] = [...covered].sort((a, b) => a - b);
  if (others.length === 0) throw new PageError('one-object');
  return corrections.edited((editor) => editor.relabel(Object.fromEntries(others.map((one) => [one, into]))), null);
}

/**
 * Gives each region a label of its own, and carries it to the other frames.
 *
 * @param {Corrections} corrections
 * @param {number} t
 * @param {number} label that they have
 * @param {Region[]} regions
 */
async function divided(corrections, t, label, regions) {
  /** @type {Edit[]} */
  let edits = [];
  const changed = await corrections.edited(
    (editor) => (edits = regions.map((region) => editor.paint({ label: editor.newLabel(), over: [label], t, region }))),
    null,
  );
  for (const edit of edits) await corrections.carry({ edit, frames: [] }, new AbortController().signal, () => {});
  return changed;
}
