// Texts about the picture: the object under the pointer, the frame, and the result.

import { byId } from '../dom.js';
import { describeFrame } from '../../model/describe.js';
import { objectName } from '../../model/palette.js';
import { NOWHERE, type State } from '../../model/store.js';
import type { Page } from '../page.js';

/** Time on one frame before it is described, in milliseconds; chosen by eye. */
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

/** Describes the frame on screen for screen readers. */
function showFrameText({ analysis, frame, timeline }: Readonly<State>) {
  const segmentation = analysis?.segmentation;
  byId('frame-text').textContent = segmentation
    ? describeFrame(segmentation.presence, segmentation.count, frame, timeline.times)
    : '';
}

function labelCanvas({ phase, headline, source }: Readonly<State>) {
  const label = phase === 'done' && source ? `${source.name}: ${headline}` : 'No result yet';
  byId('canvas').setAttribute('aria-label', label);
}
