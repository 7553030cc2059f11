/** The words about the picture: what lies under the pointer, what the frame shows, what the whole is. @module */

import { byId } from '../dom.js';
import { frameText } from '../../model/describe.js';
import { objectName } from '../../model/palette.js';
import { NOWHERE } from '../../model/store.js';

/** @typedef {import('../../model/store.js').State} State */

/** A frame that rests this long is described in words, in milliseconds. */
const REST_MS = 250;

/** @param {Pick<import('../page.js').Page, 'store' | 'layers' | 'viewer'>} page */
export function readoutPanel({ store, layers, viewer }) {
  store.watch(['spot'], ({ spot, found }) => {
    const { view } = viewer;
    const told =
      spot === NOWHERE ? [] : layers.filter(({ on }) => on).map((layer) => layer.readout?.(view, spot) ?? '');
    const words = [found?.points && spot.object >= 0 ? objectName(spot.object) : '', ...told].filter(Boolean);
    byId('readout').hidden = words.length === 0;
    if (words.length > 0) byId('readout').textContent = words.join(' · ');
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
