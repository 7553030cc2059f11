// Proposals to join objects that look like pieces of one.

import { findSimilarObjects } from './similar-objects.js';
import type { Store } from './store.js';

/** Time without changes before similar objects are searched, in milliseconds; chosen by eye. */
const SEARCH_DELAY_MS = 200;

export class JoinProposals {
  groups: number[][] = [];
  /** Groups that the user does not want to join. */
  dismissed = new Set<string>();
  timer: ReturnType<typeof setTimeout> | undefined = undefined;

  /** @param onFound called after each search */
  constructor(
    readonly store: Store,
    readonly onFound: () => void,
  ) {
    store.watch(['visit'], () => this.dismissed.clear());
    store.watch(['analysis', 'phase'], () => this.searchSoon());
  }

  /** The objects to propose; undefined if there are none. */
  get current(): number[] | undefined {
    return this.groups.find((group) => !this.dismissed.has(String(group)));
  }

  dismiss() {
    this.dismissed.add(String(this.current));
  }

  searchSoon() {
    this.groups = [];
    clearTimeout(this.timer);
    const { analysis, phase, timeline, job } = this.store.state;
    const segmentation = analysis?.segmentation;
    if (phase !== 'done' || !segmentation || !job?.corrector) return;
    this.timer = setTimeout(() => {
      const { width, height, numFrames, trajectories } = segmentation.result;
      const labels = (t: number) => segmentation.mask(t)!;
      this.groups = findSimilarObjects({
        ...{ width, height, numFrames, trajectories, labels, scene: segmentation.scene },
        ...{ spans: analysis.facts, cuts: timeline.cuts },
      });
      this.onFound();
    }, SEARCH_DELAY_MS);
  }
}
