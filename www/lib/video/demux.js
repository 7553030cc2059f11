// Video files whose container is read here and whose frames WebCodecs decodes: each frame exactly once, with its own
// time.

import { TraceCutError } from '../check/errors.js';
import { part } from '../places.js';
import { readAndClose } from './pixels.js';

/** @typedef {import('./reader.js').VideoInfo} VideoInfo */

/** A lost connection is tried again so often, with a second between. */
const RETRIES = 2;

/** What times may differ by. */
const SLACK = 1e-6;

/** Frames looked at to find the frame rate. */
const PROBED = 256;

/**
 * @typedef {import('./reader.js').Reader & {decodable: boolean, codec: string}} Demuxed
 */

/**
 * Opens a file's container; null when it is of no known kind, or nothing in it is.
 * @param {Blob | URL} source
 * @returns {Promise<Demuxed | null>}
 */
export async function openDemuxed(source) {
  const media = await part(import('../vendor/media.js'));
  const input = new media.Input({ source: sourceOf(media, source), formats: media.ALL_FORMATS });
  try {
    if (!(await input.canRead())) {
      input.dispose();
      return null;
    }
    const track = await input.getPrimaryVideoTrack();
    if (track) return await demuxed(media, input, track);
    if ((await input.getAudioTracks()).length)
      throw new TraceCutError('no-video', 'the file has no video track, only sound');
    // Perhaps one that is not known here, but to the browser's player.
    input.dispose();
    return null;
  } catch (error) {
    input.dispose();
    throw readable(error, source);
  }
}

/**
 * @param {typeof import('../vendor/media.js')} media
 * @param {Blob | URL} source
 */
function sourceOf(media, source) {
  if (!(source instanceof URL)) return new media.BlobSource(source, { handleUnhandledError: () => {} });
  return new media.UrlSource(source, {
    getRetryDelay: (attempts) => (attempts > RETRIES ? null : 1),
    handleUnhandledError: () => {},
  });
}

/**
 * @param {typeof import('../vendor/media.js')} media
 * @param {import('mediabunny').Input} input
 * @param {import('mediabunny').InputVideoTrack} track
 * @returns {Promise<Demuxed>}
 */
async function demuxed(media, input, track) {
  const codec = (await track.getCodecParameterString()) ?? String((await track.getInternalCodecId()) ?? 'unknown');
  // Transparency is merged in a worker made from text, which a strict security policy forbids, and nobody looks at it
  // here.
  const decodable =
    typeof VideoDecoder !== 'undefined' && !(await track.canBeTransparent()) && (await track.canDecode());
  /** @type {Promise<PacketList> | undefined} */
  let list;
  const packets = () => (list ??= packetList(new media.EncodedPacketSink(track)));
  return {
    codec,
    decodable,
    async info() {
      const { times, end } = await packets();
      const { bestGuessFrameRate } = await track.computeFrameRateMetrics({ targetPacketCount: PROBED });
      return {
        width: await track.getDisplayWidth(),
        height: await track.getDisplayHeight(),
        duration: times.length ? end - /** @type {number} */ (times[0]) : 0,
        frameRate: times.length > 1 ? bestGuessFrameRate : NaN,
        numFrames: times.length,
        codec,
        decodable,
      };
    },
    async times() {
      return (await packets()).times;
    },
    frames: (range) => decodedFrames(media, track, range, packets),
    at: (times) => framesAt(media, track, times, packets),
    close: () => input.dispose(),
  };
}

/** @typedef {{times: Float64Array, end: number}} PacketList */

/**
 * The times of all frames as the container lists them, in the order in which they are shown.
 * @param {import('mediabunny').EncodedPacketSink} sink
 * @returns {Promise<PacketList>}
 */
async function packetList(sink) {
  /** @type {number[]} */
  const times = [];
  let end = 0;
  for await (const { timestamp, duration } of sink.packets(undefined, undefined, { metadataOnly: true })) {
    if (unseen(timestamp, duration)) continue;
    times.push(Math.max(0, timestamp));
    end = Math.max(end, timestamp + duration);
  }
  const sorted = Float64Array.from(times).sort();
  // The last frame of a recording may last nothing; taken to last as long as the one before.
  const count = sorted.length;
  if (count > 1 && end <= at(sorted, count - 1)) end = 2 * at(sorted, count - 1) - at(sorted, count - 2);
  return { times: sorted, end };
}

/**
 * @param {Float64Array} values
 * @param {number} index
 */
function at(values, index) {
  return values[index] ?? NaN;
}

