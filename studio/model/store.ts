// The state of the page. Panels read it, change it with `set` and watch the keys that they show; the document is
// written from it and never read back. State that only one panel uses stays in that panel.

import { DEFAULT_TRIM, type Source, type Trim } from './source.js';
import { type ObjectFacts, type Segmentation, Times } from './presence.js';
import type { ClipJob, JobView } from './clip-job.js';
import type { Edit, FrameRange } from './library.js';
import type { EdgeSettings, BackdropName, View } from './view-settings.js';
import type { Preview } from './preview.js';
import type { SmoothedMasks } from './smoothing.js';

/**
 * The phase of the page. Several phases share one of the four public states in `document.body.dataset.state`, see
 * panels/status.ts.
 */
export type Phase = 'opening' | 'running' | 'stopped' | 'done' | 'error';

/**
 * Frames to show. `get` returns null if a frame is still loading, and `onReady` is called when it is ready; `more`
 * frames after it are loaded too.
 */
export type Frames = {
  get: (frame: number, more?: number) => CanvasImageSource | null;
  has: (frame: number) => boolean;
  onReady: () => void;
};

/** The viewer's frames, size in pixels. */
type Picture = { width: number; height: number; images: Frames };

/** Frames of the timeline; `cuts` are the first frames of later shots. */
export type Timeline = { numFrames: number; fps: number; times: Times; cuts: number[] };

/** A position in clip pixels and the object there; -1 for none. */
export type Spot = { x: number; y: number; object: number };

/** The result on screen. */
interface Analysis {
  segmentation: Segmentation;
  /** Facts of each object, including the background. */
  facts: ObjectFacts[];
  /** Computes the scene without objects at a frame; null if not available. */
  background: JobView['background'];
}

/** The last painted correction: its object, its painted frame `t`, and the frames that it changes. */
export type Fix = { edit: Edit; object: number; t: number; first: number; last: number; isSpreading: boolean };

export type Backdrop = { name: BackdropName; colour: string; picture: ImageBitmap | null };

export interface State {
  /** Incremented whenever another source or run begins; earlier asynchronous steps are void. */
  visit: number;
  phase: Phase;
  /** True while a file is opened beside finished work. */
  isOpening: boolean;
  headline: string;
  subline: string;
  /** Description of the objects, empty for none. */
  summary: string;
  /** Shown above the picture, empty for none. */
  notice: string;
  /** Text for screen readers. */
  announcement: string;
  error: unknown;
  name: string;
  source: Source | null;
  trim: Trim;
  /** Time of the last run per pixel and frame, in milliseconds. */
  pace: number;
  /** Parameters that differ from their defaults. */
  changed: ReadonlyMap<string, number | boolean | string>;
  job: ClipJob | null;
  /** The finished job that the current run replaced. */
  previousJob: ClipJob | null;
  /** Finished share of the run, in 0..1. */
  share: number;
  /** Preview shown until there are masks. */
  preview: Preview | null;
  /** True while finished frames of a run are shown. */
  isStreaming: boolean;
  picture: Picture;
  analysis: Analysis | null;
  hidden: ReadonlySet<number>;
  /** Objects selected to be joined, into the first. */
  selected: ReadonlySet<number>;
  timeline: Timeline;
  /** Frames whose masks should be looked at, without those that the user found fine. */
  doubts: readonly FrameRange[];
  /** Confidence in the masks of each frame, 0 to 1, NaN if unknown; null if unknown for all. */
  agreement: Float32Array | null;
  /** First frames of the doubts that the user found fine. */
  fine: ReadonlySet<number>;
  frame: number;
  isPlaying: boolean;
  loop: boolean;
  /** True if the clip has sound that the page can read. */
  hasSound: boolean;
  isMuted: boolean;
  /** True if the user prefers reduced motion. */
  isReducedMotion: boolean;
  /** True if the browser adds noise to canvas pixels. */
  isNoisy: boolean;
  view: View;
  /** Backdrop of cut-out objects. */
  backdrop: Backdrop;
  edges: EdgeSettings;
  /** Masks smoothed over time; null if smoothing is off. */
  smoothedMasks: SmoothedMasks | null;
  /** Position of the divider between original and result. */
  dividerPercent: number;
  spot: Spot;
  isCorrecting: boolean;
  /** The painted correction whose range can be changed; null after any other correction. */
  fix: Fix | null;
  /** True if the settings have changed since the run. */
  isOutdated: boolean;
}

