// Draws what each stage has found over a frame. A layer is data, how it is drawn, its key, and a line of figures.

import { drawLabels } from 'tracecut';
import {
  CUT_RED,
  EDGE_STYLES,
  drawBoundaries,
  drawCells,
  drawDiscontinuities,
  drawFlow,
  drawSaliency,
  drawSuperpixels,
  drawTrajectories,
  flowColor,
  heatColor,
  objectColor,
} from 'tracecut/draw';
import { EdgeKind } from 'tracecut/stages';
import { number } from './dom.js';

/** @typedef {import('./run.js').Run} Run */
/** @typedef {import('tracecut').Result} Result */
/** @typedef {{colors: string[], text: string}} KeyEntry */

/**
 * What is drawn: frame `t` of a run, in one of the ways that the layer offers. `unit` is the size of a pixel of the
 * canvas in pixels of the frame.
 * @typedef {{run: Run, result: Result, t: number, image: OffscreenCanvas, mode: string, unit: number}} View
 */

/**
 * @template [D=any]
 * @typedef {object} Layer
 * @property {[mode: string, text: string][]} [modes] ways to draw it, the usual one first
 * @property {(view: View) => Promise<D>} [load] computes what it needs beside the result
 * @property {(context: CanvasRenderingContext2D, view: View, data: D) => void} draw
 * @property {(view: View, data: D) => KeyEntry[]} [key]
 * @property {(view: View, data: D) => string} [facts]
 */

const GREY = '#8d9199';

/** Values that the key of a heat map shows. */
const HEAT_STEPS = [0, 0.25, 0.5, 0.75, 1];

/** Opacity of maps that cover the frame. */
const MAP_OPACITY = 0.85;

/** Share of steps that are slower than what gets full colour. */
const FAST_QUANTILE = 0.95;

/** Ends of an eigenvector's range that are left out, as a share of all trajectories. */
const OUTLIER_SHARE = 0.02;

/** Trajectories with a larger discontinuity between them are parted, if no parameter says otherwise (section 2.2). */
const DEFAULT_THRESHOLD = 0.6;

/** @type {Layer} */
const frames = {
  draw() {},
  facts: ({ result, run }) =>
    `${number(result.numFrames)} frames of ${result.width} × ${result.height} pixels, segmented in ${number(seconds(run), 1)} s.`,
};

/** @type {Layer<import('tracecut').FlowField>} */
const flow = {
  load: ({ run, t, result }) => run.map('flow', Math.min(t, result.numFrames - 2)),
  draw(context, { result }, field) {
    context.globalAlpha *= MAP_OPACITY;
    const grid = { scaleX: result.width / field.width, scaleY: result.height / field.height };
    drawFlow(context, { ...field, ...grid }, { scale: fastStep(result) });
  },
  key: ({ result }) => motionKey(result),
  facts(_, { u, v }) {
    const speeds = u.map((value, p) => Math.hypot(value, Number(v[p])));
    const mean = speeds.reduce((sum, speed) => sum + speed, 0) / speeds.length;
    const fastest = speeds.reduce((most, speed) => Math.max(most, speed), 0);
    return `${number(mean, 2)} pixels per frame on average, ${number(fastest, 1)} at most.`;
  },
};

/** @type {Layer} */
const trajectories = {
  draw(context, { result, t }) {
    const scale = fastStep(result);
    drawTrajectories(context, result, t, {
      shape: 'disc',
      color: (i) => motionColor(...stepOf(result, i, t), scale),
    });
  },
  key: ({ result }) => motionKey(result),
  facts({ result, t }) {
    const { count, x } = result.trajectories;
    return `${number(aliveIn(result, t).length)} in this frame, ${number(count)} in all, ${number(x.length / Math.max(1, count), 1)} frames long on average.`;
  },
};

