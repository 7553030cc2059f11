// Opens sources of frames: the sample, and files.

import { type Clip, sortFiles, synthClip } from '../model/library.js';
import { openImages } from './images.js';
import { openVideo } from './video.js';
import { PageError } from '../model/words.js';
import type { Source } from '../model/source.js';

/** The sample: small enough to be through in seconds, large enough to look at. */
export const SAMPLE = { width: 480, height: 270, frames: 24, seed: 0 };

/** Returns the library's own scene, with its known masks under `clip`. */
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
    async *frames(take) {
      for (let t = 0; t < take.frames; t++) {
        yield { frame: imageOf(t), time: t / 15, end: (t + 1) / 15 };
        // Lets the page draw in between.
        await new Promise((resolve) => setTimeout(resolve));
      }
    },
    close() {},
  };
}

export async function openFiles(chosen: File[]): Promise<Source> {
  const found = await sortFiles(chosen);
  const files = found.map(({ file }) => file);
  const stranger = found.find(({ kind }) => kind === null);
  if (files.length === 0 || stranger) throw new PageError('unknown-file', strangerWords(stranger?.file));
  const areImages = found.every(({ kind }) => kind === 'image');
  if (!areImages && files.length > 1) {
    const code = found.some(({ kind }) => kind === 'image') ? 'mixed-files' : 'many-videos';
    throw new PageError(code, `${files.length} files`);
  }
  const type = found[0].type ?? '';
  const source = areImages ? await openImages(files, type) : await openVideo(files[0]);
  return Object.assign(source, { files, type });
}

const strangerWords = (file?: File) => (file?.size === 0 ? `${file.name} is empty` : (file?.name ?? ''));