/**
 * @param {typeof import('../vendor/media.js')} media
 * @param {import('mediabunny').InputVideoTrack} track
 * @param {{start: number, end: number}} range
 * @param {() => Promise<PacketList>} packets
 * @returns {AsyncGenerator<import('./reader.js').TimedFrame, void, unknown>}
 */
async function* decodedFrames(media, track, { start, end }, packets) {
  const { times, end: clipEnd } = await packets();
  let next = 0;
  let last = -Infinity;
  /** @type {AsyncGenerator<import('mediabunny').VideoSample, void, unknown>} */
  const samples = new media.VideoSampleSink(track).samples(start, end);
  try {
    for await (const sample of samples) {
      if (unseen(sample.timestamp, sample.duration)) {
        sample.close();
        continue;
      }
      last = Math.max(0, sample.timestamp);
      while (next < times.length && at(times, next) <= last + SLACK) next += 1;
      // Not every container says how long its frames last; all say when the next one comes.
      const duration = (next < times.length ? at(times, next) : clipEnd) - last;
      yield {
        time: last,
        duration,
        read: (size) => pixelsOf(sample, size),
        close: () => sample.close(),
      };
    }
  } catch (error) {
    throw await broken(error, last, packets);
  }
  const final = times.findLast((time) => time < end);
  if (final !== undefined && final > start && final > last + SLACK) throw await broken('no more data', last, packets);
}

/**
 * Packets between two times are decoded once, and not at all where a later one can be decoded without them.
 * @param {typeof import('../vendor/media.js')} media
 * @param {import('mediabunny').InputVideoTrack} track
 * @param {number[]} times of frames, ascending
 * @param {() => Promise<PacketList>} packets
 * @returns {AsyncGenerator<import('./reader.js').TimedFrame, void, unknown>}
 */
async function* framesAt(media, track, times, packets) {
  const { times: all, end } = await packets();
  let last = -Infinity;
  try {
    for await (const sample of new media.VideoSampleSink(track).samplesAtTimestamps(times)) {
      if (!sample) throw new Error('no more data');
      last = Math.max(0, sample.timestamp);
      const next = all.find((time) => time > last + SLACK) ?? end;
      yield {
        time: last,
        duration: next - last,
        read: (size) => pixelsOf(sample, size),
        close: () => sample.close(),
      };
    }
  } catch (error) {
    throw await broken(error, last, packets);
  }
}

/**
 * A clip that was cut out of another may begin before 0: what ends there is not shown, what reaches beyond is the first
 * that is.
 * @param {number} timestamp
 * @param {number} duration
 */
const unseen = (timestamp, duration) => timestamp < 0 && timestamp + duration <= 0;

/**
 * @param {import('mediabunny').VideoSample} sample
 * @param {number} [size]
 * @returns {Promise<import('../worker/frames.js').RawFrame>}
 */
async function pixelsOf(sample, size) {
  if (sample.rotation === 0 && !sample.flip) return readAndClose(sample.toVideoFrame(), size);
  const { displayWidth: width, displayHeight: height } = sample;
  const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
  if (!context) throw new TraceCutError('unsupported', 'the browser gave no 2d canvas to turn the frame with');
  sample.draw(context, 0, 0, width, height);
  return { kind: 'pixels', data: new Uint8Array(context.getImageData(0, 0, width, height).data.buffer), width, height };
}

/**
 * @param {unknown} error
 * @param {number} last
 * @param {() => Promise<PacketList>} packets
 */
async function broken(error, last, packets) {
  if (error instanceof TraceCutError) return error;
  const list = await packets().catch(() => null);
  const done = list ? list.times.filter((time) => time <= last).length : 0;
  const where = list ? `after frame ${done} of ${list.times.length}` : 'in the middle';
  return new TraceCutError(
    'truncated',
    `the video breaks off ${where}${last > -Infinity ? ` (${last.toFixed(3)} s)` : ''}: the file is cut off or damaged (${words(error)})`,
    { cause: error },
  );
}

/**
 * @param {unknown} error
 * @param {Blob | URL} source
 */
function readable(error, source) {
  if (error instanceof TraceCutError) return error;
  if (source instanceof URL && /fetch/i.test(words(error))) {
    return new TraceCutError('fetch', `${source.href} cannot be fetched: ${words(error)}`, { cause: error });
  }
  return new TraceCutError('truncated', `the file cannot be read: it is cut off or damaged (${words(error)})`, {
    cause: error,
  });
}

/** @param {unknown} error */
const words = (error) => (error instanceof Error ? error.message : String(error));
