// Sound in a video that is written: the packets of its source, as they are.

import { TraceCutError, typeTag } from '../errors.js';

/** @typedef {{write: (until: number) => Promise<void>, close: () => void}} SoundTrack */

/**
 * @param {typeof import('../vendor/media.js')} media
 * @param {'webm' | 'mp4'} format
 */
export function formatOf(media, format) {
  return format === 'mp4' ? new media.Mp4OutputFormat({ fastStart: 'in-memory' }) : new media.WebMOutputFormat();
}

/**
 * Adds a track for the sound to a file that is about to be written; null where the source has none.
 * @param {typeof import('../vendor/media.js')} media
 * @param {import('../vendor/media.js').Output} output
 * @param {Required<import('./sound.js').SoundOptions>} sound
 * @param {'webm' | 'mp4'} format
 * @returns {Promise<SoundTrack | null>}
 */
export async function addSound(media, output, { source, start, end }, format) {
  const input = opened(media, source);
  try {
    const track = (await input.canRead()) ? await input.getPrimaryAudioTrack() : null;
    const codec = await track?.getCodec();
    const decoderConfig = await track?.getDecoderConfig();
    if (!track || !codec || !decoderConfig) {
      input.dispose();
      return null;
    }
    if (!output.format.getSupportedAudioCodecs().includes(codec)) throw cannotHold(codec, format);
    const target = new media.EncodedAudioPacketSource(codec);
    output.addAudioTrack(target);
    return copied(media, input, { packets: packetsOf(media, track, start, end), target, decoderConfig, start });
  } catch (error) {
    input.dispose();
    throw error;
  }
}

/**
 * @param {typeof import('../vendor/media.js')} media
 * @param {import('mediabunny').Input} input
 * @param {{packets: AsyncGenerator<import('mediabunny').EncodedPacket, void, undefined>, target:
 *   import('mediabunny').EncodedAudioPacketSource, decoderConfig: AudioDecoderConfig, start: number}} parts
 * @returns {SoundTrack}
 */
function copied(media, input, { packets, target, decoderConfig, start }) {
  /** @type {import('mediabunny').EncodedPacket | null | undefined} Read, but not written yet; null after the last. */
  let next;
  let isFirst = true;
  const read = async () => (await packets.next()).value ?? null;
  return {
    async write(until) {
      if (next === undefined) next = await read();
      for (; next && next.timestamp - start < until; next = await read()) {
        const timestamp = Math.max(0, next.timestamp - start);
        await target.add(next.clone({ timestamp }), isFirst ? { decoderConfig } : undefined);
        isFirst = false;
      }
    },
    close() {
      packets.return().catch(() => {});
      input.dispose();
    },
  };
}

/**
 * Packets of which more than half lies in the stretch that is wanted: each lasts some hundredths of a second, so the
 * sound is as long as the video to within one of them.
 * @param {typeof import('../vendor/media.js')} media
 * @param {import('mediabunny').InputAudioTrack} track
 * @param {number} start
 * @param {number} end
 */
async function* packetsOf(media, track, start, end) {
  const sink = new media.EncodedPacketSink(track);
  const first = (await sink.getPacket(start)) ?? (await sink.getFirstPacket()) ?? undefined;
  for await (const packet of sink.packets(first)) {
    const middle = packet.timestamp + packet.duration / 2;
    if (middle >= end) return;
    if (middle >= start) yield packet;
  }
}

/**
 * @param {typeof import('../vendor/media.js')} media
 * @param {Blob | ArrayBuffer | Uint8Array} source
 */
export function opened(media, source) {
  const blob =
    typeTag(source) === 'Blob' || typeTag(source) === 'File' ? source : new Blob([/** @type {any} */ (source)]);
  return new media.Input({
    source: new media.BlobSource(/** @type {Blob} */ (blob), { handleUnhandledError: () => {} }),
    formats: media.ALL_FORMATS,
  });
}

/**
 * @param {string} codec
 * @param {'webm' | 'mp4'} format
 */
function cannotHold(codec, format) {
  const [name, other] = format === 'mp4' ? ['MP4', 'webm'] : ['WebM', 'mp4'];
  return new TraceCutError(
    'unsupported',
    `sound: ${name} files cannot hold ${codec} as it is; try format: '${other}', or leave the sound out (soundInfo says which formats can)`,
  );
}
