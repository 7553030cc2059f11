// Decoding of packets by WebCodecs, through mediabunny's decoder, which knows the faults of browsers' decoders. Of a
// transparent video its colours alone. All frames before damage are given before the error.

import { isHidden } from './pictures.js';

/** Packets that wait for the decoder, at most, while no frame waits to be taken, and else; as in mediabunny. */
const MOST_AHEAD = { idle: 40, ready: 8 };

/** Milliseconds after which the decoder is looked at again: not every packet that it takes gives a frame. */
const WATCH_MS = 50;

/** Later than any frame, in seconds: the time of a packet whose picture is never shown. */
const NEVER = 1e9;

/** @typedef {import('mediabunny').EncodedPacket} EncodedPacket */
/** @typedef {import('mediabunny').VideoSample} VideoSample */
/**
 * mediabunny's own decoder, as its `VideoSampleSink` makes it.
 * @typedef {{decode: (packet: EncodedPacket) => void, flush: () => Promise<void>, close: () => void, getDecodeQueueSize: () =>
 *   number}} Decoder
 */
/** @typedef {(onSample: (sample: VideoSample) => void, onError: (error: unknown) => void) => Promise<Decoder>} OpenDecoder */

/**
 * The frames of a track from a key packet on, in the order in which they are shown; whoever takes them closes them.
 * @param {typeof import('../vendor/media.js')} media
 * @param {import('mediabunny').InputVideoTrack} track
 * @param {EncodedPacket} first
 * @param {number} lastPacket sequence number of the last that the container lists: data that ends before is damage
 * @returns {AsyncGenerator<VideoSample, void, unknown>}
 */
export async function* decodedFrom(media, track, first, lastPacket) {
  sayColours(track);
  const sink = /** @type {{_createDecoder: OpenDecoder}} */ (/** @type {unknown} */ (new media.VideoSampleSink(track)));
  const openDecoder = sink._createDecoder.bind(sink);
  const packets = shownPackets(await track.getCodec(), new media.EncodedPacketSink(track).packets(first));
  const recent = new RecentPackets();
  const decoding = new Decoding(openDecoder, packets, recent);
  let last = -Infinity;
  try {
    for await (const sample of decoding.samples()) {
      last = sample.timestamp;
      recent.forgetBefore(last);
      yield sample;
    }
  } catch (error) {
    // A decoder that fails keeps what it has not given yet.
    for await (const sample of new Decoding(openDecoder, await decodablePart(openDecoder, recent.packets)).samples()) {
      if (sample.timestamp > last) yield sample;
      else sample.close();
    }
    throw error;
  }
  if (decoding.fault) throw decoding.fault;
  if (recent.lastNumber < lastPacket) throw new Error('no more data');
}

/**
 * Packets without transparency, which nobody looks at here, and which mediabunny merges in a worker made from text,
 * forbidden by strict security policies. mediabunny gives the n-th frame the n-th time: a hidden one must not count.
 * @param {string | null} codec
 * @param {AsyncIterable<EncodedPacket>} packets
 */
async function* shownPackets(codec, packets) {
  for await (const packet of packets) {
    if (isHidden(codec, packet)) yield packet.clone({ timestamp: NEVER, sideData: {} });
    else yield packet.sideData.alpha ? packet.clone({ sideData: {} }) : packet;
  }
}

/**
 * Has the decoder take colours of a video that does not say how they are coded by ITU-R BT.601, as ffmpeg does: browsers
 * differ there.
 * @param {import('mediabunny').InputVideoTrack} track
 */
function sayColours(track) {
  track.getDecoderConfig = async () => {
    const config = await Object.getPrototypeOf(track).getDecoderConfig.call(track);
    const { primaries, transfer, matrix, fullRange } = config.colorSpace ?? {};
    const colorSpace = {
      primaries: primaries ?? 'bt709',
      transfer: transfer ?? 'bt709',
      matrix: matrix ?? 'smpte170m',
      fullRange: fullRange ?? false,
    };
    return { ...config, colorSpace };
  };
}

/** Packets that a decoder was given, from a key packet on that was before the last frame it gave. */
class RecentPackets {
  /** @type {EncodedPacket[]} */
  packets = [];
  lastNumber = -1;

