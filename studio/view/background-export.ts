// The scene without its objects, as pictures.

import { type Choice, type Export, type Subject, labelsOf } from '../model/export.js';

/** The plate reaches this far under the frame's own pixels around an object, in pixels of the plate. */
const MARGIN = 2;

export const background: Export = {
  title: 'Background',
  about:
    'The scene without any of the objects, for an editor: other frames show what is behind them. What none of them shows is transparent.',
  choices: [
    {
      id: 'background-png',
      label: 'PNG',
      says: 'Background of this frame as PNG',
      file: ({ frame }) => `background-${numbered(frame)}.png`,
      there: ({ plate }) => plate !== null,
      make: async (subject) => withoutObjects(subject, subject.frame, await subject.image(subject.frame)),
    },
    {
      id: 'background-zip',
      label: 'ZIP, all frames',
      file: () => 'background.zip',
      there: ({ plate }) => plate !== null,
      make: zip,
    },
  ],
};

async function zip(subject: Subject, { signal, onProgress }: Parameters<Choice['make']>[1]) {
  const { zipSync } = await import('fflate');
  const { numFrames } = subject.masks;
  const files: Record<string, Uint8Array> = {};
  let t = 0;
  for await (const frame of subject.frames(signal)) {
    signal.throwIfAborted();
    files[`${numbered(t)}.png`] = new Uint8Array(await (await withoutObjects(subject, t, frame)).arrayBuffer());
    t += 1;
    onProgress({ done: t, total: numFrames });
  }
  // PNG files are compressed already. The date is the first that ZIP knows.
  return new Blob([zipSync(files, { level: 0, mtime: new Date(1980, 0, 1) })], { type: 'application/zip' });
}

function numbered(frame: number) {
  return String(frame + 1).padStart(4, '0');
}

/** A frame at its own size, with the plate, which may be smaller, where objects are and close around them. */
async function withoutObjects(subject: Subject, t: number, own: ImageData) {
  const { plate } = subject;
  if (!plate) throw new Error('there is no background');
  const found = await plate(t);
  const { width, height } = own;
  const canvas = new OffscreenCanvas(width, height);
  const ctx = contextOf(canvas);
  ctx.putImageData(own, 0, 0);
  ctx.globalCompositeOperation = 'destination-out';
  const [reachX, reachY] = [(MARGIN * width) / found.width, (MARGIN * height) / found.height];
  const covered = shapeOf(await labelsOf(subject, t, own), width, height);
  for (const x of [-reachX, 0, reachX]) for (const y of [-reachY, 0, reachY]) ctx.drawImage(covered, x, y);
  ctx.globalCompositeOperation = 'destination-over';
  ctx.imageSmoothingQuality = 'high';
  const small = new OffscreenCanvas(found.width, found.height);
  contextOf(small).putImageData(new ImageData(found.data, found.width, found.height), 0, 0);
  ctx.drawImage(small, 0, 0, width, height);
  return canvas.convertToBlob({ type: 'image/png' });
}

/** Where any object is. */
function shapeOf(labels: Uint8Array, width: number, height: number) {
  const shape = new ImageData(width, height);
  labels.forEach((label, p) => (shape.data[4 * p + 3] = label > 0 ? 255 : 0));
  const canvas = new OffscreenCanvas(width, height);
  contextOf(canvas).putImageData(shape, 0, 0);
  return canvas;
}

function contextOf(canvas: OffscreenCanvas) {
  return canvas.getContext('2d')!;
}
