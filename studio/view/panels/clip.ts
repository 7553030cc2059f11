// What to take from the clip: first frame, number of frames, step and working size.

import { byId } from '../dom.js';
import { clipFacts, placeIn, takeText, wantedTake } from '../../model/clip-words.js';
import { type Source, type Take, fitTake, kindOf } from '../../model/source.js';
import type { State, Store } from '../../model/store.js';
import type { Page } from '../page.js';

export function clipPanel({ store }: Pick<Page, 'store'>) {
  new ClipPanel(store);
}

class ClipPanel {
  start = byId<HTMLInputElement>('take-start');
  frames = byId<HTMLInputElement>('take-frames');
  step = byId<HTMLSelectElement>('take-step');
  side = byId<HTMLSelectElement>('take-side');

  constructor(readonly store: Store) {
    for (const field of [this.start, this.frames, this.step, this.side])
      field.addEventListener('input', (event) => this.take(this.wanted(event.target)));
    byId('take-all').addEventListener('click', () =>
      this.take({ ...store.state.take, start: 0, frames: store.state.source?.count ?? 0 }),
    );
    // While a number is typed it is left as it is; afterwards it shows what is really taken.
    this.frames.addEventListener('blur', () => this.show(store.state));
    store.watch(['source'], ({ source }) => source && this.showSource(source));
    store.watch(['source', 'take', 'pace'], (state) => this.show(state));
  }

  wanted(changed: EventTarget | null) {
    const { take, source } = this.store.state;
    const [start, frames, step, side] = [this.start, this.frames, this.step, this.side].map(({ value }) =>
      Number(value),
    );
    return wantedTake({ start, frames, step, side }, take, source, changed === this.frames);
  }

  /** @param take as far as the source has it */
  take(take: Take) {
    const { source } = this.store.state;
    if (source) this.store.set({ take: fitTake(take, source) });
  }

  showSource(source: Source) {
    const isSample = source.kind === 'sample';
    byId('clip-form').hidden = isSample;
    byId('clip-sample').hidden = !isSample;
    byId('clip-title').textContent = kindOf(source) === 'still' ? 'Image' : 'Clip';
    byId('clip-facts').textContent = clipFacts(source);
    this.start.max = String(Math.max(0, source.count - 2));
  }

  show({ source, take, pace }: Readonly<State>) {
    if (!source) return;
    const at = placeIn(source);
    this.start.value = String(take.start);
    this.start.style.setProperty('--share', String(take.start / Math.max(1, source.count - 2)));
    this.start.setAttribute('aria-valuetext', at(take.start));
    byId('take-start-text').textContent = at(take.start);
    this.step.value = String(take.step);
    this.side.value = String(take.side);
    if (document.activeElement !== this.frames) this.frames.value = String(take.frames);
    byId('take-all').hidden = take.start === 0 && 1 + (take.frames - 1) * take.step > source.count - take.step;
    byId('take-text').textContent = takeText(source, take, pace[kindOf(source)]);
  }
}
