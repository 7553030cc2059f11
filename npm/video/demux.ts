// Video files whose container is read here and whose frames WebCodecs decodes: each picture exactly once, with its own
// time.

import { TraceCutError } from '../check/errors.js';
import { averageRate } from '../check/masks.js';
import { part } from '../places.js';
import { type PictureList, decodedFrom, listPictures } from './decode.js';
import { type ReadFrame, stretched } from './pixels.js';
import type { Reader, TimedFrame } from './reader.js';
import type { EncodedPacket, Input, InputVideoTrack, VideoSample } from 'mediabunny';

export type Media = typeof import('../vendor/media.js');

/** Retries of a lost connection, with a second between. */
const RETRIES = 2;

/** Largest difference between equal times, in seconds. */
const SLACK = 1e-6;

/** Key pictures at which decoding begins, at most: a tapped stream may begin with a broken one, which is no damage. */
const MOST_TRIES = 5;

/** The error of data that ends too early. */
const NO_MORE = new Error('no more data');

/** Key packets are looked into: containers are often wrong about them. */
const VERIFIED = { verifyKeyPackets: true };

/**
 * Opens a file's container; null when it is of no known kind.
 * @param isCut it goes on to its end, but there was more
 */
export async function openDemuxed(source: Blob | URL, isCut = false): Promise<Reader | null> {
  const media = await part(import('../vendor/media.js'));
  const input = inputOf(media, source);
  try {
    if (!(await input.canRead())) {
      input.dispose();
      return null;
    }
    const track = await chooseTrack(media, input);
    if (track) return new TrackReader(media, input, track, isCut);
    throw await withoutVideo(media, input);
  } catch (error) {
    input.dispose();
    throw readable(error, source);
  }
}

async function withoutVideo(media: Media, input: Input) {
  const hasSound = (await input.getAudioTracks()).length > 0;
  const mayLackIndex = [media.MP4, media.QTFF].includes(await input.getFormat());
  if (hasSound || !mayLackIndex)
    return new TraceCutError('no-video', `the file has no video track${hasSound ? ', only sound' : ''}`);
  const words = 'the file is cut off: the index, which MP4 files may have at their end, is missing';
  return new TraceCutError('truncated', words, { frames: 0 });
}

function inputOf(media: Media, source: Blob | URL) {
  const handleUnhandledError = () => {};
  const getRetryDelay = (attempts: number) => (attempts > RETRIES ? null : 1);
  const isAddress = source instanceof URL;
  return new media.Input({
    source: isAddress
      ? new media.UrlSource(source, { getRetryDelay, handleUnhandledError })
      : new media.BlobSource(source, { handleUnhandledError }),
    // A playlist that is a file leads nowhere.
    formats: isAddress ? media.ALL_FORMATS : media.ALL_FORMATS.filter((format) => format !== media.HLS),
  });
}

/**
 * Chooses the default track that has more than one picture, or else the largest that has, or else any: a track of one
 * picture is a cover.
 */
async function chooseTrack(media: Media, input: Input) {
  const tracks = await input.getVideoTracks();
  const moving = await filtered(tracks, (track) => isMoving(media, track));
  const candidates = moving.length > 0 ? moving : tracks;
  // A transport stream does not say which one is the default.
  const tells = (await input.getFormat()) !== media.MPEG_TS;
  const [preferred] = tells ? await filtered(candidates, async (track) => (await track.getDisposition()).default) : [];
  if (preferred) return preferred;
  const areas = await Promise.all(
    candidates.map(async (track) => (await track.getDisplayWidth()) * (await track.getDisplayHeight())),
  );
  return candidates[areas.indexOf(Math.max(...areas))];
}

async function filtered<T>(values: T[], test: (value: T) => Promise<boolean>) {
  const passed = await Promise.all(values.map(test));
  return values.filter((_, k) => passed[k]);
}

async function isMoving(media: Media, track: InputVideoTrack) {
  const sink = new media.EncodedPacketSink(track);
  const first = await sink.getFirstPacket({ metadataOnly: true });
  return first !== null && (await sink.getNextPacket(first, { metadataOnly: true })) !== null;
}

/** Frames of a track of a container. */
class TrackReader implements Reader {
  #media;
  #input;
  #track;
  #isCut;
  damage: TraceCutError | undefined;
  #listing: Promise<PictureList> | undefined;
  /** Size of the first picture, to which later ones are scaled; null until it is decoded. */
  #size: Size | null = null;

