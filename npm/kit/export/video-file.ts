// Writes a video file: frames, the sound of the source, and for WebM a layer of opacity.

import { TraceCutError, typeTag } from '../../check/errors.js';
import { loadPart } from '../../platform.js';
import { yieldThread } from '../../worker/pause.js';
import { type Codec, QUANTIZER, type SoundOptions, computeBitrate } from './video-options.js';
import type { Output, Quality } from '../../vendor/media.js';
import type { PaintedPixels, Painter } from './video-painter.js';
import type { VideoPlan } from './video.js';
import type { EncodedAudioPacketSource, EncodedPacket, Input, InputAudioTrack } from 'mediabunny';

/** Codecs that a file may hold, best first: those that browsers play, then those that compress well. */
const CODECS: Record<'webm' | 'mp4' | 'alpha', Codec[]> = {
  webm: ['vp9', 'vp8', 'av1'],
  mp4: ['avc', 'vp9', 'av1'],
  alpha: ['vp9', 'vp8'],
};

const FORMAT_NAMES = { webm: 'WebM', mp4: 'MP4' };

/** A file that is being written; times are in seconds. */
export type VideoFile = {
  add: (time: number, duration: number) => Promise<void>;
  finish: () => Promise<Blob>;
  cancel: () => Promise<void>;
};

