// Editing of the studio's model in tests: masks of the result on screen, strokes, and a brush without a panel.

import { Brush } from '../../build/model/brush.js';
import { showCorrected } from '../../build/model/show-result.js';

/** Returns the mask of a frame. */
export function maskAt(store, t) {
  return store.state.analysis.segmentation.mask(t);
}

/** Returns the masks of all frames as text. */
export function masksOf(store) {
  const { numFrames } = store.state.analysis.segmentation.result;
  return Array.from({ length: numFrames }, (_, t) => maskAt(store, t).join('')).join('|');
}

/** Returns the pixels of an object in a frame. */
export function pixelsOf(store, t, object) {
  const mask = maskAt(store, t);
  return [...mask.keys()].filter((p) => mask[p] === object);
}

/** Returns the number of pixels and the centre of each label in a frame. */
export function regionsOf(store, t) {
  const { width } = store.state.analysis.segmentation.result;
  const labels = [...new Set(maskAt(store, t))].sort((a, b) => a - b);
  const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
  return Object.fromEntries(
    labels.map((label) => {
      const pixels = pixelsOf(store, t, label);
      const [x, y] = [pixels.map((p) => p % width), pixels.map((p) => Math.floor(p / width))].map(mean);
      return [label, { area: pixels.length, x, y }];
    }),
  );
}

/** Returns a short stroke on an object. */
export function strokeOn(store, t, object) {
  const { width } = store.state.analysis.segmentation.result;
  const pixels = pixelsOf(store, t, object);
  const p = pixels[pixels.length >> 1];
  const [x, y] = [p % width, Math.floor(p / width)];
  return { t, points: [x, y, x + 2, y], radius: 1 };
}

/** Shows a correction once it is applied. @param {Promise<number[] | null>} correction resolves to the changed frames */
export async function show(store, correction) {
  showCorrected(store, await correction);
}

/**
 * Returns a brush, with its status texts and what it tells the panel.
 *
 * @param {number} object that is painted at first
 * @param {{isCarrying?: boolean}} [options] whether edits are carried to other frames
 */
export function createBrush(store, object, { isCarrying = true } = {}) {
  const panel = { object, texts: [], canShrink: false, canGrow: false };
  const brush = new Brush({
    store,
    corrector: () => store.state.job.corrections,
    object: () => panel.object,
    choose: (chosen) => (panel.object = chosen),
    appliesToOthers: () => isCarrying,
    onCarrying() {},
    onSizes: (canShrink, canGrow) => Object.assign(panel, { canShrink, canGrow }),
    showFrames: (frames) => showCorrected(store, frames),
    showStatus: (text) => panel.texts.push(text),
  });
  return { brush, panel };
}
