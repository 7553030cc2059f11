// The words about the picture: what lies under the pointer, what the frame shows, what the whole is.

import { byId } from '../dom.js';
import { frameText } from '../../model/describe.js';
import { objectName } from '../../model/palette.js';
import { NOWHERE, type State } from '../../model/store.js';
import type { Page } from '../page.js';

/** A frame that rests this long is described in words, in milliseconds. */
const REST_MS = 250;

export function readoutPanel({ store, layers, viewer }: Pick<Page, 'store' | 'layers' | 'viewer'>) {
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

/** Puts the frame on screen into words, for those who do not see it. */
function describeFrame({ found, frame, film }: Readonly<State>) {
  const points = found?.points;
  byId('frame-text').textContent = points ? frameText(points.presence, points.count, frame, film.times) : '';
}

function labelCanvas({ phase, headline, source }: Readonly<State>) {
  const label = phase === 'done' && source ? `${source.name}: ${headline}` : 'No result yet';
  byId('canvas').setAttribute('aria-label', label);
}
