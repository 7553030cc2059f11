// The timeline: frames and playing.

import { byId, h } from '../dom.js';
import { type Film, type State, type Store, withinFilm } from '../../model/store.js';
import { atTime } from '../../model/words.js';
import type { Page } from '../page.js';

export function timelinePanel({ store, keys }: Pick<Page, 'store' | 'keys'>) {
  const timeline = new Timeline(store);
  keys.on(' ', () => timeline.toggle());
  keys.on('ArrowLeft', () => timeline.step(-1));
  keys.on('ArrowRight', () => timeline.step(1));
  keys.on('Home', () => timeline.jump(0));
  keys.on('End', () => timeline.jump(timeline.last));
}

class Timeline {
  range = byId<HTMLInputElement>('scrub');
  ticking = 0;

  constructor(readonly store: Store) {
    this.connect();
    store.watch(['film'], ({ film }) => this.showFilm(film));
    store.watch(['frame', 'film'], (state) => this.showFrame(state));
    store.watch(['loop'], ({ loop }) => byId('loop').setAttribute('aria-pressed', String(loop)));
    store.watch(['playing'], ({ playing }) => this.showPlaying(playing));
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

  /** The last frame. */
  get last() {
    return this.store.state.film.numFrames - 1;
  }

  showFilm({ numFrames, times, cuts }: Film) {
    this.range.max = String(Math.max(0, numFrames - 1));
    for (const control of byId('timeline').querySelectorAll('button, input'))
      (control as HTMLButtonElement).disabled = numFrames < 2;
    const marks = cuts.map((frame) => {
      const mark = h('span', { class: 'cut', title: `Cut at ${times.at(frame)}` });
      mark.style.setProperty('--at', String(frame / Math.max(1, numFrames)));
      return mark;
    });
    byId('cuts').replaceChildren(...marks);
    const places = cuts.map((frame) => times.at(frame)).join(', ');
    byId('cuts-text').textContent = cuts.length > 0 ? `Cuts: ${places}.` : '';
  }

  showFrame({ film, frame }: Readonly<State>) {
    const { numFrames, times } = film;
    // Frames that only just arrive are no film yet.
    const at = withinFilm({ film }, frame);
    this.range.value = String(at);
    this.range.setAttribute('aria-valuetext', `Frame ${at + 1} of ${numFrames}${atTime(times, at)}`);
    const share = String(numFrames > 1 ? at / (numFrames - 1) : 0);
    for (const where of [this.range, byId('object-list')]) where.style.setProperty('--share', share);
    byId('counter').textContent = numFrames > 0 ? `${at + 1} / ${numFrames}` : '– / –';
  }

  jump(frame: number) {
    this.store.set({ playing: false, frame: withinFilm(this.store.state, frame) });
  }

  /** @param by frames; past either end it stays, or goes round when looping */
  step(by: number) {
    const { film, frame, loop } = this.store.state;
    if (film.numFrames === 0) return;
    this.jump(loop ? (frame + by + film.numFrames) % film.numFrames : frame + by);
  }

  toggle() {
    const { playing, film, loop, frame } = this.store.state;
    const isAtEnd = !loop && frame === this.last;
    if (playing) this.store.set({ playing: false });
    else if (film.numFrames > 1) this.store.set({ playing: true, frame: isAtEnd ? 0 : frame });
  }

  showPlaying(playing: boolean) {
    cancelAnimationFrame(this.ticking);
    if (playing) this.play();
    byId('play').dataset.playing = String(playing);
    byId('play').setAttribute('aria-label', playing ? 'Pause' : 'Play');
  }

  play() {
    let before = performance.now();
    /** For how long the frame on screen has been shown, in seconds. */
    let shown = 0;
    const tick = (now: number) => {
      this.ticking = requestAnimationFrame(tick);
      const { film, frame } = this.store.state;
      const lasts = (by: number) => film.times.lasts((frame + by) % film.numFrames, film.fps);
      // A page that was in the background does not try to catch up.
      shown += Math.min((now - before) / 1000, Math.max(1, lasts(0)));
      before = now;
      let due = 0;
      for (; shown >= lasts(due); due++) shown -= lasts(due);
      if (due > 0) this.advance(due);
    };
    this.ticking = requestAnimationFrame(tick);
  }

  /** @param by frames while playing */
  advance(by: number) {
    const { film, frame, loop } = this.store.state;
    if (!loop && frame + by >= this.last) this.jump(this.last);
    else this.store.set({ frame: (frame + by) % film.numFrames });
  }
}
