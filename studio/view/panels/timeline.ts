// The timeline: scrubbing and playback.

import { byId, h } from '../dom.js';
import { type Timeline, type State, type Store, clampFrame } from '../../model/store.js';
import { formatFrameTime } from '../../model/messages.js';
import type { Page } from '../page.js';

export function timelinePanel({ store, keys }: Pick<Page, 'store' | 'keys'>) {
  const timeline = new TimelinePanel(store);
  keys.on(' ', () => timeline.toggle());
  keys.on('ArrowLeft', () => timeline.step(-1));
  keys.on('ArrowRight', () => timeline.step(1));
  keys.on('Home', () => timeline.jump(0));
  keys.on('End', () => timeline.jump(timeline.last));
}

class TimelinePanel {
  range = byId<HTMLInputElement>('scrub');
  ticking = 0;

  constructor(readonly store: Store) {
    this.connect();
    store.watch(['timeline'], ({ timeline }) => this.showTimeline(timeline));
    store.watch(['frame', 'timeline'], (state) => this.showFrame(state));
    store.watch(['loop'], ({ loop }) => byId('loop').setAttribute('aria-pressed', String(loop)));
    store.watch(['isPlaying'], ({ isPlaying }) => this.showPlaying(isPlaying));
  }

  connect() {
    this.range.addEventListener('input', () => this.jump(Number(this.range.value)));
    const buttons: Record<string, () => void> = {
      play: () => this.toggle(),
      loop: () => this.store.set({ loop: !this.store.state.loop }),
      back: () => this.step(-1),
      forward: () => this.step(1),
    };
    for (const [id, act] of Object.entries(buttons)) byId(id).addEventListener('click', act);
  }

  get last() {
    return this.store.state.timeline.numFrames - 1;
  }

  showTimeline({ numFrames, times, cuts }: Timeline) {
    this.range.max = String(Math.max(0, numFrames - 1));
    for (const control of byId('timeline').querySelectorAll('button, input'))
      (control as HTMLButtonElement).disabled = numFrames < 2;
    const marks = cuts.map((frame) => {
      const mark = h('span', { class: 'cut', title: `Cut at ${times.format(frame)}` });
      mark.style.setProperty('--at', String(frame / Math.max(1, numFrames)));
      return mark;
    });
    byId('cuts').replaceChildren(...marks);
    const places = cuts.map((frame) => times.format(frame)).join(', ');
    byId('cuts-text').textContent = cuts.length > 0 ? `Cuts: ${places}.` : '';
  }

  showFrame({ timeline, frame }: Readonly<State>) {
    const { numFrames, times } = timeline;
    // Frames that just arrived may not be on the timeline yet.
    const at = clampFrame({ timeline }, frame);
    this.range.value = String(at);
    this.range.setAttribute('aria-valuetext', `Frame ${at + 1} of ${numFrames}${formatFrameTime(times, at)}`);
    const share = String(numFrames > 1 ? at / (numFrames - 1) : 0);
    for (const where of [this.range, byId('object-list')]) where.style.setProperty('--share', share);
    byId('counter').textContent = numFrames > 0 ? `${at + 1} / ${numFrames}` : '– / –';
  }

  jump(frame: number) {
    this.store.set({ isPlaying: false, frame: clampFrame(this.store.state, frame) });
  }

  /** @param by frames; stops at the ends, or wraps when looping */
  step(by: number) {
    const { timeline, frame, loop } = this.store.state;
    if (timeline.numFrames === 0) return;
    this.jump(loop ? (frame + by + timeline.numFrames) % timeline.numFrames : frame + by);
  }

  toggle() {
    const { isPlaying, timeline, loop, frame } = this.store.state;
    const isAtEnd = !loop && frame === this.last;
    if (isPlaying) this.store.set({ isPlaying: false });
    else if (timeline.numFrames > 1) this.store.set({ isPlaying: true, frame: isAtEnd ? 0 : frame });
  }

  showPlaying(playing: boolean) {
    cancelAnimationFrame(this.ticking);
    if (playing) this.play();
    byId('play').dataset.playing = String(playing);
    byId('play').setAttribute('aria-label', playing ? 'Pause' : 'Play');
  }

  play() {
    let lastTick = performance.now();
    /** Time that the current frame has been shown, in seconds. */
    let shownSeconds = 0;
    const tick = (now: number) => {
      this.ticking = requestAnimationFrame(tick);
      const { timeline, frame } = this.store.state;
      const durationOf = (by: number) => timeline.times.durationOf((frame + by) % timeline.numFrames, timeline.fps);
      // Does not catch up after the page was in the background.
      shownSeconds += Math.min((now - lastTick) / 1000, Math.max(1, durationOf(0)));
      lastTick = now;
      let due = 0;
      for (; shownSeconds >= durationOf(due); due++) shownSeconds -= durationOf(due);
      if (due > 0) this.advance(due);
    };
    this.ticking = requestAnimationFrame(tick);
  }

  advance(by: number) {
    const { timeline, frame, loop } = this.store.state;
    if (!loop && frame + by >= this.last) this.jump(this.last);
    else this.store.set({ frame: (frame + by) % timeline.numFrames });
  }
}