  constructor(media: Media, input: Input, track: InputVideoTrack, isCut: boolean) {
    this.#media = media;
    this.#input = input;
    this.#track = track;
    this.#isCut = isCut;
  }

  async info() {
    const { times, end } = await this.#pictures();
    const decodable = await this.#isDecodable();
    const { width, height } = await (decodable ? this.#firstSize() : this.#containerSize());
    if (this.#isCut) this.damage = await this.#broken(NO_MORE, times.at(-1));
    const numFrames = times.length;
    const duration = numFrames > 0 ? end - Number(times[0]) : 0;
    const frameRate = averageRate(numFrames, duration);
    return { width, height, duration, frameRate, numFrames, codec: await this.#codec(), decodable };
  }

  async times() {
    return (await this.#pictures()).times;
  }

  /** @param range in seconds */
  async *frames({ start, end }: { start: number; end: number }): AsyncGenerator<TimedFrame, void, unknown> {
    const { times, stamps } = await this.#pictures();
    const begin = times.findIndex((time) => time >= start - SLACK);
    if (begin < 0) return;
    const sink = new this.#media.EncodedPacketSink(this.#track);
    const key = begin > 0 ? await sink.getKeyPacket(Number(stamps[begin]), VERIFIED) : null;
    for await (const frame of this.#framesFrom(key)) {
      if (frame.time >= end) return frame.close();
      yield frame;
    }
  }

  /**
   * Packets between two times are decoded once, and not at all where a later one can be decoded without them.
   * @param wanted times of frames, ascending
   */
  async *at(wanted: number[]): AsyncGenerator<TimedFrame, void, unknown> {
    for (const { key, until, times } of await this.#groups(wanted)) {
      let next = 0;
      for await (const frame of this.#framesFrom(key, until)) {
        if (frame.time < Number(times[next]) - SLACK) {
          frame.close();
          continue;
        }
        yield frame;
        next += 1;
        if (next === times.length) break;
      }
      if (next < times.length) throw await this.#broken(NO_MORE, times[next]);
    }
  }

  /**
   * Groups times by the key packets that decoding begins with; `until` is the number of the last packet that is needed.
   */
  async #groups(wanted: number[]) {
    const { times, stamps } = await this.#pictures();
    const sink = new this.#media.EncodedPacketSink(this.#track);
    const groups: { key: EncodedPacket | null; until: number; times: number[] }[] = [];
    for (const time of wanted) {
      const stamp = Number(stamps[times.findIndex((one) => one >= time - SLACK)]);
      const key = await sink.getKeyPacket(stamp, VERIFIED);
      const until = (await sink.getPacket(stamp, { metadataOnly: true }))?.sequenceNumber ?? Infinity;
      const last = groups.at(-1);
      if (last && last.key?.sequenceNumber === key?.sequenceNumber) {
        last.until = Math.max(last.until, until);
        last.times.push(time);
      } else groups.push({ key, until, times: [time] });
    }
    return groups;
  }

  close() {
    this.#input.dispose();
  }

  /**
   * @param key null to begin with the first picture that can be decoded
   * @param until number of the last packet that is needed
   */
  async *#framesFrom(key: EncodedPacket | null, until: number = Infinity): AsyncGenerator<TimedFrame, void, unknown> {
    if (!(await this.#isDecodable())) throw await this.#undecodable();
    let last = -Infinity;
    let first = key ?? (await this.#nextKey(null));
    for (let tries = key ? 1 : MOST_TRIES; first; tries -= 1) {
      try {
        for await (const frame of this.#framesAfter(first, until, !key)) {
          last = frame.time;
          yield frame;
        }
        break;
      } catch (error) {
        first = last > -Infinity || tries === 1 ? null : await this.#nextKey(first);
        if (!first) throw await this.#broken(error, last);
      }
    }
    if (this.#isCut && until === Infinity) throw await this.#broken(NO_MORE, last);
  }

  #nextKey(packet: EncodedPacket | null) {
    const sink = new this.#media.EncodedPacketSink(this.#track);
    return packet ? sink.getNextKeyPacket(packet, VERIFIED) : sink.getFirstKeyPacket(VERIFIED);
  }

  /** @param isBeginning no picture comes before */
  async *#framesAfter(
    first: EncodedPacket,
    until: number,
    isBeginning: boolean,
  ): AsyncGenerator<TimedFrame, void, unknown> {
    const { stamps, times, end, lastPacket } = await this.#pictures();
    let place = -1;
    for await (const sample of decodedFrom(this.#media, this.#track, first, Math.min(until, lastPacket))) {
      const found = placeOf(stamps, sample.timestamp, place + 1);
      if (found < 0) {
        sample.close();
        continue;
      }
      place = found;
      const time = Number(times[place]);
      // Not every container says how long its frames last; all say when the next one comes.
      const duration = (place + 1 < times.length ? Number(times[place + 1]) : end) - time;
      if (isBeginning) this.#size ??= sizeOf(sample);
      yield { time, duration, read: () => this.#read(sample), close: () => sample.close() };
    }
  }

  async #read(sample: VideoSample) {
    const { width, height } = await this.#shownSize(sample);
    const raw = upright(sample);
    return sample.displayWidth === width && sample.displayHeight === height ? raw : stretched(raw, width, height);
  }

  /** The size of the first picture. A picture of the size that the container says is taken to be of that. */
  async #shownSize(sample: VideoSample) {
    if (!this.#size) {
      const { width, height } = await this.#containerSize();
      if (sample.displayWidth === width && sample.displayHeight === height) return { width, height };
    }
    return this.#firstSize();
  }

  async #firstSize(): Promise<Size> {
    try {
      if (!this.#size)
        for await (const frame of this.#framesFrom(null)) {
          frame.close();
          break;
        }
    } catch {
      // Whoever takes frames is told what is wrong.
    }
    return this.#size ?? this.#containerSize();
  }

  async #containerSize() {
    return { width: await this.#track.getDisplayWidth(), height: await this.#track.getDisplayHeight() };
  }

  #pictures() {
    return (this.#listing ??= listPictures(this.#media, this.#track));
  }

  async #codec() {
    const track = this.#track;
    return (await track.getCodecParameterString()) ?? String((await track.getInternalCodecId()) ?? 'unknown');
  }

  async #isDecodable() {
    return typeof VideoDecoder !== 'undefined' && (await this.#track.canDecode());
  }

  async #undecodable() {
    if (typeof VideoDecoder === 'undefined')
      return new TraceCutError(
        'unsupported',
        'videos are decoded by WebCodecs, which this browser or page does not have (expected Chrome 94, Firefox 130, Safari 16.4 or newer, and a page by https)',
      );
    const codec = await this.#codec();
    const others = codec.startsWith('avc') ? 'WebM' : 'MP4 (H.264) or WebM';
    return new TraceCutError('codec', `the codec ${codec} cannot be decoded by this browser; convert it to ${others}`);
  }

  async #broken(error: unknown, last: number = -Infinity) {
    if (error instanceof TraceCutError) return error;
    const { times } = await this.#pictures().catch(() => ({ times: new Float64Array() }));
    const done = times.filter((time) => time <= last).length;
    const all = this.#isCut ? '' : ` of ${times.length}`;
    const where = `after frame ${done}${all}${last > -Infinity ? ` (${last.toFixed(3)} s)` : ''}`;
    return new TraceCutError('truncated', `the video breaks off ${where}: the file is cut off or damaged`, {
      cause: error,
    });
  }
}

export type Size = { width: number; height: number };

const sizeOf = ({ displayWidth, displayHeight }: VideoSample): Size => ({ width: displayWidth, height: displayHeight });

/**
 * @param stamps ascending
 * @returns the first place from `from` on that has this time; -1 where none has
 */
function placeOf(stamps: Float64Array, stamp: number, from: number): number {
  let place = from;
  while (place < stamps.length && Number(stamps[place]) < stamp - SLACK) place += 1;
  return place < stamps.length && Number(stamps[place]) <= stamp + SLACK ? place : -1;
}

function upright(sample: VideoSample): ReadFrame {
  if (sample.rotation === 0 && !sample.flip) return { kind: 'image', image: sample.toVideoFrame() };
  const { displayWidth: width, displayHeight: height } = sample;
  const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
  if (!context) throw new TraceCutError('unsupported', 'the browser gave no 2d canvas to turn the frame with');
  sample.draw(context, 0, 0, width, height);
  return { kind: 'pixels', data: new Uint8Array(context.getImageData(0, 0, width, height).data.buffer), width, height };
}

function readable(error: unknown, source: Blob | URL) {
  if (error instanceof TraceCutError) return error;
  if (source instanceof URL && /fetch/i.test(words(error))) {
    return new TraceCutError('fetch', `${source.href} cannot be fetched: ${words(error)}`, { cause: error });
  }
  return new TraceCutError('truncated', 'the file cannot be read: it is cut off or damaged', { cause: error });
}

const words = (error: unknown) => (error instanceof Error ? error.message : String(error));
