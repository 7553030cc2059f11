// Images of a sequence, or one image, animated or still, as a source of frames.

import { Grabber, factsOf, openVideo } from './video.js';
import { PageError } from '../model/words.js';
import type { Source } from '../model/source.js';

/** Frames per second at which images of a sequence are shown; nothing says how they were taken. */
const SEQUENCE_FPS = 15;

/** Motion needs two frames: damage after fewer is an error. */
const FEWEST = 2;

/** Types of files that may hold several images. */
const MOVING = ['image/gif', 'image/png', 'image/webp', 'image/avif'];

/**
 * @param sorted in their order
 * @param type of the first one
 */
export async function openImages(sorted: File[], type: string): Promise<Source> {
  if (sorted.length === 1) return openOne(sorted[0], type);
  const first = await decode(sorted[0]);
  const size = { width: first.width, height: first.height };
  first.close();
  const grabber = new Grabber();
  return pictureSource(
    `${sorted[0].name} … ${sorted[sorted.length - 1].name}`,
    sorted.length,
    size,
    async (k, side) => {
      const picture = await decode(sorted[k]);
      if (picture.width !== size.width || picture.height !== size.height) {
        const found = `${picture.width}×${picture.height}`;
        const wanted = `${size.width}×${size.height}`;
        throw new PageError('mixed-sizes', `${sorted[k].name} is ${found}, the first is ${wanted}`);
      }
      const pixels = grabber.grab(picture, size, side);
      picture.close();
      return pixels;
    },
  );
}

/** A GIF, or another image that may hold several frames, which last as long as it says; or a still one. */
async function openOne(file: File, type: string): Promise<Source> {
  const facts = MOVING.includes(type) ? await factsOf(file).catch((error) => refuse(error, file.name)) : null;
  if (facts && facts.count > 1) return openVideo(file, 'images', facts);
  return stillSource(file.name, await decode(file));
}

function refuse(error: unknown, name: string): never {
  const isAnimated = (error as { code?: unknown })?.code === 'unsupported';
  throw new PageError(isAnimated ? 'animated' : 'unreadable-image', name);
}

function stillSource(name: string, picture: ImageBitmap): Source {
  const { width, height } = picture;
  const grabber = new Grabber();
  const read = async (_: number, side: number) => grabber.grab(picture, { width, height }, side);
  const source = pictureSource(name, 1, { width, height }, read);
  return { ...source, kind: 'still', strip: undefined, close: () => picture.close() };
}

function pictureSource(
  name: string,
  count: number,
  size: { width: number; height: number },
  read: (frame: number, side: number) => Promise<ImageData>,
): Source {
  const source: Source = {
    kind: 'images',
    name,
    ...size,
    fps: SEQUENCE_FPS,
    count,
    preview: read,
    async *strip(most, side, signal) {
      const shown = Math.min(most, count);
      for (let k = 0; k < shown; k++) {
        signal.throwIfAborted();
        yield read(Math.floor(((k + 0.5) * count) / shown), side);
      }
    },
    async *frames(take, signal) {
      source.damage = null;
      for (let k = 0; k < take.frames; k++) {
        signal.throwIfAborted();
        const frame = await read(take.start + k * take.step, take.side).catch((error) => {
          if (k < FEWEST || error?.code !== 'unreadable-image') throw error;
          source.damage = { frames: k, total: take.frames };
          return null;
        });
        if (!frame) return;
        yield { frame, time: null };
      }
    },
    close() {},
  };
  return source;
}

async function decode(file: File): Promise<ImageBitmap> {
  try {
    return await createImageBitmap(file);
  } catch {
    throw new PageError('unreadable-image', file.name);
  }
}
