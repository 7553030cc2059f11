// The masks, shots and objects of a whole clip: `VideoResult`.

import { TraceCutError, illegal, wholeNumber } from '../check/errors.js';
import { type ObjectList, objectList, tracksDat } from '../session/report.js';
import { type Runs, areasOf, checkRuns, decodeRuns, encodeRuns, joinRuns, splitRuns } from '../session/runs.js';
import { opened, saved } from '../session/saved.js';
import { breath } from '../worker/pause.js';
import type { WindowResult } from './window.js';

/** A stretch of frames without a cut, `first` and `last` included. Objects of different shots have different labels. */
export type Shot = { readonly first: number; readonly last: number };

/** Where a source was cut off or damaged: the number of frames before, and what is wrong. */
export type Truncated = { readonly frames: number; readonly reason: string };

type SavedVideo = Omit<Collected, 'runs'> & { runs: Uint32Array<ArrayBuffer> | unknown[] };

export interface Collected {
  width: number;
  height: number;
  times: Float64Array<ArrayBuffer>;
  end?: number | null;
  shots: readonly Shot[];
  runs: Runs[];
  trajectories: ClipTrajectories;
  truncated?: Truncated | null;
}

/** Frames between two breaths. */
const BATCH = 8;

/** The masks, objects and trajectories of a whole clip; made by `collect`. Its masks lie run-length coded in memory. */
export class VideoResult {
  /** Width of the masks in pixels. */
  readonly width: number;
  /** Height of the masks in pixels. */
  readonly height: number;
  /** Number of frames. */
  readonly numFrames: number;
  /** The time of each frame, in seconds. */
  readonly times: Float64Array<ArrayBuffer>;
  /** When the last frame ends, in seconds; null where nothing says. */
  readonly end: number | null;
  /** Whether the source was cut off or damaged: masks are of the frames before. Null for a whole clip. */
  readonly truncated: Truncated | null;
  /** The shots of the clip, in order. */
  readonly shots: readonly Shot[];
  /** Point trajectories over the whole clip, in pixels of the masks, each with its object. */
  readonly trajectories: ClipTrajectories;
  /** The masks as runs of equal labels, row by row: the label in the lowest 8 bits, the length above. */
  readonly runs: Runs[];
  /** The objects, by their labels. */
  readonly objects: ObjectList;

  constructor(collected: Collected) {
    this.width = collected.width;
    this.height = collected.height;
    this.numFrames = collected.times.length;
    this.times = collected.times;
    this.end = collected.end ?? null;
    this.truncated = collected.truncated ?? null;
    this.shots = collected.shots;
    this.trajectories = collected.trajectories;
    this.runs = collected.runs;
    this.objects = objectsOf(collected.runs);
  }

  /** The mask of frame `t`: one byte for each pixel, row by row; 0 is the background. */
  labels(t: number): Uint8Array<ArrayBuffer> {
    wholeNumber('param', 't', t, 0, this.numFrames - 1);
    return decodeRuns(this.runs[t]!);
  }

  /**
   * All of it for `JSON.stringify`, compressed; `fromJSON` is the way back. `structuredClone` gives its data too, as a
   * plain object without methods, which `fromJSON` takes as well.
   */
  toJSON(): Record<string, unknown> {
    const { objects: _, runs, ...rest } = this;
    return saved({ ...rest, runs: joinRuns(runs) });
  }

  /**
   * A result that was saved.
   * @param json what `JSON.stringify` made, or that parsed, or what `structuredClone` gave
   * @returns with code `data` where it is damaged, or another kind of result
   */
  static fromJSON(json: string | object): VideoResult {
    const { runs: words, ...rest } = opened<SavedVideo>(json, ['times', 'shots', 'runs', 'trajectories']);
    const frames: unknown[] = words instanceof Uint32Array ? splitRuns(words, rest.times.length) : words;
    const size = rest.width * rest.height;
    const runs = Array.from(rest.times, (_, t) => checkRuns(`the mask of frame ${t}`, frames[t], size));
    return new VideoResult({ ...rest, runs });
  }

  /**
   * The trajectories as a track file of the Moseg benchmark: number of frames, number of tracks, then for each track
   * its label and length and, line by line, `x y frame`.
   */
  toTracksDat(): string {
    return tracksDat({ ...this.trajectories, numFrames: this.numFrames });
  }
}

function objectsOf(runs: Runs[]): ObjectList {
  const areas = new Map<number, Uint32Array<ArrayBuffer>>();
  runs.forEach((frame, t) => {
    areasOf(frame).forEach((area, label) => {
      if (area === 0 || label === 0) return;
      if (!areas.has(label)) areas.set(label, new Uint32Array(runs.length));
      const own = areas.get(label)!;
      own[t] = area;
    });
  });
  return objectList([...areas].map(([label, own]) => ({ label, areas: own })));
}

/** Collects window after window. */
export class Collector {
  #runs: Runs[] = [];
  #times: number[] = [];
  #end: number | null = null;
  #shots: { first: number; last: number }[] = [];
  #tracks = new TrackCollector();
  #size = { width: 0, height: 0 };
  #clip: string | null | undefined;

