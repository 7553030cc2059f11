// A video file as it is written: frames, the sound of the source, and a layer of opacity for WebM.

import { TraceCutError, typeTag } from '../../check/errors.js';
import { part } from '../../places.js';
import { type Codec, QUANTIZER, bitrateOf } from './quality.js';
import type { Output, Quality } from '../../vendor/media.js';
import type { SoundOptions } from './sound.js';
import type { Painter } from './video-painter.js';
import type { Plan } from './video.js';
import type { EncodedAudioPacketSource, EncodedPacket, Input, InputAudioTrack } from 'mediabunny';

/** What a file may hold, best first: what browsers play, then what is small. */
const CODECS: Record<'webm' | 'mp4' | 'alpha', Codec[]> = {
  webm: ['vp9', 'vp8', 'av1'],
  mp4: ['avc', 'vp9', 'av1'],
  alpha: ['vp9', 'vp8'],
};

const NAME = { webm: 'WebM', mp4: 'MP4' };

/** A file that is being written; times are in seconds. */
export type VideoFile = {
  add: (time: number, duration: number) => Promise<void>;
  finish: () => Promise<Blob>;
  cancel: () => Promise<void>;
};

export async function openFile(painter: Painter, plan: Plan): Promise<VideoFile> {
  const media = await part(import('../../vendor/media.js'));
  // A page in WebKitGTK dies where an encoder is the first to wake its media library; players wake it well.
  globalThis.document?.createElement('video').canPlayType('video/webm');
  const { width, height } = painter.canvas;
  const video = { width, height, frameRate: plan.frameRate };
  const codecs = plan.alpha ? CODECS.alpha : CODECS[plan.format];
  const codec = (await media.getFirstEncodableVideoCodec(codecs, {
    width,
    height,
    quality: new media.Quality({ bitrate: bitrateOf(plan.quality, 'avc', video) }),
  })) as Codec | null;
  if (!codec) throw noEncoder(plan, width, height, codecs);
  const bitrate = bitrateOf(plan.quality, codec, video);
  const quantizer = QUANTIZER[plan.quality][codec];
  const quality = new media.Quality(quantizer === undefined ? { bitrate } : { bitrate, quantizer });
  const target = new media.BufferTarget();
  const output = new media.Output({ format: formatOf(media, plan.format), target });
  const encoder = plan.alpha
    ? withAlpha(media, output, painter, codec, bitrate)
    : opaque(media, output, painter, codec, quality);
  const sound = plan.sound && (await addSound(media, output, plan.sound, plan.format));
  await output.start();
  return {
    async add(time, duration) {
      await encoder.add(time, duration);
      await sound?.write(time + duration);
    },
    async finish() {
      await encoder.finish();
      await sound?.write(Infinity);
      sound?.close();
      await output.finalize();
      return new Blob([target.buffer!], { type: `video/${plan.format}` });
    },
    async cancel() {
      encoder.close();
      sound?.close();
      await output.cancel();
    },
  };
}

function opaque(
  media: typeof import('../../vendor/media.js'),
  output: Output,
  painter: Painter,
  codec: Codec,
  quality: Quality,
) {
  const source = new media.CanvasSource(painter.canvas, { codec, quality });
  output.addVideoTrack(source);
  const add = (time: number, duration: number) => source.add(time, duration);
  return { add, finish: async () => {}, close: () => {} };
}

/** @param codec one of those that can be transparent */
function withAlpha(
  media: typeof import('../../vendor/media.js'),
  output: Output,
  painter: Painter,
  codec: Codec,
  bitrate: number,
) {
  const track = new media.EncodedVideoPacketSource(codec);
  output.addVideoTrack(track);
  const encoder = new AlphaEncoder(painter, { codec: codec === 'vp8' ? 'vp8' : 'vp9', bitrate }, (color, alpha, meta) =>
    track.add(media.EncodedPacket.fromEncodedChunk(color, { alpha }), meta),
  );
  const add = (time: number, duration: number) => encoder.add(time, duration);
  return { add, finish: () => encoder.finish(), close: () => encoder.close() };
}

function noEncoder({ format, alpha }: Plan, width: number, height: number, codecs: string[]) {
  const other = format === 'mp4' ? "format: 'webm'" : alpha ? "a background colour and format: 'mp4'" : "format: 'mp4'";
  return new TraceCutError(
    'unsupported',
    `this browser encodes none of ${codecs.join(', ')} for ${NAME[format]} files of ${width} × ${height} pixels; try ${other}, or take PNG files from masksZip`,
  );
}

