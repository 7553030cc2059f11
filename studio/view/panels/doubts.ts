// The places to check on the timeline: their marks, how sure the masks of each frame are, and what to do with a place.
// Loaded when a result has any of it.

import { byId, h } from '../dom.js';
import {
  type Repair,
  acceptDoubt,
  describeDoubts,
  describeObstacle,
  doubtAt,
  repairDoubt,
  showNextDoubt,
} from '../../model/doubts.js';
import { explain, formatPercent, formatPlural } from '../../model/messages.js';
import type { State } from '../../model/store.js';
import type { Page } from '../page.js';

/** Hues of the least and the most certain masks, and the values they begin at; chosen by eye. */
const UNSURE = { hue: 10, value: 0.4 };
const SURE = { hue: 150, value: 0.95 };

const REPAIRS: [id: string, repair: Repair, title: string][] = [
  ['doubt-neighbours', 'both', 'Replace these masks by those of the frames before and after'],
  ['doubt-redo', 'before', 'Carry the masks of the frame before on, as far as they are sure'],
];

export class DoubtsPanel {
  strip = byId<HTMLCanvasElement>('certainty');
  /** Stops the current repair. */
  abort: AbortController | null = null;

  store: Page['store'];

  constructor({ store, keys }: Pick<Page, 'store' | 'keys'>) {
    this.store = store;
    keys.on('n', () => showNextDoubt(store));
    byId('doubt-next').addEventListener('click', () => showNextDoubt(store));
    byId('doubt-fine').addEventListener('click', () => this.keepFocus(() => acceptDoubt(store)));
    for (const [id, repair] of REPAIRS) byId(id).addEventListener('click', () => void this.repair(repair));
    byId('doubt-stop').addEventListener('click', () => this.abort?.abort());
    store.watch(['doubts', 'timeline'], (state) => this.showMarks(state));
    store.watch(['doubts', 'frame', 'isPlaying', 'timeline', 'job'], (state) => this.showActions(state));
    store.watch(['agreement', 'timeline'], () => this.showCertainty());
    store.watch(['visit'], () => this.abort?.abort());
    new ResizeObserver(() => this.showCertainty()).observe(this.strip);
  }

  showMarks({ doubts, timeline: { numFrames } }: Readonly<State>) {
    const share = (frames: number) => String(frames / Math.max(1, numFrames - 1));
    const marks = doubts.map(({ from, to }) => {
      const mark = h('span', { class: 'doubt' });
      mark.style.setProperty('--at', share(from));
      mark.style.setProperty('--length', share(to - 1 - from));
      return mark;
    });
    byId('doubt-marks').replaceChildren(...marks);
    byId('doubts').hidden = doubts.length === 0 && !this.abort;
    byId('doubt-next').textContent = describeDoubts(doubts.length);
  }

  /** Shows what can be done with the doubt on screen; a repair can be stopped on any frame. */
  showActions(state: Readonly<State>) {
    const doubt = state.doubts[doubtAt(state)];
    const isBusy = this.abort !== null;
    byId('doubt-actions').hidden = !isBusy && (!doubt || state.isPlaying);
    for (const id of ['doubt-status', 'doubt-stop']) byId(id).hidden = !isBusy;
    byId('doubt-fine').hidden = isBusy;
    for (const [id, repair, title] of REPAIRS) {
      const button = byId<HTMLButtonElement>(id);
      const obstacle = doubt ? describeObstacle(state, doubt, repair) : '';
      button.hidden = isBusy || !state.job?.corrector;
      button.disabled = obstacle !== '';
      button.title = obstacle || title;
    }
  }

  async repair(repair: Repair) {
    const { store } = this;
    const { state } = store;
    const doubt = state.doubts[doubtAt(state)];
    if (!doubt || this.abort) return;
    const abort = new AbortController();
    this.abort = abort;
    let count = 0;
    const onFrame = () => (byId('doubt-status').textContent = `${formatPlural((count += 1), 'frame')}…`);
    byId('doubt-status').textContent = 'Working…';
    store.set({ isPlaying: false });
    this.keepFocus(() => this.showActions(store.state));
    try {
      const range = await repairDoubt(store, doubt, repair, { signal: abort.signal, onFrame });
      if (range) store.set({ announcement: `Frames ${range.from + 1}–${range.to} have new masks.` });
    } catch (error) {
      const { title, detail } = explain(error);
      if (!abort.signal.aborted) store.set({ notice: `Not possible here: ${detail || title}.` });
    } finally {
      this.abort = null;
      this.keepFocus(() => {
        this.showMarks(store.state);
        this.showActions(store.state);
      });
    }
  }

  /** Moves the focus to what is left if `act` hides the focused button. */
  keepFocus(act: () => void) {
    const focused = document.activeElement as HTMLElement | null;
    const hadFocus = byId('doubts').contains(focused);
    act();
    if (!hadFocus || focused?.offsetParent) return;
    const next = ['doubt-stop', 'doubt-fine', 'doubt-next', 'scrub'].find((id) => byId(id).offsetParent);
    if (next) byId(next).focus();
  }

  /** Draws a bar for each frame: the surer its masks are, the taller and greener it is. */
  showCertainty() {
    const { strip } = this;
    const { agreement, timeline } = this.store.state;
    strip.hidden = !agreement || timeline.numFrames < 2;
    if (!agreement || strip.hidden) return;
    const label = describeCertainty(agreement);
    strip.setAttribute('aria-label', label);
    strip.title = label;
    const { clientWidth: width, clientHeight: height } = strip;
    const density = devicePixelRatio || 1;
    strip.width = Math.round(width * density);
    strip.height = Math.round(height * density);
    const ctx = strip.getContext('2d')!;
    ctx.scale(density, density);
    // The middle of a bar is where the scrubber shows its frame.
    const step = width / (timeline.numFrames - 1);
    const edgeOf = (t: number) => Math.round((t - 0.5) * step * density) / density;
    for (let t = 0; t < timeline.numFrames; t += 1) {
      const value = agreement[t];
      if (!(value >= 0)) continue;
      const share = Math.max(0, Math.min(1, (value - UNSURE.value) / (SURE.value - UNSURE.value)));
      ctx.fillStyle = `hsl(${UNSURE.hue + share * (SURE.hue - UNSURE.hue)} 60% 42%)`;
      const tall = Math.max(1, value * height);
      ctx.fillRect(edgeOf(t), height - tall, edgeOf(t + 1) - edgeOf(t), tall);
    }
  }
}

/** Returns `How sure the masks are: least in frame 12, 41%`. */
function describeCertainty(agreement: Float32Array): string {
  let least = -1;
  agreement.forEach((value, t) => {
    if (value >= 0 && !(least >= 0 && agreement[least] <= value)) least = t;
  });
  const text = 'How sure the masks are';
  return least < 0 ? `${text}: not known` : `${text}: least in frame ${least + 1}, ${formatPercent(agreement[least])}`;
}
