// Where a run looked that found nothing, and what to try next.

import { fitTake } from './source.js';
import { percent, plural } from './words.js';
import type { SearchReport } from './library.js';
import type { State } from './store.js';

/** Working sizes of the page, in pixels. */
const SIDES = [320, 480, 640];

/** Fewer frames say too little when every second is left out. */
const FEWEST = 26;

/** Where less of the picture was followed, weaker texture is worth trying. */
const LITTLE = 0.5;

/** Settings that follow it. */
const WEAK = { 'trajectory.structureFloor': 0.005, 'trajectory.structureMean': 0.005, 'trajectory.minLength': 4 };

/** Steps beyond this see too little that is alike. */
const LARGEST_STEP = 3;

export function whereWords({ numFrames, trajectories, coverage, speed, cameraMoves, motions }: SearchReport): string {
  if (trajectories === 0) return `Looked at ${plural(numFrames, 'frame')} and found no point to follow.`;
  const followed = `Followed ${plural(trajectories, 'point')} over ${percent(coverage)} of the picture, through ${plural(numFrames, 'frame')}`;
  const camera = cameraMoves ? `the camera moves, about ${speed.toFixed(1)} px a frame` : 'the camera stands still';
  return `${followed}; ${camera}. ${groundWords(motions)}`;
}

function groundWords(motions: number[] | null) {
  if (!motions || motions.length < 1) return 'All of it was taken as background.';
  if (motions.length === 1) return 'All points move alike: they were taken as background.';
  return `Of ${motions.length} motions the largest has ${percent(motions[0])} of the points; all were taken as background.`;
}

/**
 * What to try: only what can change the result, by what it changed on clips in which nothing was found. Every second
 * frame found slow things in two of three, a larger size and a longer part each found an elephant; weaker texture what
 * moves before a plain ground; denser points and a lower noise floor found nothing.
 */
export function triesOf(
  { source, job, changed }: State,
  { coverage }: SearchReport,
): { id: string; label: string; patch: Partial<State> }[] {
  if (!source || !job) return [];
  const { take } = job;
  const tries: { id: string; label: string; patch: Partial<State> }[] = [];
  const isOwn = source.kind !== 'sample';
  if (isOwn && take.frames >= FEWEST && take.step < LARGEST_STEP) {
    const step = take.step + 1;
    const frames = Math.ceil((take.frames * take.step) / step);
    const label = step === 2 ? 'Every 2nd frame, for slow motion' : 'Every 3rd frame';
    tries.push({ id: 'step', label, patch: { take: fitTake({ ...take, step, frames }, source) } });
  }
  if (isOwn && (take.start > 0 || take.start + take.frames * take.step < source.count)) {
    const whole = fitTake({ ...take, start: 0, frames: source.count }, source);
    tries.push({ id: 'whole', label: 'The whole clip', patch: { take: whole } });
  }
  const side = SIDES.find((one) => one > take.side);
  if (isOwn && side && Math.max(source.width, source.height) > take.side)
    tries.push({ id: 'side', label: `Finer, at ${side} px`, patch: { take: { ...take, side } } });
  if (coverage < LITTLE && Object.keys(WEAK).some((name) => !changed.has(name)))
    tries.push({
      id: 'weak',
      label: 'Follow weaker texture too',
      patch: { changed: new Map([...changed, ...Object.entries(WEAK)]) },
    });
  return tries;
}
