/** What there is to save of work that is kept: read from its files, nothing of it is on screen. @module */

import { editMasks, openProject, smoothMasks, soundInfo } from '../library.js';
import { groundOf } from '../panels/views.js';
import { edgesOf, lookPatch } from '../saved/look.js';
import { openFiles } from '../source.js';
import { durationOf, framesOf } from './export-size.js';

/**
 * @param {import('../saved/storage.js').Saved} saved
 * @param {import('../store.js').State} state of the page, whose choices stand where the work has none
 * @param {AbortSignal} signal
 * @returns {Promise<{subject: import('./export.js').Subject, close: () => void}>} at the size of the source, with the
 *   sound
 */
export async function keptSubject({ name, files, project, edits, about }, state, signal) {
  const [source, opened] = await Promise.all([openFiles(files), openProject(project)]);
  const { take } = about;
  const { edges, hidden, ground } = { ...state, hidden: new Set(), ...lookPatch(about.look, state) };
  const editor = editMasks(opened.masks);
  if (edits) editor.restore(edits);
  const { width, height, numFrames, times, end, shots, trajectories } = opened.masks;
  const found = { width, height, numFrames, times, end, shots: [...shots] };
  const picture = (/** @type {number} */ t) => source.preview(take.start + t * take.step, take.side, times[t]);
  const own = { ...found, labels: (/** @type {number} */ t) => editor.labels(t) };
  const calm = edges.smooth > 0 ? await smoothMasks(own, { reach: edges.smooth, picture, signal }) : own;
  const fps = source.fps / take.step;
  const sound = source.file ? await soundInfo(source.file).catch(() => null) : null;
  const masks = {
    ...found,
    // Masks are saved as they are: without what is not kept.
    labels: (/** @type {number} */ t) => calm.labels(t).map((label) => (hidden.has(label) ? 0 : label)),
  };
  const frames = framesOf({ source, take }, masks, Math.max(source.width, source.height));
  /** @type {import('./export.js').Subject} */
  const subject = {
    ...{ masks, source, name, fps, state, frame: 0, plate: null, points: trajectories },
    ...{ frames: frames.all, image: frames.one, quality: 'high', trail: ground.trail },
    ...{ edges: edgesOf(edges, masks), ground: groundOf(ground), look: { opacity: 1, fill: 0.5, outline: 2 } },
    objects: (object) => object > 0,
    tracks: () => opened.masks.toTracksDat(),
    sound: (format) =>
      source.file && sound?.formats.includes(format)
        ? { source: source.file, start: times[0], end: times[0] + durationOf(masks, fps) }
        : null,
  };
  return { subject, close: () => source.close() };
}