  /** @param {EncodedPacket} packet */
  add(packet) {
    this.packets.push(packet);
    this.lastNumber = packet.sequenceNumber;
  }

  /** @param {number} time of the last frame */
  forgetBefore(time) {
    const key = this.packets.findLastIndex((packet) => packet.type === 'key' && packet.timestamp <= time);
    if (key > 0) this.packets.splice(0, key);
  }
}

/** One run of a decoder. */
class Decoding {
  /** @type {VideoSample[]} */
  #ready = [];
  #bell = new Bell();
  #openDecoder;
  #packets;
  #recent;
  #isFed = false;
  #isLeft = false;
  /** What the decoder failed with. @type {unknown} */
  #failed;
  /** What the packets ended with, after whose frames. @type {unknown} */
  fault;

  /**
   * @param {OpenDecoder} openDecoder
   * @param {AsyncIterable<EncodedPacket> | EncodedPacket[]} packets
   * @param {RecentPackets} [recent] filled with packets that the decoder takes
   */
  constructor(openDecoder, packets, recent) {
    this.#openDecoder = openDecoder;
    this.#packets = packets;
    this.#recent = recent;
  }

  /** @returns {AsyncGenerator<VideoSample, void, unknown>} */
  async *samples() {
    const fail = (/** @type {unknown} */ error) => {
      this.#failed ??= error;
      this.#bell.ring();
    };
    const decoder = await this.#openDecoder((sample) => {
      this.#ready.push(sample);
      this.#bell.ring();
    }, fail);
    void this.#feed(decoder)
      .catch(fail)
      .finally(() => {
        this.#isFed = true;
        this.#bell.ring();
      });
    try {
      for (;;) {
        const sample = this.#ready.shift();
        if (sample) {
          this.#bell.ring();
          yield sample;
        } else if (this.#failed) throw this.#failed;
        else if (this.#isFed) return;
        else await this.#bell.rung();
      }
    } finally {
      this.#isLeft = true;
      this.#bell.ring();
      decoder.close();
      for (const sample of this.#ready) sample.close();
    }
  }

  /** @param {Decoder} decoder */
  async #feed(decoder) {
    try {
      for await (const packet of this.#packets) {
        while (this.#isFull(decoder) && !this.#isOver) await this.#bell.rung(WATCH_MS);
        if (this.#isOver) return;
        this.#recent?.add(packet);
        decoder.decode(packet);
      }
    } catch (error) {
      this.fault = error;
    }
    if (!this.#isOver) await decoder.flush();
  }

  /** @param {Decoder} decoder */
  #isFull(decoder) {
    const count = this.#ready.length;
    return count + decoder.getDecodeQueueSize() > (count > 0 ? MOST_AHEAD.ready : MOST_AHEAD.idle);
  }

  get #isOver() {
    return this.#isLeft || this.#failed !== undefined;
  }
}

/**
 * The packets before the first that the decoder fails at, found by halving.
 * @param {OpenDecoder} openDecoder
 * @param {EncodedPacket[]} packets that it fails at as a whole
 */
async function decodablePart(openDecoder, packets) {
  let [good, bad] = [0, packets.length];
  while (bad - good > 1) {
    const middle = Math.floor((good + bad) / 2);
    if (await isDecodable(openDecoder, packets.slice(0, middle))) good = middle;
    else bad = middle;
  }
  return packets.slice(0, good);
}

/**
 * @param {OpenDecoder} openDecoder
 * @param {EncodedPacket[]} packets
 */
async function isDecodable(openDecoder, packets) {
  try {
    for await (const sample of new Decoding(openDecoder, packets).samples()) sample.close();
    return true;
  } catch {
    return false;
  }
}

/** Lets several wait for the next change. */
class Bell {
  #ring = () => {};
  /** @type {Promise<void>} */
  #next = this.#begin();

  #begin() {
    return new Promise((/** @type {(value: void) => void} */ resolve) => (this.#ring = resolve));
  }

  ring() {
    this.#ring();
    this.#next = this.#begin();
  }

  /** @param {number} [most] milliseconds */
  async rung(most) {
    if (most === undefined) return this.#next;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    let limit;
    await Promise.race([this.#next, new Promise((resolve) => (limit = setTimeout(resolve, most)))]);
    clearTimeout(limit);
  }
}