  /** Takes all of a window at its end; on the way there the thread may answer others. */
  async add(window: WindowResult) {
    if (this.#clip === undefined) this.#clip = window.clip;
    if (window.clip !== this.#clip)
      throw illegal('data', 'clip', window.clip, `${this.#clip}: collect gives one, iterate over the windows`);
    const frames = [];
    for (const { index, time, labels } of window.frames()) {
      frames.push({ index, time, runs: encodeRuns(labels) });
      if (frames.length % BATCH === 0) await breath();
    }
    this.#size = { width: window.width, height: window.height };
    for (const { index, time, runs } of frames) {
      const shot = (this.#shots[window.shot] ??= { first: index, last: index });
      shot.last = index;
      this.#runs.push(runs);
      this.#times.push(time);
    }
    // Of frames that the next window settles nothing is asked yet.
    this.#end = window.settled.to === window.times.length ? window.end : (window.times[window.settled.to] ?? null);
    this.#tracks.add(window);
  }

  labels(t: number) {
    wholeNumber('param', 't', t, 0, this.#runs.length - 1);
    return decodeRuns(this.#runs[t]!);
  }

  /** @param damage that the source ended with */
  finish(damage: TraceCutError | null) {
    const frames = this.#runs.length;
    const result = this.sofar(damage && { frames, reason: damage.message });
    if (!result) throw new TraceCutError('no-frames', 'the source has no frames');
    return result;
  }

  /** The result of the frames that are there by now; null without any. */
  sofar(truncated: Truncated | null = null) {
    const numFrames = this.#runs.length;
    if (numFrames === 0) return null;
    return new VideoResult({
      ...this.#size,
      times: Float64Array.from(this.#times),
      end: this.#end,
      shots: this.#shots.map((shot) => ({ ...shot })),
      runs: [...this.#runs],
      trajectories: this.#tracks.finish(numFrames),
      truncated,
    });
  }
}

/**
 * Trajectories of a whole clip, shaped as `Result.trajectories`: the points of trajectory `i` are `offset[i]` to
 * `offset[i + 1]`, one for each of the consecutive frames from `startFrame[i]` on. `label[i]` is the object that most
 * of its points were on, 0 for the background.
 */
export type ClipTrajectories = {
  readonly count: number;
  readonly startFrame: Uint32Array;
  readonly offset: Uint32Array;
  readonly x: Float32Array;
  readonly y: Float32Array;
  readonly label: Uint8Array;
};

export type Track = { start: number; x: number[]; y: number[]; votes: Map<number, number> };

/** Collects the trajectories of window after window. */
class TrackCollector {
  #tracks = new Map<number, Track>();

  add({ trajectories, clusters, firstFrame }: WindowResult) {
    for (let i = 0; i < trajectories.count; i += 1) {
      const [begin, end] = [Number(trajectories.offset[i]), Number(trajectories.offset[i + 1])];
      const start = firstFrame + Number(trajectories.startFrame[i]);
      const track = this.#trackOf(Number(trajectories.id[i]), start);
      // The frames that an earlier window had are there already.
      const known = track.start + track.x.length - start;
      for (let p = begin + Math.max(0, known); p < end; p += 1) {
        track.x.push(Number(trajectories.x[p]));
        track.y.push(Number(trajectories.y[p]));
      }
      const label = Number(clusters.object?.[Number(clusters.label[i])] ?? 0);
      track.votes.set(label, (track.votes.get(label) ?? 0) + end - begin);
    }
  }

  #trackOf(id: number, start: number) {
    let track = this.#tracks.get(id);
    if (!track) this.#tracks.set(id, (track = { start, x: [], y: [], votes: new Map() }));
    return track;
  }

  /**
   * @param numFrames what lies beyond is left out
   * @returns in the order of their first frames
   */
  finish(numFrames: number): ClipTrajectories {
    const tracks = [...this.#tracks.values()]
      .filter(({ start }) => start < numFrames)
      .map((track) => ({
        ...track,
        x: track.x.slice(0, numFrames - track.start),
        y: track.y.slice(0, numFrames - track.start),
      }))
      .sort((a, b) => a.start - b.start);
    const offset = new Uint32Array(tracks.length + 1);
    tracks.forEach((track, i) => (offset[i + 1] = Number(offset[i]) + track.x.length));
    const points = Number(offset[tracks.length]);
    const joined = {
      count: tracks.length,
      startFrame: Uint32Array.from(tracks, ({ start }) => start),
      offset,
      x: new Float32Array(points),
      y: new Float32Array(points),
      label: Uint8Array.from(tracks, ({ votes }) => majority(votes)),
    };
    tracks.forEach((track, i) => {
      joined.x.set(track.x, offset[i]);
      joined.y.set(track.y, offset[i]);
    });
    return joined;
  }
}

/** The label with most votes, the lowest of equals. */
function majority(votes: Map<number, number>) {
  let best = 0;
  let most = -1;
  for (const [label, count] of votes) {
    if (count > most || (count === most && label < best)) [best, most] = [label, count];
  }
  return best;
}
