// Reads the container of video files, whose frames WebCodecs decodes: each picture exactly once, with its own time.

import { TraceCutError } from '../check/errors.js';
import { computeFrameRate } from '../check/masks.js';
import { loadPart } from '../platform.js';
import { type PictureList, decodeFrom, listPictures } from './decode.js';
import { type ReadFrame, stretchFrame } from './pixels.js';
import type { Reader, TimedFrame } from './reader.js';
import type { EncodedPacket, Input, InputVideoTrack, VideoSample } from 'mediabunny';

export type Media = typeof import('../vendor/media.js');

/** Retries of a lost connection, one second apart. */
const RETRIES = 2;

/** Largest difference between equal times, in seconds: far above rounding, far below the spacing of pictures. */
const SAME_TIME_S = 1e-6;

/** Most key pictures at which decoding is tried: a captured stream may begin with a broken one, which is no damage. */
const MAX_TRIES = 5;

/** Error of data that end too early. */
const END_OF_DATA = new Error('no more data');

/** Makes mediabunny inspect key packets, as containers are often wrong about them. */
const VERIFIED = { verifyKeyPackets: true };

/**
 * Opens a file's container; null if its format is unknown.
 * @param isCut true if the file is the undamaged part of a longer one
 */
export async function openDemuxed(source: Blob | URL, isCut = false): Promise<Reader | null> {
  const media = await loadPart(import('../vendor/media.js'));
  const input = createInput(media, source);
  try {
    if (!(await input.canRead())) {
      input.dispose();
      return null;
    }
    const track = await chooseTrack(media, input);
    if (track) return new TrackReader(media, input, track, isCut);
    throw await createNoVideoError(media, input);
  } catch (error) {
    input.dispose();
    throw toReadError(error, source);
  }
}

async function createNoVideoError(media: Media, input: Input) {
  const hasSound = (await input.getAudioTracks()).length > 0;
  const mayLackIndex = [media.MP4, media.QTFF].includes(await input.getFormat());
  if (hasSound || !mayLackIndex)
    return new TraceCutError('no-video', `the file has no video track${hasSound ? ', only sound' : ''}`);
  const message = 'the file is cut off: the index, which MP4 files may have at their end, is missing';
  return new TraceCutError('truncated', message, { frames: 0 });
}

function createInput(media: Media, source: Blob | URL) {
  const handleUnhandledError = () => {};
  const getRetryDelay = (attempts: number) => (attempts > RETRIES ? null : 1);
  const isAddress = source instanceof URL;
  return new media.Input({
    source: isAddress
      ? new media.UrlSource(source, { getRetryDelay, handleUnhandledError })
      : new media.BlobSource(source, { handleUnhandledError }),
    // A playlist in a file cannot be resolved.
    formats: isAddress ? media.ALL_FORMATS : media.ALL_FORMATS.filter((format) => format !== media.HLS),
  });
}

/**
 * Chooses the default track that has more than one picture, else the largest that has, else any: a track of one picture is
 * a cover.
 */
async function chooseTrack(media: Media, input: Input) {
  const tracks = await input.getVideoTracks();
  const clips = await filterAsync(tracks, (track) => hasSeveralPictures(media, track));
  const candidates = clips.length > 0 ? clips : tracks;
  // A transport stream has no default track.
  const hasDefaults = (await input.getFormat()) !== media.MPEG_TS;
  const [preferred] = hasDefaults
    ? await filterAsync(candidates, async (track) => (await track.getDisposition()).default)
    : [];
  if (preferred) return preferred;
  const areas = await Promise.all(
    candidates.map(async (track) => (await track.getDisplayWidth()) * (await track.getDisplayHeight())),
  );
  return candidates[areas.indexOf(Math.max(...areas))];
}

async function filterAsync<T>(values: T[], test: (value: T) => Promise<boolean>) {
  const results = await Promise.all(values.map(test));
  return values.filter((_, k) => results[k]);
}

async function hasSeveralPictures(media: Media, track: InputVideoTrack) {
  const sink = new media.EncodedPacketSink(track);
  const first = await sink.getFirstPacket({ metadataOnly: true });
  return first !== null && (await sink.getNextPacket(first, { metadataOnly: true })) !== null;
}

