// Sound that a file cannot hold as it is: decoded, brought to 48 kHz and encoded as Opus, all by the browser.

import { TraceCutError } from '../../check/errors.js';
import type { SoundTrack } from './video-file.js';
import type { EncodedAudioPacketSource, InputAudioTrack } from 'mediabunny';

/** What Opus works at, in samples a second. */
const RATE = 48000;

const BITRATE = { 1: 96000, 2: 160000 };

/** Decoders are started this much earlier, in seconds: the first samples of some codecs need those before. */
const PREROLL = 0.1;

/** A gap or an overlap of sounds is closed from this length on, in seconds; times in files are rounded. */
const GAP = 0.005;

/** Samples that one call of the encoder takes. */
const BLOCK = 9600;

/** Packets on their way through a decoder or encoder before more are read. */
const MOST_WAITING = 8;

const MICROSECONDS = 1e6;

/** Sound that can be converted. */
export type Conversion = { decoder: AudioDecoderConfig; encoder: AudioEncoderConfig };

/** How this browser converts a track; null where it cannot. */
export async function conversionOf(track: InputAudioTrack): Promise<Conversion | null> {
  if (typeof AudioDecoder === 'undefined' || typeof AudioEncoder === 'undefined') return null;
  const decoder = await track.getDecoderConfig();
  if (!decoder) return null;
  const numberOfChannels = decoder.numberOfChannels === 1 ? 1 : 2;
  const encoder = { codec: 'opus', sampleRate: RATE, numberOfChannels, bitrate: BITRATE[numberOfChannels] };
  const supported = await Promise.all([
    AudioDecoder.isConfigSupported(decoder),
    AudioEncoder.isConfigSupported(encoder),
  ]).catch(() => []);
  return supported.length > 0 && supported.every((one) => one.supported) ? { decoder, encoder } : null;
}

