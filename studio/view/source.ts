// Opens sources of frames: the sample, and files.

import { type Clip, sortFiles, synthClip } from '../model/library.js';
import { openImages } from './images.js';
import { openVideo } from './video.js';
import { PageError } from '../model/messages.js';
import type { Source } from '../model/source.js';

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

export async function openFiles(files: File[]): Promise<Source> {
  const sorted = await sortFiles(files);
  const usable = sorted.map(({ file }) => file);
  const unknown = sorted.find(({ kind }) => kind === null);
  if (usable.length === 0 || unknown) throw new PageError('unknown-file', strangerWords(unknown?.file));
  const areImages = sorted.every(({ kind }) => kind === 'image');
  if (!areImages && usable.length > 1) {
    const code = sorted.some(({ kind }) => kind === 'image') ? 'mixed-files' : 'many-videos';
    throw new PageError(code, `${usable.length} files`);
  }
  const type = sorted[0].type ?? '';
  const source = areImages ? await openImages(usable, type) : await openVideo(usable[0]);
  return Object.assign(source, { files: usable, type });
}

const strangerWords = (file?: File) => (file?.size === 0 ? `${file.name} is empty` : (file?.name ?? ''));