/** @type {Layer} */
const embedding = {
  modes: [
    ['1,2,3', 'Eigenvectors 2, 3 and 4 as red, green and blue'],
    ...[1, 2, 3, 4, 5, 6].map((k) => /** @type {[string, string]} */ ([String(k), `Eigenvector ${k + 1}`])),
  ],
  draw(context, { result, t, mode }) {
    const columns = mode.split(',').map((k) => eigenvector(result, Number(k)));
    const [red, green = red, blue = red] = columns;
    if (!red || !green || !blue) return;
    context.globalAlpha *= MAP_OPACITY;
    drawCells(context, result, t, {
      color: (i) =>
        columns.length > 1
          ? hex([red, green, blue].map((column) => 255 * Number(column[i])))
          : valueColor(Number(red[i])),
    });
  },
  key: ({ mode }) =>
    mode.includes(',')
      ? [{ colors: [], text: 'Cells of like colour move alike.' }]
      : [{ colors: HEAT_STEPS.map(valueColor), text: 'from low to high' }],
  facts({ result }) {
    const { dimensions, eigenvalues } = result.embedding;
    return `${number(dimensions)} eigenvectors, with eigenvalues from ${number(Number(eigenvalues[0]), 3)} to ${number(Number(eigenvalues[dimensions - 1]), 3)}.`;
  },
};

/** @type {Layer} */
const discontinuities = {
  modes: [
    ['threshold', 'Above the threshold'],
    ['strength', 'All, by strength'],
    ['segments', 'Parted by them alone (Figure 1c)'],
  ],
  draw(context, { run, result, t, mode }) {
    if (mode === 'segments') {
      const { thresholdClusters: clusters } = result;
      drawTrajectories(context, { ...own(result), clusters }, t, { color: 'cluster' });
    } else {
      const calm = 'rgb(255 255 255 / 0.4)';
      drawDiscontinuities(context, result, t, { calm, threshold: mode === 'strength' ? 0 : thresholdOf(run) });
    }
  },
  key: ({ run, mode }) =>
    mode === 'segments'
      ? [{ colors: [0, 1, 2].map(objectColor), text: 'a colour for each segment' }]
      : [
          { colors: [CUT_RED], text: mode === 'strength' ? 'wider: larger d' : `d above ${thresholdOf(run)}` },
          { colors: ['#ffffff'], text: mode === 'strength' ? 'd = 0' : 'other neighbours' },
        ],
  facts({ run, result, t }) {
    const { d } = result.edges(t);
    const above = d.filter((value) => value > thresholdOf(run)).length;
    return `${number(above)} of ${number(d.length)} edges in this frame are above ${thresholdOf(run)}; ${number(result.thresholdClusters.count)} segments by them alone.`;
  },
};

/** @type {Layer<import('tracecut').SaliencyMap | undefined>} */
const saliency = {
  modes: [
    ['context', 'Trajectories in context (s̄)'],
    ['trajectories', 'Trajectories (s)'],
    ['pixels', 'Pixels (S)'],
    ['foreground', 'Foreground'],
    ['components', 'Connected components'],
  ],
  load: async ({ run, t, mode }) => (mode === 'pixels' ? run.map('saliency', t) : undefined),
  draw(context, { result, t, mode }, map) {
    const { saliency: found } = result;
    if (!found) return;
    if (mode === 'foreground')
      return drawTrajectories(context, result, t, {
        shape: 'disc',
        color: (i) => (found.foreground[i] ? CUT_RED : GREY),
      });
    if (mode === 'components')
      return drawTrajectories(context, result, t, { shape: 'disc', color: (i) => componentColor(result, i, t) });
    context.globalAlpha *= MAP_OPACITY;
    if (map) return drawSaliency(context, map);
    const values = mode === 'context' ? found.inContext : found.ofPoints;
    drawCells(context, result, t, { color: (i) => valueColor(Number(values[i])) });
  },
  key({ mode }) {
    if (mode === 'foreground')
      return [
        { colors: [CUT_RED], text: 'foreground' },
        { colors: [GREY], text: 'background' },
      ];
    if (mode === 'components')
      return [
        { colors: [1, 2, 3].map(objectColor), text: 'a colour for each component' },
        { colors: [CUT_RED], text: 'too small' },
        { colors: [GREY], text: 'background' },
      ];
    return [{ colors: HEAT_STEPS.map(valueColor), text: '0 to 1' }];
  },
  facts({ result, t }) {
    const foreground = result.saliency?.foreground ?? [];
    const inFrame = aliveIn(result, t);
    const salient = inFrame.filter((i) => foreground[i]).length;
    return `${number(salient)} of ${number(inFrame.length)} trajectories in this frame are foreground, in ${number(Number(result.components?.count[t] ?? 0))} components.`;
  },
};

