// Decodes packets with WebCodecs through mediabunny, which works around faults of browsers' decoders. Transparent videos
// yield their colours only. All frames before damage are yielded before the error.

import type { EncodedPacket, InputVideoTrack as Track, VideoSample } from 'mediabunny';

/** Time of a packet whose picture is never shown, in seconds: later than any frame. */
const NEVER_S = 1e9;

export type Media = typeof import('../vendor/media.js');

/**
 * Decodes the frames of a track from a key packet on, in display order; the caller closes them.
 * @param lastPacket sequence number of the last packet to decode, which the container lists: data that end earlier are
 *   damaged
 */
export async function* decodeFrom(
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
    for await (const sample of decodePackets(media, track, toShownPacket(codec, first), fed.read())) {
      last = sample.timestamp;
      fed.dropBefore(last);
      yield sample;
    }
  } catch (error) {
    // A decoder that fails withholds the frames that it has not output yet.
    const decodable = await findDecodablePackets(media, track, fed.recent);
    for await (const sample of decodePackets(media, track, decodable[0], decodable)) {
      if (sample.timestamp > last) yield sample;
      else sample.close();
    }
    throw error;
  }
  if (fed.fault) throw fed.fault;
  if (fed.lastNumber < lastPacket) throw new Error('no more data');
}

/**
 * Makes the decoder assume ITU-R BT.601 for a video that does not specify its colour space, as ffmpeg does: browsers
 * differ.
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
 * Decodes packets. mediabunny's sink takes packets of the track itself; here it is given others.
 * @param first a key packet
 * @param packets from the first on
 */
function decodePackets(
  media: Media,
  track: Track,
  first: EncodedPacket | undefined,
  packets: Iterable<EncodedPacket> | AsyncIterable<EncodedPacket>,
): AsyncIterable<VideoSample> {
  const packetSink = {
    getKeyPacket: async () => first,
    getFirstKeyPacket: async () => first,
    packets: () => iterate(packets),
  };
  return Object.assign(new media.VideoSampleSink(track), { _createPacketSink: () => packetSink }).samples();
}

async function* iterate<T>(values: Iterable<T> | AsyncIterable<T>) {
  yield* values;
}

/** Records the packets passed to a decoder. */
class FedPackets {
  #codec;
  #packets;
  #lastPacket;
  /** Packets since the last key packet that is not after the last frame. */
  recent: EncodedPacket[] = [];
  /** Sequence number of the last packet. */
  lastNumber = -1;
  /** Error that ended reading. */
  fault: unknown;

  constructor(codec: string | null, packets: AsyncIterable<EncodedPacket>, lastPacket: number) {
    this.#codec = codec;
    this.#packets = packets;
    this.#lastPacket = lastPacket;
  }

  /** Yields the packets that can be read. */
  async *read(): AsyncGenerator<EncodedPacket, void, unknown> {
    try {
      for await (const packet of this.#packets) {
        this.lastNumber = packet.sequenceNumber;
        const shownPacket = toShownPacket(this.#codec, packet);
        this.recent.push(shownPacket);
        yield shownPacket;
        if (this.lastNumber >= this.#lastPacket) return;
      }
    } catch (error) {
      this.fault = error;
    }
  }

  dropBefore(time: number) {
    const key = this.recent.findLastIndex((packet) => packet.type === 'key' && packet.timestamp <= time);
    if (key > 0) this.recent.splice(0, key);
  }
}

/**
 * Removes the alpha of a packet, which is not used here, as mediabunny merges it in a worker made from text, forbidden by
 * strict security policies. As mediabunny gives the n-th frame the n-th time, a hidden packet gets a time that never comes.
 */
function toShownPacket(codec: string | null, packet: EncodedPacket) {
  if (isHidden(codec, packet)) return packet.clone({ timestamp: NEVER_S, sideData: {} });
  return packet.sideData.alpha ? packet.clone({ sideData: {} }) : packet;
}

/**
 * Returns the packets before the first that the decoder fails at, found by bisection.
 * @param packets that it fails at as a whole
 */
async function findDecodablePackets(media: Media, track: Track, packets: EncodedPacket[]) {
  let [numGood, numBad] = [0, packets.length];
  while (numBad - numGood > 1) {
    const middle = Math.floor((numGood + numBad) / 2);
    if (await isDecodable(media, track, packets.slice(0, middle))) numGood = middle;
    else numBad = middle;
  }
  return packets.slice(0, numGood);
}

async function isDecodable(media: Media, track: Track, packets: EncodedPacket[]) {
  try {
    for await (const sample of decodePackets(media, track, packets[0], packets)) sample.close();
    return true;
  } catch {
    return false;
  }
}

export interface PictureList {
  /** Times in the container, in seconds, ascending. */
  stamps: Float64Array;
  /** Times from 0 on, each later than the one before. */
  times: Float64Array;
  /** Time at which the last picture ends, in seconds. */
  end: number;
  /** Sequence number of the last packet. */
  lastPacket: number;
}

/** Duration of a picture without one, in seconds. */
const DEFAULT_DURATION_S = 1 / 25;

/** Lists the pictures of a track without decoding, in display order; of a damaged file those before the damage. */
export async function listPictures(media: typeof import('../vendor/media.js'), track: Track): Promise<PictureList> {
  const codec = await track.getCodec();
  const sink = new media.EncodedPacketSink(track);
  const pictures: { stamp: number; duration: number }[] = [];
  let [lastPacket, isBegun] = [-1, false];
  try {
    for await (const packet of sink.packets(undefined, undefined, { metadataOnly: codec !== 'vp8' })) {
      lastPacket = packet.sequenceNumber;
      // Nothing can be decoded before the first key packet: a transport stream may begin anywhere.
      isBegun ||= packet.type === 'key';
      if (isBegun && isShown(codec, packet)) pictures.push({ stamp: packet.timestamp, duration: packet.duration });
    }
  } catch (error) {
    // Reading the frames fails at the same place, with an error that names it.
    if (pictures.length === 0) throw error;
  }
  pictures.sort((a, b) => a.stamp - b.stamp);
  return { stamps: Float64Array.from(pictures, ({ stamp }) => stamp), ...repairTimes(pictures), lastPacket };
}

/**
 * Returns true if a packet's picture is shown. A clip cut out of another may begin before 0: pictures that end there are
 * not shown, the first that extends beyond is.
 */
function isShown(codec: string | null, packet: EncodedPacket) {
  const { timestamp, duration } = packet;
  return !isHidden(codec, packet) && (timestamp >= 0 || timestamp + duration > 0);
}

/**
 * Returns true for a packet of VP8 that is only a reference for later ones (RFC 6386, 9.1: the bit `show_frame`); other
 * codecs pack these with shown pictures.
 */
const isHidden = (codec: string | null, { data }: EncodedPacket) =>
  codec === 'vp8' && data.length > 0 && (Number(data[0]) & 0x10) === 0;

/** Makes times increase: a missing or equal time follows after the duration of the picture before. */
function repairTimes(pictures: { stamp: number; duration: number }[]) {
  const times = new Float64Array(pictures.length);
  let end = 0;
  pictures.forEach(({ stamp, duration }, k) => {
    const [time, before] = [Math.max(0, stamp), k > 0 ? Number(times[k - 1]) : -Infinity];
    times[k] = time > before ? time : end;
    const fallback = k > 0 ? Number(times[k]) - before : DEFAULT_DURATION_S;
    end = Number(times[k]) + (duration > 0 ? duration : fallback);
  });
  return { times, end };
}
