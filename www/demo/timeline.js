/** Playing, stepping and scrubbing, and one lane per object that shows in which frames it is there. @module */

import { byId } from './dom.js';
import { objectColor } from './palette.js';

/** Most lanes shown; further objects are small. */
const MAX_LANES = 9;

const LANE_PX = 4;
const GAP_PX = 3;

export class Timeline {
  /** @param {(frame: number) => void} onFrame called when another frame is to be shown */
  constructor(onFrame) {
    this.onFrame = onFrame;
    this.range = /** @type {HTMLInputElement} */ (byId('scrub'));
    this.lanes = /** @type {HTMLCanvasElement} */ (byId('lanes'));
    this.playButton = byId('play');
    this.loopButton = byId('loop');
    this.frame = 0;
    this.numFrames = 0;
    this.fps = 25;
    this.ticking = 0;
    /** @type {import('./points.js').Points | null} */
    this.points = null;
    this.range.addEventListener('input', () => {
      this.pause();
      this.seek(Number(this.range.value));
    });
    this.playButton.addEventListener('click', () => this.toggle());
    this.loopButton.addEventListener('click', () => this.setLoop(!this.loop));
    byId('first').addEventListener('click', () => this.jump(0));
    byId('back').addEventListener('click', () => this.step(-1));
    byId('forward').addEventListener('click', () => this.step(1));
    byId('last').addEventListener('click', () => this.jump(this.numFrames - 1));
    new ResizeObserver(() => this.drawLanes()).observe(this.lanes);
    this.setClip(0, 25);
  }

  /** @returns {boolean} */
  get loop() {
    return this.loopButton.getAttribute('aria-pressed') === 'true';
  }

  /** @returns {boolean} */
  get playing() {
    return this.ticking !== 0;
  }

  /** @param {boolean} on */
  setLoop(on) {
    this.loopButton.setAttribute('aria-pressed', String(on));
  }

  /**
   * @param {number} numFrames
   * @param {number} fps frames to show in a second
   */
  setClip(numFrames, fps) {
    this.pause();
    this.points = null;
    this.numFrames = numFrames;
    this.fps = fps;
    this.range.max = String(Math.max(0, numFrames - 1));
    for (const control of byId('timeline').querySelectorAll('button, input')) {
      /** @type {HTMLButtonElement} */ (control).disabled = numFrames < 2;
    }
    this.lanes.hidden = true;
    this.seek(0);
  }

  /** @param {import('./points.js').Points} points */
  setPresence(points) {
    this.points = points;
    const lanes = Math.min(MAX_LANES, points.count);
    this.lanes.style.height = `${lanes * (LANE_PX + GAP_PX) + GAP_PX}px`;
    this.lanes.hidden = false;
    this.drawLanes();
  }

  /** @param {number} frame */
  seek(frame) {
    this.frame = Math.max(0, Math.min(this.numFrames - 1, frame));
    this.range.value = String(this.frame);
    this.range.setAttribute('aria-valuetext', `Frame ${this.frame + 1} of ${this.numFrames}`);
    this.range.style.setProperty('--share', String(this.numFrames > 1 ? this.frame / (this.numFrames - 1) : 0));
    byId('counter').textContent = this.numFrames > 0 ? `${this.frame + 1} / ${this.numFrames}` : '– / –';
    this.onFrame(this.frame);
  }

  /** @param {number} frame */
  jump(frame) {
    this.pause();
    this.seek(frame);
  }

  /** @param {number} by frames; past either end it stays, or goes round when looping */
  step(by) {
    const next = this.frame + by;
    this.jump(this.loop ? (next + this.numFrames) % this.numFrames : next);
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  play() {
    if (this.numFrames < 2 || this.playing) return;
    if (!this.loop && this.frame === this.numFrames - 1) this.seek(0);
    let shownAt = performance.now();
    const tick = (/** @type {number} */ now) => {
      const due = Math.floor(((now - shownAt) * this.fps) / 1000);
      if (due > 0) {
        // A page that was in the background does not try to catch up.
        shownAt = due > this.fps ? now : shownAt + (due * 1000) / this.fps;
        if (!this.loop && this.frame + due >= this.numFrames - 1) return this.jump(this.numFrames - 1);
        this.seek((this.frame + due) % this.numFrames);
      }
      this.ticking = requestAnimationFrame(tick);
    };
    this.ticking = requestAnimationFrame(tick);
    this.showPlaying(true);
  }

  pause() {
    cancelAnimationFrame(this.ticking);
    this.ticking = 0;
    this.showPlaying(false);
  }

  /** @param {boolean} playing */
  showPlaying(playing) {
    this.playButton.dataset.playing = String(playing);
    this.playButton.setAttribute('aria-label', playing ? 'Pause' : 'Play');
  }

  /** Strength of a lane is the object's size in the frame against its largest size. */
  drawLanes() {
    const { points, lanes } = this;
    if (!points || lanes.hidden) return;
    const density = devicePixelRatio || 1;
    const width = lanes.clientWidth;
    lanes.width = Math.round(width * density);
    lanes.height = Math.round(lanes.clientHeight * density);
    const ctx = /** @type {CanvasRenderingContext2D} */ (lanes.getContext('2d'));
    ctx.scale(density, density);
    const { numFrames } = points.result;
    for (let k = 0; k < Math.min(MAX_LANES, points.count); k++) {
      const counts = Array.from({ length: numFrames }, (_, t) => points.presence[t * points.count + k]);
      const most = Math.max(1, ...counts);
      ctx.fillStyle = objectColor(k);
      const y = GAP_PX + k * (LANE_PX + GAP_PX);
      counts.forEach((n, t) => {
        ctx.globalAlpha = n === 0 ? 0.08 : 0.3 + 0.7 * (n / most);
        // Cells meet without a seam: each begins where the last one ends.
        const x = Math.round((t / numFrames) * width);
        ctx.fillRect(x, y, Math.round(((t + 1) / numFrames) * width) - x, LANE_PX);
      });
    }
  }
}
