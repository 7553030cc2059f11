// The places to check: ranges of frames whose masks may be wrong (`doubts` of a result).

import { showCorrected } from './show-result.js';
import { type State, type Store, clampFrame, shotOf } from './store.js';
import type { FrameRange } from './library.js';

/** Repairs of a doubt: with the masks of both neighbours, or onward from the frame before. */
export type Repair = 'both' | 'before';

/** Returns the number of the doubt that has the frame on screen; -1 if none has. */
export function doubtAt({ doubts, frame }: Pick<State, 'doubts' | 'frame'>): number {
  return doubts.findIndex(({ from, to }) => from <= frame && frame < to);
}

/** Shows the middle of the next doubt, after the last one the first. */
export function showNextDoubt(store: Store) {
  const { doubts, frame } = store.state;
  const next = doubts.find(({ from }) => from > frame) ?? doubts[0];
  if (!next) return;
  const middle = Math.floor((next.from + next.to - 1) / 2);
  store.set({ isPlaying: false, frame: clampFrame(store.state, middle) });
}

/** Removes the doubt on screen, which the user found fine, and shows the next one. */
export function acceptDoubt(store: Store) {
  const accepted = store.state.doubts[doubtAt(store.state)];
  if (!accepted) return;
  removeDoubt(store, accepted);
  showNextDoubt(store);
}

function removeDoubt(store: Store, { from }: FrameRange) {
  const { doubts, fine } = store.state;
  store.set({ doubts: doubts.filter((doubt) => doubt.from !== from), fine: new Set([...fine, from]) });
}

/** Returns why a doubt cannot be repaired; empty if it can. */
export function describeObstacle(state: Pick<State, 'timeline'>, doubt: FrameRange, repair: Repair): string {
  const shot = shotOf(state, doubt.from);
  if (doubt.from === shot.from)
    return shot.from === 0 ? 'There is no frame before these.' : 'There is a cut before these frames.';
  if (repair === 'before' || doubt.to < shot.to) return '';
  return shot.to === state.timeline.numFrames ? 'There is no frame after these.' : 'There is a cut after these frames.';
}

/**
 * Repairs the masks of a doubt, or of all frames from there to the end of its shot, and accepts the doubt.
 * @returns the repaired frames; null if another clip is open
 */
export async function repairDoubt(
  store: Store,
  doubt: FrameRange,
  repair: Repair,
  { signal, onFrame }: { signal: AbortSignal; onFrame: () => void },
): Promise<FrameRange | null> {
  const { job, visit } = store.state;
  const range = { from: doubt.from, to: repair === 'both' ? doubt.to : shotOf(store.state, doubt.from).to };
  const frames = (await job?.corrector?.interpolate(range, { sides: repair, signal, onFrame })) ?? null;
  if (visit !== store.state.visit) return null;
  removeDoubt(store, doubt);
  showCorrected(store, frames);
  // A repair ends early where it is no longer sure.
  return frames ? { from: Math.min(...frames), to: Math.max(...frames) + 1 } : range;
}

/** Returns `3 places to check`; empty without any. */
export function describeDoubts(count: number): string {
  return count === 0 ? '' : count === 1 ? '1 place to check' : `${count} places to check`;
}
