// Texts about the picture: the object under the pointer, the frame, and the result.

import { byId } from '../dom.js';
import { describeFrame } from '../../model/describe.js';
import { objectName } from '../../model/palette.js';
import type { State } from '../../model/store.js';
import type { Page } from '../page.js';

/** Time on one frame before it is described, in milliseconds; chosen by eye. */
const REST_MS = 250;

export function readoutPanel({ store }: Pick<Page, 'store'>) {
  store.watch(['spot'], ({ spot, analysis }) => {
    const isNamed = analysis !== null && spot.object >= 0;
    byId('readout').hidden = !isNamed;
    if (isNamed) byId('readout').textContent = objectName(spot.object);
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
