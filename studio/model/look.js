/**
 * What was chosen for a result beside its masks: their edges and smoothing, what is kept, the ground. Kept with the
 * work.
 * @module
 */

import { SCREEN_GREEN } from './library.js';
import { DEFAULT_EDGES } from './store.js';

/**
 * The smallest piece that counts, in percent of the frame; how far objects grow, or shrink where it is negative, and how
 * soft their edges are, in pixels of the masks; over how many frames before and after they are smoothed.
 *
 * @typedef {{smallest: number, grow: number, feather: number, smooth: number}} EdgeChoice
 */

/** A project file's extension. */
export const EXTENSION = '.tracecut';

/**
 * @param {EdgeChoice} choice
 * @param {{width: number, height: number}} size of the masks
 * @returns {import('./library.js').MaskEdges} as the package takes it
 */
export function edgesOf({ smallest, grow, feather }, { width, height }) {
  return { smallest: Math.ceil((smallest / 100) * width * height), grow, feather };
}

/** @typedef {import('./store.js').State} State */

/**
 * Grounds with a picture are kept without it: they are transparent.
 *
 * @typedef {object} Look
 * @property {EdgeChoice} edges
 * @property {number[]} hidden objects that are not kept
 * @property {{name: string, colour: string}} ground
 */

/** What edges may be. @type {Record<keyof EdgeChoice, [min: number, max: number]>} */
const RANGES = { smallest: [0, 1], grow: [-10, 10], feather: [0, 20], smooth: [0, 2] };
const KEPT_GROUNDS = ['transparent', 'green', 'colour', 'blurred', 'desaturated', 'dimmed'];

/**
 * @param {Pick<State, 'edges' | 'hidden' | 'ground'>} state
 * @returns {Look}
 */
export function lookOf({ edges, hidden, ground: { name, colour } }) {
  const known = name === 'picture' ? 'transparent' : name;
  return { edges: { ...edges }, hidden: [...hidden], ground: { name: known, colour } };
}

/**
 * What a file says is looked at closely: anyone may have written it.
 *
 * @param {unknown} look undefined in works of earlier versions
 * @param {State} state
 * @returns {Partial<State>} what of it can be taken
 */
export function lookPatch(look, { ground }) {
  if (!look) return {};
  const found = /** @type {{edges?: any, hidden?: any, ground?: any}} */ (look);
  const edges = { ...DEFAULT_EDGES };
  for (const [name, [min, max]] of /** @type {[keyof typeof RANGES, [number, number]][]} */ (Object.entries(RANGES)))
    if (isWithin(found.edges?.[name], min, max)) edges[name] = found.edges[name];
  edges.smooth = Math.round(edges.smooth);
  const hidden = Array.isArray(found.hidden) ? found.hidden.filter((one) => isWithin(one, 0, 255)) : [];
  return { edges, hidden: new Set(hidden), ground: { ...ground, ...savedGround(found.ground) } };
}

/**
 * @param {any} ground
 * @returns {Partial<import('./store.js').Ground>}
 */
function savedGround(ground) {
  if (!KEPT_GROUNDS.includes(ground?.name)) return {};
  return {
    name: ground.name,
    ...(/^#[0-9a-f]{6}$/.test(ground.colour) ? { colour: ground.colour } : {}),
  };
}

/**
 * @param {unknown} value
 * @param {number} min
 * @param {number} max
 */
function isWithin(value, min, max) {
  return typeof value === 'number' && value >= min && value <= max;
}

/** @typedef {'transparent' | 'green' | 'colour' | 'blurred' | 'desaturated' | 'dimmed' | 'picture'} GroundName */

/** @typedef {'overlay' | 'beside' | 'slider' | 'cutout'} View */

/**
 * @param {import('./store.js').Ground} ground
 * @returns {import('./library.js').Ground} as the package takes it
 */
export function groundOf({ name, colour, picture }) {
  if (name === 'green') return SCREEN_GREEN;
  if (name === 'colour') return colour;
  return name === 'picture' && picture ? picture : name;
}
