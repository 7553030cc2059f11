// The sound of a clip, for videos that are made of it.

import { illegal, isPlainObject, typeTag } from '../../check/errors.js';
import { part } from '../../places.js';

/** Where sound is taken from. */
export interface SoundOptions {
  /** A video file. */
  source: Blob | ArrayBuffer | Uint8Array;
  /** Seconds; the file's beginning if not given. */
  start?: number;
  /** Seconds; the file's end if not given. */
  end?: number;
}

/**
 * The sound of a file: the codec, and the formats of `encodeVideo` that can have it; in those of `converted` it is Opus,
 * which this browser makes of it, in all others it is as in the file.
 */
export type SoundInfo = {
  readonly codec: string;
  readonly channels: number;
  readonly sampleRate: number;
  readonly formats: ('webm' | 'mp4')[];
  readonly converted: ('webm' | 'mp4')[];
};

/** What a file's sound is, and which formats can have it; null where it has none. */
export async function soundInfo(source: Blob | ArrayBuffer | Uint8Array): Promise<SoundInfo | null> {
  const [media, { formatOf, opened }] = await Promise.all([import('../../vendor/media.js'), import('./video-file.js')]);
  const input = opened(media, source);
  try {
    const track = (await input.canRead()) ? await input.getPrimaryAudioTrack() : null;
    const codec = await track?.getCodec();
    if (!track || !codec) return null;
    const all: ('webm' | 'mp4')[] = ['webm', 'mp4'];
    const others = all.filter((format) => !formatOf(media, format).getSupportedAudioCodecs().includes(codec));
    const isConverted =
      others.length > 0 && (await (await part(import('./sound-convert.js'))).conversionOf(track)) !== null;
    const converted = isConverted ? others : [];
    return {
      codec,
      channels: await track.getNumberOfChannels(),
      sampleRate: await track.getSampleRate(),
      formats: all.filter((format) => !others.includes(format) || converted.includes(format)),
      converted,
    };
  } finally {
    input.dispose();
  }
}

/** Refuses what is no sound. */
export function checkedSound(sound: unknown): Required<SoundOptions> | null {
  if (sound === undefined) return null;
  const legal = 'an object {source, start, end} with a video file and seconds';
  if (!isPlainObject(sound)) throw illegal('param', 'sound', sound, legal);
  const { source, start = 0, end = Infinity } = sound;
  if (!['Blob', 'File', 'ArrayBuffer', 'Uint8Array'].includes(typeTag(source)))
    throw illegal('param', 'sound.source', source, 'a Blob, or the bytes of a file');
  if (typeof start !== 'number' || !(start >= 0)) throw illegal('param', 'sound.start', start, 'seconds, 0 or more');
  if (typeof end !== 'number' || !(end > start)) throw illegal('param', 'sound.end', end, `more than start = ${start}`);
  return { source: source as Blob, start, end };
}
