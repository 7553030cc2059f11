// The sound of a file as WAV: 16-bit samples at the rate of the file, of an exact length.

import { TraceCutError } from '../../check/errors.js';
import { loadPart } from '../../platform.js';
import { countChannels, decodeSound, findDecoder } from './sound-convert.js';
import { openInput } from './video-file.js';
import type { SoundOptions } from './video-options.js';

const HEADER_BYTES = 44;
const BYTES_PER_SAMPLE = 2;
const MAX_SAMPLE = 32767;

/** A WAV file to read; `close` releases the source. */
export type Wav = {
  sampleRate: number;
  channels: number;
  size: number;
  read: () => AsyncGenerator<Uint8Array<ArrayBuffer>, void, undefined>;
  close: () => void;
};

/**
 * Opens the sound of a source as a WAV file; returns null if the source has none.
 * @param seconds length of the file, which ends in silence if the sound is shorter
 */
export async function openWav({ source, start }: Required<SoundOptions>, seconds: number): Promise<Wav | null> {
  const media = await loadPart(import('../../vendor/media.js'));
  const input = openInput(media, source);
  const close = () => input.dispose();
  try {
    const track = (await input.canRead()) ? await input.getPrimaryAudioTrack() : null;
    if (!track) {
      close();
      return null;
    }
    const config = await findDecoder(track);
    if (!config) throw createDecoderError(String(await track.getCodec()));
    const rate = await track.getSampleRate();
    const channels = countChannels(config);
    const length = Math.round(seconds * rate);
    const read = async function* () {
      yield encodeWavHeader(length, channels, rate);
      let blocks: Uint8Array<ArrayBuffer>[] = [];
      let count = 0;
      const emit = (data: Float32Array<ArrayBuffer>, blockLength: number) => {
        blocks.push(toPcm(data, blockLength, channels));
        count += blockLength;
      };
      const decoder = decodeSound(media, track, { config, channels, rate, start, end: start + length / rate, emit });
      try {
        for (let time = 0; time < Infinity;) {
          time = await decoder.read();
          yield* blocks;
          blocks = [];
        }
      } finally {
        decoder.close();
      }
      if (count < length) yield new Uint8Array((length - count) * channels * BYTES_PER_SAMPLE);
    };
    return { sampleRate: rate, channels, size: HEADER_BYTES + length * channels * BYTES_PER_SAMPLE, read, close };
  } catch (error) {
    close();
    throw error;
  }
}

/** @param length samples of each channel */
function encodeWavHeader(length: number, channels: number, rate: number): Uint8Array<ArrayBuffer> {
  const frameBytes = channels * BYTES_PER_SAMPLE;
  const header = new DataView(new ArrayBuffer(HEADER_BYTES));
  const writeText = (at: number, text: string) =>
    [...text].forEach((letter, k) => header.setUint8(at + k, letter.charCodeAt(0)));
  writeText(0, 'RIFF');
  header.setUint32(4, HEADER_BYTES - 8 + length * frameBytes, true);
  writeText(8, 'WAVEfmt ');
  header.setUint32(16, 16, true);
  header.setUint16(20, 1, true); // PCM
  header.setUint16(22, channels, true);
  header.setUint32(24, rate, true);
  header.setUint32(28, rate * frameBytes, true);
  header.setUint16(32, frameBytes, true);
  header.setUint16(34, 8 * BYTES_PER_SAMPLE, true);
  writeText(36, 'data');
  header.setUint32(40, length * frameBytes, true);
  return new Uint8Array(header.buffer);
}

/** Converts planar samples to interleaved ones of 16 bits. */
function toPcm(data: Float32Array, length: number, channels: number): Uint8Array<ArrayBuffer> {
  const pcm = new DataView(new ArrayBuffer(data.length * BYTES_PER_SAMPLE));
  for (let c = 0; c < channels; c += 1)
    for (let k = 0; k < length; k += 1) {
      const sample = Math.max(-1, Math.min(1, Number(data[c * length + k])));
      pcm.setInt16((k * channels + c) * BYTES_PER_SAMPLE, Math.round(MAX_SAMPLE * sample), true);
    }
  return new Uint8Array(pcm.buffer);
}

function createDecoderError(codec: string) {
  return new TraceCutError(
    'unsupported',
    `sound: this browser cannot decode ${codec}; omit the sound (soundInfo lists the formats)`,
  );
}
