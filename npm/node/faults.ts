// Locates damage: the first decoded picture that must not be yielded. `cli/src/ffmpeg/faults.rs` does the same.

import { type Track, listShownPictures } from './listing.js';
import type { Message, ShownPicture } from './log.js';

/** Times that differ by less are equal, in seconds: far below the spacing of pictures, far above rounding. */
const SAME_TIME_S = 1e-6;

/** Factor from the step before; longer steps between pictures may have lost pictures in them. Chosen by eye. */
const LONG_STEP_FACTOR = 1.5;

/** Demuxers that cut packets out of a stream. */
const STREAM_DEMUXERS = ['mpegts', 'mpeg'];

/**
 * Compares decoded pictures with the packets of the file. Four things are damage:
 *
 * - a decoded picture that the decoder calls faulty;
 * - a packet that is not whole: pictures from its time on;
 * - a packet that could not be decoded: pictures after the first listed time without a picture. Packets before the first
 *   picture may fail, as where a recording begins between two key pictures;
 * - a file that could not be read on: pictures of the packets after that place, or what the end lacks. Some pictures before
 *   that place are shown later than lost ones, so times must not jump there.
 */
export class FaultFinder {
  #packets;
  /** Pictures in display order. */
  #listed;
  /** Pictures from one of these times on are damaged. */
  #damageTimes;
  #isCutOff;
  /** Pictures later than this may follow lost ones, in seconds. */
  #jumpTime = Infinity;
  #numRead = 0;
  #numDecoded = 0;
  #numFailed = 0;
  /** Numbers of decoded pictures. */
  #faulty = new Set<number>();
  /** Number of listed times before the first picture. */
  #numBeforeFirst = 0;
  #lastTime: number | null = null;
  #lastStep = Infinity;

  constructor(track: Track, demuxer: string) {
    const { packets } = track;
    this.#packets = packets;
    this.#listed = listShownPictures(track);
    // Where packets are cut out of a stream, each is complete, and takes over its mark, when the next begins.
    const late = STREAM_DEMUXERS.includes(demuxer) ? 1 : 0;
    const corruptPackets = packets.flatMap(({ isCorrupt }, index) => (isCorrupt ? [index + late] : []));
    this.#damageTimes = corruptPackets.flatMap((index) => packets[index]?.time ?? []);
    this.#isCutOff = corruptPackets.includes(packets.length);
  }

  /** Processes a message; messages come in the order of the log. */
  take(message: Message) {
    if (message.kind === 'packet-read') this.#numRead += 1;
    if (message.kind === 'decoded') this.#numDecoded += 1;
    if (message.kind === 'faulty') this.#faulty.add(this.#numDecoded);
    if (message.kind === 'decoding-failed') this.#numFailed += 1;
    if (message.kind === 'reading-failed') this.#takeReadingFailure(message.isEnd);
  }

  #takeReadingFailure(isEnd: boolean) {
    // ffmpeg probes the first packets before it reports one. A place among them is unknown.
    if (this.#numRead === 0 && !isEnd) return;
    const place = this.#numRead || this.#packets.length;
    const later = this.#packets.slice(place).flatMap(({ isShown, time }) => (isShown ? (time ?? []) : []));
    if (later.length > 0) this.#damageTimes.push(later.reduce((least, time) => Math.min(least, time)));
    else this.#isCutOff = true;
    // No lost picture is shown before its decoding time.
    const last = this.#packets[Math.min(place, this.#packets.length) - 1];
    const nextDecoding = last?.decodingTime == null ? Infinity : last.decodingTime + last.duration;
    this.#jumpTime = Math.min(this.#jumpTime, nextDecoding);
  }

  /** Returns true if the next picture is whole, and no picture before it is missing. */
  isWhole({ index, time }: ShownPicture) {
    if (this.#faulty.has(index)) return false;
    if (time === null) return true;
    const last = this.#lastTime;
    if (last === null) return !this.#damageTimes.some((damage) => Math.abs(damage - time) < SAME_TIME_S);
    const from = last + SAME_TIME_S;
    if (time > this.#jumpTime + SAME_TIME_S && time - last > LONG_STEP_FACTOR * this.#lastStep) return false;
    return !this.#isDamagedBetween(from, time + SAME_TIME_S) && !this.#isMissingBetween(from, time - SAME_TIME_S);
  }

  /** Records that a picture is yielded. */
  record({ time }: ShownPicture) {
    if (time === null) return;
    if (this.#lastTime === null) this.#numBeforeFirst = this.#countBefore(time - SAME_TIME_S);
    else this.#lastStep = time - this.#lastTime;
    this.#lastTime = time;
  }

  /** Returns how long the picture at a time is shown, in seconds; null if the file does not say. */
  getDuration(time: number | null) {
    const picture = time === null ? undefined : this.#listed[this.#countBefore(time - SAME_TIME_S)];
    return picture && Math.abs(picture.time - Number(time)) < SAME_TIME_S && picture.duration > 0
      ? picture.duration
      : null;
  }

  /** Returns true if nothing is missing after the last picture. */
  isWholeAtEnd() {
    if (this.#isCutOff) return false;
    if (this.#lastTime === null) return true;
    const from = this.#lastTime + SAME_TIME_S;
    return !this.#isDamagedBetween(from, Infinity) && !this.#isMissingBetween(from, Infinity);
  }

  #isDamagedBetween(from: number, to: number) {
    return this.#damageTimes.some((damage) => damage >= from && damage <= to);
  }

  /** Returns true if a listed time has no picture because its packet could not be decoded. */
  #isMissingBetween(from: number, to: number) {
    if (this.#numFailed <= this.#numBeforeFirst) return false;
    const next = this.#listed[this.#countBefore(from)];
    return next !== undefined && next.time <= to;
  }

  #countBefore(time: number) {
    let [low, high] = [0, this.#listed.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (Number(this.#listed[middle]?.time) < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}
