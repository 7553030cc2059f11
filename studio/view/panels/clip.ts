// The form of the clip: first frame, number of frames, step and working size.

import { byId } from '../dom.js';
import { describeClip, frameFormatter, describeTrim, trimFromInputs } from '../../model/clip-text.js';
import { type Source, type Trim, clampTrim } from '../../model/source.js';
import type { State, Store } from '../../model/store.js';
import type { Page } from '../page.js';

export function clipPanel({ store }: Pick<Page, 'store'>) {
  new ClipPanel(store);
}

class ClipPanel {
  start = byId<HTMLInputElement>('clip-start');
  frames = byId<HTMLInputElement>('clip-frames');
  step = byId<HTMLSelectElement>('clip-step');
  side = byId<HTMLSelectElement>('clip-side');

  constructor(readonly store: Store) {
    for (const field of [this.start, this.frames, this.step, this.side])
      field.addEventListener('input', (event) => this.setTrim(this.readInputs(event.target)));
    byId('clip-all').addEventListener('click', () =>
      this.setTrim({ ...store.state.trim, start: 0, frames: store.state.source?.count ?? 0 }),
    );
    // The number is corrected only after typing.
    this.frames.addEventListener('blur', () => this.show(store.state));
    store.watch(['source'], ({ source }) => source && this.showSource(source));
    store.watch(['source', 'trim', 'pace'], (state) => this.show(state));
  }

  readInputs(changed: EventTarget | null) {
    const { trim, source } = this.store.state;
    const [start, frames, step, side] = [this.start, this.frames, this.step, this.side].map(({ value }) =>
      Number(value),
    );
    return trimFromInputs({ start, frames, step, side }, trim, source, changed === this.frames);
  }

  /** @param trim clamped to the source */
  setTrim(trim: Trim) {
    const { source } = this.store.state;
    if (source) this.store.set({ trim: clampTrim(trim, source) });
  }

  showSource(source: Source) {
    const isSample = source.kind === 'sample';
    byId('clip-more').hidden = isSample;
    byId('clip-facts').textContent = describeClip(source);
    this.start.max = String(Math.max(0, source.count - 2));
  }

  show({ source, trim, pace }: Readonly<State>) {
    if (!source) return;
    const at = frameFormatter(source);
    this.start.value = String(trim.start);
    this.start.style.setProperty('--share', String(trim.start / Math.max(1, source.count - 2)));
    this.start.setAttribute('aria-valuetext', at(trim.start));
    byId('clip-start-text').textContent = at(trim.start);
    this.step.value = String(trim.step);
    this.side.value = String(trim.side);
    if (document.activeElement !== this.frames) this.frames.value = String(trim.frames);
    byId('clip-all').hidden = trim.start === 0 && 1 + (trim.frames - 1) * trim.step > source.count - trim.step;
    byId('clip-text').textContent = describeTrim(source, trim, pace);
  }
}
