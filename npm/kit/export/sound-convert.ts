// Sound that a file format cannot hold: decoded, resampled to 48 kHz and encoded as Opus, all by the browser.

import { TraceCutError } from '../../check/errors.js';
import type { SoundTrack } from './video-file.js';
import type { EncodedAudioPacketSource, InputAudioTrack } from 'mediabunny';

/** Sample rate of Opus, in samples a second. */
const OPUS_RATE = 48000;

/** Bits per second for one and two channels. */
const BITRATES = { 1: 96000, 2: 160000 };

/** Seconds by which decoders start earlier: the first samples of some codecs depend on those before. */
const PREROLL_S = 0.1;

/** Shortest gap or overlap of sounds that is closed; times in files are rounded. */
const MIN_GAP_S = 0.005;

/** Samples passed to the encoder at once: a fifth of a second. */
const BLOCK_SAMPLES = 9600;

/** Packets in a decoder or encoder before reading waits. */
const MAX_QUEUED = 8;

const MICROSECONDS = 1e6;

/** Configuration of a conversion. */
type Conversion = { decoder: AudioDecoderConfig; encoder: AudioEncoderConfig };

/** Returns the conversion of a track by this browser; null if it has none. */
export async function findConversion(track: InputAudioTrack): Promise<Conversion | null> {
  if (typeof AudioDecoder === 'undefined' || typeof AudioEncoder === 'undefined') return null;
  const decoder = await track.getDecoderConfig();
  if (!decoder) return null;
  const numberOfChannels = decoder.numberOfChannels === 1 ? 1 : 2;
  const encoder = { codec: 'opus', sampleRate: OPUS_RATE, numberOfChannels, bitrate: BITRATES[numberOfChannels] };
  const supported = await Promise.all([
    AudioDecoder.isConfigSupported(decoder),
    AudioEncoder.isConfigSupported(encoder),
  ]).catch(() => []);
  return supported.length > 0 && supported.every((config) => config.supported) ? { decoder, encoder } : null;
}

/** Converts a track; `close` leaves the track's file open. */
export function convertSound(
  media: typeof import('../../vendor/media.js'),
  track: InputAudioTrack,
  {
    conversion,
    target,
    start,
    end,
  }: { conversion: Conversion; target: EncodedAudioPacketSource; start: number; end: number },
): SoundTrack {
  let failure: unknown = null;
  const fail = (error: unknown) => void (failure ??= error);
  let written: Promise<void> = Promise.resolve();
  const encoder = new AudioEncoder({
    output: (chunk, meta) => {
      written = written.then(() => target.add(media.EncodedPacket.fromEncodedChunk(chunk), meta)).catch(fail);
    },
    error: fail,
  });
  encoder.configure(conversion.encoder);
  const stream = new SampleStream(conversion.encoder.numberOfChannels, start, end, (data) => {
    encoder.encode(data);
    data.close();
  });
  const decoder = new AudioDecoder({
    output: (data) => {
      try {
        if (encoder.state === 'configured') stream.push(data);
      } catch (error) {
        fail(error);
      } finally {
        data.close();
      }
    },
    error: fail,
  });
  decoder.configure(conversion.decoder);
  const check = () => {
    if (!failure) return;
    const reason = failure instanceof Error ? failure.message : String(failure);
    throw new TraceCutError('unsupported', `the browser could not convert the sound: ${reason}`, { cause: failure });
  };
  const packets = readPackets(media, track, start, end);
  /** Seconds of the video up to which packets were read. */
  let readUntil = -Infinity;
  const drain = async () => {
    while (!failure && decoder.decodeQueueSize > MAX_QUEUED) await waitForDequeue(decoder);
    while (!failure && encoder.encodeQueueSize > MAX_QUEUED) await waitForDequeue(encoder);
    await written;
    check();
  };
  return {
    async write(until) {
      while (readUntil < until) {
        const { value: packet } = await packets.next();
        if (packet) {
          readUntil = packet.timestamp - start;
          decoder.decode(packet.toEncodedAudioChunk());
          await drain();
        } else {
          readUntil = Infinity;
          await decoder.flush().catch(fail);
          check();
          stream.end();
          await encoder.flush().catch(fail);
          await drain();
        }
      }
    },
    close() {
      packets.return().catch(() => {});
      for (const codec of [decoder, encoder]) if (codec.state !== 'closed') codec.close();
    },
  };
}

