/**
 * A clip of a few seconds from the camera: preview, countdown, recording. The camera is on only while the dialog is
 * open. @module
 */

import { byId, connectDialog } from '../dom.js';
import { PageError, explain, plural } from '../words.js';

/** Containers and codecs in the order in which they are tried. */
const TYPES = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm', 'video/mp4'];

const COUNT_DOWN = 3;

/** What the browser calls it when there is no picture, and what the page calls it. @type {Record<string, string>} */
const CODES = {
  NotAllowedError: 'camera-denied',
  SecurityError: 'camera-denied',
  NotFoundError: 'no-camera',
  OverconstrainedError: 'no-camera',
  NotReadableError: 'camera-busy',
  AbortError: 'camera-busy',
};

export class WebcamDialog {
  /** @param {(file: File) => void} onClip */
  constructor(onClip) {
    this.onClip = onClip;
    this.dialog = /** @type {HTMLDialogElement} */ (byId('camera'));
    this.preview = /** @type {HTMLVideoElement} */ (byId('camera-preview'));
    this.length = /** @type {HTMLSelectElement} */ (byId('camera-length'));
    this.button = /** @type {HTMLButtonElement} */ (byId('camera-record'));
    /** @type {MediaStream | null} */
    this.stream = null;
    /** Grows when the dialog is opened or closed: what was awaited before that is void. */
    this.visit = 0;
    byId('camera-close').addEventListener('click', () => this.dialog.close());
    this.button.addEventListener('click', () => this.record());
    this.dialog.addEventListener('close', () => this.stop());
    connectDialog(this.dialog);
  }

  async open() {
    const visit = ++this.visit;
    this.tell('Waiting for the camera…');
    this.button.disabled = true;
    this.dialog.showModal();
    try {
      if (!navigator.mediaDevices?.getUserMedia || typeof MediaRecorder === 'undefined')
        throw new PageError('camera-unsupported');
      const stream = await navigator.mediaDevices.getUserMedia({
        audio: false,
        video: { width: { ideal: 640 }, frameRate: { ideal: 30 } },
      });
      if (visit !== this.visit) return turnOff(stream);
      this.stream = stream;
      this.preview.srcObject = stream;
      await this.preview.play();
      this.button.disabled = false;
      this.button.focus();
      this.tell('Put something in motion in front of the camera. Nothing leaves this device.');
    } catch (error) {
      if (visit === this.visit) this.fail(error);
    }
  }

  async record() {
    const { stream, visit } = this;
    if (!stream) return;
    this.button.disabled = true;
    const seconds = Number(this.length.value);
    try {
      for (let left = COUNT_DOWN; left > 0; left--) {
        byId('camera-count').textContent = String(left);
        this.tell(`Recording starts in ${plural(left, 'second')}.`);
        await wait(1000);
        if (visit !== this.visit) return;
      }
      byId('camera-count').textContent = '';
      this.tell(`Recording ${plural(seconds, 'second')}…`);
      const blob = await recorded(stream, 1000 * seconds);
      if (visit !== this.visit) return;
      if (blob.size === 0) throw new PageError('camera-busy');
      const type = blob.type.split(';')[0];
      const file = new File([blob], `camera.${type === 'video/mp4' ? 'mp4' : 'webm'}`, { type });
      this.dialog.close();
      this.onClip(file);
    } catch (error) {
      if (visit === this.visit) this.fail(error);
    }
  }

  /** Turns the camera off. */
  stop() {
    this.visit += 1;
    if (this.stream) turnOff(this.stream);
    this.stream = null;
    this.preview.srcObject = null;
    byId('camera-count').textContent = '';
  }

  /** @param {unknown} error */
  fail(error) {
    this.stop();
    const code = CODES[error instanceof DOMException ? error.name : ''];
    const { title, advice } = explain(code ? new PageError(code) : error);
    this.tell(`${title}. ${advice}`, true);
  }

  /**
   * @param {string} text
   * @param {boolean} [wrong]
   */
  tell(text, wrong = false) {
    byId('camera-status').textContent = text;
    byId('camera-status').classList.toggle('is-wrong', wrong);
  }
}

/** @param {MediaStream} stream */
function turnOff(stream) {
  for (const track of stream.getTracks()) track.stop();
}

/**
 * @param {MediaStream} stream
 * @param {number} ms
 * @returns {Promise<Blob>} the file
 */
function recorded(stream, ms) {
  return new Promise((resolve, reject) => {
    const mimeType = TYPES.find((type) => MediaRecorder.isTypeSupported(type));
    const recorder = new MediaRecorder(stream, { ...(mimeType ? { mimeType } : {}), videoBitsPerSecond: 4_000_000 });
    /** @type {Blob[]} */
    const parts = [];
    recorder.ondataavailable = ({ data }) => parts.push(data);
    recorder.onstop = () => resolve(new Blob(parts, { type: recorder.mimeType }));
    recorder.onerror = () => reject(new PageError('camera-busy'));
    recorder.start();
    setTimeout(() => recorder.state !== 'inactive' && recorder.stop(), ms);
  });
}

/** @param {number} ms */
function wait(ms) {
  return new Promise((resolve) => setTimeout(resolve, ms));
}
