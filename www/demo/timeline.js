/** Playing, stepping and scrubbing. @module */

import { byId, h } from './dom.js';
import { Lanes } from './lanes.js';
import { Times } from './times.js';
import { atTime } from './words.js';

export class Timeline {
  /** @param {(frame: number) => void} onFrame called when another frame is to be shown */
  constructor(onFrame) {
    this.onFrame = onFrame;
    this.range = /** @type {HTMLInputElement} */ (byId('scrub'));
    this.lanes = new Lanes((frame) => this.jump(frame));
    this.times = new Times(null);
    this.playButton = byId('play');
    this.loopButton = byId('loop');
    this.frame = 0;
    this.numFrames = 0;
    this.fps = 25;
    this.ticking = 0;
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
   * @param {Times} [times] of the frames
   */
  setClip(numFrames, fps, times = new Times(null)) {
    this.pause();
    this.times = times;
    this.numFrames = numFrames;
    this.fps = fps;
    this.range.max = String(Math.max(0, numFrames - 1));
    for (const control of byId('timeline').querySelectorAll('button, input')) {
      /** @type {HTMLButtonElement} */ (control).disabled = numFrames < 2;
    }
    this.lanes.clear();
    this.setCuts([]);
    this.seek(0);
  }

  /** @param {number[]} frames with which new shots begin */
  setCuts(frames) {
    const marks = frames.map((frame) => {
      const mark = h('span', { class: 'cut', title: `Cut at ${this.times.at(frame)}` });
      mark.style.setProperty('--at', String(frame / Math.max(1, this.numFrames)));
      return mark;
    });
    byId('cuts').replaceChildren(...marks);
    byId('cuts-text').textContent = frames.length > 0 ? `Cuts: ${frames.map((frame) => this.times.at(frame)).join(', ')}.` : '';
  }

  /** @param {number} frame */
  seek(frame) {
    this.frame = Math.max(0, Math.min(this.numFrames - 1, frame));
    this.range.value = String(this.frame);
    this.range.setAttribute('aria-valuetext', `Frame ${this.frame + 1} of ${this.numFrames}${atTime(this.times, this.frame)}`);
    const share = String(this.numFrames > 1 ? this.frame / (this.numFrames - 1) : 0);
    this.range.style.setProperty('--share', share);
    this.lanes.list.style.setProperty('--share', share);
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
}
