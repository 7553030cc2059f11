// Sound that is decoded by the browser: resampled to 48 kHz and encoded as Opus for a file format that cannot hold it as
// it is, or left as samples.

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

/** Samples emitted at once: a fifth of a second at 48 kHz. */
const BLOCK_SAMPLES = 9600;

/** Packets in a decoder or encoder before reading waits. */
const MAX_QUEUED = 8;

const MICROSECONDS = 1e6;

/** Configuration of a conversion. */
type Conversion = { decoder: AudioDecoderConfig; encoder: AudioEncoderConfig };

/** Returns the decoder configuration of a track; null if this browser cannot decode it. */
export async function findDecoder(track: InputAudioTrack): Promise<AudioDecoderConfig | null> {
  if (typeof AudioDecoder === 'undefined') return null;
  const config = await track.getDecoderConfig();
  const support = config && (await AudioDecoder.isConfigSupported(config).catch(() => null));
  return support?.supported ? config : null;
}

/** Returns the number of channels of decoded sound: more than two are mixed down. */
export function countChannels({ numberOfChannels }: AudioDecoderConfig): 1 | 2 {
  return numberOfChannels === 1 ? 1 : 2;
}

/** Returns the conversion of a track by this browser; null if it has none. */
export async function findConversion(track: InputAudioTrack): Promise<Conversion | null> {
  const decoder = await findDecoder(track);
  if (!decoder || typeof AudioEncoder === 'undefined') return null;
  const numberOfChannels = countChannels(decoder);
  const encoder = { codec: 'opus', sampleRate: OPUS_RATE, numberOfChannels, bitrate: BITRATES[numberOfChannels] };
  const support = await AudioEncoder.isConfigSupported(encoder).catch(() => null);
  return support?.supported ? { decoder, encoder } : null;
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
  const { numberOfChannels } = conversion.encoder;
  const decoder = decodeSound(media, track, {
    ...{ config: conversion.decoder, channels: numberOfChannels, rate: OPUS_RATE, start, end },
    emit: (data, numberOfFrames, first) => {
      if (encoder.state !== 'configured') return;
      const timestamp = Math.round((first / OPUS_RATE) * MICROSECONDS);
      const format = { format: 'f32-planar' as const, sampleRate: OPUS_RATE, numberOfChannels };
      const block = new AudioData({ ...format, numberOfFrames, timestamp, data });
      encoder.encode(block);
      block.close();
    },
  });
  /** Seconds of the video up to which packets were read. */
  let readUntil = -Infinity;
  const drain = async () => {
    while (!failure && encoder.encodeQueueSize > MAX_QUEUED) await waitForDequeue(encoder);
    await written;
    if (failure) throw createFailure(failure);
  };
  return {
    async write(until) {
      while (readUntil < until) {
        readUntil = await decoder.read();
        if (readUntil === Infinity) await encoder.flush().catch(fail);
        await drain();
      }
    },
    close() {
      decoder.close();
      if (encoder.state !== 'closed') encoder.close();
    },
  };
}

/** Takes a block of planar samples, their number, and the number of those before it. */
type EmitSamples = (data: Float32Array<ArrayBuffer>, count: number, first: number) => void;

/** Decodes a range of a track to samples at a rate; `close` leaves the track's file open. */
export function decodeSound(
  media: typeof import('../../vendor/media.js'),
  track: InputAudioTrack,
  {
    config,
    channels,
    rate,
    start,
    end,
    emit,
  }: { config: AudioDecoderConfig; channels: number; rate: number; start: number; end: number; emit: EmitSamples },
) {
  let failure: unknown = null;
  const fail = (error: unknown) => void (failure ??= error);
  const stream = new SampleStream(channels, rate, start, end, emit);
  const decoder = new AudioDecoder({
    output: (data) => {
      try {
        stream.push(data);
      } catch (error) {
        fail(error);
      } finally {
        data.close();
      }
    },
    error: fail,
  });
  decoder.configure(config);
  const packets = readPackets(media, track, start, end);
  return {
    /** Decodes the next packet; returns its time from the start in seconds, `Infinity` if there is none. */
    async read(): Promise<number> {
      const { value: packet } = await packets.next();
      if (packet) {
        decoder.decode(packet.toEncodedAudioChunk());
        while (!failure && decoder.decodeQueueSize > MAX_QUEUED) await waitForDequeue(decoder);
      } else {
        await decoder.flush().catch(fail);
      }
      if (failure) throw createFailure(failure);
      if (packet) return packet.timestamp - start;
      stream.end();
      return Infinity;
    },
    close() {
      packets.return().catch(() => {});
      if (decoder.state !== 'closed') decoder.close();
    },
  };
}

