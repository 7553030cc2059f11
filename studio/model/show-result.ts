// Puts progress and results into the store: picture, timeline, facts and messages.

import { BLANK, clampFrame, phasePatch, type State, type Store, type Timeline } from './store.js';
import { PREVIEW_FRAMES } from './preview.js';
import { describeDamage, formatSeconds, formatTimeLeft, PREVIEW_MESSAGES, stageName } from './messages.js';
import { describeObjects } from './describe.js';
import { Segmentation, Times } from './presence.js';
import { keepHidden } from './selection.js';
import type { ClipJob } from './clip-job.js';
import { type StageClock, yieldThread } from './library.js';

const NOISE_REMARK = 'This browser adds noise to pixels to prevent tracking, so results may vary slightly.';

/**
 * Shows the result of a finished run. Masks are shown first and messages after a pause, so that the page stays
 * responsive.
 */
export async function showResult(store: Store, job: ClipJob) {
  const { isStreaming, frame, picture, pace, visit } = store.state;
  const { width, height } = job.images;
  const timeline = createTimeline(job, job.shown.result.numFrames);
  const { patch, statusPatch } = resultPatch(store.state, job, timeline);
  store.set({
    timeline,
    frame: clampFrame({ timeline }, isStreaming ? frame : 0),
    picture: isStreaming ? picture : { width, height, images: job.images },
    pace: job.pacePerPixel ?? pace,
    share: job.isPartial ? job.share : 1,
    ...patch,
  });
  await yieldThread();
  if (store.state.visit !== visit || store.state.phase !== 'running') return;
  store.set(statusPatch);
  // Measures the time to the first result; only once, as entries stay in memory.
  if (performance.getEntriesByName('masks').length === 0) performance.mark('masks');
  if (!store.state.isReducedMotion && !isStreaming) store.set({ isPlaying: timeline.numFrames > 1 });
}

/** Shows the preview. It does not play by itself, as drawing would slow down the run. */
export function showPreview(store: Store, job: ClipJob) {
  const { phase, isStreaming } = store.state;
  if (job !== store.state.job || phase !== 'running' || isStreaming) return;
  const { width, height } = job.images;
  store.set({
    timeline: createTimeline(job, PREVIEW_FRAMES),
    frame: 0,
    picture: { width, height, images: job.images },
    preview: job.preview,
    announcement: PREVIEW_MESSAGES.live,
  });
}

/** Shows the finished frames of a run. */
export function showWindow(store: Store, job: ClipJob) {
  const { isStreaming, frame, picture, isPlaying } = store.state;
  const { width, height, length } = job.images;
  const timeline = createTimeline(job, Math.max(job.trim.frames, length));
  const { headline, patch } = analysisPatch(store.state, job, timeline);
  store.set({
    timeline,
    frame: clampFrame({ timeline }, isStreaming ? frame : 0),
    picture: isStreaming ? picture : { width, height, images: job.images },
    isStreaming: true,
    isPlaying: isStreaming && isPlaying,
    announcement: `${job.settledFrames} of ${job.trim.frames} frames are done: ${headline}`,
    ...patch,
  });
}

/**
 * Shows a corrected result at the same frame.
 * @param frames the changed frames; null for all
 */
export function showCorrected(store: Store, frames: number[] | null = null) {
  const { job, timeline, analysis } = store.state;
  if (!job || !analysis) return;
  job.recount(frames, analysis.segmentation);
  const { patch, statusPatch } = resultPatch(store.state, job, timeline);
  store.set({ ...patch, ...statusPatch });
}

/** Returns the changes for a result, and for the phase `done`. */
function resultPatch(
  state: State,
  job: ClipJob,
  timeline: Timeline,
): { patch: Partial<State>; statusPatch: Partial<State> } {
  const { headline, numbers, summary, patch } = analysisPatch(state, job, timeline);
  const facts = [...numbers, `computed in ${formatSeconds(job.ms)}`].join(' · ');
  return { patch, statusPatch: phasePatch('done', headline, facts, summary) };
}

/** Returns the changes that depend on the result only. */
function analysisPatch(
  { hidden, source, isNoisy, fine }: State,
  job: ClipJob,
  timeline: Timeline,
): { headline: string; numbers: string[]; summary: string; patch: Partial<State> } {
  const { result, presence, background, numbers, headline, notice } = job.shown;
  const segmentation = new Segmentation(result, presence);
  const facts = Array.from({ length: segmentation.count }, (_, object) =>
    segmentation.presence.facts(object, segmentation.scene),
  ).filter((objectFacts) => objectFacts !== undefined);
  const damage = job.source.damage ? describeDamage(job.source.damage) : '';
  const messages = [damage, notice(facts), job.droppedCorrections].filter(Boolean).join(' ');
  const remark = messages || (source?.kind !== 'sample' && isNoisy ? NOISE_REMARK : '');
  return {
    headline: headline(facts),
    numbers,
    summary: describeObjects(facts, result.numFrames, timeline.times),
    patch: {
      preview: null,
      analysis: { segmentation, facts, background },
      doubts: result.doubts.filter(({ from }) => !fine.has(from)),
      agreement: result.agreement ?? null,
      hidden: keepHidden(hidden, facts),
      selected: BLANK.selected,
      notice: remark,
    },
  };
}

function createTimeline({ source, trim, times, end, cuts }: ClipJob, numFrames: number): Timeline {
  return {
    numFrames,
    fps: source.fps / trim.step,
    // Frames are read ahead of the masks.
    times: new Times(times.length > 0 ? times.slice(0, numFrames) : null, times[numFrames] ?? end),
    cuts: [...cuts],
  };
}

/**
 * Returns the changes of the state; a new stage is also announced.
 * @param headline on screen
 */
export function progressPatch(clock: StageClock, headline: string): Partial<State> {
  const name = stageName(clock.stageOnScreen);
  const msLeft = clock.timeLeft(performance.now());
  const percent = `${Math.floor(100 * clock.share)}%`;
  return {
    ...(headline === name ? {} : { headline: name, announcement: name }),
    subline: msLeft === null ? percent : `${percent} · ${formatTimeLeft(msLeft)}`,
    share: clock.share,
  };
}
