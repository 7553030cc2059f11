/** A freshly opened clip waits a moment for settings, shows what is chosen, and then starts by itself. @module */

import { oneFrame } from './viewer.js';
import { phasePatch } from './store.js';

/** How long a freshly opened clip waits for a change of settings before it starts by itself. */
const HOLD_SECONDS = 4;

export class Setup {
  /**
   * @param {import('./store.js').Store} store
   * @param {{start: () => void, fail: (visit: number, error: unknown) => void}} next
   */
  constructor(store, { start, fail }) {
    this.store = store;
    this.start = start;
    this.fail = fail;
    this.countdown = 0;
    /** The visit for which a preview is being fetched, 0 for none. */
    this.previewing = 0;
    store.watch(['take', 'changed'], () => this.hold());
    store.watch(['take'], () => this.onTake());
  }

  onTake() {
    const { phase, visit } = this.store.state;
    if (phase === 'setup') this.preview().catch((error) => this.fail(visit, error));
  }

  /** Shows the first frame and counts down. */
  async begin() {
    const { visit } = this.store.state;
    await this.preview();
    if (visit !== this.store.state.visit) return;
    let left = HOLD_SECONDS;
    const words = () => `Starts in ${left} s with the settings under “Clip”. Changing one holds it.`;
    this.store.set({ ...phasePatch('setup', 'Ready to segment', ''), subline: words() });
    this.countdown = window.setInterval(() => {
      left -= 1;
      if (left > 0) this.store.set({ subline: words() });
      else this.start();
    }, 1000);
  }

  /** Waits for “Start” from now on. */
  hold() {
    clearInterval(this.countdown);
    if (this.store.state.phase === 'setup') this.store.set({ subline: 'Press “Start” when the settings are right.' });
  }

  leave() {
    clearInterval(this.countdown);
  }

  /** Shows the first frame of what is chosen; while one is fetched, only the newest wish is kept. */
  async preview() {
    const { source, visit, take } = this.store.state;
    if (!source || this.previewing === visit) return;
    const { start, side } = take;
    this.previewing = visit;
    try {
      const image = await createImageBitmap(await source.preview(start, side));
      const { state } = this.store;
      if (visit === state.visit && state.phase !== 'running')
        this.store.set({ frame: 0, picture: { width: image.width, height: image.height, images: oneFrame(image) } });
    } finally {
      if (this.previewing === visit) this.previewing = 0;
    }
    const { state } = this.store;
    const isStale = state.take.start !== start || state.take.side !== side;
    if (visit === state.visit && state.phase === 'setup' && isStale) await this.preview();
  }
}
