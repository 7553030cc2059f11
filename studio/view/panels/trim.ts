// The filmstrip of the opened clip with a handle at either end: what lies between is what a run takes. It is there
// before, during and after a run; the clip can be played from it without one.

import { type ClipPlayer, openPlayer } from '../clip-player.js';
import { lastOf, lengthOf, partWords, placeIn } from '../../model/clip-words.js';
import { byId, h } from '../dom.js';
import { type Source, fitTake } from '../../model/source.js';
import { explain } from '../../model/words.js';
import type { State, Store } from '../../model/store.js';
import type { Page } from '../page.js';

/** Pictures of the strip, and their long side in pixels. */
const PICTURES = 12;
const SIDE = 112;

export function trimPanel({ store, app, keys }: Pick<Page, 'store' | 'app' | 'keys'>) {
  const panel = new TrimPanel(store);
  byId('trim-run').addEventListener('click', () => app.again());
  keys.on(
    'p',
    () => panel.toggle(),
    () => !byId('trim').hidden,
  );
}

class TrimPanel {
  from = byId<HTMLInputElement>('trim-from');
  to = byId<HTMLInputElement>('trim-to');
  strip = byId('trim-strip');
  player: ClipPlayer | null = null;
  playing = false;
  /** The strip of the source before is void. */
  drawing = new AbortController();

  constructor(readonly store: Store) {
    this.connect();
    store.watch(['source'], ({ source }) => this.open(source));
    store.watch(['source', 'take'], (state) => this.show(state));
    store.watch(['source', 'take', 'phase', 'job'], (state) => showRun(state));
    // What is found takes the screen.
    store.watch(['phase'], () => this.hide());
  }

  connect() {
    for (const handle of [this.from, this.to]) {
      handle.addEventListener('input', () => this.look(handle));
      handle.addEventListener('change', () => this.choose());
      handle.addEventListener('blur', () => this.playing || this.hide());
      handle.addEventListener('pointerup', () => this.playing || this.hide());
    }
    byId('trim-play').addEventListener('click', () => this.toggle());
    byId('trim-all').addEventListener('click', () => {
      const { source, take } = this.store.state;
      if (source) this.store.set({ take: fitTake({ ...take, start: 0, frames: source.count }, source) });
    });
  }

  open(source: Source | null) {
    this.hide();
    this.player?.close();
    this.player = null;
    this.drawing.abort();
    const trims = Boolean(source?.strip && source.count > 2);
    byId('trim').hidden = !trims;
    this.strip.replaceChildren();
    if (!source || !trims) return;
    this.from.max = this.to.max = String(source.count - 1);
    this.drawing = new AbortController();
    this.draw(source, this.drawing.signal);
  }

  async draw(source: Source, signal: AbortSignal) {
    const shape = source.width / source.height;
    const side = Math.round(shape > 1 ? SIDE : SIDE / shape);
    const places = Array.from({ length: Math.min(PICTURES, source.count) }, () => h('canvas'));
    this.strip.replaceChildren(...places);
    try {
      let at = 0;
      for await (const image of source.strip?.(PICTURES, side, signal) ?? []) {
        const canvas = places[at++];
        Object.assign(canvas, { width: image.width, height: image.height });
        canvas.getContext('2d')?.putImageData(image, 0, 0);
      }
    } catch (error) {
      // What cannot be read is told by the run; what was asked wrongly is a fault of the page.
      if (explain(error).code === 'param') throw error;
    }
    if (!signal.aborted) this.strip.dataset.ready = source.name;
  }

  show({ source, take }: Readonly<State>) {
    if (!source?.strip) return;
    const last = lastOf(take);
    this.from.value = String(take.start);
    this.to.value = String(last);
    this.words(source, take.start, last);
  }

  words(source: Source, first: number, last: number) {
    const whole = first === 0 && last >= source.count - 1;
    const at = placeIn(source);
    this.from.setAttribute('aria-valuetext', at(first));
    this.to.setAttribute('aria-valuetext', at(last));
    const box = byId('trim-box');
    box.style.setProperty('--from', String(first / (source.count - 1)));
    box.style.setProperty('--to', String(last / (source.count - 1)));
    byId('trim-text').textContent = whole ? `Whole clip, ${lengthOf(source)}` : partWords(source, first, last);
    byId('trim-all').hidden = whole;
  }

  /** While a handle moves: the frame that it stands on. The handles never meet. */
  look(handle: HTMLInputElement) {
    const { source, take } = this.store.state;
    if (!source) return;
    if (handle === this.from)
      this.from.value = String(Math.min(Number(this.from.value), Number(this.to.value) - take.step));
    else this.to.value = String(Math.max(Number(this.to.value), Number(this.from.value) + take.step));
    this.words(source, Number(this.from.value), Number(this.to.value));
    this.stop();
    this.reveal().show(Number(handle.value));
  }

  /** A handle rests: that is the part that is meant. */
  choose() {
    const { source, take } = this.store.state;
    if (!source) return;
    const start = Number(this.from.value);
    const frames = Math.floor((Number(this.to.value) - start) / take.step) + 1;
    if (start === take.start && frames === take.frames) return;
    this.store.set({ take: fitTake({ ...take, start, frames }, source) });
  }

  toggle() {
    const { source, take } = this.store.state;
    if (!source) return;
    if (this.playing) return this.hide();
    this.store.set({ playing: false });
    this.playing = true;
    this.reveal().play(take.start, lastOf(take), (frame) =>
      byId('trim-box').style.setProperty('--at', String(frame / (source.count - 1))),
    );
    this.showPlaying();
  }

  reveal() {
    const { source } = this.store.state;
    const player = (this.player ??= openPlayer(source!));
    byId('preview').replaceChildren(player.element);
    byId('preview').hidden = false;
    return player;
  }

  stop() {
    this.player?.pause();
    this.playing = false;
    this.showPlaying();
  }

  hide() {
    this.stop();
    byId('preview').hidden = true;
  }

  showPlaying() {
    const button = byId('trim-play');
    button.dataset.playing = String(this.playing);
    button.setAttribute('aria-label', this.playing ? 'Stop the clip' : 'Play the clip');
    byId('trim-box').toggleAttribute('data-playing', this.playing);
  }
}

/** A run under way follows the handles by itself; one that has ended is asked for. */
function showRun({ source, take, phase, job }: Readonly<State>) {
  const done = phase === 'done' || phase === 'stopped';
  const other = job !== null && (job.take.start !== take.start || lastOf(job.take) !== lastOf(take));
  const button = byId('trim-run');
  button.hidden = !(done && other);
  const whole = source && take.start === 0 && lastOf(take) + take.step >= source.count;
  button.textContent = whole ? 'Run the whole clip' : 'Run this part';
}
