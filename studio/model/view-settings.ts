// View settings of a result: edges, hidden objects and backdrop. Saved with the project.

import { type Backdrop as CutoutBackdrop, type MaskEdges, SCREEN_GREEN } from './library.js';
import { DEFAULT_EDGES, type Backdrop, type State } from './store.js';

/**
 * `smallest` piece in percent of the frame; `grow` (negative: shrink) and `feather` in pixels of the masks; `smooth`
 * over this many frames before and after.
 */
export type EdgeSettings = { smallest: number; grow: number; feather: number; smooth: number };

export const PROJECT_EXTENSION = '.tracecut';

export function maskEdges(
  { smallest, grow, feather }: EdgeSettings,
  { width, height }: { width: number; height: number },
): MaskEdges {
  return { smallest: Math.ceil((smallest / 100) * width * height), grow, feather };
}

/** A backdrop picture is not saved: it becomes transparent. */
export interface ViewSettings {
  edges: EdgeSettings;
  hidden: number[];
  backdrop: { name: string; colour: string };
}

/** Valid ranges of the edges. */
const EDGE_RANGES: Record<keyof EdgeSettings, [min: number, max: number]> = {
  smallest: [0, 1],
  grow: [-10, 10],
  feather: [0, 20],
  smooth: [0, 2],
};
const STORED_BACKDROPS: BackdropName[] = ['transparent', 'green', 'colour', 'blurred', 'desaturated', 'dimmed'];

export function toViewSettings({
  edges,
  hidden,
  backdrop: { name, colour },
}: Pick<State, 'edges' | 'hidden' | 'backdrop'>): ViewSettings {
  const storedName = name === 'picture' ? 'transparent' : name;
  return { edges: { ...edges }, hidden: [...hidden], backdrop: { name: storedName, colour } };
}

/** Validates view settings from a file and returns the changes. */
export function viewSettingsPatch(settings: unknown, { backdrop }: State): Partial<State> {
  if (!settings) return {};
  const fields = settings as { edges?: Record<string, unknown>; hidden?: unknown; backdrop?: unknown };
  const edges = { ...DEFAULT_EDGES };
  for (const [name, [min, max]] of Object.entries(EDGE_RANGES) as [keyof typeof EDGE_RANGES, [number, number]][]) {
    const value = fields.edges?.[name];
    if (isWithin(value, min, max)) edges[name] = value;
  }
  edges.smooth = Math.round(edges.smooth);
  const hidden = Array.isArray(fields.hidden) ? fields.hidden.filter((object) => isWithin(object, 0, 255)) : [];
  return { edges, hidden: new Set(hidden), backdrop: { ...backdrop, ...readBackdrop(fields.backdrop) } };
}

function readBackdrop(backdrop: unknown): Partial<Backdrop> {
  const { name, colour } = (backdrop ?? {}) as { name?: unknown; colour?: unknown };
  const stored = STORED_BACKDROPS.find((backdropName) => backdropName === name);
  if (!stored) return {};
  return { name: stored, ...(typeof colour === 'string' && /^#[0-9a-f]{6}$/.test(colour) ? { colour } : {}) };
}

function isWithin(value: unknown, min: number, max: number): value is number {
  return typeof value === 'number' && value >= min && value <= max;
}

export type BackdropName = 'transparent' | 'green' | 'colour' | 'blurred' | 'desaturated' | 'dimmed' | 'picture';

export type View = 'overlay' | 'beside' | 'slider' | 'cutout';

export function toCutoutBackdrop({ name, colour, picture }: Backdrop): CutoutBackdrop {
  if (name === 'green') return SCREEN_GREEN;
  if (name === 'colour') return colour;
  return name === 'picture' && picture ? picture : name;
}
