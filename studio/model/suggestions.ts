// Reports why nothing was found, and suggests what to try.

import { clampTrim } from './source.js';
import { formatPercent, formatPlural } from './messages.js';
import type { SearchReport } from './library.js';
import type { State } from './store.js';

const WORKING_SIDES_PX = [320, 480, 640];

/** Fewest frames for skipping every second one; chosen by eye. */
const MIN_FRAMES_TO_SKIP = 26;

/** Coverage below which weaker texture is suggested; chosen by eye. */
const LOW_COVERAGE = 0.5;

/** Settings that track weaker texture. */
const WEAK_TEXTURE_SETTINGS = {
  'trajectory.structureFloor': 0.005,
  'trajectory.structureMean': 0.005,
  'trajectory.minLength': 4,
};

/** Largest suggested step; frames further apart are too different. */
const MAX_STEP = 3;

export function describeSearch({
  numFrames,
  trajectories,
  coverage,
  speed,
  cameraMoves,
  motions,
}: SearchReport): string {
  if (trajectories === 0) return `No points to track in ${formatPlural(numFrames, 'frame')}.`;
  const followed = `Tracked ${formatPlural(trajectories, 'point')} over ${formatPercent(coverage)} of the picture in ${formatPlural(numFrames, 'frame')}`;
  const camera = cameraMoves ? `the camera moves about ${speed.toFixed(1)} px/frame` : 'the camera is still';
  return `${followed}; ${camera}. ${describeMotions(motions)}`;
}

function describeMotions(motions: number[] | null) {
  if (!motions || motions.length < 1) return 'Nothing stands out.';
  if (motions.length === 1) return 'Everything moves together, so nothing stands out.';
  return `There are ${motions.length} motions, the largest with ${formatPercent(motions[0])} of the points; none stands out.`;
}

/**
 * Suggests changes that helped on clips without a result. Skipping frames found slow objects in two of three clips, a
 * larger size and a longer part one each, and weaker texture objects in front of plain backgrounds; denser points and
 * a lower noise floor found nothing.
 */
export function suggestChanges(
  { source, job, changed }: State,
  { coverage }: SearchReport,
): { id: string; label: string; patch: Partial<State> }[] {
  if (!source || !job) return [];
  const { trim } = job;
  const suggestions: { id: string; label: string; patch: Partial<State> }[] = [];
  const isUserClip = source.kind !== 'sample';
  if (isUserClip && trim.frames >= MIN_FRAMES_TO_SKIP && trim.step < MAX_STEP) {
    const step = trim.step + 1;
    const frames = Math.ceil((trim.frames * trim.step) / step);
    const label = step === 2 ? 'Every 2nd frame, for slow motion' : 'Every 3rd frame';
    suggestions.push({ id: 'step', label, patch: { trim: clampTrim({ ...trim, step, frames }, source) } });
  }
  if (isUserClip && (trim.start > 0 || trim.start + trim.frames * trim.step < source.count)) {
    const wholeClip = clampTrim({ ...trim, start: 0, frames: source.count }, source);
    suggestions.push({ id: 'whole', label: 'Whole clip', patch: { trim: wholeClip } });
  }
  const side = WORKING_SIDES_PX.find((largerSide) => largerSide > trim.side);
  if (isUserClip && side && Math.max(source.width, source.height) > trim.side)
    suggestions.push({ id: 'side', label: `Larger, at ${side} px`, patch: { trim: { ...trim, side } } });
  if (coverage < LOW_COVERAGE && Object.keys(WEAK_TEXTURE_SETTINGS).some((name) => !changed.has(name)))
    suggestions.push({
      id: 'weak',
      label: 'Track weaker texture',
      patch: { changed: new Map([...changed, ...Object.entries(WEAK_TEXTURE_SETTINGS)]) },
    });
  return suggestions;
}
