/** What a run has found, put into the store: picture, timeline, facts and words. @module */

import { readsAreNoisy } from '../grabber.js';
import { stagesOf } from '../panels/stages.js';
import { kindOf } from '../source.js';
import { phasePatch, withinFilm } from '../store.js';
import { seconds } from '../words.js';
import { summaryOf } from './describe.js';
import { Points } from './points.js';
import { hiddenAmong } from './selection.js';
import { Times } from './times.js';

/** @typedef {import('../run/jobs.js').AnyJob} AnyJob */
/** @typedef {import('../store.js').Film} Film */
/** @typedef {import('../store.js').State} State */
/** @typedef {import('../store.js').Store} Store */

const NOISE_REMARK =
  'This browser alters pixels that a page reads, against tracking. Results may differ a little from run to run.';

const CALM = matchMedia('(prefers-reduced-motion: reduce)');

/**
 * A run that has ended. What was shown window by window stays at the frame on screen.
 *
 * @param {Store} store
 * @param {AnyJob} job
 */
export function showResult(store, job) {
  const { streaming, frame, picture, pace, source } = store.state;
  const { width, height, length } = job.images;
  const { shown } = job;
  const film = shown.result ? filmOf(job, shown.result.numFrames) : store.state.film;
  store.set({
    film,
    frame: withinFilm({ film }, streaming ? frame : 0),
    picture: streaming ? picture : { width, height, images: job.images },
    pace: { ...pace, [kindOf(source)]: job.ms / (width * height * Math.max(1, length)) },
    stages: stagesOf(job, 'done'),
    share: 1,
    ...resultPatch(store.state, job, film),
  });
  // For whoever wants to know how long a visitor waits.
  if (shown.result) performance.mark('masks');
  if (!CALM.matches && !streaming) store.set({ playing: film.numFrames > 1 });
}

/**
 * While windows of a long clip are still to come, what is settled can be looked at.
 *
 * @param {Store} store
 * @param {AnyJob} job
 */
export function showWindow(store, job) {
  const { streaming, frame, picture } = store.state;
  const { width, height, length } = job.images;
  const film = filmOf(job, Math.max(job.take.frames, length));
  const { headline, patch } = foundPatch(store.state, job, film);
  store.set({
    film,
    frame: withinFilm({ film }, streaming ? frame : 0),
    picture: streaming ? picture : { width, height, images: job.images },
    streaming: true,
    live: `${job.settled} of ${job.take.frames} frames are done: ${headline}`,
    ...patch,
  });
}

/**
 * A corrected result takes the place of the one before; the frame on screen stays.
 *
 * @param {Store} store
 * @param {number[] | null} [frames] those that changed; all where it is left out
 */
export function showCorrected(store, frames = null) {
  const { job, film, found } = store.state;
  if (!job || !found?.points) return;
  job.recount(frames, found.points);
  store.set(resultPatch(store.state, job, film));
}

/**
 * @param {State} state
 * @param {AnyJob} job
 * @param {Film} film
 * @returns {Partial<State>} what is found, and the phase `done` in words
 */
function resultPatch(state, job, film) {
  const { headline, numbers, summary, patch } = foundPatch(state, job, film);
  const facts = [...numbers, `computed in ${seconds(job.ms)}`].join(' · ');
  return { ...patch, ...phasePatch('done', headline, facts, summary) };
}

/**
 * Everything that depends on the result alone.
 *
 * @param {State} state
 * @param {AnyJob} job
 * @param {Film} film
 * @returns {{headline: string, numbers: string[], summary: string, patch: Partial<State>}}
 */
function foundPatch({ hidden, source }, job, film) {
  const { result, presence, windows, answers, numbers, headline, notice } = job.shown;
  const points = result && new Points(result, presence);
  const facts = Array.from({ length: points?.count ?? 0 }, (_, object) =>
    points?.presence.facts(object, points.scene),
  ).filter((one) => one !== undefined);
  const remark = notice(facts) || (source?.kind !== 'sample' && readsAreNoisy() ? NOISE_REMARK : '');
  return {
    headline: headline(facts),
    numbers,
    summary: result ? summaryOf(facts, result.numFrames, film.times) : '',
    patch: { found: { points, facts, windows, answers }, hidden: hiddenAmong(hidden, facts), notice: remark },
  };
}

/**
 * @param {AnyJob} job
 * @param {number} numFrames
 * @returns {Film}
 */
function filmOf({ source, take, times, end, cuts }, numFrames) {
  return {
    numFrames,
    fps: source.fps / take.step,
    // Frames are read ahead of those that are shown.
    times: new Times(times.length > 0 ? times.slice(0, numFrames) : null, times[numFrames] ?? end),
    cuts: [...cuts],
  };
}
