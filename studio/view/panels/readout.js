/** The words about the picture: what lies under the pointer, what the frame shows, what the whole is. @module */

import { byId } from '../dom.js';
import { frameText } from '../result/describe.js';
import { objectName } from '../result/palette.js';
import { NOWHERE } from '../store.js';
import { count } from '../words.js';

/** @typedef {import('../store.js').State} State */

/** A frame that rests this long is described in words, in milliseconds. */
const REST_MS = 250;

/** @param {Pick<import('../page.js').Page, 'store' | 'layers' | 'viewer'>} page */
export function readoutPanel({ store, layers, viewer }) {
  store.watch(['spot'], ({ spot, found }) => {
    const { view } = viewer;
    const told = spot === NOWHERE ? [] : layers.filter((layer) => layer.on && !layer.missing?.(view));
    showReadout(
      found?.points ?? null,
      spot,
      told.map((layer) => layer.readout?.(view, spot) ?? ''),
    );
  });
  let resting = 0;
  store.watch(['frame', 'film'], () => {
    clearTimeout(resting);
    resting = window.setTimeout(() => describeFrame(store.state), REST_MS);
  });
  store.watch(['found'], describeFrame);
  store.watch(['phase', 'headline', 'source'], labelCanvas);
}

/**
 * @param {import('../result/points.js').Points | null} points
 * @param {import('../layers/layer.js').Spot} spot
 * @param {string[]} more what the layers say about it
 */
function showReadout(points, { object, trajectory }, more) {
  const words = [];
  if (points && object >= 0) {
    words.push(objectName(object));
    if (trajectory >= 0) words.push(`trajectory ${count(trajectory)}, ${lifeOf(points, trajectory)}`);
  }
  words.push(...more.filter((text) => text !== ''));
  const readout = byId('readout');
  readout.hidden = words.length === 0;
  if (words.length > 0) readout.textContent = words.join(' · ');
}

/**
 * @param {import('../result/points.js').Points} points
 * @param {number} trajectory
 */
function lifeOf({ result }, trajectory) {
  const { startFrame, offset } = result.trajectories;
  const first = startFrame[trajectory];
  return `frames ${first + 1}–${first + offset[trajectory + 1] - offset[trajectory]}`;
}

/**
 * Puts the frame on screen into words, for those who do not see it.
 *
 * @param {Readonly<State>} state
 */
function describeFrame({ found, frame, film }) {
  const points = found?.points;
  byId('frame-text').textContent = points ? frameText(points.presence, points.count, frame, film.times) : '';
}

/** @param {Readonly<State>} state */
function labelCanvas({ phase, headline, source }) {
  const label = phase === 'done' && source ? `${source.name}: ${headline}` : 'No result yet';
  byId('canvas').setAttribute('aria-label', label);
}