function waitForDequeue(codec: AudioDecoder | AudioEncoder) {
  // A codec that fails fires no event.
  return new Promise((resolve) => {
    const timer = setTimeout(resolve, 1000);
    codec.addEventListener('dequeue', () => (clearTimeout(timer), resolve(undefined)), { once: true });
  });
}

async function* readPackets(
  media: typeof import('../../vendor/media.js'),
  track: InputAudioTrack,
  start: number,
  end: number,
) {
  const sink = new media.EncodedPacketSink(track);
  const first = (await sink.getPacket(start - PREROLL_S)) ?? (await sink.getFirstPacket()) ?? undefined;
  for await (const packet of sink.packets(first)) {
    if (packet.timestamp >= end) return;
    yield packet;
  }
}

/** Resamples decoded sound to one continuous stream: gaps become silence, samples outside of the range are dropped. */
class SampleStream {
  #maxSamples: number;
  /** Sample rate of the source, 0 until known. */
  rate = 0;
  filter = createFilter(OPUS_RATE);
  /** Samples of the source so far, and the number of those already dropped. */
  #length = 0;
  #dropped = 0;
  /** Samples emitted. */
  #emitted = 0;
  #buffered: Float32Array<ArrayBuffer>[];

  /**
   * @param channels of the output
   * @param start seconds
   * @param emit takes samples at 48 kHz, from time 0 on
   */
  constructor(
    readonly channels: number,
    public start: number,
    end: number,
    readonly emit: (data: AudioData) => void,
  ) {
    this.#maxSamples = Math.round((end - start) * OPUS_RATE);
    this.#buffered = Array.from({ length: channels }, () => new Float32Array(0));
  }

  push(data: AudioData) {
    if (this.rate === 0) {
      this.rate = data.sampleRate;
      this.filter = createFilter(this.rate);
    }
    if (data.sampleRate !== this.rate) throw new Error('its sample rate changes');
    const gap = Math.round((data.timestamp / MICROSECONDS - this.start) * this.rate) - this.#length;
    const isDiscontinuous = this.#length === 0 || Math.abs(gap) > MIN_GAP_S * this.rate;
    const skipped = isDiscontinuous ? Math.max(0, -gap) : 0;
    if (skipped >= data.numberOfFrames) return;
    const planes = mixDown(data, this.channels).map((plane) => plane.subarray(skipped));
    this.#append(planes, isDiscontinuous ? Math.max(0, gap) : 0);
    this.run(BLOCK_SAMPLES);
  }

  end() {
    if (this.rate === 0) return;
    this.#maxSamples = Math.min(this.#maxSamples, Math.floor((this.#length * OPUS_RATE) / this.rate));
    // The filter reads samples after the last one.
    this.#append([], this.filter.reach);
    this.run(1);
  }

