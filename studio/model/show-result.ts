// What a run has found, put into the store: picture, timeline, facts and words.

import { kindOf } from './source.js';
import { BLANK, type Film, type State, type Store, phasePatch, withinFilm } from './store.js';
import { COVERED } from './preview.js';
import { turn } from './stage-clock.js';
import { PREVIEW, damageWords, seconds } from './words.js';
import { summaryOf } from './describe.js';
import { Points } from './points.js';
import { hiddenAmong } from './selection.js';
import { Times } from './presence.js';
import type { AnyJob } from './job.js';

const NOISE_REMARK =
  'This browser alters pixels that a page reads, against tracking. Results may differ a little from run to run.';

/**
 * A run that has ended. What was shown window by window stays at the frame on screen. What is found is shown first, and
 * said when the page has had its turn: both together are more than a moment's work.
 */
export async function showResult(store: Store, job: AnyJob) {
  const { streaming, frame, picture, pace, source, visit } = store.state;
  const { width, height, length } = job.images;
  const { shown } = job;
  const film = shown.result ? filmOf(job, shown.result.numFrames) : store.state.film;
  const { patch, words } = resultPatch(store.state, job, film);
  store.set({
    film,
    frame: withinFilm({ film }, streaming ? frame : 0),
    picture: streaming ? picture : { width, height, images: job.images },
    pace: { ...pace, [kindOf(source)]: job.ms / (width * height * Math.max(1, length)) },
    share: 1,
    ...patch,
  });
  await turn();
  if (store.state.visit !== visit || store.state.phase !== 'running') return;
  store.set(words);
  // For whoever wants to know how long a visitor waits; of later clips each would stay in memory.
  if (shown.result && performance.getEntriesByName('masks').length === 0) performance.mark('masks');
  if (!store.state.calm && !streaming) store.set({ playing: film.numFrames > 1 });
}

/**
 * While nothing is settled, coarse masks of the first frames can be looked at. They do not play by themselves: drawing
 * would take from the run what it needs.
 */
export function showPreview(store: Store, job: AnyJob) {
  const { phase, streaming } = store.state;
  if (job !== store.state.job || phase !== 'running' || streaming) return;
  const { width, height } = job.images;
  store.set({
    film: filmOf(job, COVERED),
    frame: 0,
    picture: { width, height, images: job.images },
    preview: job.preview,
    live: PREVIEW.live,
  });
}

/** While windows of a long clip are still to come, what is settled can be looked at. */
export function showWindow(store: Store, job: AnyJob) {
  const { streaming, frame, picture, playing } = store.state;
  const { width, height, length } = job.images;
  const film = filmOf(job, Math.max(job.take.frames, length));
  const { headline, patch } = foundPatch(store.state, job, film);
  store.set({
    film,
    frame: withinFilm({ film }, streaming ? frame : 0),
    picture: streaming ? picture : { width, height, images: job.images },
    streaming: true,
    playing: streaming && playing,
    live: `${job.settled} of ${job.take.frames} frames are done: ${headline}`,
    ...patch,
  });
}

/**
 * A corrected result takes the place of the one before; the frame on screen stays.
 * @param frames those that changed; all where it is left out
 */
export function showCorrected(store: Store, frames: number[] | null = null) {
  const { job, film, found } = store.state;
  if (!job || !found?.points) return;
  job.recount(frames, found.points);
  const { patch, words } = resultPatch(store.state, job, film);
  store.set({ ...patch, ...words });
}

/** Returns what is found, and the phase `done` in words. */
function resultPatch(state: State, job: AnyJob, film: Film): { patch: Partial<State>; words: Partial<State> } {
  const { headline, numbers, summary, patch } = foundPatch(state, job, film);
  const facts = [...numbers, `computed in ${seconds(job.ms)}`].join(' · ');
  return { patch, words: phasePatch('done', headline, facts, summary) };
}

/** Everything that depends on the result alone. */
function foundPatch(
  { hidden, source, isNoisy }: State,
  job: AnyJob,
  film: Film,
): { headline: string; numbers: string[]; summary: string; patch: Partial<State> } {
  const { result, presence, answers, numbers, headline, notice } = job.shown;
  const points = result && new Points(result, presence);
  const facts = Array.from({ length: points?.count ?? 0 }, (_, object) =>
    points?.presence.facts(object, points.scene),
  ).filter((one) => one !== undefined);
  const damage = job.source.damage ? damageWords(job.source.damage) : '';
  const said = [damage, notice(facts), job.lost].filter(Boolean).join(' ');
  const remark = said || (source?.kind !== 'sample' && isNoisy ? NOISE_REMARK : '');
  return {
    headline: headline(facts),
    numbers,
    summary: result ? summaryOf(facts, result.numFrames, film.times) : '',
    patch: {
      preview: null,
      found: { points, facts, answers },
      hidden: hiddenAmong(hidden, facts),
      chosen: BLANK.chosen,
      notice: remark,
    },
  };
}

function filmOf({ source, take, times, end, cuts }: AnyJob, numFrames: number): Film {
  return {
    numFrames,
    fps: source.fps / take.step,
    // Frames are read ahead of those that are shown.
    times: new Times(times.length > 0 ? times.slice(0, numFrames) : null, times[numFrames] ?? end),
    cuts: [...cuts],
  };
}
