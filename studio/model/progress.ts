// Progress of a run as text.

import { stageName, formatTimeLeft } from './messages.js';
import type { StageClock } from './library.js';
import type { State } from './store.js';

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
