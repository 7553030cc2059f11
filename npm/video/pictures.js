// The pictures of a video track as its container lists them: when each is shown, and for how long.

/**
 * @typedef {object} PictureList
 * @property {Float64Array} stamps times as the container has them, in seconds, ascending
 * @property {Float64Array} times the same from 0 on, each later than the one before
 * @property {number} end when the last picture ends, in seconds
 * @property {number} lastPacket sequence number of the last packet
 */

/** Seconds that a picture is shown where nothing says how long. */
const USUAL_SECONDS = 1 / 25;

/**
 * Lists the pictures of a track, without decoding, in the order in which they are shown; of a damaged file those before
 * the damage.
 * @param {typeof import('../vendor/media.js')} media
 * @param {import('mediabunny').InputVideoTrack} track
 * @returns {Promise<PictureList>}
 */
export async function listPictures(media, track) {
  const codec = await track.getCodec();
  const sink = new media.EncodedPacketSink(track);
  /** @type {{stamp: number, duration: number}[]} */
  const shown = [];
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
 * @param {string | null} codec
 * @param {import('mediabunny').EncodedPacket} packet
 */
function isShown(codec, packet) {
  const { timestamp, duration } = packet;
  return !isHidden(codec, packet) && (timestamp >= 0 || timestamp + duration > 0);
}

/**
 * VP8 has packets that are looked at by later ones alone (RFC 6386, 9.1: the bit `show_frame`); other codecs have them
 * inside of packets that are shown.
 * @param {string | null} codec
 * @param {import('mediabunny').EncodedPacket} packet
 */
export const isHidden = (codec, { data }) => codec === 'vp8' && data.length > 0 && (Number(data[0]) & 0x10) === 0;

/**
 * Times that increase: a missing or equal one follows after the duration of the picture before.
 * @param {{stamp: number, duration: number}[]} pictures
 */
function mended(pictures) {
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
