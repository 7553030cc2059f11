// Exports of the scene without objects.

import { type Choice, type Export, type Subject, resizeLabels } from '../model/export.js';

/** Width by which the background overlaps the frame around objects, in pixels of the background; chosen by eye. */
const MARGIN_PX = 2;

export const background: Export = {
  title: 'Background',
  about: 'The scene without objects, filled in from other frames. What no frame shows is transparent.',
  choices: [
    {
      id: 'background-png',
      label: 'PNG',
      ariaLabel: 'Background of this frame as PNG',
      file: ({ frame }) => `background-${frameNumber(frame)}.png`,
      isAvailable: ({ plate }) => plate !== null,
      make: async (subject) => renderBackground(subject, subject.frame, await subject.image(subject.frame)),
    },
    {
      id: 'background-zip',
      label: 'ZIP, all frames',
      file: () => 'background.zip',
      isAvailable: ({ plate }) => plate !== null,
      make: makeZip,
    },
  ],
};

async function makeZip(subject: Subject, { signal, onProgress }: Parameters<Choice['make']>[1]) {
  const { zipSync } = await import('fflate');
  const { numFrames } = subject.masks;
  const files: Record<string, Uint8Array> = {};
  let t = 0;
  for await (const { frame, pixels } of subject.frames(signal)) {
    signal.throwIfAborted();
    const picture = ((await pixels?.()) ?? frame) as ImageData;
    files[`${frameNumber(t)}.png`] = new Uint8Array(await (await renderBackground(subject, t, picture)).arrayBuffer());
    t += 1;
    onProgress({ done: t, total: numFrames });
  }
  // PNG files are compressed already. The date is the earliest that ZIP can store.
  return new Blob([zipSync(files, { level: 0, mtime: new Date(1980, 0, 1) })], { type: 'application/zip' });
}

function frameNumber(frame: number) {
  return String(frame + 1).padStart(4, '0');
}

/** Draws the background over the objects of a frame, at the frame's size. */
async function renderBackground(subject: Subject, t: number, frame: ImageData) {
  const { plate } = subject;
  if (!plate) throw new Error('there is no background');
  const background = await plate(t);
  const { width, height } = frame;
  const canvas = new OffscreenCanvas(width, height);
  const ctx = get2dContext(canvas);
  ctx.putImageData(frame, 0, 0);
  ctx.globalCompositeOperation = 'destination-out';
  const [reachX, reachY] = [(MARGIN_PX * width) / background.width, (MARGIN_PX * height) / background.height];
  const covered = drawObjectShape(await resizeLabels(subject, t, frame), width, height);
  for (const x of [-reachX, 0, reachX]) for (const y of [-reachY, 0, reachY]) ctx.drawImage(covered, x, y);
  ctx.globalCompositeOperation = 'destination-over';
  ctx.imageSmoothingQuality = 'high';
  const small = new OffscreenCanvas(background.width, background.height);
  get2dContext(small).putImageData(new ImageData(background.data, background.width, background.height), 0, 0);
  ctx.drawImage(small, 0, 0, width, height);
  return canvas.convertToBlob({ type: 'image/png' });
}

function drawObjectShape(labels: Uint8Array, width: number, height: number) {
  const shape = new ImageData(width, height);
  labels.forEach((label, p) => (shape.data[4 * p + 3] = label > 0 ? 255 : 0));
  const canvas = new OffscreenCanvas(width, height);
  get2dContext(canvas).putImageData(shape, 0, 0);
  return canvas;
}

function get2dContext(canvas: OffscreenCanvas) {
  return canvas.getContext('2d')!;
}
