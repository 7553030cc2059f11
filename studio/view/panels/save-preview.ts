// Previews an export: the file that it would make of the current frame, so that it looks exactly like the saved one.

import { encodeVideo } from '../../model/library.js';
import { byId } from '../dom.js';
import type { Choice, Subject } from '../../model/export.js';

type PreviewElement = HTMLVideoElement | HTMLImageElement;

/** Longer presses drag, in CSS pixels; chosen by eye. */
const DRAG_PX = 4;

export class SavePreview {
  box = byId('export-preview');
  choice: Choice | null = null;
  /** Previews of this frame; null if they failed. */
  previews = new Map<Choice, PreviewElement | null>();
  /** Stops the current preview. */
  abort: AbortController | null = null;

  constructor(
    public choices: Choice[],
    readonly subject: () => Subject | null,
    readonly sketch: (choice: Choice) => HTMLElement | null,
  ) {
    this.connect();
  }

  connect() {
    byId('export-actual-size').addEventListener('click', () => this.enlarge(!this.isActualSize));
    const { box } = this;
    let press: { x: number; y: number } | null = null;
    let isDragged = false;
    box.addEventListener('pointerdown', (event) => {
      // Touch scrolls natively.
      if (event.pointerType === 'mouse') press = { x: event.clientX, y: event.clientY };
      isDragged = false;
    });
    box.addEventListener('pointermove', (event) => {
      if (!press) return;
      const [dx, dy] = [event.clientX - press.x, event.clientY - press.y];
      isDragged ||= Math.hypot(dx, dy) > DRAG_PX;
      if (!isDragged) return;
      box.scrollBy(-dx, -dy);
      press = { x: event.clientX, y: event.clientY };
    });
    for (const kind of ['pointerup', 'pointerleave']) box.addEventListener(kind, () => (press = null));
    box.addEventListener('click', (event) => isDragged || this.enlarge(!this.isActualSize, event));
  }

  get isActualSize() {
    return this.box.hasAttribute('data-actual-size');
  }

  /** Clears the previews of another frame or other settings. */
  begin() {
    this.stop();
    for (const element of this.previews.values()) if (element) URL.revokeObjectURL(element.src);
    this.previews.clear();
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
    const element = this.previews.get(choice);
    if (element !== undefined) return this.showElement(choice, element);
    this.box.toggleAttribute('data-waits', true);
    const sketch = this.sketch(choice);
    if (sketch) this.box.replaceChildren(sketch);
    if (!this.abort) void this.makePreviews((this.abort = new AbortController()));
  }

  /** Makes the visible preview first, then the others. */
  async makePreviews(abort: AbortController) {
    const subject = this.subject();
    const frameSubject = subject && singleFrame(subject);
    for (let next = this.choice; frameSubject && next; next = this.nextChoice()) {
      const element = await createPreview(next, frameSubject, abort.signal).catch((error) => {
        // Saving reports the error.
        if (!abort.signal.aborted) console.info('There is no preview.', error);
        return null;
      });
      if (abort.signal.aborted) return element && URL.revokeObjectURL(element.src);
      this.previews.set(next, element);
      if (next === this.choice) this.showElement(next, element);
    }
    if (this.abort === abort) this.abort = null;
  }

  nextChoice(): Choice | null {
    return [this.choice, ...this.choices].find((choice) => choice && !this.previews.has(choice)) ?? null;
  }

  showElement(choice: Choice, element: PreviewElement | null) {
    this.box.toggleAttribute('data-waits', false);
    if (!element) {
      byId('export-preview-text').textContent = 'No preview.';
      return;
    }
    const { width, height } = naturalSize(element);
    this.box.dataset.shows = choice.id;
    // A video has no pixels at first: what was shown before stays below it until then.
    const before = [...this.box.children].filter((child) => child !== element);
    this.box.prepend(element);
    requestAnimationFrame(() => requestAnimationFrame(() => before.forEach((child) => child.remove())));
    element.style.setProperty('--true', `${width / devicePixelRatio}px`);
    byId('export-preview-text').textContent = `Output: ${width} × ${height}`;
  }

  /**
   * @param isTrue true for actual pixels, false for the whole frame
   * @param at the fixed point
   */
  enlarge(isTrue: boolean, at?: { clientX: number; clientY: number }) {
    const { box } = this;
    const element = box.firstElementChild;
    const before = element?.getBoundingClientRect();
    box.toggleAttribute('data-actual-size', isTrue);
    byId('export-actual-size').setAttribute('aria-pressed', String(isTrue));
    if (!element || !before || !isTrue) return;
    const place = box.getBoundingClientRect();
    const { clientX, clientY } = at ?? { clientX: place.x + place.width / 2, clientY: place.y + place.height / 2 };
    const now = element.getBoundingClientRect();
    const scale = now.width / before.width;
    box.scrollTo(
      scale * (clientX - before.x) - (clientX - place.x),
      scale * (clientY - before.y) - (clientY - place.y),
    );
  }
}

/** Starts the worker and the encoder with an empty picture. */
export async function warmUp() {
  const mask = { width: 8, height: 8, numFrames: 1, labels: () => new Uint8Array(64) };
  await encodeVideo(mask, [new ImageData(16, 16)], { style: 'cutout' });
}

async function createPreview(choice: Choice, subject: Subject, signal: AbortSignal): Promise<PreviewElement | null> {
  if (choice.isAvailable?.(subject) === false) return null;
  const file = await choice.make(subject, { signal, onProgress() {} });
  return file instanceof Blob ? createElement(file) : null;
}

/** Returns the data to export for the current frame only. */
function singleFrame(subject: Subject): Subject {
  const { masks, frame, image, state } = subject;
  // Read once, while the encoder is loaded.
  const read = image(frame);
  read.catch(() => {});
  return {
    ...subject,
    masks: {
      ...masks,
      numFrames: 1,
      labels: () => state.smoothedMasks?.labels(frame) ?? masks.labels(frame),
      times: masks.times ? [masks.times[frame]] : null,
      end: masks.times?.[frame + 1] ?? masks.end,
      shots: [{ first: 0, last: 0 }],
    },
    async *frames() {
      yield { frame: await read, time: null };
    },
    sound: () => null,
  };
}

/** @param file a video, a picture, or an archive of pictures */
async function createElement(file: Blob): Promise<PreviewElement> {
  if (file.type.startsWith('video/')) return createVideo(file);
  const image = new Image();
  image.alt = '';
  // Dragging scrolls the box.
  image.draggable = false;
  image.src = URL.createObjectURL(await extractPicture(file));
  await image.decode();
  return image;
}

async function createVideo(file: Blob) {
  const video = document.createElement('video');
  Object.assign(video, { muted: true, playsInline: true, preload: 'auto', src: URL.createObjectURL(file) });
  await new Promise((resolve, reject) => {
    video.addEventListener('loadeddata', resolve, { once: true });
    video.addEventListener('error', () => reject(video.error), { once: true });
  });
  return video;
}

async function extractPicture(file: Blob) {
  if (file.type !== 'application/zip') return file;
  const { unzipSync } = await import('fflate');
  const files = unzipSync(new Uint8Array(await file.arrayBuffer()));
  const [name] = Object.keys(files).filter((fileName) => fileName.endsWith('.png'));
  return new Blob([files[name]], { type: 'image/png' });
}

function naturalSize(element: PreviewElement) {
  return element instanceof HTMLVideoElement
    ? { width: element.videoWidth, height: element.videoHeight }
    : { width: element.naturalWidth, height: element.naturalHeight };
}
