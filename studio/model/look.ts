// What was chosen for a result beside its masks: their edges and smoothing, what is kept, the ground. Kept with the
// work.

import { type Backdrop as CutoutGround, type MaskEdges, SCREEN_GREEN } from './library.js';
import { DEFAULT_EDGES, type Ground, type State } from './store.js';

/**
 * The smallest piece that counts, in percent of the frame; how far objects grow, or shrink where it is negative, and how
 * soft their edges are, in pixels of the masks; over how many frames before and after they are smoothed.
 */
export type EdgeChoice = { smallest: number; grow: number; feather: number; smooth: number };

/** A project file's extension. */
export const EXTENSION = '.tracecut';

export function edgesOf(
  { smallest, grow, feather }: EdgeChoice,
  { width, height }: { width: number; height: number },
): MaskEdges {
  return { smallest: Math.ceil((smallest / 100) * width * height), grow, feather };
}

/** Grounds with a picture are kept without it: they are transparent. */
export interface Look {
  edges: EdgeChoice;
  /** Objects that are not kept. */
  hidden: number[];
  ground: { name: string; colour: string };
}

/** What edges may be. */
const RANGES: Record<keyof EdgeChoice, [min: number, max: number]> = {
  smallest: [0, 1],
  grow: [-10, 10],
  feather: [0, 20],
  smooth: [0, 2],
};
const KEPT_GROUNDS: GroundName[] = ['transparent', 'green', 'colour', 'blurred', 'desaturated', 'dimmed'];

export function lookOf({ edges, hidden, ground: { name, colour } }: Pick<State, 'edges' | 'hidden' | 'ground'>): Look {
  const known = name === 'picture' ? 'transparent' : name;
  return { edges: { ...edges }, hidden: [...hidden], ground: { name: known, colour } };
}

/** What a file says is looked at closely: anyone may have written it. */
export function lookPatch(look: unknown, { ground }: State): Partial<State> {
  if (!look) return {};
  const found = look as { edges?: Record<string, unknown>; hidden?: unknown; ground?: unknown };
  const edges = { ...DEFAULT_EDGES };
  for (const [name, [min, max]] of Object.entries(RANGES) as [keyof typeof RANGES, [number, number]][]) {
    const value = found.edges?.[name];
    if (isWithin(value, min, max)) edges[name] = value;
  }
  edges.smooth = Math.round(edges.smooth);
  const hidden = Array.isArray(found.hidden) ? found.hidden.filter((one) => isWithin(one, 0, 255)) : [];
  return { edges, hidden: new Set(hidden), ground: { ...ground, ...savedGround(found.ground) } };
}

function savedGround(ground: unknown): Partial<Ground> {
  const { name, colour } = (ground ?? {}) as { name?: unknown; colour?: unknown };
  const kept = KEPT_GROUNDS.find((one) => one === name);
  if (!kept) return {};
  return { name: kept, ...(typeof colour === 'string' && /^#[0-9a-f]{6}$/.test(colour) ? { colour } : {}) };
}

function isWithin(value: unknown, min: number, max: number): value is number {
  return typeof value === 'number' && value >= min && value <= max;
}

export type GroundName = 'transparent' | 'green' | 'colour' | 'blurred' | 'desaturated' | 'dimmed' | 'picture';

export type View = 'overlay' | 'beside' | 'slider' | 'cutout';

export function groundOf({ name, colour, picture }: Ground): CutoutGround {
  if (name === 'green') return SCREEN_GREEN;
  if (name === 'colour') return colour;
  return name === 'picture' && picture ? picture : name;
}
