// The sound of a clip, for videos made from it.

import { checkOptions, illegal, typeTag } from '../../check/errors.js';
import { loadPart } from '../../places.js';

/** Source of the sound. */
export interface SoundOptions {
  /** Video file. */
  source: Blob | ArrayBuffer | Uint8Array;
  /** Start in seconds; the file's start if not given. */
  start?: number;
  /** End in seconds; the file's end if not given. */
  end?: number;
}

/**
 * The sound of a file: its codec, and the formats that can hold it: those of `encodeVideo`, and `wav` for `encodeImages`
 * if this browser can decode it. Formats in `converted` get it as Opus, encoded by this browser; other videos get it as
 * it is in the file.
 */
export type SoundInfo = {
  readonly codec: string;
  readonly channels: number;
  readonly sampleRate: number;
  readonly formats: ('webm' | 'mp4' | 'wav')[];
  readonly converted: ('webm' | 'mp4')[];
};

/** Returns the codec of a file's sound and the formats that can hold it; null if the file has none. */
export async function soundInfo(source: Blob | ArrayBuffer | Uint8Array): Promise<SoundInfo | null> {
  const [media, { createFormat, openInput: openInput }] = await Promise.all([
    import('../../vendor/media.js'),
    import('./video-file.js'),
  ]);
  const input = openInput(media, source);
  try {
    const track = (await input.canRead()) ? await input.getPrimaryAudioTrack() : null;
    const codec = await track?.getCodec();
    if (!track || !codec) return null;
    const videos: ('webm' | 'mp4')[] = ['webm', 'mp4'];
    const unsupported = videos.filter(
      (format) => !createFormat(media, format).getSupportedAudioCodecs().includes(codec),
    );
    const { findConversion, findDecoder } = await loadPart(import('./sound-convert.js'));
    const isConverted = unsupported.length > 0 && (await findConversion(track)) !== null;
    const isDecoded = (await findDecoder(track)) !== null;
    return {
      codec,
      channels: await track.getNumberOfChannels(),
      sampleRate: await track.getSampleRate(),
      formats: [
        ...videos.filter((format) => isConverted || !unsupported.includes(format)),
        ...(isDecoded ? (['wav'] as const) : []),
      ],
      converted: isConverted ? unsupported : [],
    };
  } finally {
    input.dispose();
  }
}

/** Checks the option `sound`; returns null if it is not given. */
export function checkSound(sound: unknown): Required<SoundOptions> | null {
  if (sound === undefined) return null;
  const legal = ['source', 'start', 'end'];
  const {
    source,
    start = 0,
    end = Infinity,
  } = checkOptions<SoundOptions>(sound as SoundOptions, legal, {
    prefix: 'sound.',
  });
  if (!['Blob', 'File', 'ArrayBuffer', 'Uint8Array'].includes(typeTag(source)))
    throw illegal('param', 'sound.source', source, 'a Blob, or the bytes of a file');
  if (typeof start !== 'number' || !(start >= 0)) throw illegal('param', 'sound.start', start, 'seconds, 0 or more');
  if (typeof end !== 'number' || !(end > start)) throw illegal('param', 'sound.end', end, `more than start = ${start}`);
  return { source, start, end };
}
