/** Puts a finished run on the page: picture, timeline, lists and words. @module */

import { summaryOf } from './describe.js';
import { byId } from './dom.js';
import { Job } from './job.js';
import { fillObjects } from './panel-objects.js';
import { showStages } from './panel-stages.js';
import { Points } from './points.js';
import { say, showNotice, showPhase, showProgress } from './status.js';
import { Times } from './times.js';
import { LONG, STILL, countObjects, headline, plural, remark, seconds } from './words.js';

/** @typedef {import('./app.js').App} App */
/** @typedef {{headline: string, numbers: string[], summary: string}} Words */

const NOISE_REMARK =
  'This browser alters pixels that a page reads, against tracking. Results may differ a little from run to run.';

const CALM = matchMedia('(prefers-reduced-motion: reduce)');

/** @typedef {import('./job.js').Job | import('./long-job.js').LongJob} ClipJob */

/**
 * @param {App} app
 * @param {ClipJob} job
 */
export function showClipResult(app, job) {
  const { images } = job;
  if (job instanceof Job) app.viewer.setClip(images.width, images.height, images);
  setTimeline(app, job, job.shown.result.numFrames);
  app.clip.setPace(job.ms / (images.width * images.height * Math.max(1, images.length)));
  conclude(app, job, present(app, job));
  app.viewer.draw();
  // For whoever wants to know how long a visitor waits.
  performance.mark('masks');
  if (!CALM.matches && job instanceof Job) app.timeline.play();
}

/**
 * While windows of a long clip are still to come, what is settled can be looked at.
 *
 * @param {App} app
 * @param {import('./long-job.js').LongJob} job
 */
export function showWindow(app, job) {
  const first = !document.body.hasAttribute('data-streaming');
  if (first) {
    app.viewer.setClip(job.images.width, job.images.height, job.images);
    document.body.toggleAttribute('data-streaming', true);
  }
  setTimeline(app, job, Math.max(job.take.frames, job.images.length), first ? 0 : app.timeline.frame);
  const { headline: title } = present(app, job);
  say(`${job.settled} of ${job.take.frames} frames are done: ${title}`);
}

/**
 * A corrected result takes the place of the one before; the frame on screen stays.
 *
 * @param {App} app
 * @param {ClipJob} job
 */
export function showCorrectedResult(app, job) {
  const { headline: title, numbers, summary } = present(app, job);
  byId('canvas').setAttribute('aria-label', `${job.source.name}: ${title}`);
  showPhase('done', title, [...numbers, `computed in ${seconds(job.ms)}`].join(' · '), summary);
  app.describeFrame();
}

/**
 * @param {App} app
 * @param {ClipJob} job
 * @param {number} numFrames
 * @param {number} [frame] to stay at; the one on screen if the clip is long
 */
function setTimeline(app, job, numFrames, frame = job instanceof Job ? 0 : app.timeline.frame) {
  const { source, take, times } = job;
  const playing = app.timeline.playing;
  app.timeline.setClip(numFrames, source.fps / take.step, new Times(times.length > 0 ? times : null));
  app.timeline.setCuts(job instanceof Job ? [] : job.cuts);
  app.timeline.seek(frame);
  if (playing) app.timeline.play();
}

/**
 * Everything that depends on the result alone.
 *
 * @param {App} app
 * @param {ClipJob} job
 * @returns {Words}
 */
function present(app, job) {
  const { result, presence, windows, answers, numbers } = job.shown;
  const { timeline, selection } = app;
  const points = new Points(result, presence);
  app.points = points;
  app.viewer.setResult(points, answers, windows);
  app.updatePanel();
  const facts = Array.from({ length: points.count }, (_, object) => points.presence.facts(object));
  app.facts = facts;
  fillObjects(facts.filter(({ object, first }) => object === 0 || first >= 0), selection, {
    times: timeline.times,
    motionsOf: (object) => points.clustersOf(object),
  });
  timeline.lanes.fill(points.presence, facts.slice(1), timeline.numFrames, timeline.times);
  showNotice(noticeOf(app, job, result, facts));
  const title = windows ? countObjects(facts) : headline(result, facts);
  return { headline: title, numbers, summary: summaryOf(facts, result.numFrames, timeline.times) };
}

/**
 * @param {App} app
 * @param {ClipJob} job
 * @param {import('./points.js').Result} result
 * @param {import('./presence.js').Facts[]} facts
 * @returns {string}
 */
function noticeOf(app, job, result, facts) {
  if (!(job instanceof Job)) {
    if (job.partial) return LONG.partial(job.settled, job.take.frames);
    return facts.some(({ object, first }) => object > 0 && first >= 0) || !job.result ? LONG.remark : LONG.nothing;
  }
  return remark(result) || (app.noisy && job.source.kind !== 'sample' ? NOISE_REMARK : '');
}

/**
 * @param {App} app
 * @param {import('./still.js').StillJob} job
 */
export function showStillResult(app, job) {
  const { found, images } = job;
  const { width, height } = images;
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
  const numbers = [plural(found.superpixels?.count ?? 0, 'superpixel'), job.size];
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
  showPhase('done', words.headline, [...words.numbers, `computed in ${seconds(job.ms)}`].join(' · '), words.summary);
  app.updatePending();
}