export async function openVideoFile(painter: Painter, plan: VideoPlan): Promise<VideoFile> {
  const media = await loadPart(import('../../vendor/media.js'));
  // A page in WebKitGTK crashes if an encoder is the first to load its media library; players load it safely.
  globalThis.document?.createElement('video').canPlayType('video/webm');
  const { width, height } = painter.canvas;
  const video = { width, height, frameRate: plan.frameRate };
  const codecs = plan.alpha ? CODECS.alpha : CODECS[plan.format];
  const codec = (await media.getFirstEncodableVideoCodec(codecs, {
    width,
    height,
    quality: new media.Quality({ bitrate: computeBitrate(plan.quality, 'avc', video) }),
  })) as Codec | null;
  if (!codec) throw createNoEncoderError(plan, width, height, codecs);
  const bitrate = computeBitrate(plan.quality, codec, video);
  const quantizer = QUANTIZER[plan.quality][codec];
  const quality = new media.Quality(quantizer === undefined ? { bitrate } : { bitrate, quantizer });
  const target = new media.BufferTarget();
  const output = new media.Output({ format: createFormat(media, plan.format), target });
  const encoder = plan.alpha
    ? createAlphaEncoder(media, output, painter, codec, bitrate)
    : createOpaqueEncoder(media, output, painter, codec, quality);
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

function createOpaqueEncoder(
  media: typeof import('../../vendor/media.js'),
  output: Output,
  painter: Painter,
  codec: Codec,
  quality: Quality,
) {
  const source = new media.VideoSampleSource({ codec, quality });
  output.addVideoTrack(source);
  const add = async (time: number, duration: number) => {
    const sample = new media.VideoSample(toVideoFrame(painter, time, duration));
    await source.add(sample);
    sample.close();
  };
  return { add, finish: async () => {}, close: () => {} };
}

/** Colours of the frames to encode, which cameras write and editors expect. */
const COLOR_SPACE: VideoColorSpaceInit = { primaries: 'bt709', transfer: 'bt709', matrix: 'bt709', fullRange: false };

const MICROSECONDS = 1e6;

/**
 * Returns the painted picture, which is opaque.
 * @param time in seconds
 */
function toVideoFrame(painter: Painter, time: number, duration: number): VideoFrame {
  const { width, height } = painter.canvas;
  const data = painter.plan.style === 'alpha' ? convertMaskToI420(painter) : convertToI420(painter.pixels());
  return new VideoFrame(data, {
    ...{ format: 'I420', codedWidth: width, codedHeight: height, colorSpace: COLOR_SPACE, transfer: [data.buffer] },
    ...createTimestamps(time, duration),
  });
}

/** Converts seconds to microseconds. */
function createTimestamps(time: number, duration: number) {
  return { timestamp: Math.round(time * MICROSECONDS), duration: Math.round(duration * MICROSECONDS) };
}

/** @param codec one that supports alpha */
function createAlphaEncoder(
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

function createNoEncoderError({ format, alpha }: VideoPlan, width: number, height: number, codecs: string[]) {
  const alternative =
    format === 'mp4' ? "format: 'webm'" : alpha ? "a background colour and format: 'mp4'" : "format: 'mp4'";
  return new TraceCutError(
    'unsupported',
    `this browser encodes none of ${codecs.join(', ')} for ${FORMAT_NAMES[format]} files of ${width} × ${height} pixels; try ${alternative}, or PNG files by masksZip`,
  );
}

// A transparent video: WebM keeps the alpha of each frame as the brightness of a second picture beside the first. Both are
// encoded here and not by the muxer's library, because that splits frames in a worker that it creates from text, which a
// strict content security policy forbids.

/** Codec strings of WebCodecs: VP9 of profile 0, level 5.1, 8 bits; VP8 has no levels. */
const CODEC_STRING = { vp9: 'vp09.00.51.08', vp8: 'vp8' };

/** Most frames from one key frame to the next: two seconds at 25 frames per second. */
const KEY_FRAME_INTERVAL = 50;

/** Frames in an encoder before painting waits. */
const MAX_QUEUED = 4;

/** Writes an encoded picture and its encoded alpha. */
type WritePair = (color: EncodedVideoChunk, alpha: Uint8Array, meta?: EncodedVideoChunkMetadata) => Promise<void>;

/** Encodes the colours and the alpha of painted frames, and writes both together. */
class AlphaEncoder {
  #failure: unknown = null;
  #count = 0;
  #written: Promise<void> = Promise.resolve();
  #colors: [EncodedVideoChunk, EncodedVideoChunkMetadata | undefined][] = [];
  #alphas: EncodedVideoChunk[] = [];
  color: VideoEncoder;
  alpha: VideoEncoder;

  /** @param config bitrate of each of the two encoders, in bits a second */
  constructor(
    readonly painter: Painter,
    config: { codec: 'vp9' | 'vp8'; bitrate: number },
    readonly write: WritePair,
  ) {
    this.color = this.#createEncoder(config, (chunk, meta) => this.#colors.push([chunk, meta]));
    this.alpha = this.#createEncoder(config, (chunk) => this.#alphas.push(chunk));
  }

  #createEncoder(
    { codec: codec, bitrate }: { codec: 'vp9' | 'vp8'; bitrate: number },
    take: (chunk: EncodedVideoChunk, meta?: EncodedVideoChunkMetadata) => void,
  ) {
    const { width, height } = this.painter.canvas;
    const encoder = new VideoEncoder({
      output: (chunk, meta) => {
        take(chunk, meta);
        this.#writePairs();
      },
      error: (error) => (this.#failure ??= error),
    });
    encoder.configure({ codec: CODEC_STRING[codec], width, height, bitrate, latencyMode: 'quality', alpha: 'discard' });
    return encoder;
  }

  /** @param time in seconds */
  async add(time: number, duration: number) {
    const keyFrame = this.#count % KEY_FRAME_INTERVAL === 0;
    this.#count += 1;
    encode(this.color, toVideoFrame(this.painter, time, duration), keyFrame);
    // Large frames take the page's thread for some time.
    await yieldThread();
    const { width, height } = this.painter.size;
    encode(
      this.alpha,
      new VideoFrame(convertGreyToI420(this.painter.alpha(), width, height), {
        ...createTimestamps(time, duration),
        format: 'I420',
        codedWidth: width,
        codedHeight: height,
      }),
      keyFrame,
    );
    for (const encoder of [this.color, this.alpha]) {
      while (encoder.encodeQueueSize > MAX_QUEUED && !this.#failure)
        await new Promise((resolve) => encoder.addEventListener('dequeue', resolve, { once: true }));
    }
    await this.#written;
    this.#check();
  }

  /** Writes the pictures of which both parts are encoded; encoders keep the order. */
  #writePairs() {
    while (this.#colors.length > 0 && this.#alphas.length > 0) {
      const [chunk, meta] = this.#colors.shift()!;
      const encodedAlpha = this.#alphas.shift()!;
      const alpha = new Uint8Array(encodedAlpha.byteLength);
      encodedAlpha.copyTo(alpha);
      this.#written = this.#written
        .then(() => this.write(chunk, alpha, meta))
        .catch((error) => void (this.#failure ??= error));
    }
  }

  async finish() {
    await Promise.all([this.color.flush(), this.alpha.flush()]).catch((error) => (this.#failure ??= error));
    await this.#written;
    this.#check();
    this.close();
  }

  close() {
    for (const encoder of [this.color, this.alpha]) if (encoder.state !== 'closed') encoder.close();
  }

  #check() {
    if (!this.#failure) return;
    const reason = this.#failure instanceof Error ? this.#failure.message : String(this.#failure);
    throw new TraceCutError('unsupported', `the browser's video encoder failed: ${reason}`, { cause: this.#failure });
  }
}

function encode(encoder: VideoEncoder, frame: VideoFrame, keyFrame: boolean) {
  try {
    encoder.encode(frame, { keyFrame });
  } finally {
    frame.close();
  }
}

/** Allocates the planes of I420: brightness, then two of half the size for colours, which are grey. */
function createI420(width: number, height: number): Uint8Array<ArrayBuffer> {
  const size = width * height;
  const planes = new Uint8Array(size + 2 * Math.ceil(width / 2) * Math.ceil(height / 2));
  return planes.fill(128, size);
}

function convertGreyToI420(values: Uint8Array, width: number, height: number) {
  const planes = createI420(width, height);
  planes.set(values);
  return planes;
}

/** Converts a grey as `convertToI420` does. */
const toLimitedRange = (grey: number) => (56284 * grey + 16.5 * 65536) >> 16;

const BLACK_BRIGHTNESS = toLimitedRange(0);

/** Converts the opacity of a frame, white on black. An odd size is extended by a copy of the last row or column. */
function convertMaskToI420(painter: Painter) {
  const { width, height } = painter.canvas;
  const { size } = painter;
  const planes = createI420(width, height);
  const alpha = painter.alpha();
  const brightness = Uint8Array.from({ length: 256 }, (_, grey) => toLimitedRange(grey));
  for (let y = 0, p = 0; y < height; y += 1) {
    const row = Math.min(y, size.height - 1) * size.width;
    for (let x = 0; x < width; x += 1, p += 1) planes[p] = brightness[alpha[row + Math.min(x, size.width - 1)]!]!;
  }
  return planes;
}

/**
 * Converts an opaque picture to I420 as BT.709 in limited range (Rec. ITU-R BT.709-6, 3 and 4), in fixed point of 16 bits.
 * Browsers convert too, but to colours of their own choice.
 */
function convertToI420({ data, width, height, box }: PaintedPixels): Uint8Array<ArrayBuffer> {
  const planes = createI420(width, height);
  planes.fill(BLACK_BRIGHTNESS, 0, width * height);
  const [right, bottom] = [box.x + box.width, box.y + box.height];
  for (let y = box.y; y < bottom; y += 1) {
    const row = y * width;
    for (let p = row + box.x, q = 4 * p; p < row + right; p += 1, q += 4)
      planes[p] = (11966 * data[q]! + 40254 * data[q + 1]! + 4064 * data[q + 2]! + 16.5 * 65536) >> 16;
  }
  const size = Math.ceil(width / 2) * Math.ceil(height / 2);
  for (let y = box.y; y < bottom; y += 2) {
    const below = y + 1 < height ? 4 * width : 0;
    let at = width * height + (y / 2) * Math.ceil(width / 2) + box.x / 2;
    for (let x = box.x; x < right; x += 2, at += 1) {
      const q = 4 * (y * width + x);
      const beside = x + 1 < width ? 4 : 0;
      // Sums of four pixels: 18 bits are shifted out.
      const red = data[q]! + data[q + beside]! + data[q + below]! + data[q + below + beside]!;
      const green = data[q + 1]! + data[q + beside + 1]! + data[q + below + 1]! + data[q + below + beside + 1]!;
      const blue = data[q + 2]! + data[q + beside + 2]! + data[q + below + 2]! + data[q + below + beside + 2]!;
      planes[at] = (28785 * blue - 6596 * red - 22189 * green + 128.5 * 2 ** 18) >> 18;
      planes[at + size] = (28785 * red - 26145 * green - 2640 * blue + 128.5 * 2 ** 18) >> 18;
    }
  }
  return planes;
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
  const media = await loadPart(import('../../vendor/media.js'));
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

export type SoundTrack = { write: (until: number) => Promise<void>; close: () => void };

/** @internal Its types are those of the bundled library, which the package does not declare. */
export function createFormat(media: typeof import('../../vendor/media.js'), format: 'webm' | 'mp4') {
  return format === 'mp4' ? new media.Mp4OutputFormat({ fastStart: 'in-memory' }) : new media.WebMOutputFormat();
}

/** Adds a sound track to a file that is about to be written; null if the source has none. */
async function addSound(
  media: typeof import('../../vendor/media.js'),
  output: Output,
  { source, start, end }: Required<SoundOptions>,
  format: 'webm' | 'mp4',
): Promise<SoundTrack | null> {
  const input = openInput(media, source);
  try {
    const track = (await input.canRead()) ? await input.getPrimaryAudioTrack() : null;
    const codec = await track?.getCodec();
    const decoderConfig = await track?.getDecoderConfig();
    if (!track || !codec || !decoderConfig) {
      input.dispose();
      return null;
    }
    if (!output.format.getSupportedAudioCodecs().includes(codec)) {
      const { findConversion, convertSound } = await loadPart(import('./sound-convert.js'));
      const conversion = await findConversion(track);
      if (!conversion) throw createSoundError(codec, format);
      const target = new media.EncodedAudioPacketSource('opus');
      output.addAudioTrack(target);
      const { write, close } = convertSound(media, track, { conversion, target, start, end });
      return { write, close: () => (close(), input.dispose()) };
    }
    const target = new media.EncodedAudioPacketSource(codec);
    output.addAudioTrack(target);
    return copySound(media, input, { packets: readPackets(media, track, start, end), target, decoderConfig, start });
  } catch (error) {
    input.dispose();
    throw error;
  }
}

function copySound(
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
  /** Read, but not written yet; null after the last packet. */
  let next: EncodedPacket | null | undefined;
  let isFirst = true;
  const readNext = async () => (await packets.next()).value ?? null;
  return {
    async write(until) {
      if (next === undefined) next = await readNext();
      for (; next && next.timestamp - start < until; next = await readNext()) {
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
 * Yields the packets that lie more than half within the range: each lasts some hundredths of a second, so the sound is
 * as long as the video to within one of them. Packets of plain samples may be longer and are cut.
 */
async function* readPackets(
  media: typeof import('../../vendor/media.js'),
  track: InputAudioTrack,
  start: number,
  end: number,
) {
  const sink = new media.EncodedPacketSink(track);
  const first = (await sink.getPacket(start)) ?? (await sink.getFirstPacket()) ?? undefined;
  const isPlain = /^(pcm|[au]law)/.test(String(await track.getCodec()));
  const rate = await track.getSampleRate();
  for await (const original of sink.packets(first)) {
    const packet = isPlain ? cutPacket(original, rate, start, end) : original;
    const middle = packet.timestamp + packet.duration / 2;
    if (middle >= end) return;
    if (middle >= start) yield packet;
  }
}

/** @param rate samples a second */
function cutPacket(packet: EncodedPacket, rate: number, start: number, end: number) {
  const count = Math.round(packet.duration * rate);
  const [from, to] = [start, end].map((at) => Math.min(count, Math.max(0, Math.round((at - packet.timestamp) * rate))));
  if (from === undefined || to === undefined || from >= to || to - from === count) return packet;
  const bytes = packet.data.byteLength / count;
  const data = packet.data.subarray(from * bytes, to * bytes);
  return packet.clone({ data, timestamp: packet.timestamp + from / rate, duration: (to - from) / rate });
}

/** @internal As `createFormat`. */
export function openInput(media: typeof import('../../vendor/media.js'), source: Blob | ArrayBuffer | Uint8Array) {
  const blob = typeTag(source) === 'Blob' || typeTag(source) === 'File' ? source : new Blob([source as BlobPart]);
  return new media.Input({
    source: new media.BlobSource(blob as Blob, { handleUnhandledError: () => {} }),
    formats: media.ALL_FORMATS,
  });
}

function createSoundError(codec: string, format: 'webm' | 'mp4') {
  const [name, alternative] = format === 'mp4' ? ['MP4', 'webm'] : ['WebM', 'mp4'];
  return new TraceCutError(
    'unsupported',
    `sound: ${name} files cannot hold ${codec} as it is, and this browser cannot convert it to Opus; try format: '${alternative}', or omit the sound (soundInfo lists the formats)`,
  );
}