/** @type {Layer} */
const clusters = {
  modes: [
    ['cluster', 'By cluster'],
    ['object', 'By object'],
  ],
  draw: (context, { result, t, mode }) =>
    drawTrajectories(context, result, t, { color: /** @type {'cluster' | 'object'} */ (mode) }),
  key({ result, mode }) {
    const { count, object } = result.clusters;
    const labels = mode === 'object' && object ? [...new Set(object)].sort((a, b) => a - b) : [...Array(count).keys()];
    const shown = labels.slice(0, 12);
    const entries = shown.map((label) => ({ colors: [objectColor(label)], text: nameOf(label, mode) }));
    return labels.length > shown.length
      ? [...entries, { colors: [], text: `and ${labels.length - shown.length} more` }]
      : entries;
  },
  facts: ({ result }) =>
    `${number(result.clusters.count)} clusters, of which ${number(Array.from(result.clusters.object ?? []).filter((label) => label > 0).length)} belong to ${number(result.objects?.length ?? 0)} objects.`,
};

/** @type {Layer<{map: import('tracecut').BoundaryMap, superpixels: import('tracecut').Superpixels | undefined}>} */
const contours = {
  modes: [
    ['segments', 'Line segments over Pb'],
    ['pb', 'Pb'],
    ['thin', 'Ridges of Pb'],
  ],
  async load({ run, t, mode }) {
    const map = await run.map('boundaries', t);
    return { map, superpixels: mode === 'segments' ? await run.map('superpixels', t) : undefined };
  },
  draw(context, { mode, unit }, { map, superpixels }) {
    drawBoundaries(context, map, { of: mode === 'thin' ? 'thin' : 'pb' });
    if (superpixels) strokeEdges(context, superpixels, 'Constraint', 2 * unit);
  },
  key: ({ mode }) => [
    { colors: ['#ffffff', '#808080', '#000000'], text: 'Pb, 0 to 0.6' },
    ...(mode === 'segments' ? [{ colors: [EDGE_STYLES.Constraint.color], text: 'line segments' }] : []),
  ],
  facts: (_, { map }) =>
    `Pb is above 0.1 in ${number((100 * map.pb.filter((value) => value > 0.1).length) / map.pb.length, 1)}% of the frame.`,
};

/** @type {Layer<import('tracecut').Superpixels>} */
const superpixels = {
  modes: [
    ['gabriel', 'Gabriel graph (Figure 8b)'],
    ['delaunay', 'Delaunay triangulation (Figure 8a)'],
    ['mean', 'Superpixels in their mean colour'],
    ['random', 'Superpixels in random colours'],
  ],
  load: ({ run, t }) => run.map('superpixels', t),
  draw(context, { image, mode, unit }, found) {
    if (mode === 'mean' || mode === 'random') return drawSuperpixels(context, found, { fill: mode, image });
    const deleted = mode === 'delaunay';
    drawSuperpixels(context, found, { fill: 'none', borders: false, edges: true, deleted, width: 2.5 * unit });
  },
  key: ({ mode }) =>
    mode === 'mean' || mode === 'random'
      ? []
      : [
          { colors: [EDGE_STYLES.Constraint.color], text: 'contour (constraint)' },
          { colors: [EDGE_STYLES.Gabriel.color], text: 'Gabriel edge' },
          ...(mode === 'delaunay' ? [{ colors: ['#c8c8c8'], text: 'deleted edge' }] : []),
        ],
  facts(_, { count, edges }) {
    const ofKind = (/** @type {number} */ kind) => number(edges.kind.filter((one) => one === kind).length);
    return `${number(count)} superpixels in this frame: ${ofKind(EdgeKind.Constraint)} contour edges, ${ofKind(EdgeKind.Gabriel)} Gabriel edges, ${ofKind(EdgeKind.Deleted)} deleted.`;
  },
};

