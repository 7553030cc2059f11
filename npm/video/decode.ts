// Decoding of packets by WebCodecs, through mediabunny, which knows the faults of browsers' decoders. Of a transparent
// video its colours alone. All frames before damage are given before the error.

import type { EncodedPacket, InputVideoTrack as Track, VideoSample } from 'mediabunny';

/** Later than any frame, in seconds: the time of a packet whose picture is never shown. */
const NEVER = 1e9;

export type Media = typeof import('../vendor/media.js');

/**
 * The frames of a track from a key packet on, in the order in which they are shown; whoever takes them closes them.
 * @param lastPacket sequence number of the last to be decoded, which the container lists: data that ends before is
 *   damage
 */
export async function* decodedFrom(
  media: Media,
  track: Track,
  first: EncodedPacket,
  lastPacket: number,
): AsyncGenerator<VideoSample, void, unknown> {
  setDefaultColours(track);
  const codec = await track.getCodec();
  const fed = new FedPackets(codec, new media.EncodedPacketSink(track).packets(first), lastPacket);
  let last = -Infinity;
  try {
    for await (const sample of decoded(media, track, toShownPacket(codec, first), fed.all())) {
      last = sample.timestamp;
      fed.forgetBefore(last);
      yield sample;
    }
  } catch (error) {
    // A decoder that fails keeps what it has not given yet.
    const good = await findDecodablePackets(media, track, fed.recent);
    for await (const sample of decoded(media, track, good[0], good)) {
      if (sample.timestamp > last) yield sample;
      else sample.close();
    }
    throw error;
  }
  if (fed.fault) throw fed.fault;
  if (fed.lastNumber < lastPacket) throw new Error('no more data');
}

/**
 * Has the decoder take colours of a video that does not say how they are coded by ITU-R BT.601, as ffmpeg does: browsers
 * differ there.
 */
