// The words about the picture: what lies under the pointer, what the frame shows, what the whole is.

import { byId } from '../dom.js';
import { describeFrame } from '../../model/describe.js';
import { objectName } from '../../model/palette.js';
import { NOWHERE, type State } from '../../model/store.js';
import type { Page } from '../page.js';

/** A frame that rests this long is described in words, in milliseconds. */
const REST_MS = 250;

export function readoutPanel({ store, layers, viewer }: Pick<Page, 'store' | 'layers' | 'viewer'>) {
  store.watch(['spot'], ({ spot, analysis }) => {
    const { view } = viewer;
    const layerTexts =
      spot === NOWHERE ? [] : layers.filter(({ isOn }) => isOn).map((layer) => layer.readout?.(view, spot) ?? '');
    const parts = [analysis?.segmentation && spot.object >= 0 ? objectName(spot.object) : '', ...layerTexts].filter(
      Boolean,
    );
    byId('readout').hidden = parts.length === 0;
    if (parts.length > 0) byId('readout').textContent = parts.join(' · ');
  });
  let resting = 0;
  store.watch(['frame', 'timeline'], () => {
    clearTimeout(resting);
    resting = window.setTimeout(() => showFrameText(store.state), REST_MS);
  });
  store.watch(['analysis'], showFrameText);
  store.watch(['phase', 'headline', 'source'], labelCanvas);
}

/** Puts the frame on screen into words, for those who do not see it. */
function showFrameText({ analysis, frame, timeline }: Readonly<State>) {
  const points = analysis?.segmentation;
  byId('frame-text').textContent = points ? describeFrame(points.presence, points.count, frame, timeline.times) : '';
}

function labelCanvas({ phase, headline, source }: Readonly<State>) {
  const label = phase === 'done' && source ? `${source.name}: ${headline}` : 'No result yet';
  byId('canvas').setAttribute('aria-label', label);
}
