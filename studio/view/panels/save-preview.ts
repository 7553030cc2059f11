// The frame on screen as a choice will save it: that choice's own file, made of this frame alone and shown as it is.
// Nothing else paints it, so it cannot look otherwise than what is saved.

import { encodeVideo } from '../../model/library.js';
import { byId } from '../dom.js';
import type { Choice, Subject } from '../../model/export.js';

type Shown = HTMLVideoElement | HTMLImageElement;

/** A press that goes farther drags, in CSS pixels. */
const DRAG_PX = 4;

export class SavePreview {
  box = byId('export-preview');
  choice: Choice | null = null;
  /** What was made of this frame; null where that failed. */
  made = new Map<Choice, Shown | null>();
  /** Of what is being made. */
  abort: AbortController | null = null;

  constructor(
    public choices: Choice[],
    readonly subject: () => Subject | null,
  ) {
    this.connect();
  }

  connect() {
    byId('export-true').addEventListener('click', () => this.enlarge(!this.isTrue));
    const { box } = this;
    let press: { x: number; y: number } | null = null;
    let dragged = false;
    box.addEventListener('pointerdown', (event) => {
      // Fingers scroll by themselves.
      if (event.pointerType === 'mouse') press = { x: event.clientX, y: event.clientY };
      dragged = false;
    });
    box.addEventListener('pointermove', (event) => {
      if (!press) return;
      const [dx, dy] = [event.clientX - press.x, event.clientY - press.y];
      dragged ||= Math.hypot(dx, dy) > DRAG_PX;
      if (!dragged) return;
      box.scrollBy(-dx, -dy);
      press = { x: event.clientX, y: event.clientY };
    });
    for (const kind of ['pointerup', 'pointerleave']) box.addEventListener(kind, () => (press = null));
    box.addEventListener('click', (event) => dragged || this.enlarge(!this.isTrue, event));
  }

  get isTrue() {
    return this.box.hasAttribute('data-true');
  }

  /** What was made of another frame, or with other settings, is shown no more. */
  begin() {
    this.stop();
    for (const shown of this.made.values()) if (shown) URL.revokeObjectURL(shown.src);
    this.made.clear();
    this.choice = null;
    this.enlarge(false);
    this.box.replaceChildren();
    byId('export-preview-text').textContent = '';
  }

  stop() {
    this.abort?.abort();
    this.abort = null;
  }

  show(choice: Choice) {
    this.choice = choice;
    const known = this.made.get(choice);
    if (known !== undefined) return this.put(choice, known);
    this.box.toggleAttribute('data-waits', true);
    if (!this.abort) void this.work((this.abort = new AbortController()));
  }

  /** One after the other: first what is to be shown, then the others, which are there when somebody looks. */
  async work(work: AbortController) {
    const subject = this.subject();
    const one = subject && oneOf(subject);
    for (let next = this.choice; one && next; next = this.next()) {
      const shown = await made(next, one, work.signal).catch((error) => {
        // Saving says what is wrong.
        if (!work.signal.aborted) console.info('There is no preview.', error);
        return null;
      });
      if (work.signal.aborted) return shown && URL.revokeObjectURL(shown.src);
      this.made.set(next, shown);
      if (next === this.choice) this.put(next, shown);
    }
    if (this.abort === work) this.abort = null;
  }

  /** Returns the preview that is to be made next. */
  next(): Choice | null {
    return [this.choice, ...this.choices].find((one) => one && !this.made.has(one)) ?? null;
  }

  put(choice: Choice, shown: Shown | null) {
    this.box.toggleAttribute('data-waits', false);
    if (!shown) {
      this.box.replaceChildren();
      byId('export-preview-text').textContent = 'No preview of this one.';
      return;
    }
    const { width, height } = sizeOf(shown);
    this.box.dataset.shows = choice.id;
    this.box.replaceChildren(shown);
    shown.style.setProperty('--true', `${width / devicePixelRatio}px`);
    byId('export-preview-text').textContent = `As it is saved, ${width} × ${height}`;
  }

  /**
   * @param isTrue a pixel of the file on one of the screen, or the whole frame
   * @param at what stays in place
   */
  enlarge(isTrue: boolean, at?: { clientX: number; clientY: number }) {
    const { box } = this;
    const shown = box.firstElementChild;
    const before = shown?.getBoundingClientRect();
    box.toggleAttribute('data-true', isTrue);
    byId('export-true').setAttribute('aria-pressed', String(isTrue));
    if (!shown || !before || !isTrue) return;
    const place = box.getBoundingClientRect();
    const { clientX, clientY } = at ?? { clientX: place.x + place.width / 2, clientY: place.y + place.height / 2 };
    const now = shown.getBoundingClientRect();
    const scale = now.width / before.width;
    box.scrollTo(
      scale * (clientX - before.x) - (clientX - place.x),
      scale * (clientY - before.y) - (clientY - place.y),
    );
  }
}

/** Starts what the first preview would wait for, with a picture of nothing: the worker that moves borders, and the encoder. */
export async function warmUp() {
  const mask = { width: 8, height: 8, numFrames: 1, labels: () => new Uint8Array(64) };
  await encodeVideo(mask, [new ImageData(16, 16)], { style: 'cutout' });
}

async function made(choice: Choice, subject: Subject, signal: AbortSignal): Promise<Shown | null> {
  if (choice.there?.(subject) === false) return null;
  const file = await choice.make(subject, { signal, onProgress() {} });
  return file instanceof Blob ? shownOf(file) : null;
}

/** The frame on screen alone. */
function oneOf(subject: Subject): Subject {
  const { masks, frame, image, state } = subject;
  // Read once, while what encodes is fetched.
  const read = image(frame);
  read.catch(() => {});
  return {
    ...subject,
    masks: {
      ...masks,
      numFrames: 1,
      labels: () => state.smoothed?.labels(frame) ?? masks.labels(frame),
      times: masks.times ? [masks.times[frame]] : null,
      end: masks.times?.[frame + 1] ?? masks.end,
      shots: [{ first: 0, last: 0 }],
    },
    async *frames() {
      yield await read;
    },
    sound: () => null,
  };
}

/** @param file a video, a picture, or an archive of pictures */
async function shownOf(file: Blob): Promise<Shown> {
  if (file.type.startsWith('video/')) return videoOf(file);
  const image = new Image();
  image.alt = '';
  image.src = URL.createObjectURL(await pictureOf(file));
  await image.decode();
  return image;
}

async function videoOf(file: Blob) {
  const video = document.createElement('video');
  Object.assign(video, { muted: true, playsInline: true, preload: 'auto', src: URL.createObjectURL(file) });
  await new Promise((done, failed) => {
    video.addEventListener('loadeddata', done, { once: true });
    video.addEventListener('error', () => failed(video.error), { once: true });
  });
  return video;
}

async function pictureOf(file: Blob) {
  if (file.type !== 'application/zip') return file;
  const { unzipSync } = await import('fflate');
  const files = unzipSync(new Uint8Array(await file.arrayBuffer()));
  const [name] = Object.keys(files).filter((one) => one.endsWith('.png'));
  return new Blob([files[name]], { type: 'image/png' });
}

function sizeOf(shown: Shown) {
  return shown instanceof HTMLVideoElement
    ? { width: shown.videoWidth, height: shown.videoHeight }
    : { width: shown.naturalWidth, height: shown.naturalHeight };
}