/** Reads the frames of a track of a container. */
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
    const { times, end } = await this.#listPictures();
    const decodable = await this.#isDecodable();
    const { width, height } = await (decodable ? this.#readFirstSize() : this.#readContainerSize());
    if (this.#isCut) this.damage = await this.#createDamageError(END_OF_DATA, times.at(-1));
    const numFrames = times.length;
    const duration = numFrames > 0 ? end - Number(times[0]) : 0;
    const frameRate = computeFrameRate(numFrames, duration);
    return { width, height, duration, frameRate, numFrames, codec: await this.#readCodec(), decodable };
  }

  async times() {
    return (await this.#listPictures()).times;
  }

  /** @param range in seconds */
  async *frames({ start, end }: { start: number; end: number }): AsyncGenerator<TimedFrame, void, unknown> {
    const { times, stamps } = await this.#listPictures();
    const begin = times.findIndex((time) => time >= start - SAME_TIME_S);
    if (begin < 0) return;
    const sink = new this.#media.EncodedPacketSink(this.#track);
    const key = begin > 0 ? await sink.getKeyPacket(Number(stamps[begin]), VERIFIED) : null;
    for await (const frame of this.#framesFrom(key)) {
      if (frame.time >= end) return frame.close();
      yield frame;
    }
  }

  /**
   * Yields the frames at these times. Packets between two times are decoded once, or not at all if a later picture does not
   * depend on them.
   * @param wanted times of frames, ascending
   */
  async *framesAt(requestedTimes: number[]): AsyncGenerator<TimedFrame, void, unknown> {
    for (const { key, until, times } of await this.#groupByKey(requestedTimes)) {
      let next = 0;
      for await (const frame of this.#framesFrom(key, until)) {
        if (frame.time < Number(times[next]) - SAME_TIME_S) {
          frame.close();
          continue;
        }
        yield frame;
        next += 1;
        if (next === times.length) break;
      }
      if (next < times.length) throw await this.#createDamageError(END_OF_DATA, times[next]);
    }
  }

  /** Groups times by the key packet at which decoding begins; `until` is the number of the last packet needed. */
  async #groupByKey(requestedTimes: number[]) {
    const { times, stamps } = await this.#listPictures();
    const sink = new this.#media.EncodedPacketSink(this.#track);
    const groups: { key: EncodedPacket | null; until: number; times: number[] }[] = [];
    for (const time of requestedTimes) {
      const stamp = Number(stamps[times.findIndex((other) => other >= time - SAME_TIME_S)]);
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
   * @param until number of the last packet needed
   */
  async *#framesFrom(key: EncodedPacket | null, until: number = Infinity): AsyncGenerator<TimedFrame, void, unknown> {
    if (!(await this.#isDecodable())) throw await this.#createCodecError();
    let last = -Infinity;
    let first = key ?? (await this.#nextKey(null));
    for (let tries = key ? 1 : MAX_TRIES; first; tries -= 1) {
      try {
        for await (const frame of this.#framesAfter(first, until, !key)) {
          last = frame.time;
          yield frame;
        }
        break;
      } catch (error) {
        first = last > -Infinity || tries === 1 ? null : await this.#nextKey(first);
        if (!first) throw await this.#createDamageError(error, last);
      }
    }
    if (this.#isCut && until === Infinity) throw await this.#createDamageError(END_OF_DATA, last);
  }

  #nextKey(packet: EncodedPacket | null) {
    const sink = new this.#media.EncodedPacketSink(this.#track);
    return packet ? sink.getNextKeyPacket(packet, VERIFIED) : sink.getFirstKeyPacket(VERIFIED);
  }

  /** @param isBeginning true if no picture comes before */
  async *#framesAfter(
    first: EncodedPacket,
    until: number,
    isBeginning: boolean,
  ): AsyncGenerator<TimedFrame, void, unknown> {
    const { stamps, times, end, lastPacket } = await this.#listPictures();
    let index = -1;
    for await (const sample of decodeFrom(this.#media, this.#track, first, Math.min(until, lastPacket))) {
      const next = findStamp(stamps, sample.timestamp, index + 1);
      if (next < 0) {
        sample.close();
        continue;
      }
      index = next;
      const time = Number(times[index]);
      // Not every container has durations; all have the time of the next frame.
      const duration = (index + 1 < times.length ? Number(times[index + 1]) : end) - time;
      if (isBeginning) this.#size ??= getDisplaySize(sample);
      yield { time, duration, read: () => this.#read(sample), close: () => sample.close() };
    }
  }

  async #read(sample: VideoSample) {
    const { width, height } = await this.#getShownSize(sample);
    const raw = toUpright(sample);
    return sample.displayWidth === width && sample.displayHeight === height ? raw : stretchFrame(raw, width, height);
  }

  /** Returns the size of the first picture. A picture of the size in the container is assumed to have that size. */
  async #getShownSize(sample: VideoSample) {
    if (!this.#size) {
      const { width, height } = await this.#readContainerSize();
      if (sample.displayWidth === width && sample.displayHeight === height) return { width, height };
    }
    return this.#readFirstSize();
  }

  async #readFirstSize(): Promise<Size> {
    try {
      if (!this.#size)
        for await (const frame of this.#framesFrom(null)) {
          frame.close();
          break;
        }
    } catch {
      // The error is thrown to callers that read frames.
    }
    return this.#size ?? this.#readContainerSize();
  }

  async #readContainerSize() {
    return { width: await this.#track.getDisplayWidth(), height: await this.#track.getDisplayHeight() };
  }

  #listPictures() {
    return (this.#listing ??= listPictures(this.#media, this.#track));
  }

  async #readCodec() {
    const track = this.#track;
    return (await track.getCodecParameterString()) ?? String((await track.getInternalCodecId()) ?? 'unknown');
  }

  async #isDecodable() {
    return typeof VideoDecoder !== 'undefined' && (await this.#track.canDecode());
  }

  async #createCodecError() {
    if (typeof VideoDecoder === 'undefined')
      return new TraceCutError(
        'unsupported',
        'decoding videos needs WebCodecs (Chrome 94, Firefox 130, Safari 16.4 or newer, and a page served by https)',
      );
    const codec = await this.#readCodec();
    const alternatives = codec.startsWith('avc') ? 'WebM' : 'MP4 (H.264) or WebM';
    return new TraceCutError(
      'codec',
      `the codec ${codec} cannot be decoded by this browser; convert it to ${alternatives}`,
    );
  }

  async #createDamageError(error: unknown, last: number = -Infinity) {
    if (error instanceof TraceCutError) return error;
    const { times } = await this.#listPictures().catch(() => ({ times: new Float64Array() }));
    const numFrames = times.filter((time) => time <= last).length;
    const total = this.#isCut ? '' : ` of ${times.length}`;
    const place = `after frame ${numFrames}${total}${last > -Infinity ? ` (${last.toFixed(3)} s)` : ''}`;
    return new TraceCutError('truncated', `the video breaks off ${place}: the file is cut off or damaged`, {
      cause: error,
    });
  }
}

export type Size = { width: number; height: number };

const getDisplaySize = ({ displayWidth, displayHeight }: VideoSample): Size => ({
  width: displayWidth,
  height: displayHeight,
});

/**
 * @param stamps ascending
 * @returns the first index from `from` on with this time; -1 if there is none
 */
function findStamp(stamps: Float64Array, stamp: number, from: number): number {
  let index = from;
  while (index < stamps.length && Number(stamps[index]) < stamp - SAME_TIME_S) index += 1;
  return index < stamps.length && Number(stamps[index]) <= stamp + SAME_TIME_S ? index : -1;
}

function toUpright(sample: VideoSample): ReadFrame {
  if (sample.rotation === 0 && !sample.flip) return { kind: 'image', image: sample.toVideoFrame() };
  const { displayWidth: width, displayHeight: height } = sample;
  const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
  if (!context) throw new TraceCutError('unsupported', 'the browser cannot create a 2D canvas');
  sample.draw(context, 0, 0, width, height);
  return { kind: 'pixels', data: new Uint8Array(context.getImageData(0, 0, width, height).data.buffer), width, height };
}

function toReadError(error: unknown, source: Blob | URL) {
  if (error instanceof TraceCutError) return error;
  if (source instanceof URL && /fetch/i.test(getMessage(error))) {
    return new TraceCutError('fetch', `${source.href} cannot be fetched: ${getMessage(error)}`, { cause: error });
  }
  return new TraceCutError('truncated', 'the file cannot be read: it is cut off or damaged', { cause: error });
}

const getMessage = (error: unknown) => (error instanceof Error ? error.message : String(error));
