// The places to check: ranges of frames whose masks may be wrong (`doubts` of a result).

import { type State, type Store, clampFrame } from './store.js';

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
  const { doubts, fine } = store.state;
  const accepted = doubts[doubtAt(store.state)];
  if (!accepted) return;
  store.set({ doubts: doubts.filter((doubt) => doubt !== accepted), fine: new Set([...fine, accepted.from]) });
  showNextDoubt(store);
}

/** Returns `3 places to check`; empty without any. */
export function describeDoubts(count: number): string {
  return count === 0 ? '' : count === 1 ? '1 place to check' : `${count} places to check`;
}
