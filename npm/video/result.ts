// The masks, shots and objects of a whole clip: `VideoResult`.

import { TraceCutError, checkWholeNumber, illegal } from '../check/errors.js';
import { type ObjectList, listObjects, tracksDat } from '../session/report.js';
import {
  type Runs,
  checkRuns,
  countPixels,
  decodeRuns,
  encodeRuns,
  joinRuns,
  restoreFields,
  splitRuns,
  toSaved,
} from '../session/serialize.js';
import { yieldThread } from '../worker/pause.js';
import type { FrameRange } from '../session/result.js';
import type { WindowResult } from './window.js';

/** A range of frames without a cut, `first` and `last` included. Objects of different shots have different labels. */
export type Shot = { readonly first: number; readonly last: number };

/** Damage of a source: the number of frames before it, and the reason. */
export type Truncation = { readonly frames: number; readonly reason: string };

type SavedVideo = Omit<VideoResultData, 'runs'> & { runs: Uint32Array<ArrayBuffer> | unknown[] };

export interface VideoResultData {
  width: number;
  height: number;
  times: Float64Array<ArrayBuffer>;
  end?: number | null;
  shots: readonly Shot[];
  runs: Runs[];
  doubts?: readonly FrameRange[];
  trajectories: ClipTrajectories;
  truncated?: Truncation | null;
}

/** Frames between two pauses for the page's thread. */
const BATCH = 8;

/** Masks, objects and trajectories of a whole clip; created by `collect`. Its masks are kept as run lengths. */
export class VideoResult {
  /** Width of the masks in pixels. */
  readonly width: number;
  /** Height of the masks in pixels. */
  readonly height: number;
  /** Number of frames. */
  readonly numFrames: number;
  /** The time of each frame, in seconds. */
  readonly times: Float64Array<ArrayBuffer>;
  /** Time at which the last frame ends, in seconds; null if unknown. */
  readonly end: number | null;
  /** Damage of the source, if masks are of the frames before it only; null for a whole clip. */
  readonly truncated: Truncation | null;
  /** The shots of the clip, in order. */
  readonly shots: readonly Shot[];
  /** The frames whose masks should be looked at, as of `Result`. */
  readonly doubts: readonly FrameRange[];
  /** Point trajectories over the whole clip, in pixels of the masks, each with its object. */
  readonly trajectories: ClipTrajectories;
  /** The masks as runs of equal labels, row by row: the label in the lowest 8 bits, the length above. */
  readonly runs: Runs[];
  /** The objects, by their labels. */
  readonly objects: ObjectList;

  constructor(collected: VideoResultData) {
    this.width = collected.width;
    this.height = collected.height;
    this.numFrames = collected.times.length;
    this.times = collected.times;
    this.end = collected.end ?? null;
    this.truncated = collected.truncated ?? null;
    this.shots = collected.shots;
    this.doubts = collected.doubts ?? [];
    this.trajectories = collected.trajectories;
    this.runs = collected.runs;
    this.objects = measureObjects(collected.runs);
  }

  /** Returns the mask of frame `t`: one byte for each pixel, row by row; 0 is the background. */
  labels(t: number): Uint8Array<ArrayBuffer> {
    checkWholeNumber('param', 't', t, 0, this.numFrames - 1);
    return decodeRuns(this.runs[t]!);
  }

  /**
   * Returns all data for `JSON.stringify`, compressed; `fromJSON` restores them. `structuredClone` returns its data as a
   * plain object without methods, which `fromJSON` accepts too.
   */
  toJSON(): Record<string, unknown> {
    const { objects: _, runs, ...rest } = this;
    return toSaved({ ...rest, runs: joinRuns(runs) });
  }

  /**
   * Restores a saved result.
   * @param json from `JSON.stringify`, or that parsed, or from `structuredClone`
   * @throws error `data` if it is damaged, or another kind of result
   */
  static fromJSON(json: string | object): VideoResult {
    const { runs: savedRuns, ...rest } = restoreFields<SavedVideo>(json, ['times', 'shots', 'runs', 'trajectories']);
    const frames: unknown[] = savedRuns instanceof Uint32Array ? splitRuns(savedRuns, rest.times.length) : savedRuns;
    const size = rest.width * rest.height;
    const runs = Array.from(rest.times, (_, t) => checkRuns(`the mask of frame ${t}`, frames[t], size));
    return new VideoResult({ ...rest, runs });
  }

  /**
   * Formats the trajectories as a track file of the Moseg benchmark: number of frames, number of tracks, then for each
   * track its label and length and, line by line, `x y frame`.
   */
  toTracksDat(): string {
    return tracksDat({ ...this.trajectories, numFrames: this.numFrames });
  }
}

function measureObjects(runs: Runs[]): ObjectList {
  const areas = new Map<number, Uint32Array<ArrayBuffer>>();
  runs.forEach((frame, t) => {
    countPixels(frame).forEach((area, label) => {
      if (area === 0 || label === 0) return;
      if (!areas.has(label)) areas.set(label, new Uint32Array(runs.length));
      const labelAreas = areas.get(label)!;
      labelAreas[t] = area;
    });
  });
  return listObjects([...areas].map(([label, labelAreas]) => ({ label, areas: labelAreas })));
}