/** @typedef {{sure: Float32Array, background?: import('tracecut').Background, superpixels?: import('tracecut').Superpixels}} CutData */

/** @type {Layer<CutData>} */
const cut = {
  modes: [
    ['masks', 'Masks'],
    ['superpixels', 'Masks and superpixels'],
    ['background', 'Scene without objects'],
  ],
  async load({ run, result, t, mode }) {
    const sure = result.masks ? await result.objectConfidence() : new Float32Array();
    if (mode === 'background') return { sure, background: await run.map('background', t) };
    return mode === 'superpixels' ? { sure, superpixels: await run.map('superpixels', t) } : { sure };
  },
  draw(context, { result, t }, { background, superpixels: found }) {
    if (!result.masks) return;
    if (background) return drawBackground(context, result, background);
    drawLabels(context, /** @type {import('tracecut').MaskSource} */ (result), t);
    if (found) drawSuperpixels(context, found, { fill: 'none' });
  },
  key: ({ result }, { sure }) =>
    (result.objects ?? []).map(({ label }) => ({
      colors: [objectColor(label)],
      text: `Object ${label}, ${number(100 * Number(sure[label]))}% confident`,
    })),
  facts({ result, t }) {
    if (!result.masks) return 'No masks: clip.dense is off.';
    const areas = (result.objects ?? []).map((object) => Number(object.areas[t]));
    const covered = areas.reduce((sum, area) => sum + area, 0) / (result.width * result.height);
    return `${number(areas.filter(Boolean).length)} of ${number(areas.length)} objects in this frame; they cover ${number(100 * covered, 1)}% of it.`;
  },
};

export const LAYERS = {
  frames,
  flow,
  trajectories,
  embedding,
  discontinuities,
  saliency,
  clusters,
  contours,
  superpixels,
  cut,
};

/**
 * Names a label of the masks, or a cluster.
 * @param {number} label
 * @param {string} [mode]
 */
export function nameOf(label, mode = 'object') {
  if (mode === 'cluster') return `Cluster ${label}`;
  return label === 0 ? 'Background' : `Object ${label}`;
}

/** @param {Run} run */
function seconds({ result }) {
  return Object.values(result.seconds).reduce((sum, one) => sum + one, 0);
}

/** @param {Run} run */
function thresholdOf({ options }) {
  return options.discontinuity?.threshold ?? DEFAULT_THRESHOLD;
}

/** The fields that drawing needs, to replace one. @param {Result} result */
function own({ width, height, numFrames, trajectories: list }) {
  return { width, height, numFrames, trajectories: list };
}

/**
 * Lists the trajectories that have a point in frame `t`.
 * @param {Result} result
 * @param {number} t
 */
function aliveIn({ trajectories: { count, startFrame, offset } }, t) {
  return [...Array(count).keys()].filter((i) => {
    const age = t - Number(startFrame[i]);
    return age >= 0 && age < Number(offset[i + 1]) - Number(offset[i]);
  });
}

/**
 * Returns the place of a trajectory's point of frame `t` in `x` and `y`.
 * @param {Result} result
 * @param {number} i
 * @param {number} t
 */
function pointIndex({ trajectories: { startFrame, offset } }, i, t) {
  return Number(offset[i]) + t - Number(startFrame[i]);
}

/**
 * Returns the step of a trajectory to frame `t`, or from it if it starts there, in pixels.
 * @param {Result} result
 * @param {number} i
 * @param {number} t
 * @returns {[u: number, v: number]}
 */
function stepOf(result, i, t) {
  const { x, y, offset } = result.trajectories;
  const to = Math.max(pointIndex(result, i, t), Number(offset[i]) + 1);
  return [Number(x[to]) - Number(x[to - 1]), Number(y[to]) - Number(y[to - 1])];
}

/** @type {WeakMap<Result, number>} */
const fastSteps = new WeakMap();

/**
 * Returns the length of a fast step of the clip, in pixels per frame: it gets full colour.
 * @param {Result} result
 */
