// The filmstrip with handles that trim the clip, before, during and after a run. It also plays the original clip.

import { type ClipPlayer, openPlayer } from '../clip-player.js';
import { lastFrame, describeLength, describePart, frameFormatter } from '../../model/clip-text.js';
import { byId, h } from '../dom.js';
import { type Source, clampTrim } from '../../model/source.js';
import { explain } from '../../model/messages.js';
import type { State, Store } from '../../model/store.js';
import type { Page } from '../page.js';

/** Number of pictures in the strip, and their long side; chosen by eye. */
const STRIP_PICTURES = 12;
const STRIP_SIDE_PX = 112;

export function trimPanel({ store, app, keys }: Pick<Page, 'store' | 'app' | 'keys'>) {
  const panel = new TrimPanel(store);
  byId('trim-run').addEventListener('click', () => app.rerun());
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
  /** Stops drawing the strip of the previous source. */
  drawing = new AbortController();
  /** The source whose strip is not drawn yet. */
  undrawn: Source | null = null;

  constructor(readonly store: Store) {
    this.connect();
    store.watch(['source'], ({ source }) => this.open(source));
    store.watch(['source', 'phase', 'isStreaming'], (state) => this.drawAfterMasks(state));
    store.watch(['isMuted'], ({ isMuted }) => this.player?.mute(isMuted));
    store.watch(['source', 'trim'], (state) => this.show(state));
    store.watch(['source', 'trim', 'phase', 'job'], (state) => showRun(state));
    // Results replace the player.
    store.watch(['phase'], () => this.hide());
  }

  connect() {
    for (const handle of [this.from, this.to]) {
      handle.addEventListener('input', () => this.moveHandle(handle));
      handle.addEventListener('change', () => this.applyHandles());
      handle.addEventListener('blur', () => this.playing || this.hide());
      handle.addEventListener('pointerup', () => this.playing || this.hide());
    }
    byId('trim-play').addEventListener('click', () => this.toggle());
    byId('trim-all').addEventListener('click', () => {
      const { source, trim } = this.store.state;
      if (source) this.store.set({ trim: clampTrim({ ...trim, start: 0, frames: source.count }, source) });
    });
  }

  open(source: Source | null) {
    this.hide();
    this.player?.close();
    this.player = null;
    this.drawing.abort();
    delete this.strip.dataset.ready;
    const canTrim = Boolean(source?.strip && source.count > 2);
    byId('trim').hidden = !canTrim;
    this.strip.replaceChildren();
    this.undrawn = canTrim ? source : null;
    if (!source || !canTrim) return;
    this.from.max = this.to.max = String(source.count - 1);
    const count = Math.min(STRIP_PICTURES, source.count);
    this.strip.replaceChildren(...Array.from({ length: count }, () => h('canvas')));
  }

  /** Draws the strip once there are masks, or none will come: it decodes the file a second time, which delays them. */
  drawAfterMasks({ phase, isStreaming }: Readonly<State>) {
    const source = this.undrawn;
    if (!source || !(isStreaming || ['stopped', 'done', 'error'].includes(phase))) return;
    this.undrawn = null;
    this.drawing = new AbortController();
    this.draw(source, this.drawing.signal);
  }

  async draw(source: Source, signal: AbortSignal) {
    const shape = source.width / source.height;
    const side = Math.round(shape > 1 ? STRIP_SIDE_PX : STRIP_SIDE_PX / shape);
    const places = [...this.strip.children] as HTMLCanvasElement[];
    try {
      let at = 0;
      for await (const image of source.strip?.(STRIP_PICTURES, side, signal) ?? []) {
        const canvas = places[at++];
        Object.assign(canvas, { width: image.width, height: image.height });
        canvas.getContext('2d')?.putImageData(image, 0, 0);
      }
    } catch (error) {
      // The run reports unreadable files; wrong parameters are errors of the page.
      if (explain(error).code === 'param') throw error;
    }
    if (!signal.aborted) this.strip.dataset.ready = source.name;
  }

  show({ source, trim }: Readonly<State>) {
    if (!source?.strip) return;
    const last = lastFrame(trim);
    this.from.value = String(trim.start);
    this.to.value = String(last);
    this.showPart(source, trim.start, last);
  }

  showPart(source: Source, first: number, last: number) {
    const isWhole = first === 0 && last >= source.count - 1;
    const at = frameFormatter(source);
    this.from.setAttribute('aria-valuetext', at(first));
    this.to.setAttribute('aria-valuetext', at(last));
    const box = byId('trim-box');
    box.style.setProperty('--from', String(first / (source.count - 1)));
    box.style.setProperty('--to', String(last / (source.count - 1)));
    byId('trim-text').textContent = isWhole
      ? `Whole clip, ${describeLength(source)}`
      : describePart(source, first, last);
    byId('trim-all').hidden = isWhole;
  }

  /** Shows the frame of a moving handle; the handles never meet. */
  moveHandle(handle: HTMLInputElement) {
    const { source, trim } = this.store.state;
    if (!source) return;
    if (handle === this.from)
      this.from.value = String(Math.min(Number(this.from.value), Number(this.to.value) - trim.step));
    else this.to.value = String(Math.max(Number(this.to.value), Number(this.from.value) + trim.step));
    this.showPart(source, Number(this.from.value), Number(this.to.value));
    this.stop();
    this.reveal().show(Number(handle.value));
  }

  /** Applies the trim when a handle is released. */
  applyHandles() {
    const { source, trim } = this.store.state;
    if (!source) return;
    const start = Number(this.from.value);
    const frames = Math.floor((Number(this.to.value) - start) / trim.step) + 1;
    if (start === trim.start && frames === trim.frames) return;
    this.store.set({ trim: clampTrim({ ...trim, start, frames }, source) });
  }

  toggle() {
    const { source, trim } = this.store.state;
    if (!source) return;
    if (this.playing) return this.hide();
    this.store.set({ isPlaying: false });
    this.playing = true;
    this.reveal().play(trim.start, lastFrame(trim), (frame) =>
      byId('trim-box').style.setProperty('--at', String(frame / (source.count - 1))),
    );
    this.showPlaying();
  }

  reveal() {
    const { source, isMuted } = this.store.state;
    const player = (this.player ??= openPlayer(source!));
    player.mute(isMuted);
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

/** Offers to run the part, unless a run follows the handles already. */
function showRun({ source, trim, phase, job }: Readonly<State>) {
  const hasEnded = phase === 'done' || phase === 'stopped';
  const isOtherPart = job !== null && (job.trim.start !== trim.start || lastFrame(job.trim) !== lastFrame(trim));
  const button = byId('trim-run');
  button.hidden = !(hasEnded && isOtherPart);
  const isWhole = source && trim.start === 0 && lastFrame(trim) + trim.step >= source.count;
  button.textContent = isWhole ? 'Run the whole clip' : 'Run this part';
}