/** Collects the results of windows. */
export class Collector {
  #runs: Runs[] = [];
  #times: number[] = [];
  #end: number | null = null;
  #shots: { first: number; last: number }[] = [];
  #doubts: FrameRange[] = [];
  #tracks = new TrackCollector();
  #size = { width: 0, height: 0 };
  #clip: string | null | undefined;

  /** Adds a finished window; pauses on the way for other work of the thread. */
  async add(window: WindowResult) {
    if (this.#clip === undefined) this.#clip = window.clip;
    if (window.clip !== this.#clip)
      throw illegal('data', 'clip', window.clip, `${this.#clip}: collect gives one, iterate over the windows`);
    const frames = [];
    for (const { index, time, labels } of window.frames()) {
      frames.push({ index, time, runs: encodeRuns(labels) });
      if (frames.length % BATCH === 0) await yieldThread();
    }
    this.#size = { width: window.width, height: window.height };
    for (const { index, time, runs } of frames) {
      const shot = (this.#shots[window.shot] ??= { first: index, last: index });
      shot.last = index;
      this.#runs.push(runs);
      this.#times.push(time);
    }
    // The next window settles frames that are ignored here.
    this.#end = window.settled.to === window.times.length ? window.end : (window.times[window.settled.to] ?? null);
    this.#addDoubts(window);
    this.#tracks.add(window);
  }

  /** Adds the doubts of the settled frames; one that continues that of the window before extends it. */
  #addDoubts({ doubts, settled, firstFrame }: WindowResult) {
    for (const doubt of doubts ?? []) {
      const from = firstFrame + Math.max(doubt.from, settled.from);
      const to = firstFrame + Math.min(doubt.to, settled.to);
      if (from >= to) continue;
      const last = this.#doubts.at(-1);
      if (last?.to === from) this.#doubts[this.#doubts.length - 1] = { from: last.from, to };
      else this.#doubts.push({ from, to });
    }
  }

  labels(t: number) {
    checkWholeNumber('param', 't', t, 0, this.#runs.length - 1);
    return decodeRuns(this.#runs[t]!);
  }

  /** @param damage that ended the source */
  finish(damage: TraceCutError | null) {
    const frames = this.#runs.length;
    const result = this.createPartialResult(damage && { frames, reason: damage.message });
    if (!result) throw new TraceCutError('no-frames', 'the source has no frames');
    return result;
  }

  /** Returns the result of the frames collected so far; null without any. */
  createPartialResult(truncated: Truncation | null = null) {
    const numFrames = this.#runs.length;
    if (numFrames === 0) return null;
    return new VideoResult({
      ...this.#size,
      times: Float64Array.from(this.#times),
      end: this.#end,
      shots: this.#shots.map((shot) => ({ ...shot })),
      runs: [...this.#runs],
      doubts: [...this.#doubts],
      trajectories: this.#tracks.finish(numFrames),
      truncated,
    });
  }
}

/**
 * Trajectories of a whole clip, in the form of `Result.trajectories`: trajectory `i` has the points `offset[i]` to
 * `offset[i + 1]`, one for each of the consecutive frames from `startFrame[i]` on. `label[i]` is the object of most of its
 * points, 0 for the background.
 */
export type ClipTrajectories = {
  readonly count: number;
  readonly startFrame: Uint32Array;
  readonly offset: Uint32Array;
  readonly x: Float32Array;
  readonly y: Float32Array;
  readonly label: Uint8Array;
};

type CollectedTrack = { start: number; x: number[]; y: number[]; votes: Map<number, number> };

/** Collects the trajectories of windows. */
class TrackCollector {
  #tracks = new Map<number, CollectedTrack>();

  add({ trajectories, clusters, firstFrame }: WindowResult) {
    for (let i = 0; i < trajectories.count; i += 1) {
      const [begin, end] = [Number(trajectories.offset[i]), Number(trajectories.offset[i + 1])];
      const start = firstFrame + Number(trajectories.startFrame[i]);
      const track = this.#getTrack(Number(trajectories.id[i]), start);
      // Frames of an earlier window are collected already.
      const numCollected = track.start + track.x.length - start;
      for (let p = begin + Math.max(0, numCollected); p < end; p += 1) {
        track.x.push(Number(trajectories.x[p]));
        track.y.push(Number(trajectories.y[p]));
      }
      const label = Number(clusters.object[Number(clusters.label[i])] ?? 0);
      track.votes.set(label, (track.votes.get(label) ?? 0) + end - begin);
    }
  }

  #getTrack(id: number, start: number) {
    let track = this.#tracks.get(id);
    if (!track) this.#tracks.set(id, (track = { start, x: [], y: [], votes: new Map() }));
    return track;
  }

  /**
   * @param numFrames later frames are dropped
   * @returns by first frame
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
    const list = {
      count: tracks.length,
      startFrame: Uint32Array.from(tracks, ({ start }) => start),
      offset,
      x: new Float32Array(points),
      y: new Float32Array(points),
      label: Uint8Array.from(tracks, ({ votes }) => findMajority(votes)),
    };
    tracks.forEach((track, i) => {
      list.x.set(track.x, offset[i]);
      list.y.set(track.y, offset[i]);
    });
    return list;
  }
}

/** Returns the label with most votes, the lowest of equals. */
function findMajority(votes: Map<number, number>) {
  let best = 0;
  let most = -1;
  for (const [label, count] of votes) {
    if (count > most || (count === most && label < best)) [best, most] = [label, count];
  }
  return best;
}
