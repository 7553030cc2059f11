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
  if (trajectories === 0) return `No points to track in ${plural(numFrames, 'frame')}.`;
  const followed = `Tracked ${plural(trajectories, 'point')} over ${percent(coverage)} of the picture in ${plural(numFrames, 'frame')}`;
  const camera = cameraMoves ? `the camera moves about ${speed.toFixed(1)} px/frame` : 'the camera is still';
  return `${followed}; ${camera}. ${groundWords(motions)}`;
}

function groundWords(motions: number[] | null) {
  if (!motions || motions.length < 1) return 'Nothing stands out.';
  if (motions.length === 1) return 'Everything moves together, so nothing stands out.';
  return `There are ${motions.length} motions, the largest with ${percent(motions[0])} of the points; none stands out.`;
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
    tries.push({ id: 'whole', label: 'Whole clip', patch: { take: whole } });
  }
  const side = SIDES.find((one) => one > take.side);
  if (isOwn && side && Math.max(source.width, source.height) > take.side)
    tries.push({ id: 'side', label: `Larger, at ${side} px`, patch: { take: { ...take, side } } });
  if (coverage < LITTLE && Object.keys(WEAK).some((name) => !changed.has(name)))
    tries.push({
      id: 'weak',
      label: 'Track weaker texture',
      patch: { changed: new Map([...changed, ...Object.entries(WEAK)]) },
    });
  return tries;
}
