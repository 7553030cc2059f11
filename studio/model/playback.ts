// Moving through the frames of a clip: jumps, steps, and playback at the pace of the clip.

import { type Store, clampFrame } from './store.js';

/** Pauses at a frame. */
export function jumpTo(store: Store, frame: number) {
  store.set({ isPlaying: false, frame: clampFrame(store.state, frame) });
}

/** @param by frames; stops at the ends, or wraps when looping */
export function stepFrames(store: Store, by: number) {
  const { timeline, frame, loop } = store.state;
  if (timeline.numFrames === 0) return;
  jumpTo(store, loop ? (frame + by + timeline.numFrames) % timeline.numFrames : frame + by);
}

/** Plays or pauses; at the end of a clip that does not loop, plays from the start. */
export function togglePlaying(store: Store) {
  const { isPlaying, timeline, loop, frame } = store.state;
  const isAtEnd = !loop && frame === timeline.numFrames - 1;
  if (isPlaying) store.set({ isPlaying: false });
  else if (timeline.numFrames > 1) store.set({ isPlaying: true, frame: isAtEnd ? 0 : frame });
}

/** Advances a playing clip by the time that passes. */
export class Playback {
  /** Time that the frame on screen has been shown, in seconds. */
  shownSeconds = 0;

  constructor(readonly store: Store) {}

  /** @param seconds since the last call */
  pass(seconds: number) {
    const { timeline, frame } = this.store.state;
    const durationOf = (by: number) => timeline.times.durationOf((frame + by) % timeline.numFrames, timeline.fps);
    // Does not catch up after the page was in the background.
    this.shownSeconds += Math.min(seconds, Math.max(1, durationOf(0)));
    let due = 0;
    for (; this.shownSeconds >= durationOf(due); due++) this.shownSeconds -= durationOf(due);
    if (due > 0) this.advance(due);
  }

  advance(by: number) {
    const { timeline, frame, loop } = this.store.state;
    const last = timeline.numFrames - 1;
    if (!loop && frame + by >= last) jumpTo(this.store, last);
    else this.store.set({ frame: (frame + by) % timeline.numFrames });
  }
}