// A video that is transparent: WebM keeps the alpha of each frame as a second picture beside the first, whose
// brightness it is. Both are encoded here and not by the muxer's library, because that splits frames in a worker of its
// own making, which a strict content security policy forbids.

const CODEC_STRING = { vp9: 'vp09.00.51.08', vp8: 'vp8' };

/** Frames from one key frame to the next, at most. */
const KEY_FRAMES = 50;

/** Frames on their way through an encoder before more are painted. */
const MOST_WAITING = 4;

const MICROSECONDS = 1e6;

/** Takes a coded picture and the coded alpha that belongs to it. */
export type WritePair = (
  color: EncodedVideoChunk,
  alpha: Uint8Array,
  meta?: EncodedVideoChunkMetadata,
) => Promise<void>;

/** Encodes what a painter has painted, colours and alpha, and hands both on together. */
class AlphaEncoder {
  failure: unknown = null;
  count = 0;
  written: Promise<void> = Promise.resolve();
  colors: [EncodedVideoChunk, EncodedVideoChunkMetadata | undefined][] = [];
  alphas: EncodedVideoChunk[] = [];
  color: VideoEncoder;
  alpha: VideoEncoder;

  /** @param config bitrate of each of the two, in bits a second */
  constructor(
    readonly painter: Painter,
    config: { codec: 'vp9' | 'vp8'; bitrate: number },
    readonly write: WritePair,
  ) {
    this.color = this.encoder(config, (chunk, meta) => this.colors.push([chunk, meta]));
    this.alpha = this.encoder(config, (chunk) => this.alphas.push(chunk));
  }

  encoder(
    { codec, bitrate }: { codec: 'vp9' | 'vp8'; bitrate: number },
    take: (chunk: EncodedVideoChunk, meta?: EncodedVideoChunkMetadata) => void,
  ) {
    const { width, height } = this.painter.canvas;
    const encoder = new VideoEncoder({
      output: (chunk, meta) => {
        take(chunk, meta);
        this.pair();
      },
      error: (error) => (this.failure ??= error),
    });
    encoder.configure({ codec: CODEC_STRING[codec], width, height, bitrate, latencyMode: 'quality', alpha: 'discard' });
    return encoder;
  }

  /** @param time in seconds */
  async add(time: number, duration: number) {
    const keyFrame = this.count % KEY_FRAMES === 0;
    this.count += 1;
    const init = { timestamp: Math.round(time * MICROSECONDS), duration: Math.round(duration * MICROSECONDS) };
    encode(this.color, new VideoFrame(this.painter.canvas, { ...init, alpha: 'discard' }), keyFrame);
    const { width, height } = this.painter.size;
    encode(
      this.alpha,
      new VideoFrame(brightness(this.painter.alpha(), width, height), {
        ...init,
        format: 'I420',
        codedWidth: width,
        codedHeight: height,
      }),
      keyFrame,
    );
    for (const encoder of [this.color, this.alpha]) {
      while (encoder.encodeQueueSize > MOST_WAITING && !this.failure)
        await new Promise((done) => encoder.addEventListener('dequeue', done, { once: true }));
    }
    await this.written;
    this.check();
  }

  /** Hands on what has come of both; encoders keep the order. */
  pair() {
    while (this.colors.length > 0 && this.alphas.length > 0) {
      const [chunk, meta] = this.colors.shift()!;
      const beside = this.alphas.shift()!;
      const alpha = new Uint8Array(beside.byteLength);
      beside.copyTo(alpha);
      this.written = this.written
        .then(() => this.write(chunk, alpha, meta))
        .catch((error) => void (this.failure ??= error));
    }
  }

  async finish() {
    await Promise.all([this.color.flush(), this.alpha.flush()]).catch((error) => (this.failure ??= error));
    await this.written;
    this.check();
    this.close();
  }

  close() {
    for (const encoder of [this.color, this.alpha]) if (encoder.state !== 'closed') encoder.close();
  }

  check() {
    if (!this.failure) return;
    const words = this.failure instanceof Error ? this.failure.message : String(this.failure);
    throw new TraceCutError('unsupported', `the browser's video encoder gave up: ${words}`, { cause: this.failure });
  }
}

function encode(encoder: VideoEncoder, frame: VideoFrame, keyFrame: boolean) {
  try {
    encoder.encode(frame, { keyFrame });
  } finally {
    frame.close();
  }
}