/** Returns a reader whose `close` leaves the file of the track open. */
export function converted(
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
  const line = new Line(conversion.encoder.numberOfChannels, start, end, (data) => {
    encoder.encode(data);
    data.close();
  });
  const decoder = new AudioDecoder({
    output: (data) => {
      try {
        if (encoder.state === 'configured') line.push(data);
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
    const words = failure instanceof Error ? failure.message : String(failure);
    throw new TraceCutError('unsupported', `the browser could not convert the sound: ${words}`, { cause: failure });
  };
  const packets = packetsOf(media, track, start, end);
  /** Seconds of the video up to which packets were read. */
  let read = -Infinity;
  const drained = async () => {
    while (!failure && decoder.decodeQueueSize > MOST_WAITING) await dequeued(decoder);
    while (!failure && encoder.encodeQueueSize > MOST_WAITING) await dequeued(encoder);
    await written;
    check();
  };
  return {
    async write(until) {
      while (read < until) {
        const { value: packet } = await packets.next();
        if (packet) {
          read = packet.timestamp - start;
          decoder.decode(packet.toEncodedAudioChunk());
          await drained();
        } else {
          read = Infinity;
          await decoder.flush().catch(fail);
          check();
          line.end();
          await encoder.flush().catch(fail);
          await drained();
        }
      }
    },
    close() {
      packets.return().catch(() => {});
      for (const codec of [decoder, encoder]) if (codec.state !== 'closed') codec.close();
    },
  };
}

function dequeued(codec: AudioDecoder | AudioEncoder) {
  // A codec that fails tells nothing of its queue.
  return new Promise((done) => {
    const timer = setTimeout(done, 1000);
    codec.addEventListener('dequeue', () => (clearTimeout(timer), done(undefined)), { once: true });
  });
}

async function* packetsOf(
  media: typeof import('../../vendor/media.js'),
  track: InputAudioTrack,
  start: number,
  end: number,
) {
  const sink = new media.EncodedPacketSink(track);
  const first = (await sink.getPacket(start - PREROLL)) ?? (await sink.getFirstPacket()) ?? undefined;
  for await (const packet of sink.packets(first)) {
    if (packet.timestamp >= end) return;
    yield packet;
  }
}

/** Decoded sound as one line of samples from the start on: gaps are silent, and what lies outside is left out. */
class Line {
  most: number;
  /** Of the source, once it is known. */
  rate = 0;
  filter = filterOf(RATE);
  /** Samples of the source so far, and how many of them are no longer needed. */
  length = 0;
  gone = 0;
  /** Samples given. */
  given = 0;
  waiting: Float32Array<ArrayBuffer>[];

  /**
   * @param channels of what is given
   * @param start seconds
   * @param give takes samples at 48 kHz, from time 0 on
   */
  constructor(
    readonly channels: number,
    public start: number,
    end: number,
    readonly give: (data: AudioData) => void,
  ) {
    this.most = Math.round((end - start) * RATE);
    this.waiting = Array.from({ length: channels }, () => new Float32Array(0));
  }

  push(data: AudioData) {
    if (this.rate === 0) {
      this.rate = data.sampleRate;
      this.filter = filterOf(this.rate);
    }
    if (data.sampleRate !== this.rate) throw new Error('its sample rate changes');
    const gap = Math.round((data.timestamp / MICROSECONDS - this.start) * this.rate) - this.length;
    const isOff = this.length === 0 || Math.abs(gap) > GAP * this.rate;
    const skipped = isOff ? Math.max(0, -gap) : 0;
    if (skipped >= data.numberOfFrames) return;
    const planes = mixed(data, this.channels).map((plane) => plane.subarray(skipped));
    this.append(planes, isOff ? Math.max(0, gap) : 0);
    this.run(BLOCK);
  }

  end() {
    if (this.rate === 0) return;
    this.most = Math.min(this.most, Math.floor((this.length * RATE) / this.rate));
    // The filter wants samples after the last.
    this.append([], this.filter.reach);
    this.run(1);
  }

  /** @param silent samples before them */
  append(planes: Float32Array[], silent: number) {
    const count = silent + (planes[0]?.length ?? 0);
    this.waiting = this.waiting.map((plane, c) => {
      const longer = new Float32Array(plane.length + count);
      longer.set(plane);
      longer.set(planes[c] ?? [], plane.length + silent);
      return longer;
    });
    this.length += count;
  }

  /** @param least samples of a block, unless it is the last */
  run(least: number) {
    const { rate, filter, channels } = this;
    const ready = Math.min(this.most, Math.floor(((this.length - filter.reach) * RATE) / rate));
    for (;;) {
      const count = Math.min(BLOCK, ready - this.given);
      if (count <= 0 || (count < least && ready < this.most)) return;
      const data = new Float32Array(count * channels);
      this.waiting.forEach((plane, c) =>
        filter.fill(data.subarray(c * count, (c + 1) * count), plane, this.gone, this.given),
      );
      const timestamp = Math.round((this.given / RATE) * MICROSECONDS);
      const form = { format: 'f32-planar' as const, sampleRate: RATE, numberOfChannels: channels };
      this.give(new AudioData({ ...form, numberOfFrames: count, timestamp, data }));
      this.given += count;
      const done = Math.max(0, Math.floor((this.given * rate) / RATE) - filter.reach - this.gone);
      this.waiting = this.waiting.map((plane) => plane.slice(done));
      this.gone += done;
    }
  }
}

/** Zero crossings of the filter on each side. */
const CROSSINGS = 24;

/**
 * A low-pass that resamples to 48 kHz: a sinc in a Hann window, once for each place between two samples.
 * @param rate of the source
 */
function filterOf(rate: number) {
  const scale = Math.min(1, RATE / rate);
  const reach = rate === RATE ? 0 : Math.ceil(CROSSINGS / scale);
  const taps = 2 * reach + 1;
  /** By the remainder of the place. */
  const phases = new Map<number, Float32Array>();
  const weightsAt = (remainder: number) => {
    const found = phases.get(remainder);
    if (found) return found;
    const weights = new Float32Array(taps).map((_, k) => {
      const x = (k - reach - remainder / RATE) * scale;
      const window = Math.abs(x) < CROSSINGS ? 0.5 + 0.5 * Math.cos((Math.PI * x) / CROSSINGS) : 0;
      return x === 0 ? 1 : (Math.sin(Math.PI * x) / (Math.PI * x)) * window;
    });
    // Silence stays silent and a constant stays as it is.
    const whole = weights.reduce((total, one) => total + one, 0);
    const even = weights.map((one) => one / whole);
    phases.set(remainder, even);
    return even;
  };
  return {
    reach,
    /**
     * @param plane of the source
     * @param before samples of the source before the plane
     * @param first place in the result of the block
     */
    fill(block: Float32Array, plane: Float32Array, before: number, first: number) {
      for (let k = 0; k < block.length; k += 1) {
        const place = (first + k) * rate;
        const remainder = place % RATE;
        const weights = weightsAt(remainder);
        const from = (place - remainder) / RATE - reach - before;
        let value = 0;
        for (let i = 0; i < taps; i += 1) value += Number(weights[i]) * (plane[from + i] ?? 0);
        block[k] = value;
      }
    },
  };
}

/**
 * Sound in one or two channels. Of more, the first two are left and right, the last two are behind, and one is between.
 */
function mixed(data: AudioData, channels: number): Float32Array[] {
  const { numberOfFrames, numberOfChannels } = data;
  const plane = (planeIndex: number) => {
    const values = new Float32Array(numberOfFrames);
    data.copyTo(values, { planeIndex, format: 'f32-planar' });
    return values;
  };
  const last = numberOfChannels - 1;
  if (last < channels) return Array.from({ length: channels }, (_, c) => plane(Math.min(c, last)));
  if (channels === 1) return [sum([plane(0), plane(1)], 1, 1)];
  const centre = numberOfChannels === 4 ? [] : [plane(2)];
  return [0, 1].map((c) => sum([plane(c), ...centre, ...(last > 2 ? [plane(last - 1 + c)] : [])], 1, Math.SQRT1_2));
}

/**
 * Planes in one, as loud as one of them at most.
 * @param first weight of the first
 * @param others weight of each other
 */
function sum(planes: Float32Array[], first: number, others: number) {
  const whole = first + others * (planes.length - 1);
  const result = new Float32Array(planes[0]?.length ?? 0);
  planes.forEach((plane, n) =>
    plane.forEach((one, k) => (result[k] = Number(result[k]) + ((n ? others : first) / whole) * one)),
  );
  return result;
}
