// Lists the packets in a file's video tracks (`-f framecrc`), and chooses a track.

import { type TimeBase, toSeconds } from './log.js';

/**
 * A packet, which usually holds one picture: its decoding and display times in seconds, null if it has none, and how long
 * its picture is shown, 0 if the file does not say. It is shown unless an edit list drops it.
 */
export type Packet = {
  decodingTime: number | null;
  time: number | null;
  duration: number;
  isCorrupt: boolean;
  isShown: boolean;
};

/**
 * A video track that is no attached picture: its index among those (`0:V:position`), and its packets in file order.
 */
export type Track = { position: number; codec: string; numPixels: number; packets: Packet[] };

/** A picture of a packet; its duration is 0 if the file does not say. */
export type ListedPicture = { time: number; duration: number };

/** Relative tolerance within which steps between pictures are equal, for times in whole milliseconds. */
const STEP_TOLERANCE = 0.25;
/** Printed by ffmpeg as the time of a packet without one. */
const NO_TIME = '-9223372036854775808';
/** `AV_PKT_FLAG_CORRUPT`: the packet is not whole. */
const CORRUPT_FLAG = 2;
/** `AV_PKT_FLAG_DISCARD`: the packet is needed for decoding, but an edit list drops its picture. */
const DISCARD_FLAG = 4;

/** Reads the tracks in a list. */
export async function readTracks(list: AsyncIterable<Uint8Array>): Promise<Track[]> {
  const [reader, decoder] = [new ListReader(), new TextDecoder()];
  let rest = '';
  for await (const bytes of list) {
    const lines = (rest + decoder.decode(bytes, { stream: true })).split('\n');
    rest = lines.pop() ?? '';
    for (const line of lines) reader.readLine(line);
  }
  return reader.tracks;
}

/** Reads a list line by line. */
class ListReader {
  tracks: (Track & { timeBase: TimeBase })[] = [];

  readLine(line: string) {
    const [, name, position, text = ''] = /^#(\w+) (\d+): (.*)/.exec(line) ?? [];
    if (name) this.#readHeader(name, Number(position), text);
    else if (!line.startsWith('#')) this.#readPacket(line.split(',').map((word) => word.trim()));
  }

  #readHeader(name: string, position: number, text: string) {
    const [first, second] = text.split(/[/x]/).map(Number);
    const numbers = { numerator: Number(first), denominator: Number(second) };
    if (name === 'tb') this.tracks[position] = { position, timeBase: numbers, codec: '', numPixels: 0, packets: [] };
    const track = this.tracks[position];
    if (track && name === 'codec_id') track.codec = text;
    if (track && name === 'dimensions') track.numPixels = Number(first) * Number(second);
  }

  /** @param words track, decoding time, presentation time, duration, bytes, checksum, and optionally `F=0x2` */
  #readPacket([position, dts, pts, duration, , , ...more]: string[]) {
    const track = this.tracks[Number(position)];
    if (!track) return;
    const flags = Number(more.find((word) => word.startsWith('F='))?.slice(2) ?? 0);
    track.packets.push({
      decodingTime: dts === NO_TIME ? null : toSeconds(Number(dts), track.timeBase),
      time: pts === NO_TIME ? null : toSeconds(Number(pts), track.timeBase),
      duration: toSeconds(Math.max(0, Number(duration)), track.timeBase),
      isCorrupt: (flags & CORRUPT_FLAG) !== 0,
      isShown: (flags & DISCARD_FLAG) === 0,
    });
  }
}

const endsBeforeStart = ({ time, duration }: Packet) => time !== null && time < 0 && time + duration <= 0;

/** Returns the number of shown pictures. */
export function countPictures({ packets }: Track) {
  return packets.filter((packet) => packet.isShown && !endsBeforeStart(packet)).length;
}

/**
 * Returns the pictures whose time is known, in display order.
 *
 * If an MP4 file has durations only in its decoding times, ffmpeg 5 and 6 give all packets the average of the track. A
 * duration that all packets share, although the pictures are not evenly spaced, counts as unknown.
 */
export function listShownPictures({ packets }: Track): ListedPicture[] {
  const pictures = packets
    .flatMap(({ time, duration, isShown }) => (isShown && time !== null ? [{ time, duration }] : []))
    .sort((a, b) => a.time - b.time);
  const average = pictures[0]?.duration ?? 0;
  const isSteady = pictures.every(({ time }, k) => {
    const next = pictures[k + 1];
    return !next || Math.abs(next.time - time - average) <= STEP_TOLERANCE * average;
  });
  const isInvented = !isSteady && pictures.every(({ duration }) => duration === average);
  return isInvented ? pictures.map(({ time }) => ({ time, duration: 0 })) : pictures;
}

/**
 * Chooses the track of a clip: the first default track with several pictures, else the largest with several pictures,
 * else the largest with one.
 * @param defaults true for each default track
 */
export function chooseTrack(tracks: readonly Track[], defaults: readonly boolean[]): Track | undefined {
  const clips = tracks.filter((track) => countPictures(track) > 1);
  const preferred = clips.find(({ position }) => defaults[position]);
  return preferred ?? findLargest(clips) ?? findLargest(tracks.filter(({ packets }) => packets.length > 0));
}

function findLargest(tracks: readonly Track[]) {
  return tracks.reduce(
    (best: Track | undefined, track) => (best && best.numPixels >= track.numPixels ? best : track),
    undefined,
  );
}