/** A grey picture as encoders take it: brightness, then two planes of half the size for colours. */
function brightness(values: Uint8Array, width: number, height: number) {
  const planes = new Uint8Array(values.length + 2 * Math.ceil(width / 2) * Math.ceil(height / 2)).fill(128);
  planes.set(values);
  return planes;
}

export type SoundTrack = { write: (until: number) => Promise<void>; close: () => void };

export function formatOf(media: typeof import('../../vendor/media.js'), format: 'webm' | 'mp4') {
  return format === 'mp4' ? new media.Mp4OutputFormat({ fastStart: 'in-memory' }) : new media.WebMOutputFormat();
}

/** Adds a track for the sound to a file that is about to be written; null where the source has none. */
async function addSound(
  media: typeof import('../../vendor/media.js'),
  output: Output,
  { source, start, end }: Required<SoundOptions>,
  format: 'webm' | 'mp4',
): Promise<SoundTrack | null> {
  const input = opened(media, source);
  try {
    const track = (await input.canRead()) ? await input.getPrimaryAudioTrack() : null;
    const codec = await track?.getCodec();
    const decoderConfig = await track?.getDecoderConfig();
    if (!track || !codec || !decoderConfig) {
      input.dispose();
      return null;
    }
    if (!output.format.getSupportedAudioCodecs().includes(codec)) {
      const { conversionOf, converted } = await part(import('./sound-convert.js'));
      const conversion = await conversionOf(track);
      if (!conversion) throw cannotHold(codec, format);
      const target = new media.EncodedAudioPacketSource('opus');
      output.addAudioTrack(target);
      const { write, close } = converted(media, track, { conversion, target, start, end });
      return { write, close: () => (close(), input.dispose()) };
    }
    const target = new media.EncodedAudioPacketSource(codec);
    output.addAudioTrack(target);
    return copied(media, input, { packets: packetsOf(media, track, start, end), target, decoderConfig, start });
  } catch (error) {
    input.dispose();
    throw error;
  }
}

function copied(
  media: typeof import('../../vendor/media.js'),
  input: Input,
  {
    packets,
    target,
    decoderConfig,
    start,
  }: {
    packets: AsyncGenerator<EncodedPacket, void, undefined>;
    target: EncodedAudioPacketSource;
    decoderConfig: AudioDecoderConfig;
    start: number;
  },
): SoundTrack {
  /** Read, but not written yet; null after the last. */
  let next: EncodedPacket | null | undefined;
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
 * sound is as long as the video to within one of them. Those of plain samples may last longer and are cut.
 */
async function* packetsOf(
  media: typeof import('../../vendor/media.js'),
  track: InputAudioTrack,
  start: number,
  end: number,
) {
  const sink = new media.EncodedPacketSink(track);
  const first = (await sink.getPacket(start)) ?? (await sink.getFirstPacket()) ?? undefined;
  const isPlain = /^(pcm|[au]law)/.test(String(await track.getCodec()));
  const rate = await track.getSampleRate();
  for await (const whole of sink.packets(first)) {
    const packet = isPlain ? cutTo(whole, rate, start, end) : whole;
    const middle = packet.timestamp + packet.duration / 2;
    if (middle >= end) return;
    if (middle >= start) yield packet;
  }
}

/** @param rate samples a second */
function cutTo(packet: EncodedPacket, rate: number, start: number, end: number) {
  const count = Math.round(packet.duration * rate);
  const [from, to] = [start, end].map((at) => Math.min(count, Math.max(0, Math.round((at - packet.timestamp) * rate))));
  if (from === undefined || to === undefined || from >= to || to - from === count) return packet;
  const bytes = packet.data.byteLength / count;
  const data = packet.data.subarray(from * bytes, to * bytes);
  return packet.clone({ data, timestamp: packet.timestamp + from / rate, duration: (to - from) / rate });
}

export function opened(media: typeof import('../../vendor/media.js'), source: Blob | ArrayBuffer | Uint8Array) {
  const blob = typeTag(source) === 'Blob' || typeTag(source) === 'File' ? source : new Blob([source as BlobPart]);
  return new media.Input({
    source: new media.BlobSource(blob as Blob, { handleUnhandledError: () => {} }),
    formats: media.ALL_FORMATS,
  });
}

function cannotHold(codec: string, format: 'webm' | 'mp4') {
  const [name, other] = format === 'mp4' ? ['MP4', 'webm'] : ['WebM', 'mp4'];
  return new TraceCutError(
    'unsupported',
    `sound: ${name} files cannot hold ${codec} as it is, and this browser does not turn it into Opus; try format: '${other}', or leave the sound out (soundInfo says which formats can)`,
  );
}
