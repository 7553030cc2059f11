// What the page knows, in one place. Everyone may read it, change it with `set`, and watch the keys that they show:
// the document is written from it and never read back. What only one panel looks at stays with that panel.

import { DEFAULT_TAKE, type Source, type Take } from './source.js';
import { type Facts, Times } from './presence.js';
import type { Answers, Spot } from './answers.js';
import type { AnyJob } from './job.js';
import type { EdgeChoice, GroundName, View } from './look.js';
import type { Points } from './points.js';
import type { Preview } from './preview.js';
import type { Smoothed } from './smoothing.js';

/**
 * What the page is doing. Several phases share one of the four public states in `document.body.dataset.state`, see
 * panels/status.ts.
 */
export type Phase = 'opening' | 'running' | 'stopped' | 'done' | 'error';

/**
 * Frames to show: `get` gives null for one that is still on its way; then `onReady` is called. `more` frames after it are
 * made ready too.
 */
export type Frames = {
  get: (frame: number, more?: number) => CanvasImageSource | null;
  has: (frame: number) => boolean;
  onReady: () => void;
};

/** What the viewer shows, size in pixels. */
type Picture = { width: number; height: number; images: Frames };

/** What the timeline goes over: `fps` frames a second, and the frames with which new shots begin. */
export type Film = { numFrames: number; fps: number; times: Times; cuts: number[] };

/** What is known of the clip by now. */
interface Found {
  /** Null for a still image. */
  points: Points | null;
  /** Of each object, the background among them. */
  facts: Facts[];
  answers: Partial<Answers>;
}

export type Ground = { name: GroundName; colour: string; picture: ImageBitmap | null };

export interface State {
  /** Grows whenever something else begins: what was awaited before that is void. */
  visit: number;
  phase: Phase;
  headline: string;
  subline: string;
  /** What is seen, empty for nothing. */
  summary: string;
  /** Shown above the picture, empty for none. */
  notice: string;
  /** What screen readers are told. */
  live: string;
  error: unknown;
  name: string;
  source: Source | null;
  take: Take;
  /** Milliseconds that the last run took per pixel and frame. */
  pace: Record<'clip' | 'still', number>;
  /** Parameters that differ from their defaults. */
  changed: ReadonlyMap<string, number | boolean | string>;
  job: AnyJob | null;
  /** Corrected, until it was run again. */
  before: AnyJob | null;
  /** Of the run that is through, in 0..1. */
  share: number;
  /** Shown until there are masks. */
  preview: Preview | null;
  /** Whether windows of a run under way are shown already. */
  streaming: boolean;
  picture: Picture;
  found: Found | null;
  hidden: ReadonlySet<number>;
  /** Objects that are to be joined, into the first. */
  chosen: ReadonlySet<number>;
  film: Film;
  frame: number;
  playing: boolean;
  loop: boolean;
  /** Whether nothing is to move by itself. */
  calm: boolean;
  /** Whether the browser alters pixels that a page reads. */
  isNoisy: boolean;
  view: View;
  /** What cut-out objects lie on. */
  ground: Ground;
  edges: EdgeChoice;
  /** Masks as far as they are smoothed over time; null where they are not. */
  smoothed: Smoothed | null;
  /** Where the original ends under the slider, in percent. */
  split: number;
  spot: Spot;
  correcting: boolean;
  /** Whether the result was made with other settings than those chosen now. */
  pending: boolean;
}

const NO_FRAMES: Frames = { get: () => null, has: () => false, onReady() {} };

/** Specks are nobody's wish. */
export const DEFAULT_EDGES: EdgeChoice = { smallest: 0.02, grow: 0, feather: 0, smooth: 0 };

export const NOWHERE: Spot = { x: -1, y: -1, object: -1 };

/** The state of a page with no clip. */
export const BLANK = {
  notice: '',
  job: null,
  before: null,
  preview: null,
  streaming: false,
  picture: { width: 16, height: 9, images: NO_FRAMES },
  found: null,
  hidden: new Set<number>(),
  chosen: new Set<number>(),
  film: { numFrames: 0, fps: 25, times: new Times(null), cuts: [] },
  frame: 0,
  playing: false,
  spot: NOWHERE,
  correcting: false,
};

const INITIAL: State = {
  ...BLANK,
  visit: 0,
  phase: 'opening',
  headline: 'Loading…',
  subline: '\u00a0',
  summary: '',
  live: '',
  error: null,
  name: '\u00a0',
  source: null,
  take: DEFAULT_TAKE,
  pace: { clip: 0, still: 0 },
  changed: new Map(),
  share: 0,
  loop: true,
  calm: false,
  isNoisy: false,
  view: 'overlay',
  edges: DEFAULT_EDGES,
  smoothed: null,
  ground: { name: 'transparent', colour: '#f4f1ea', picture: null },
  split: 50,
  pending: false,
};

export class Store {
  state: Readonly<State> = { ...INITIAL };
  watchers: { keys: (keyof State)[]; show: (state: Readonly<State>) => void; last: boolean }[] = [];

  /** Changes state and tells everyone whom it concerns, once each, before it returns. */
  set(patch: Partial<State>) {
    const keys = Object.keys(patch) as (keyof State)[];
    const changed = keys.filter((key) => !Object.is(patch[key], this.state[key]));
    this.state = { ...this.state, ...patch };
    for (const watcher of this.watchers)
      if (watcher.keys.some((key) => changed.includes(key))) watcher.show(this.state);
  }

  /**
   * Shows what there is, and again whenever one of these keys changes.
   * @param order `last` for whoever is to find everything else in place
   */
  watch(keys: (keyof State)[], show: (state: Readonly<State>) => void, { last = false }: { last?: boolean } = {}) {
    this.watchers.push({ keys, show, last });
    this.watchers.sort((a, b) => Number(a.last) - Number(b.last));
    show(this.state);
  }
}

/** Enters a phase. */
export function phasePatch(phase: Phase, headline: string, subline: string, summary = ''): Partial<State> {
  const live = [headline, subline, summary].filter(Boolean).join('. ');
  return { phase, headline, subline, summary, live, error: null };
}

export function errorPatch(error: unknown): Partial<State> {
  return { ...phasePatch('error', 'Nothing to show', ''), live: '', error };
}

/** Clamps a frame to the film. */
export function withinFilm({ film }: Pick<State, 'film'>, frame: number): number {
  return Math.max(0, Math.min(film.numFrames - 1, frame));
}