  /** @param silent samples of silence before the planes */
  #append(planes: Float32Array[], silent: number) {
    const count = silent + (planes[0]?.length ?? 0);
    this.#buffered = this.#buffered.map((plane, c) => {
      const longer = new Float32Array(plane.length + count);
      longer.set(plane);
      longer.set(planes[c] ?? [], plane.length + silent);
      return longer;
    });
    this.#length += count;
  }

  /** @param least fewest samples of a block, unless it is the last */
  run(least: number) {
    const { rate, filter, channels } = this;
    const ready = Math.min(this.#maxSamples, Math.floor(((this.#length - filter.reach) * OPUS_RATE) / rate));
    for (;;) {
      const count = Math.min(BLOCK_SAMPLES, ready - this.#emitted);
      if (count <= 0 || (count < least && ready < this.#maxSamples)) return;
      const data = new Float32Array(count * channels);
      this.#buffered.forEach((plane, c) =>
        filter.fill(data.subarray(c * count, (c + 1) * count), plane, this.#dropped, this.#emitted),
      );
      const timestamp = Math.round((this.#emitted / OPUS_RATE) * MICROSECONDS);
      const format = { format: 'f32-planar' as const, sampleRate: OPUS_RATE, numberOfChannels: channels };
      this.emit(new AudioData({ ...format, numberOfFrames: count, timestamp, data: data }));
      this.#emitted += count;
      const consumed = Math.max(0, Math.floor((this.#emitted * rate) / OPUS_RATE) - filter.reach - this.#dropped);
      this.#buffered = this.#buffered.map((plane) => plane.slice(consumed));
      this.#dropped += consumed;
    }
  }
}

/** Zero crossings of the filter on each side: a longer filter cuts off more sharply. */
const CROSSINGS = 24;

/**
 * Creates a low-pass filter that resamples to 48 kHz: a sinc in a Hann window, sampled for each place between two
 * samples.
 * @param rate of the source
 */
function createFilter(rate: number) {
  const scale = Math.min(1, OPUS_RATE / rate);
  const reach = rate === OPUS_RATE ? 0 : Math.ceil(CROSSINGS / scale);
  const taps = 2 * reach + 1;
  /** Weights by the remainder of the place. */
  const phases = new Map<number, Float32Array>();
  const getWeights = (remainder: number) => {
    const cached = phases.get(remainder);
    if (cached) return cached;
    const weights = new Float32Array(taps).map((_, k) => {
      const x = (k - reach - remainder / OPUS_RATE) * scale;
      const window = Math.abs(x) < CROSSINGS ? 0.5 + 0.5 * Math.cos((Math.PI * x) / CROSSINGS) : 0;
      return x === 0 ? 1 : (Math.sin(Math.PI * x) / (Math.PI * x)) * window;
    });
    // The weights add up to 1, so that a constant stays as it is.
    const total = weights.reduce((sum, weight) => sum + weight, 0);
    const normalized = weights.map((weight) => weight / total);
    phases.set(remainder, normalized);
    return normalized;
  };
  return {
    reach,
    /**
     * @param plane of the source
     * @param before samples of the source before the plane
     * @param first index of the block's first sample in the output
     */
    fill(block: Float32Array, plane: Float32Array, before: number, first: number) {
      for (let k = 0; k < block.length; k += 1) {
        const place = (first + k) * rate;
        const remainder = place % OPUS_RATE;
        const weights = getWeights(remainder);
        const from = (place - remainder) / OPUS_RATE - reach - before;
        let value = 0;
        for (let i = 0; i < taps; i += 1) value += Number(weights[i]) * (plane[from + i] ?? 0);
        block[k] = value;
      }
    },
  };
}

/**
 * Mixes sound down to one or two channels. With more channels, the first two are left and right, the last two are the
 * rear, and one between them is the centre.
 */
function mixDown(data: AudioData, channels: number): Float32Array[] {
  const { numberOfFrames, numberOfChannels } = data;
  const plane = (planeIndex: number) => {
    const values = new Float32Array(numberOfFrames);
    data.copyTo(values, { planeIndex, format: 'f32-planar' });
    return values;
  };
  const last = numberOfChannels - 1;
  if (last < channels) return Array.from({ length: channels }, (_, c) => plane(Math.min(c, last)));
  if (channels === 1) return [mixPlanes([plane(0), plane(1)], 1, 1)];
  const centre = numberOfChannels === 4 ? [] : [plane(2)];
  return [0, 1].map((c) =>
    mixPlanes([plane(c), ...centre, ...(last > 2 ? [plane(last - 1 + c)] : [])], 1, Math.SQRT1_2),
  );
}

/**
 * Mixes planes to one that is at most as loud as one of them.
 * @param first weight of the first plane
 * @param others weight of each other plane
 */
function mixPlanes(planes: Float32Array[], first: number, others: number) {
  const totalWeight = first + others * (planes.length - 1);
  const result = new Float32Array(planes[0]?.length ?? 0);
  planes.forEach((plane, n) =>
    plane.forEach((sample, k) => (result[k] = Number(result[k]) + ((n ? others : first) / totalWeight) * sample)),
  );
  return result;
}
