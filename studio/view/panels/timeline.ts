// The timeline: scrubbing and playback.

import { byId, h } from '../dom.js';
import { type Timeline, type State, type Store, clampFrame } from '../../model/store.js';
import { Playback, jumpTo, stepFrames, togglePlaying } from '../../model/playback.js';
import { formatFrameTime } from '../../model/messages.js';
import type { Page } from '../page.js';

export function timelinePanel({ store, keys }: Pick<Page, 'store' | 'keys'>) {
  new TimelinePanel(store);
  keys.on(' ', () => togglePlaying(store));
  keys.on('ArrowLeft', () => stepFrames(store, -1));
  keys.on('ArrowRight', () => stepFrames(store, 1));
  keys.on('Home', () => jumpTo(store, 0));
  keys.on('End', () => jumpTo(store, store.state.timeline.numFrames - 1));
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
    this.range.addEventListener('input', () => jumpTo(this.store, Number(this.range.value)));
    const buttons: Record<string, () => void> = {
      play: () => togglePlaying(this.store),
      loop: () => this.store.set({ loop: !this.store.state.loop }),
      back: () => stepFrames(this.store, -1),
      forward: () => stepFrames(this.store, 1),
    };
    for (const [id, act] of Object.entries(buttons)) byId(id).addEventListener('click', act);
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

  showPlaying(playing: boolean) {
    cancelAnimationFrame(this.ticking);
    if (playing) this.play();
    byId('play').dataset.playing = String(playing);
    byId('play').setAttribute('aria-label', playing ? 'Pause' : 'Play');
  }

  play() {
    const playback = new Playback(this.store);
    let lastTick = performance.now();
    const tick = (now: number) => {
      this.ticking = requestAnimationFrame(tick);
      playback.pass((now - lastTick) / 1000);
      lastTick = now;
    };
    this.ticking = requestAnimationFrame(tick);
  }
}
