// Opens sources of frames: the sample, videos, image sequences and animated images.

import { Grabber, openVideo, readVideoFacts } from './video.js';
import { PageError } from '../model/messages.js';
import { sortClipFiles, type Source } from '../model/source.js';
import { type Clip, synthClip } from '../model/library.js';

/** Frame rate of image sequences, which have none of their own; chosen by eye. */
const SEQUENCE_FPS = 15;

/** Fewest frames before damage that are usable: motion needs two. */
const MIN_FRAMES = 2;

const ANIMATED_TYPES = ['image/gif', 'image/png', 'image/webp', 'image/avif'];

/**
 * Opens an image sequence, or one animated image.
 * @param sorted in their order
 * @param type of the first file
 */
export async function openImages(sorted: File[], type: string): Promise<Source> {
  if (sorted.length === 1) return openSingleImage(sorted[0], type);
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
        const actualSize = `${picture.width}×${picture.height}`;
        const expectedSize = `${size.width}×${size.height}`;
        throw new PageError('mixed-sizes', `${sorted[k].name} is ${actualSize}, the first is ${expectedSize}`);
      }
      const pixels = grabber.grab(picture, size, side);
      picture.close();
      return pixels;
    },
  );
}

/** Opens an animated image with its own timing. */
async function openSingleImage(file: File, type: string): Promise<Source> {
  const facts = ANIMATED_TYPES.includes(type)
    ? await readVideoFacts(file).catch((error) => refuse(error, file.name))
    : null;
  if (facts && facts.count > 1) return openVideo(file, 'images', facts);
  (await decode(file)).close();
  throw new PageError('one-image', file.name);
}

function refuse(error: unknown, name: string): never {
  const isAnimated = (error as { code?: unknown })?.code === 'unsupported';
  throw new PageError(isAnimated ? 'animated' : 'unreadable-image', name);
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
      const shownCount = Math.min(most, count);
      for (let k = 0; k < shownCount; k++) {
        signal.throwIfAborted();
        yield read(Math.floor(((k + 0.5) * count) / shownCount), side);
      }
    },
    async *frames(trim, signal) {
      source.damage = null;
      for (let k = 0; k < trim.frames; k++) {
        signal.throwIfAborted();
        const frame = await read(trim.start + k * trim.step, trim.side).catch((error) => {
          if (k < MIN_FRAMES || error?.code !== 'unreadable-image') throw error;
          source.damage = { frames: k, total: trim.frames };
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

/** The sample clip: processed in seconds, large enough to look at. */
export const SAMPLE = { width: 480, height: 270, frames: 24, seed: 0 };

/** Returns the package's synthetic scene; `clip` has its true masks. */
export async function sampleSource(): Promise<Source & { clip: Clip }> {
  const clip = await synthClip(SAMPLE);
  const imageOf = (t: number) => {
    const { data, width, height } = clip.frame(t);
    return new ImageData(new Uint8ClampedArray(data), width, height);
  };
  return {
    clip,
    kind: 'sample',
    name: 'Sample clip',
    width: clip.width,
    height: clip.height,
    fps: 15,
    count: clip.numFrames,
    preview: async (frame) => imageOf(frame),
    async *frames(trim) {
      for (let t = 0; t < trim.frames; t++) {
        yield { frame: imageOf(t), time: t / 15, end: (t + 1) / 15 };
        // Lets the page draw in between.
        await new Promise((resolve) => setTimeout(resolve));
      }
    },
    close() {},
  };
}

export async function openFiles(opened: File[]): Promise<Source> {
  const { kind, files, type } = await sortClipFiles(opened);
  const source = kind === 'images' ? await openImages(files, type) : await openVideo(files[0]);
  return Object.assign(source, { files, type });
}