const NO_FRAMES: Frames = { get: () => null, has: () => false, onReady() {} };

/** Default edges: removes specks, changes nothing else. */
export const DEFAULT_EDGES: EdgeSettings = { smallest: 0.02, grow: 0, feather: 0, smooth: 0 };

export const NOWHERE: Spot = { x: -1, y: -1, object: -1 };

/** State of a page without a clip. */
export const BLANK = {
  isOpening: false,
  notice: '',
  job: null,
  previousJob: null,
  share: 0,
  preview: null,
  isStreaming: false,
  picture: { width: 16, height: 9, images: NO_FRAMES },
  analysis: null,
  hidden: new Set<number>(),
  selected: new Set<number>(),
  timeline: { numFrames: 0, fps: 25, times: new Times(null), cuts: [] },
  doubts: [] as FrameRange[],
  agreement: null,
  fine: new Set<number>(),
  frame: 0,
  isPlaying: false,
  spot: NOWHERE,
  isCorrecting: false,
  fix: null,
};

const INITIAL: State = {
  ...BLANK,
  visit: 0,
  phase: 'opening',
  headline: 'Loading…',
  subline: '\u00a0',
  summary: '',
  announcement: '',
  error: null,
  name: '\u00a0',
  source: null,
  trim: DEFAULT_TRIM,
  pace: 0,
  changed: new Map(),
  loop: true,
  hasSound: false,
  isMuted: false,
  isReducedMotion: false,
  isNoisy: false,
  view: 'overlay',
  edges: DEFAULT_EDGES,
  smoothedMasks: null,
  backdrop: { name: 'transparent', colour: '#f4f1ea', picture: null },
  dividerPercent: 50,
  isOutdated: false,
};

export class Store {
  state: Readonly<State> = { ...INITIAL };
  watchers: { keys: (keyof State)[]; show: (state: Readonly<State>) => void; last: boolean }[] = [];

  /** Changes the state and calls each concerned watcher once. */
  set(patch: Partial<State>) {
    const keys = Object.keys(patch) as (keyof State)[];
    const changed = keys.filter((key) => !Object.is(patch[key], this.state[key]));
    this.state = { ...this.state, ...patch };
    for (const watcher of this.watchers)
      if (watcher.keys.some((key) => changed.includes(key))) watcher.show(this.state);
  }

  /**
   * Calls `show` now and whenever one of the keys changes.
   * @param options `last` calls it after all other watchers
   */
  watch(keys: (keyof State)[], show: (state: Readonly<State>) => void, { last = false }: { last?: boolean } = {}) {
    this.watchers.push({ keys, show, last });
    this.watchers.sort((a, b) => Number(a.last) - Number(b.last));
    show(this.state);
  }
}

/** Returns the changes that enter a phase. */
export function phasePatch(phase: Phase, headline: string, subline: string, summary = ''): Partial<State> {
  const announcement = [headline, subline, summary].filter(Boolean).join('. ');
  return { phase, headline, subline, summary, announcement, error: null };
}

export function errorPatch(error: unknown): Partial<State> {
  return { ...phasePatch('error', 'Nothing to show', ''), announcement: '', error };
}

/** Returns the shot of a frame. */
export function shotOf({ timeline: { cuts, numFrames } }: Pick<State, 'timeline'>, frame: number): FrameRange {
  return {
    from: Math.max(0, ...cuts.filter((cut) => cut <= frame)),
    to: Math.min(numFrames, ...cuts.filter((cut) => cut > frame)),
  };
}

export function clampFrame({ timeline }: Pick<State, 'timeline'>, frame: number): number {
  return Math.max(0, Math.min(timeline.numFrames - 1, frame));
}
