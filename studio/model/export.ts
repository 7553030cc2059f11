// What an export is, and what it is made of.

import { masksAtSize } from './library.js';
import type { Plate } from './answers.js';
import type {
  Backdrop as Ground,
  MaskEdges,
  MaskSource,
  SoundOptions,
  TrajectoryPoints,
  VideoQuality,
} from './library.js';
import type { GroundName } from './look.js';
import type { Source } from './source.js';
import type { Film, State } from './store.js';

/** What there is to save. */
export interface Subject {
  masks: {
    width: number;
    height: number;
    numFrames: number;
    labels: (t: number) => Uint8Array;
    times: ArrayLike<number> | null;
    end: number | null;
    shots: { first: number; last: number }[];
  };
  /** All frames, at the size that is wanted. */
  frames: (signal: AbortSignal) => AsyncIterable<ImageData>;
  image: (t: number) => Promise<ImageData>;
  /** Of the masks on screen. */
  look: Look;
  /** Of videos. */
  quality: VideoQuality;
  /** Of the masks on screen. */
  edges: MaskEdges;
  /** Of cut-out objects on screen. */
  ground: Ground;
  /** Of videos; null for none. */
  sound: (format: 'webm' | 'mp4') => SoundOptions | null;
  source: Source;
  /** The scene of a frame without the objects, which may be smaller; null where nobody knows. */
  plate: ((t: number) => Promise<Plate>) | null;
  frame: number;
  objects: (object: number) => boolean;
  name: string;
  /** Where frames have no times. */
  fps: number;
  /** The trajectories as a track file. */
  tracks: () => string | Promise<string>;
  /** Of the trajectories, in pixels of the masks. */
  points: TrajectoryPoints;
  state: State;
}

/**
 * How masks look on screen: how opaque they are as a whole, and their fill, 0 to 1; how wide their outline is, in
 * pixels of the picture that is saved.
 */
export type Look = { opacity: number; fill: number; outline: number };

/** What there is to save, before it is known how. */
type Found = Omit<Subject, 'objects' | 'frames' | 'image' | 'look' | 'quality' | 'sound' | 'ground' | 'edges'>;

type Work = { signal: AbortSignal; onProgress: (progress: { done: number; total: number }) => void };

export interface Choice {
  id: string;
  /** Of its button; that of a cut-out names the ground on screen. */
  label: string | ((ground: GroundName) => string);
  /** To screen readers, where the label is short. */
  says?: string;
  /** What is added to the clip's name. */
  file: (subject: Subject) => string;
  /** Whether it can be made; always if not said. */
  there?: (subject: Found) => boolean;
  /** Of a file that is written while it is made. */
  type?: string;
  make: (subject: Subject, work: Work) => Promise<Blob | ReadableStream<Uint8Array<ArrayBuffer>>>;
}

export type Export = { title: string; about: string; choices: Choice[] };

/** Returns what an export is made of; null without masks. */
export function subjectOf(state: State): Found | null {
  const { found, job, film, frame } = state;
  const points = found?.points;
  if (!points || !job) return null;
  const { width, height, numFrames } = points.result;
  const labels = (t: number) => points.mask(t)!;
  return {
    masks: {
      width,
      height,
      numFrames,
      labels,
      times: film.times.seconds?.slice(0, numFrames) ?? null,
      end: endOf(film, numFrames),
      shots: shotsOf(film, numFrames),
    },
    source: job.source,
    plate: found?.answers.background ?? null,
    frame,
    name: job.source.name,
    fps: film.fps,
    tracks: () => points.result.toTracksDat(),
    points: points.result.trajectories,
    state,
  };
}

/** @returns stretches without a cut */
export function shotsOf({ cuts }: Film, numFrames: number): { first: number; last: number }[] {
  const starts = [0, ...cuts.filter((cut) => cut < numFrames)];
  return starts.map((first, k) => ({ first, last: (starts[k + 1] ?? numFrames) - 1 }));
}

/** @returns when the last of them ends, in seconds; null where nobody knows */
function endOf({ times }: Film, numFrames: number): number | null {
  return times.seconds?.[numFrames] ?? times.end;
}

/** Returns all masks, at the size that is wanted. */
export function masksOf({ masks, frames, edges }: Subject, work: Work): Promise<MaskSource> {
  return masksAtSize(masks, frames(work.signal), { ...work, edges });
}

/** @param frame that frame, at the size that is wanted */
export async function labelsOf({ masks, edges }: Subject, t: number, frame: ImageData): Promise<Uint8Array> {
  const one = { ...masks, numFrames: 1, times: null, end: null, shots: [], labels: () => masks.labels(t) };
  return (await masksAtSize(one, [frame], { edges })).labels(0);
}

/** Returns the option that replaces times. */
export function rateOf({ masks, fps }: Subject): { frameRate?: number } {
  return masks.times ? {} : { frameRate: fps };
}

/** @returns what files made of it begin with: no extension, nothing that a file system minds */
export function stemOf(name: string): string {
  const stem = name
    .replace(/ … .*$/, '')
    .replace(/\.[a-z0-9]{2,5}$/i, '')
    .replace(/[^\p{L}\p{N}._-]+/gu, '-')
    .replace(/^[-.]+|[-.]+$/g, '');
  return (stem || 'clip').slice(0, 80).toLowerCase();
}
