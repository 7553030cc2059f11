/** Puts a finished run on the page: picture, timeline, lists and words. @module */

import { summaryOf } from './describe.js';
import { byId } from './dom.js';
import { fillObjects } from './panel-objects.js';
import { showStages } from './panel-stages.js';
import { Points } from './points.js';
import { showNotice, showPhase, showProgress } from './status.js';
import { Times } from './times.js';
import { STILL, headline, plural, remark, seconds } from './words.js';

/** @typedef {import('./app.js').App} App */
/** @typedef {{headline: string, numbers: string[], summary: string}} Words */

const NOISE_REMARK =
  'This browser alters pixels that a page reads, against tracking. Results may differ a little from run to run.';

const CALM = matchMedia('(prefers-reduced-motion: reduce)');

/**
 * @param {App} app
 * @param {import('./job.js').Job} job
 */
export function showClipResult(app, job) {
  const { result, images, source, take } = job;
  const { width, height } = images[0];
  app.viewer.setClip(width, height, images);
  app.timeline.setClip(result.numFrames, source.fps / take.step, Times.of(source, take));
  app.clip.setPace(job.ms / (width * height * images.length));
  conclude(app, job, present(app, job));
  app.viewer.draw();
  if (!CALM.matches) app.timeline.play();
}

/**
 * A corrected result takes the place of the one before; the frame on screen stays.
 *
 * @param {App} app
 * @param {import('./job.js').Job} job
 */
export function showCorrectedResult(app, job) {
  const { headline: title, numbers, summary } = present(app, job);
  byId('canvas').setAttribute('aria-label', `${job.source.name}: ${title}`);
  showPhase('done', title, numbers.join(' · '), summary);
  app.describeFrame();
}

/**
 * Everything that depends on the result alone.
 *
 * @param {App} app
 * @param {import('./job.js').Job} job
 * @returns {Words}
 */
function present(app, job) {
  const { result, images, session, source } = job;
  const { timeline } = app;
  const points = new Points(result);
  app.points = points;
  app.viewer.setResult(points, {
    flow: (t) => session.flow(t),
    boundaries: (t) => result.boundaries(t),
    superpixels: result.objects && remembered((/** @type {number} */ t) => result.superpixels(t)),
    saliencyMap: (t) => result.saliencyMap(t),
  });
  app.updatePanel();
  const facts = Array.from({ length: points.count }, (_, object) => points.presence.facts(object));
  app.facts = facts;
  fillObjects(facts, app.selection, { times: timeline.times, motionsOf: (object) => points.clustersOf(object) });
  timeline.lanes.fill(points.presence, facts.slice(1), result.numFrames, timeline.times);
  showNotice(remark(result) || (app.noisy && source.kind !== 'sample' ? NOISE_REMARK : ''));
  const { width, height } = images[0];
  const numbers = [
    plural(result.trajectories.count, 'trajectory', 'trajectories'),
    `${plural(images.length, 'frame')} of ${width} × ${height}`,
    `computed in ${seconds(job.ms)}`,
  ];
  return { headline: headline(result, facts), numbers, summary: summaryOf(facts, result.numFrames, timeline.times) };
}

/**
 * @param {App} app
 * @param {import('./still.js').StillJob} job
 */
export function showStillResult(app, job) {
  const { found, images } = job;
  const { width, height } = images[0];
  const answer = async (/** @type {keyof typeof found} */ what) => /** @type {any} */ (found[what]);
  app.viewer.setClip(width, height, images);
  app.viewer.setResult(null, {
    boundaries: () => answer('boundaries'),
    superpixels: () => answer('superpixels'),
    imageEdges: () => answer('imageEdges'),
  });
  app.updatePanel();
  app.clip.setPace(job.ms / (width * height));
  showNotice(STILL.remark);
  const numbers = [plural(found.superpixels?.count ?? 0, 'superpixel'), `${width} × ${height}`, `computed in ${seconds(job.ms)}`];
  conclude(app, job, { headline: STILL.headline, numbers, summary: '' });
}

/**
 * @param {App} app
 * @param {import('./run.js').Run} job
 * @param {Words} words
 */
function conclude(app, job, words) {
  app.learn(job);
  showStages(job, 'done');
  showProgress(1);
  byId('canvas').setAttribute('aria-label', `${job.source.name}: ${words.headline}`);
  showPhase('done', words.headline, words.numbers.join(' · '), words.summary);
  app.updatePending();
}

/**
 * Superpixels serve two layers; each frame's are fetched once.
 *
 * @template T
 * @param {(frame: number) => Promise<T>} ask
 * @returns {(frame: number) => Promise<T>}
 */
function remembered(ask) {
  /** @type {Map<number, Promise<T>>} */
  const known = new Map();
  return (frame) => {
    const answer = known.get(frame) ?? ask(frame);
    known.set(frame, answer);
    return answer;
  };
}
