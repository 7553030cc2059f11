// The type of exports, and the data they are made from.

import { masksAtSize } from './library.js';
import type { Plate } from './clip-job.js';
import type { MaskEdges, MaskSource, SoundInfo, SoundOptions, TrajectoryPoints, VideoQuality } from './library.js';
import type { BackdropName } from './view-settings.js';
import type { Picture, Source } from './source.js';
import type { Timeline, State } from './store.js';

/** The data of an export. */
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
  /** All frames, at the chosen size. */
  frames: (signal: AbortSignal) => AsyncIterable<Picture>;
  image: (t: number) => Promise<ImageData>;
  maskStyle: MaskStyle;
  quality: VideoQuality;
  edges: MaskEdges;
  /** Options of the soundtrack; null for none. */
  sound: (format: SoundInfo['formats'][number]) => SoundOptions | null;
  source: Source;
  /** The background of a frame without objects, which may be smaller; null if not available. */
  plate: ((t: number) => Promise<Plate>) | null;
  frame: number;
  objects: (object: number) => boolean;
  name: string;
  /** Used if frames have no times. */
  fps: number;
  /** The trajectories as a track file. */
  tracks: () => string | Promise<string>;
  /** Points of the trajectories, in pixels of the masks. */
  points: TrajectoryPoints;
  state: State;
}

/**
 * Drawing style of masks: opacity of the whole and of the fill, 0 to 1, and outline width in pixels of the saved
 * picture.
 */
export type MaskStyle = { opacity: number; fill: number; outline: number };

/** The data of an export without the chosen options. */
type ExportSource = Omit<Subject, 'objects' | 'frames' | 'image' | 'maskStyle' | 'quality' | 'sound' | 'edges'>;

type ExportTask = { signal: AbortSignal; onProgress: (progress: { done: number; total: number }) => void };

export interface Choice {
  id: string;
  /** Label of its button; may depend on the backdrop. */
  label: string | ((backdrop: BackdropName) => string);
  /** Label for screen readers, if different. */
  ariaLabel?: string;
  /** Returns the suffix of the file name. */
  file: (subject: Subject) => string;
  /** Returns whether it can be made; always if absent. */
  isAvailable?: (subject: ExportSource) => boolean;
  /** Media type of a file that is streamed to disk. */
  type?: string;
  make: (subject: Subject, task: ExportTask) => Promise<Blob | ReadableStream<Uint8Array<ArrayBuffer>>>;
}

export type Export = { title: string; about: string; choices: Choice[] };

/** Returns the data to export; null without masks. */
export function exportSource(state: State): ExportSource | null {
  const { analysis, job, timeline, frame } = state;
  const segmentation = analysis?.segmentation;
  if (!segmentation || !job) return null;
  const { width, height, numFrames } = segmentation.result;
  const labels = (t: number) => segmentation.mask(t)!;
  return {
    masks: {
      width,
      height,
      numFrames,
      labels,
      times: timeline.times.seconds?.slice(0, numFrames) ?? null,
      end: lastFrameEnd(timeline, numFrames),
      shots: splitShots(timeline, numFrames),
    },
    source: job.source,
    plate: analysis?.background ?? null,
    frame,
    name: job.source.name,
    fps: timeline.fps,
    tracks: () => segmentation.result.toTracksDat(),
    points: segmentation.result.trajectories,
    state,
  };
}

/** Returns the first and last frame of each shot. */
export function splitShots({ cuts }: Timeline, numFrames: number): { first: number; last: number }[] {
  const starts = [0, ...cuts.filter((cut) => cut < numFrames)];
  return starts.map((first, k) => ({ first, last: (starts[k + 1] ?? numFrames) - 1 }));
}

/** Returns the end of the last frame in seconds; null if unknown. */
function lastFrameEnd({ times }: Timeline, numFrames: number): number | null {
  return times.seconds?.[numFrames] ?? times.end;
}

/** Resizes all masks to the chosen size. */
export function resizeMasks({ masks, frames, edges }: Subject, task: ExportTask): Promise<MaskSource> {
  return masksAtSize(masks, frames(task.signal), { ...task, edges });
}

/**
 * Resizes the mask of frame `t`.
 * @param frame its picture, at the chosen size
 */
export async function resizeLabels({ masks, edges }: Subject, t: number, frame: ImageData): Promise<Uint8Array> {
  const frameMasks = { ...masks, numFrames: 1, times: null, end: null, shots: [], labels: () => masks.labels(t) };
  return (await masksAtSize(frameMasks, [frame], { edges })).labels(0);
}

/** Returns the frame rate option if frames have no times. */
export function frameRateOption({ masks, fps }: Subject): { frameRate?: number } {
  return masks.times ? {} : { frameRate: fps };
}

/** Returns the start of file names: no extension, only safe characters. */
export function fileStem(name: string): string {
  const stem = name
    .replace(/ … .*$/, '')
    .replace(/\.[a-z0-9]{2,5}$/i, '')
    .replace(/[^\p{L}\p{N}._-]+/gu, '-')
    .replace(/^[-.]+|[-.]+$/g, '');
  return (stem || 'clip').slice(0, 80).toLowerCase();
}
