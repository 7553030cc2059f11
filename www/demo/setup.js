/** A freshly opened clip waits a moment for settings, shows what is chosen, and then starts by itself. @module */

import { phase, showPhase, showSubline } from './status.js';
import { oneFrame } from './viewer.js';

/** @typedef {import('./app.js').App} App */

/** How long a freshly opened clip waits for a change of settings before it starts by itself. */
const HOLD_SECONDS = 4;

export class Setup {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    this.countdown = 0;
    /** The visit for which a preview is being fetched, 0 for none. */
    this.previewing = 0;
  }

  /** Shows the first frame and counts down. */
  async begin() {
    const { visit } = this.app;
    await this.preview();
    if (visit !== this.app.visit) return;
    let left = HOLD_SECONDS;
    const tell = () => showSubline(`Starts in ${left} s with the settings under “Clip”. Changing one holds it.`);
    showPhase('setup', 'Ready to segment', '');
    tell();
    this.countdown = window.setInterval(() => {
      left -= 1;
      if (left > 0) tell();
      else this.app.start();
    }, 1000);
  }

  /** Waits for “Start” from now on. */
  hold() {
    clearInterval(this.countdown);
    if (phase() === 'setup') showSubline('Press “Start” when the settings are right.');
  }

  leave() {
    clearInterval(this.countdown);
  }

  /** Shows the first frame of what is chosen; while one is fetched, only the newest wish is kept. */
  async preview() {
    const { source, visit, viewer, clip } = this.app;
    if (!source || this.previewing === visit) return;
    const { start, side } = clip.take;
    this.previewing = visit;
    try {
      const image = await createImageBitmap(await source.preview(start, side));
      if (visit === this.app.visit && phase() !== 'running') viewer.setClip(image.width, image.height, oneFrame(image));
    } finally {
      if (this.previewing === visit) this.previewing = 0;
    }
    const now = clip.take;
    if (visit === this.app.visit && phase() === 'setup' && (now.start !== start || now.side !== side)) await this.preview();
  }
}
