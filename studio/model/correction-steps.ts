// The steps of the tools that fix a result: which ones are possible, and the status text after one.

import { explain, formatSeconds } from './messages.js';
import { showCorrected } from './show-result.js';
import type { Corrections } from './corrections.js';
import type { Store } from './store.js';

/** What the user has selected: `object` to correct and `target` to join it with, 0 for none; a clicked place; strokes. */
export type StepChoice = { object: number; target: number; hasPlace: boolean; tool: string; numStrokes: number };

/**
 * Returns which steps can be taken.
 * @param hasPrevious true if the run replaced another result, which undo restores
 */
export function possibleSteps(
  corrector: Pick<Corrections, 'splitsAtPlace' | 'undoCount' | 'redoCount'>,
  { object, target, hasPlace, tool, numStrokes }: StepChoice,
  hasPrevious: boolean,
) {
  const isObject = object !== 0;
  return {
    applyStrokes: numStrokes >= (tool === 'apart' ? 2 : 1),
    clearStrokes: numStrokes > 0,
    join: isObject && target !== 0,
    makeBackground: isObject,
    // Without a session, no part of the background can be split off.
    split: isObject ? hasPlace || !corrector.splitsAtPlace : hasPlace && !corrector.splitsAtPlace,
    undo: corrector.undoCount() > 0 || hasPrevious,
    redo: corrector.redoCount() > 0,
  };
}

/**
 * Applies a correction and shows it.
 * @param correct resolves to the changed frames; null for all
 * @param doneText status instead of the elapsed time
 * @returns the status; null if another clip is open
 */
export async function applyStep(
  store: Store,
  correct: () => Promise<number[] | null>,
  doneText?: string,
): Promise<{ text: string; isError: boolean } | null> {
  const { visit } = store.state;
  const began = performance.now();
  try {
    const frames = await correct();
    if (visit !== store.state.visit) return null;
    showCorrected(store, frames);
    const message = doneText ?? `Corrected in ${formatSeconds(performance.now() - began)}`;
    return { text: `${message}. ${store.state.headline}.`, isError: false };
  } catch (error) {
    const { title, detail } = explain(error);
    return visit === store.state.visit ? { text: `Not possible here: ${detail || title}.`, isError: true } : null;
  }
}