function fastStep(result) {
  const known = fastSteps.get(result);
  if (known) return known;
  const { count, startFrame, offset } = result.trajectories;
  const steps = Float32Array.from({ length: count }, (_, i) => {
    const middle = (Number(offset[i + 1]) - Number(offset[i])) >> 1;
    return Math.hypot(...stepOf(result, i, Number(startFrame[i]) + middle));
  }).sort();
  const fast = Math.max(0.5, Number(steps[Math.floor(FAST_QUANTILE * (steps.length - 1))] ?? 0));
  fastSteps.set(result, fast);
  return fast;
}

/** @param {Result} result @returns {KeyEntry[]} */
function motionKey(result) {
  const arrows = /** @type {const} */ ([
    [1, 0, 'right'],
    [0, 1, 'down'],
    [-1, 0, 'left'],
    [0, -1, 'up'],
  ]);
  return [
    ...arrows.map(([u, v, text]) => ({ colors: [motionColor(u, v, 1)], text })),
    { colors: [], text: `White: still. Full colour: ${number(fastStep(result), 1)} pixels per frame.` },
  ];
}

/**
 * Returns one eigenvector scaled to 0 to 1 over the trajectories, without its outliers.
 * @param {Result} result
 * @param {number} k 0 is the constant one
 */
function eigenvector({ embedding: { dimensions, vectors }, trajectories: { count } }, k) {
  const column = Float32Array.from({ length: count }, (_, i) => Number(vectors[i * dimensions + k] ?? 0));
  const sorted = column.slice().sort();
  const at = (/** @type {number} */ share) => Number(sorted[Math.round(share * (count - 1))]);
  const [low, high] = [at(OUTLIER_SHARE), at(1 - OUTLIER_SHARE)];
  return column.map((value) => Math.min(1, Math.max(0, (value - low) / (high - low || 1))));
}

/**
 * @param {Result} result
 * @param {number} i
 * @param {number} t
 */
function componentColor(result, i, t) {
  if (!result.saliency?.foreground[i]) return GREY;
  const component = Number(result.components?.ofPoint[pointIndex(result, i, t)]);
  return component < 0 ? CUT_RED : objectColor(1 + (component % 255));
}

/**
 * Strokes one kind of edges alone, which drawSuperpixels cannot.
 * @param {CanvasRenderingContext2D} context
 * @param {import('tracecut').Superpixels} found
 * @param {'Constraint' | 'Gabriel'} kind
 * @param {number} width
 */
function strokeEdges(context, { edges, scaleX, scaleY }, kind, width) {
  context.beginPath();
  edges.kind.forEach((one, e) => {
    if (one !== EdgeKind[kind]) return;
    context.moveTo((Number(edges.x0[e]) + 0.5) * scaleX, (Number(edges.y0[e]) + 0.5) * scaleY);
    context.lineTo((Number(edges.x1[e]) + 0.5) * scaleX, (Number(edges.y1[e]) + 0.5) * scaleY);
  });
  context.strokeStyle = EDGE_STYLES[kind].color;
  context.lineWidth = width;
  context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Result} result
 * @param {import('tracecut').Background} background
 */
function drawBackground(context, result, { data, width, height }) {
  const canvas = new OffscreenCanvas(width, height);
  /** @type {OffscreenCanvasRenderingContext2D} */ (canvas.getContext('2d')).putImageData(
    new ImageData(data, width, height),
    0,
    0,
  );
  context.drawImage(canvas, 0, 0, result.width, result.height);
}

/** The colour of a motion, for CSS. @param {number} u @param {number} v @param {number} scale that gets full colour */
function motionColor(u, v, scale) {
  const rgba = new Uint8ClampedArray(4);
  flowColor(u, v, scale, rgba);
  return hex([...rgba.subarray(0, 3)]);
}

/** The colour of a value of 0 to 1, for CSS. @param {number} value */
function valueColor(value) {
  const rgba = new Uint8ClampedArray(4);
  heatColor(value, rgba);
  return hex([...rgba.subarray(0, 3)]);
}

/** @param {number[]} rgb */
function hex(rgb) {
  return `#${rgb.map((level) => Math.round(level).toString(16).padStart(2, '0')).join('')}`;
}