function setDefaultColours(track: Track) {
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

/**
 * The frames of these packets. mediabunny's sink takes packets of the track itself; here it is given others.
 * @param first a key packet
 * @param packets from the first on
 */
function decoded(
  media: Media,
  track: Track,
  first: EncodedPacket | undefined,
  packets: Iterable<EncodedPacket> | AsyncIterable<EncodedPacket>,
): AsyncIterable<VideoSample> {
  const given = { getKeyPacket: async () => first, getFirstKeyPacket: async () => first, packets: () => each(packets) };
  return Object.assign(new media.VideoSampleSink(track), { _createPacketSink: () => given }).samples();
}

async function* each<T>(values: Iterable<T> | AsyncIterable<T>) {
  yield* values;
}

/** Packets on their way to a decoder. */
class FedPackets {
  #codec;
  #packets;
  #lastPacket;
  /** Those from a key packet on that is not after the last frame. */
  recent: EncodedPacket[] = [];
  /** Sequence number of the last one. */
  lastNumber = -1;
  /** What reading them ended with. */
  fault: unknown;

  constructor(codec: string | null, packets: AsyncIterable<EncodedPacket>, lastPacket: number) {
    this.#codec = codec;
    this.#packets = packets;
    this.#lastPacket = lastPacket;
  }

  /** Yields the packets that can be read. */
  async *all(): AsyncGenerator<EncodedPacket, void, unknown> {
    try {
      for await (const packet of this.#packets) {
        this.lastNumber = packet.sequenceNumber;
        const shown = toShownPacket(this.#codec, packet);
        this.recent.push(shown);
        yield shown;
        if (this.lastNumber >= this.#lastPacket) return;
      }
    } catch (error) {
      this.fault = error;
    }
  }

  forgetBefore(time: number) {
    const key = this.recent.findLastIndex((packet) => packet.type === 'key' && packet.timestamp <= time);
    if (key > 0) this.recent.splice(0, key);
  }
}

/**
 * A packet without transparency, which nobody looks at here, and which mediabunny merges in a worker made from text,
 * forbidden by strict security policies. mediabunny gives the n-th frame the n-th time: a hidden one must not count.
 */
function toShownPacket(codec: string | null, packet: EncodedPacket) {
  if (isHidden(codec, packet)) return packet.clone({ timestamp: NEVER, sideData: {} });
  return packet.sideData.alpha ? packet.clone({ sideData: {} }) : packet;
}

/**
 * The packets before the first that the decoder fails at, found by halving.
 * @param packets that it fails at as a whole
 */
async function findDecodablePackets(media: Media, track: Track, packets: EncodedPacket[]) {
  let [good, bad] = [0, packets.length];
  while (bad - good > 1) {
    const middle = Math.floor((good + bad) / 2);
    if (await isDecodable(media, track, packets.slice(0, middle))) good = middle;
    else bad = middle;
  }
  return packets.slice(0, good);
}

async function isDecodable(media: Media, track: Track, packets: EncodedPacket[]) {
  try {
    for await (const sample of decoded(media, track, packets[0], packets)) sample.close();
    return true;
  } catch {
    return false;
  }
}

export interface PictureList {
  /** Times as the container has them, in seconds, ascending. */
  stamps: Float64Array;
  /** The same from 0 on, each later than the one before. */
  times: Float64Array;
  /** When the last picture ends, in seconds. */
  end: number;
  /** Sequence number of the last packet. */
  lastPacket: number;
}

/** Seconds that a picture is shown where nothing says how long. */
const USUAL_SECONDS = 1 / 25;

/**
 * Lists the pictures of a track, without decoding, in the order in which they are shown; of a damaged file those before
 * the damage.
 */
export async function listPictures(media: typeof import('../vendor/media.js'), track: Track): Promise<PictureList> {
  const codec = await track.getCodec();
  const sink = new media.EncodedPacketSink(track);
  const shown: { stamp: number; duration: number }[] = [];
  let [lastPacket, isBegun] = [-1, false];
  try {
    for await (const packet of sink.packets(undefined, undefined, { metadataOnly: codec !== 'vp8' })) {
      lastPacket = packet.sequenceNumber;
      // Before the first key packet nothing can be decoded: a transport stream may begin anywhere.
      isBegun ||= packet.type === 'key';
      if (isBegun && isShown(codec, packet)) shown.push({ stamp: packet.timestamp, duration: packet.duration });
    }
  } catch (error) {
    // Whoever takes its frames comes to the same place, and says where it is.
    if (shown.length === 0) throw error;
  }
  shown.sort((a, b) => a.stamp - b.stamp);
  return { stamps: Float64Array.from(shown, ({ stamp }) => stamp), ...mended(shown), lastPacket };
}

/**
 * A clip that was cut out of another may begin before 0: what ends there is not shown, what reaches beyond is the first
 * that is.
 */
function isShown(codec: string | null, packet: EncodedPacket) {
  const { timestamp, duration } = packet;
  return !isHidden(codec, packet) && (timestamp >= 0 || timestamp + duration > 0);
}

/**
 * VP8 has packets that are looked at by later ones alone (RFC 6386, 9.1: the bit `show_frame`); other codecs have them
 * inside of packets that are shown.
 */
export const isHidden = (codec: string | null, { data }: EncodedPacket) =>
  codec === 'vp8' && data.length > 0 && (Number(data[0]) & 0x10) === 0;

/** Times that increase: a missing or equal one follows after the duration of the picture before. */
function mended(pictures: { stamp: number; duration: number }[]) {
  const times = new Float64Array(pictures.length);
  let end = 0;
  pictures.forEach(({ stamp, duration }, k) => {
    const [time, before] = [Math.max(0, stamp), k > 0 ? Number(times[k - 1]) : -Infinity];
    times[k] = time > before ? time : end;
    const usual = k > 0 ? Number(times[k]) - before : USUAL_SECONDS;
    end = Number(times[k]) + (duration > 0 ? duration : usual);
  });
  return { times, end };
}
