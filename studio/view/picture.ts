// A small picture of a work, to know it by: the frame with most of its objects, and their masks.

import { type MaskSource, drawLabels } from '../model/library.js';

/** Its longer side, in pixels: twice as large as it is shown. */
const SIDE = 192;

/** So many frames of a clip are looked at. */
const LOOKED_AT = 16;

/**
 * @param hidden objects that are not kept
 * @returns null where there is no frame
 */
export async function smallPicture(
  masks: MaskSource,
  frame: (t: number) => Promise<CanvasImageSource | ImageData | null>,
  hidden: readonly number[] = [],
): Promise<Blob | null> {
  const t = fullest(masks, hidden);
  const found = await frame(t).catch(() => null);
  if (!found) return null;
  const picture = found instanceof ImageData ? await createImageBitmap(found) : found;
  const { width, height } = masks;
  const scale = Math.min(1, SIDE / Math.max(width, height));
  const canvas = new OffscreenCanvas(Math.max(1, Math.round(scale * width)), Math.max(1, Math.round(scale * height)));
  const ctx = canvas.getContext('2d')!;
  ctx.imageSmoothingQuality = 'high';
  ctx.scale(canvas.width / width, canvas.height / height);
  ctx.drawImage(picture, 0, 0, width, height);
  if (picture !== found && picture instanceof ImageBitmap) picture.close();
  const objects = (object: number) => object > 0 && !hidden.includes(object);
  drawLabels(ctx, masks, t, { outlineWidth: 2 / scale, objects });
  return canvas.convertToBlob({ type: 'image/jpeg', quality: 0.85 });
}

/** Returns the frame, of a sample, in which objects cover most. */
function fullest(masks: MaskSource, hidden: readonly number[]): number {
  const step = Math.max(1, Math.floor(masks.numFrames / LOOKED_AT));
  let [best, most] = [0, -1];
  for (let t = 0; t < masks.numFrames; t += step) {
    let count = 0;
    for (const label of masks.labels(t)) if (label > 0 && !hidden.includes(label)) count += 1;
    if (count > most) [best, most] = [t, count];
  }
  return best;
}
