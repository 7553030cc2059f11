/** A clip from the camera: the dialog is fetched when it is first opened. @module */

import { byId } from '../dom.js';
import { onDemand } from './on-demand.js';

/** @param {Pick<import('./panels.js').Page, 'app' | 'store'>} page */
export function webcamPanel({ app, store }) {
  const open = onDemand(store, async () => {
    const { WebcamDialog } = await import('./webcam-dialog.js');
    return new WebcamDialog((file) => app.openRecording(file));
  });
  byId('camera-open').addEventListener('click', open);
}
