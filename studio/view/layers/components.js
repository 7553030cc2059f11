/**
 * The connected pieces of the foreground in the frame, each in a colour that it keeps while its trajectories last.
 * @module
 */

import { drawTrajectories } from '../library.js';
import { h, key } from '../dom.js';
import { fromCorner, opacity, toggle } from './layer.js';
import { markerSize } from './trajectories.js';
import { CUT_RED, FAINT, objectColor, objectShape } from '../result/palette.js';
import { NOTHING } from '../words.js';

/** @typedef {import('./layer.js').View} View */
/** @typedef {import('../result/points.js').Points} Points */

/** Links longer than this many distances between points cross gaps, and are not drawn. */
const MAX_STEPS = 4;

/** Size of the points that belong to no component. */
const FAINT_SIZE = 0.55;

/** @returns {import('./layer.js').Layer} */
export function componentLayer() {
  const links = toggle('Links', true);
  /** @type {Int32Array[] | null} */
  let colors = null;
  return {
    id: 'components',
    name: 'Components',
    key: 'c',
    only: 'clip',
    about: 'Connected pieces of the foreground. Trajectories that are in two of them are not one thing.',
    z: 64,
    on: false,
    settings: { opacity: opacity(), links },
    legend: () => [
      h(
        'span',
        { class: 'key' },
        ...[1, 2, 3].map((n) => key('dot', objectColor(n), '')),
        'a colour for each component',
      ),
      key('dot', CUT_RED, 'foreground, too small a piece'),
      key('dot', FAINT, 'background'),
    ],
    missing: ({ points }) => (points ? reason(points) : ''),
    reset() {
      colors = null;
    },
    draw(ctx, view) {
      const { points } = view;
      if (!points?.result.components || !points.result.saliency) return;
      colors ??= steadyColors(points);
      const own = colors[view.frame];
      const { foreground } = points.result.saliency;
      const pieceOf = (/** @type {number} */ i) => points.result.components?.ofPoint[points.index(i, view.frame)] ?? -1;
      const { radius, width } = markerSize(view);
      const drawPoints = (/** @type {import('../library.js').DrawTrajectoriesOptions} */ options) =>
        fromCorner(ctx, () =>
          drawTrajectories(ctx, points.result, view.frame, {
            objects: view.visible,
            tail: 0,
            radius,
            width,
            ...options,
          }),
        );
      drawPoints({
        which: (i) => pieceOf(i) < 0 && !foreground[i],
        color: FAINT,
        radius: FAINT_SIZE * radius,
        rim: false,
      });
      drawPoints({ which: (i) => pieceOf(i) < 0 && foreground[i] === 1, color: CUT_RED, radius: FAINT_SIZE * radius });
      if (links.value > 0) drawLinks(ctx, view, points, own);
      const number = (/** @type {number} */ i) => steady(own[pieceOf(i)]);
      drawPoints({
        which: (i) => pieceOf(i) >= 0,
        color: (i) => objectColor(number(i)),
        shape: (i) => objectShape(number(i)),
      });
    },
    readout({ points, frame }, { trajectory }) {
      const { components } = points?.result ?? {};
      if (!points || !components || trajectory < 0) return '';
      const component = components.ofPoint[points.index(trajectory, frame)];
      return component < 0 ? 'no component' : `component ${component + 1} of ${components.count[frame]}`;
    },
  };
}

/** @param {Points} points */
function reason({ result: { components, saliency } }) {
  if (!components || !saliency) return NOTHING.motion;
  if (components.count.some(Boolean)) return '';
  return saliency.foreground.includes(1) ? NOTHING.pieces : NOTHING.foreground;
}

/**
 * Components are numbered anew in each frame. Here they get numbers that last: each takes the number of most of
 * its trajectories' last ones, where two want the same the one with more of them, and what is left over a new one.
 *
 * @param {Points} points of a result with components
 * @returns {Int32Array[]} for each frame the lasting number of each of its components
 */
export function steadyColors(points) {
  const { numFrames, trajectories, components } = points.result;
  const { count, ofPoint } = /** @type {{count: Uint32Array, ofPoint: Int32Array}} */ (components);
  const last = new Int32Array(trajectories.count).fill(-1);
  let before = new Set();
  return Array.from({ length: numFrames }, (_, frame) => {
    const members = [...points.at(frame).id]
      .map((id) => ({ id, component: ofPoint[points.index(id, frame)] }))
      .filter(({ component }) => component >= 0);
    const numbers = inherited(count[frame], members, last);
    for (let c = 0; c < numbers.length; c++) if (numbers[c] < 0) numbers[c] = firstFree(numbers, before);
    for (const { id, component } of members) last[id] = numbers[component];
    before = new Set(numbers);
    return numbers;
  });
}

/**
 * @param {number} count components of the frame
 * @param {{id: number, component: number}[]} members
 * @param {Int32Array} last number of each trajectory, -1 for none
 * @returns {Int32Array} -1 for components that inherit none
 */
function inherited(count, members, last) {
  /** @type {Map<string, {component: number, number: number, votes: number}>} */
  const ballots = new Map();
  for (const { id, component } of members) {
    if (last[id] < 0) continue;
    const ballot = ballots.get(`${component} ${last[id]}`) ?? { component, number: last[id], votes: 0 };
    ballot.votes += 1;
    ballots.set(`${component} ${last[id]}`, ballot);
  }
  const numbers = new Int32Array(count).fill(-1);
  for (const { component, number } of [...ballots.values()].sort((a, b) => b.votes - a.votes)) {
    if (numbers[component] < 0 && !numbers.includes(number)) numbers[component] = number;
  }
  return numbers;
}

/**
 * @param {Int32Array} numbers of this frame
 * @param {Set<number>} before those of the frame before
 */
function firstFree(numbers, before) {
  let number = 0;
  while (numbers.includes(number) || before.has(number)) number += 1;
  return number;
}

/**
 * The label whose colour a lasting number takes; there may be more of them than labels.
 *
 * @param {number} number
 */
function steady(number) {
  return 1 + (number % 255);
}

/**
 * @param {import('./layer.js').Canvas2D} ctx
 * @param {View} view
 * @param {Points} points
 * @param {Int32Array} colors
 */
function drawLinks(ctx, view, points, colors) {
  const { i, j } = points.result.edges(view.frame);
  const { x, y } = points.result.trajectories;
  const ofPoint = points.result.components?.ofPoint ?? new Int32Array();
  const longest = MAX_STEPS * points.spacing(view.frame);
  const paths = Array.from(colors, () => new Path2D());
  for (let e = 0; e < i.length; e++) {
    const [a, b] = [points.index(i[e], view.frame), points.index(j[e], view.frame)];
    if (a < 0 || b < 0 || ofPoint[a] < 0 || ofPoint[a] !== ofPoint[b] || points.distance(a, b) > longest) continue;
    if (!view.visible(points.object[i[e]]) || !view.visible(points.object[j[e]])) continue;
    paths[ofPoint[a]].moveTo(x[a], y[a]);
    paths[ofPoint[a]].lineTo(x[b], y[b]);
  }
  ctx.lineWidth = 0.9 * view.unit;
  paths.forEach((path, component) => {
    ctx.strokeStyle = objectColor(steady(colors[component]));
    ctx.stroke(path);
  });
}
