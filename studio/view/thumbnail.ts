// Thumbnails of projects: the frame with most object pixels, and its masks.

import { type MaskSource, drawLabels } from '../model/library.js';
import { runInSlices } from '../model/slices.js';

/** Long side in pixels: twice the displayed size. */
const THUMBNAIL_SIDE_PX = 192;

/** Number of sampled frames; chosen by eye. */
const MAX_SAMPLED_FRAMES = 16;

/**
 * @param hidden objects to leave out
 * @returns null if the frame is missing
 */
export async function makeThumbnail(
  masks: MaskSource,
  frame: (t: number) => Promise<CanvasImageSource | ImageData | null>,
  hidden: readonly number[] = [],
): Promise<Blob | null> {
  const t = await findFullestFrame(masks, hidden);
  const image = await frame(t).catch(() => null);
  if (!image) return null;
  const picture = image instanceof ImageData ? await createImageBitmap(image) : image;
  const { width, height } = masks;
  const scale = Math.min(1, THUMBNAIL_SIDE_PX / Math.max(width, height));
  const canvas = new OffscreenCanvas(Math.max(1, Math.round(scale * width)), Math.max(1, Math.round(scale * height)));
  const ctx = canvas.getContext('2d')!;
  ctx.imageSmoothingQuality = 'high';
  ctx.scale(canvas.width / width, canvas.height / height);
  ctx.drawImage(picture, 0, 0, width, height);
  if (picture !== image && picture instanceof ImageBitmap) picture.close();
  const objects = (object: number) => object > 0 && !hidden.includes(object);
  drawLabels(ctx, masks, t, { outlineWidth: 2 / scale, objects });
  return canvas.convertToBlob({ type: 'image/jpeg', quality: 0.85 });
}

/** Returns the sampled frame with most object pixels. */
async function findFullestFrame(masks: MaskSource, hidden: readonly number[]): Promise<number> {
  const step = Math.max(1, Math.floor(masks.numFrames / MAX_SAMPLED_FRAMES));
  const isCounted = Uint8Array.from({ length: 256 }, (_, label) => Number(label > 0 && !hidden.includes(label)));
  let [best, most] = [0, -1];
  function* countFrames() {
    for (let t = 0; t < masks.numFrames; t += step) {
      const labels = masks.labels(t);
      let count = 0;
      for (let p = 0; p < labels.length; p += 1) count += isCounted[labels[p]];
      if (count > most) [best, most] = [t, count];
      yield;
    }
  }
  await runInSlices(countFrames());
  return best;
}
