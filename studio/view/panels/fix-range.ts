// The frames of the last painted correction, below the scrubber: a bar in the colour of its object, with two handles that
// remove it from frames or carry it on.

import { byId } from '../dom.js';
import { formatFrameTime } from '../../model/messages.js';
import { objectColor } from '../../model/palette.js';
import { type Fix, type State, clampFrame, shotOf } from '../../model/store.js';
import type { Brush } from '../../model/brush.js';
import type { Page } from '../page.js';

type Range = { first: number; last: number };

export class FixRange {
  box = byId('fix-range');
  first = byId<HTMLInputElement>('fix-first');
  last = byId<HTMLInputElement>('fix-last');
  /** The range that the user wants; null once it is reached. */
  wanted: Range | null = null;

  constructor(
    readonly store: Page['store'],
    readonly brush: Pick<Brush, 'moveEnds'>,
  ) {
    for (const handle of [this.first, this.last]) {
      handle.addEventListener('input', () => this.moveHandle(handle));
      handle.addEventListener('change', () => void this.apply());
    }
    store.watch(['fix', 'isCorrecting', 'timeline'], (state) => this.show(state));
  }

  show({ fix, isCorrecting, timeline: { numFrames } }: Readonly<State>) {
    this.box.hidden = !fix || !isCorrecting || numFrames < 2;
    if (!fix || this.box.hidden) return;
    this.box.style.setProperty('--mark', objectColor(fix.object));
    // While it spreads by itself, there is nothing to hold.
    this.box.toggleAttribute('data-spreading', fix.isSpreading && !this.wanted);
    for (const handle of [this.first, this.last]) {
      handle.max = String(numFrames - 1);
      handle.disabled = fix.isSpreading && !this.wanted;
    }
    this.showHandles(this.wanted ?? fix);
    this.showBar(fix);
  }

  showBar({ first, last }: Range) {
    const most = Number(this.first.max);
    this.box.style.setProperty('--from', String(first / most));
    this.box.style.setProperty('--to', String(last / most));
  }

  showHandles({ first, last }: Range) {
    const { numFrames, times } = this.store.state.timeline;
    for (const [handle, frame] of [
      [this.first, first],
      [this.last, last],
    ] as const) {
      handle.value = String(frame);
      handle.setAttribute('aria-valuetext', `Frame ${frame + 1} of ${numFrames}${formatFrameTime(times, frame)}`);
    }
  }

  /** Shows the frame of a moving handle. The painted frame stays inside, and the range inside of the shot. */
  moveHandle(handle: HTMLInputElement) {
    const { fix } = this.store.state;
    if (!fix) return;
    const range = this.rangeOf(fix);
    this.wanted = range;
    this.showHandles(range);
    this.showBar(range);
    const frame = clampFrame(this.store.state, handle === this.first ? range.first : range.last);
    this.store.set({ isPlaying: false, frame });
  }

  /** Returns the range of the handles, around the painted frame and in its shot. */
  rangeOf({ t }: Fix): Range {
    const { from, to } = shotOf(this.store.state, t);
    return {
      first: Math.max(from, Math.min(t, Number(this.first.value))),
      last: Math.min(to - 1, Math.max(t, Number(this.last.value))),
    };
  }

  /** Applies the range when a handle is released. */
  async apply() {
    const { wanted } = this;
    if (!wanted) return;
    await this.brush.moveEnds(wanted);
    // The handle may have been moved again.
    if (this.wanted !== wanted) return;
    this.wanted = null;
    this.show(this.store.state);
  }
}