function createFailure(cause: unknown) {
  const reason = cause instanceof Error ? cause.message : String(cause);
  return new TraceCutError('unsupported', `the browser could not convert the sound: ${reason}`, { cause });
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
  sourceRate = 0;
  filter: Filter;
  /** Samples of the source so far, and the number of those already dropped. */
  #length = 0;
  #dropped = 0;
  /** Samples emitted. */
  #emitted = 0;
  #buffered: Float32Array<ArrayBuffer>[];

  /**
   * @param channels of the output
   * @param rate of the output, in samples a second
   * @param start seconds
   */
  constructor(
    readonly channels: number,
    readonly rate: number,
    public start: number,
    end: number,
    readonly emit: EmitSamples,
  ) {
    this.filter = createFilter(rate, rate);
    this.#maxSamples = Math.round((end - start) * rate);
    this.#buffered = Array.from({ length: channels }, () => new Float32Array(0));
  }

  push(data: AudioData) {
    if (this.sourceRate === 0) {
      this.sourceRate = data.sampleRate;
      this.filter = createFilter(this.sourceRate, this.rate);
    }
    if (data.sampleRate !== this.sourceRate) throw new Error('its sample rate changes');
    const gap = Math.round((data.timestamp / MICROSECONDS - this.start) * this.sourceRate) - this.#length;
    const isDiscontinuous = this.#length === 0 || Math.abs(gap) > MIN_GAP_S * this.sourceRate;
    const skipped = isDiscontinuous ? Math.max(0, -gap) : 0;
    if (skipped >= data.numberOfFrames) return;
    const planes = mixDown(data, this.channels).map((plane) => plane.subarray(skipped));
    this.#append(planes, isDiscontinuous ? Math.max(0, gap) : 0);
    this.run(BLOCK_SAMPLES);
  }

  end() {
    if (this.sourceRate === 0) return;
    this.#maxSamples = Math.min(this.#maxSamples, Math.floor((this.#length * this.rate) / this.sourceRate));
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
    const { sourceRate, rate, filter, channels } = this;
    const ready = Math.min(this.#maxSamples, Math.floor(((this.#length - filter.reach) * rate) / sourceRate));
    for (;;) {
      const count = Math.min(BLOCK_SAMPLES, ready - this.#emitted);
      if (count <= 0 || (count < least && ready < this.#maxSamples)) return;
      const data = new Float32Array(count * channels);
      this.#buffered.forEach((plane, c) =>
        filter.fill(data.subarray(c * count, (c + 1) * count), plane, this.#dropped, this.#emitted),
      );
      this.emit(data, count, this.#emitted);
      this.#emitted += count;
      const consumed = Math.max(0, Math.floor((this.#emitted * sourceRate) / rate) - filter.reach - this.#dropped);
      this.#buffered = this.#buffered.map((plane) => plane.slice(consumed));
      this.#dropped += consumed;
    }
  }
}

/** Zero crossings of the filter on each side: a longer filter cuts off more sharply. */
const CROSSINGS = 24;

type Filter = ReturnType<typeof createFilter>;

/**
 * Creates a low-pass filter that resamples: a sinc in a Hann window, sampled for each place between two samples.
 * @param from rate of the source
 * @param to rate of the output
 */
function createFilter(from: number, to: number) {
  const scale = Math.min(1, to / from);
  const reach = from === to ? 0 : Math.ceil(CROSSINGS / scale);
  const taps = 2 * reach + 1;
  /** Weights by the remainder of the place. */
  const phases = new Map<number, Float32Array>();
  const getWeights = (remainder: number) => {
    const cached = phases.get(remainder);
    if (cached) return cached;
    const weights = new Float32Array(taps).map((_, k) => {
      const x = (k - reach - remainder / to) * scale;
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
        const place = (first + k) * from;
        const remainder = place % to;
        const weights = getWeights(remainder);
        const left = (place - remainder) / to - reach - before;
        let value = 0;
        for (let i = 0; i < taps; i += 1) value += Number(weights[i]) * (plane[left + i] ?? 0);
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
