// Draws the output of each stage over a frame. Each layer has drawing modes, loads the maps it needs besides the result,
// draws them, and describes them by a legend and a line of figures.

import { drawLabels, parameters } from 'tracecut';
import { CUT_RED, EDGE_STYLES, drawBoundaries, drawCells, drawDiscontinuities, drawFlow } from 'tracecut/draw';
import { drawSaliency, drawSuperpixels, drawTrajectories, flowColor, heatColor, objectColor } from 'tracecut/draw';
import { EdgeKind } from 'tracecut/stages';
import { number } from './dom.js';

/** @typedef {import('tracecut').Result} Result */

/**
 * The input of a drawing: frame `t` of a run, in one of the layer's modes. `unit` is the size of a canvas pixel in frame
 * pixels.
 * @typedef {{run: import('./clip.js').Run, result: Result, t: number, image: OffscreenCanvas, mode: string, unit: number}} View
 */

/** Colours with their meaning. @typedef {[colors: string[], text: string][]} Legend */

/**
 * @typedef {object} Layer
 * @property {Record<string, string>} [modes]
 * @property {(view: View) => Promise<any>} [load]
 * @property {(context: CanvasRenderingContext2D, view: View, data: any) => void} draw
 * @property {(view: View, data: any) => Legend} [legend]
 * @property {(view: View, data: any) => string} facts
 */

const GREY = '#8d9199';

/** Opacity of maps that cover the frame, and of the black under lines and points. */
const MAP_OPACITY = 0.85;
const DIM_OPACITY = 0.45;

/** Quantile of the step lengths that gets full colour. */
const FAST_QUANTILE = 0.95;

/** Share of trajectories clipped at either end of an eigenvector's range. */
const OUTLIER_SHARE = 0.02;

/** Maximum number of entries in a legend. */
const MAX_ENTRIES = 12;

const DEFAULT_THRESHOLD = parameters().find(({ name }) => name === 'discontinuity.threshold').default;

/** @type {Record<string, Layer>} */
export const LAYERS = {
  frames: {
    draw() {},
    facts: ({ result }) => `${number(result.numFrames)} frames of ${result.width} × ${result.height} pixels.`,
  },

  flow: {
    load: ({ run, t, result }) => run.ask('flow', Math.min(t, result.numFrames - 2)),
    draw(context, { result }, field) {
      context.globalAlpha *= MAP_OPACITY;
      const grid = { scaleX: result.width / field.width, scaleY: result.height / field.height };
      drawFlow(context, { ...field, ...grid }, { scale: fastStep(result) });
    },
    legend: motionLegend,
    facts(_, { u, v }) {
      const speeds = u.map((value, p) => Math.hypot(value, v[p])).sort();
      return `${number(speeds[speeds.length >> 1], 1)} pixels per frame (median), ${number(speeds.at(-1), 1)} at most.`;
    },
  },

  trajectories: {
    draw(context, { result, t }) {
      dim(context, result);
      const scale = fastStep(result);
      const color = (i) => motionColor(...stepOf(result, i, t), scale);
      drawTrajectories(context, result, t, { shape: 'disc', color });
    },
    legend: motionLegend,
    facts({ result, t }) {
      const { count, x } = result.trajectories;
      const mean = number(x.length / Math.max(1, count), 1);
      return `${number(aliveIn(result, t).length)} in this frame, ${number(count)} in total, ${mean} frames long on average.`;
    },
  },

  embedding: {
    modes: {
      '1,2,3': 'Eigenvectors 2 to 4 as red, green, blue',
      ...Object.fromEntries([1, 2, 3, 4, 5, 6].map((k) => [k, `Eigenvector ${k + 1}`])),
    },
    draw(context, { result, t, mode }) {
      context.globalAlpha *= MAP_OPACITY;
      const columns = mode.split(',').map((k) => eigenvector(result, Number(k)));
      const color = (i) => (columns[1] ? hex(columns.map((column) => 255 * column[i])) : valueColor(columns[0][i]));
      drawCells(context, result, t, { color });
    },
    legend: ({ mode }) =>
      mode.includes(',') ? [[[], 'Similar colours mean similar motion.']] : [[heatColors(), 'low to high']],
    facts({ result }) {
      const { dimensions, eigenvalues } = result.embedding;
      return `${dimensions} eigenvectors with eigenvalues from ${number(eigenvalues[0], 3)} to ${number(eigenvalues[dimensions - 1], 3)}.`;
    },
  },

  discontinuities: {
    modes: {
      threshold: 'Above the threshold',
      strength: 'All, by strength',
      segments: 'Segments they separate (Figure 1c)',
    },
    draw(context, { run, result, t, mode }) {
      dim(context, result);
      if (mode === 'segments')
        drawTrajectories(context, { ...result, clusters: result.thresholdClusters }, t, { color: 'cluster' });
      else {
        const calm = 'rgb(255 255 255 / 0.4)';
        drawDiscontinuities(context, result, t, { calm, threshold: mode === 'strength' ? 0 : thresholdOf(run) });
      }
    },
    legend({ run, mode }) {
      if (mode === 'segments') return [[[0, 1, 2].map(objectColor), 'one colour per segment']];
      if (mode === 'strength') return [[[CUT_RED], 'd, by line width']];
      return [
        [[CUT_RED], `d above ${thresholdOf(run)}`],
        [['#ffffff'], 'other neighbours'],
      ];
    },
    facts({ run, result, t }) {
      const { d } = result.edges(t);
      const above = d.filter((value) => value > thresholdOf(run)).length;
      return `${number(above)} of ${number(d.length)} edges in this frame are above ${thresholdOf(run)}.`;
    },
  },

  saliency: {
    modes: {
      context: 'Trajectories in context (s̄)',
      trajectories: 'Trajectories (s)',
      pixels: 'Pixels (S)',
      foreground: 'Foreground',
      components: 'Connected components',
    },
    load: async ({ run, t, mode }) => (mode === 'pixels' ? run.ask('saliencyMap', t) : null),
    draw(context, { result, t, mode }, map) {
      const { inContext, ofPoints, foreground } = result.saliency;
      if (mode === 'foreground' || mode === 'components') {
        dim(context, result);
        const foregroundColor = mode === 'components' ? (i) => componentColor(result, i, t) : () => CUT_RED;
        const color = (i) => (foreground[i] ? foregroundColor(i) : GREY);
        return drawTrajectories(context, result, t, { shape: 'disc', color });
      }
      context.globalAlpha *= MAP_OPACITY;
      if (map) return drawSaliency(context, map);
      const values = mode === 'context' ? inContext : ofPoints;
      drawCells(context, result, t, { color: (i) => valueColor(values[i]) });
    },
    legend({ mode }) {
      if (mode === 'foreground') return [[[CUT_RED], 'foreground'], ...GREY_IS_BACKGROUND];
      if (mode !== 'components') return [[heatColors(), '0 to 1']];
      const component = [[1, 2, 3].map(objectColor), 'one colour per component'];
      return /** @type {Legend} */ ([component, [[CUT_RED], 'too small'], ...GREY_IS_BACKGROUND]);
    },
    facts({ result, t }) {
      const alive = aliveIn(result, t);
      const foreground = alive.filter((i) => result.saliency.foreground[i]);
      return `${number(foreground.length)} of ${number(alive.length)} trajectories in this frame are foreground, in ${result.components.count[t]} components.`;
    },
  },

  clusters: {
    modes: { cluster: 'By cluster', object: 'By object' },
    draw(context, { result, t, mode }) {
      dim(context, result);
      drawTrajectories(context, result, t, { color: mode });
    },
    legend({ result: { clusters }, mode }) {
      const labels =
        mode === 'object' && clusters.object.length > 0
          ? [...new Set(clusters.object)]
          : [...Array(clusters.count).keys()];
      const name = (label) => (mode === 'object' ? nameOf(label) : `Cluster ${label}`);
      const listed = labels.sort((a, b) => a - b).slice(0, MAX_ENTRIES);
      const entries = listed.map((label) => /** @type {Legend[0]} */ ([[objectColor(label)], name(label)]));
      const omitted = labels.length - listed.length;
      return omitted > 0 ? [...entries, [[], `and ${omitted} more`]] : entries;
    },
    facts({ result: { clusters, objects, masks } }) {
      if (masks.length === 0) return `${clusters.count} clusters.`;
      const background = clusters.object.filter((label) => label === 0).length;
      return `${clusters.count} clusters: ${background} background, ${clusters.count - background} in ${objects.length} objects.`;
    },
  },

  contours: {
    modes: { segments: 'Line segments over Pb', pb: 'Pb', thin: 'Ridges of Pb' },
    load: ({ run, t, mode }) =>
      Promise.all([run.ask('boundaries', t), mode === 'segments' ? run.ask('superpixels', t) : null]),
    draw(context, { mode, unit }, [map, superpixels]) {
      drawBoundaries(context, map, { of: mode === 'thin' ? 'thin' : 'pb' });
      if (superpixels) strokeContours(context, superpixels, 2 * unit);
    },
    legend({ mode }) {
      const pb = /** @type {Legend} */ ([[['#ffffff', '#808080', '#000000'], 'Pb, 0 to 0.6']]);
      return mode === 'segments' ? [...pb, [[EDGE_STYLES.Constraint.color], 'line segments']] : pb;
    },
    facts(_, [{ pb }]) {
      const share = pb.filter((value) => value > 0.1).length / pb.length;
      return `Pb is above 0.1 in ${number(100 * share)}% of this frame.`;
    },
  },

  superpixels: {
    modes: {
      gabriel: 'Gabriel graph (Figure 8b)',
      delaunay: 'Delaunay triangulation (Figure 8a)',
      mean: 'Superpixels in mean colours',
      random: 'Superpixels in random colours',
    },
    load: ({ run, t }) => run.ask('superpixels', t),
    draw(context, { image, mode, unit }, superpixels) {
      if (mode === 'mean' || mode === 'random') return drawSuperpixels(context, superpixels, { fill: mode, image });
      dim(context, image);
      const deleted = mode === 'delaunay';
      drawSuperpixels(context, superpixels, { fill: 'none', borders: false, edges: true, deleted, width: 3 * unit });
    },
    legend({ mode }) {
      if (mode === 'mean' || mode === 'random') return [];
      const kept = /** @type {Legend} */ ([
        [[EDGE_STYLES.Constraint.color], 'contour (constraint)'],
        [[EDGE_STYLES.Gabriel.color], 'Gabriel edge'],
      ]);
      return mode === 'delaunay' ? [...kept, [['#c8c8c8'], 'deleted edge']] : kept;
    },
    facts(_, { count, edges: { kind } }) {
      const numEdges = (name) => number(kind.filter((value) => value === EdgeKind[name]).length);
      return `${number(count)} superpixels in this frame. Edges: ${numEdges('Constraint')} contour, ${numEdges('Gabriel')} Gabriel, ${numEdges('Deleted')} deleted.`;
    },
  },

  cut: {
    modes: { masks: 'Masks', superpixels: 'Masks and superpixels', background: 'Scene without objects' },
    async load({ run, result, t, mode }) {
      if (!result.masks) return {};
      return mode === 'masks' ? {} : { [mode]: await run.ask(mode, t) };
    },
    draw(context, { result, t }, { superpixels, background }) {
      if (background) return drawBackground(context, background, result);
      if (result.masks.length > 0) drawLabels(context, result, t);
      if (superpixels) drawSuperpixels(context, superpixels, { fill: 'none' });
    },
    legend({ result, mode }) {
      if (mode === 'background') return [[['#000000'], 'covered in every frame']];
      return result.objects.map(({ label }) => [[objectColor(label)], nameOf(label)]);
    },
    facts({ result, t }) {
      if (!result.masks) return 'No masks: clip.dense is false.';
      const areas = result.objects.map((object) => object.areas[t]);
      const share = areas.reduce((sum, area) => sum + area, 0) / (result.width * result.height);
      return `${areas.filter(Boolean).length} of ${areas.length} objects are in this frame, covering ${number(100 * share)}% of it.`;
    },
  },
};

/** @type {Legend} */
const GREY_IS_BACKGROUND = [[[GREY], 'background']];

/** Returns the name of a mask label. @param {number} label */
export function nameOf(label) {
  return label === 0 ? 'Background' : `Object ${label}`;
}

function thresholdOf({ options }) {
  return options.discontinuity?.threshold ?? DEFAULT_THRESHOLD;
}

/** Returns the index in `x` and `y` of a trajectory's point in frame `t`, -1 if there is none. @param {Result} result */
export function pointIndex({ trajectories: { startFrame, offset } }, i, t) {
  const index = offset[i] + t - startFrame[i];
  return t >= startFrame[i] && index < offset[i + 1] ? index : -1;
}

/** Lists the trajectories with a point in frame `t`. @param {Result} result */
function aliveIn(result, t) {
  return [...Array(result.trajectories.count).keys()].filter((i) => pointIndex(result, i, t) >= 0);
}

/**
 * Returns a trajectory's step to frame `t` in pixels, or from `t` if it starts there.
 * @param {Result} result
 * @returns {[u: number, v: number]}
 */
function stepOf(result, i, t) {
  const { x, y, offset } = result.trajectories;
  const to = Math.max(pointIndex(result, i, t), offset[i] + 1);
  return [x[to] - x[to - 1], y[to] - y[to - 1]];
}

/** Returns the speed that gets full colour, in pixels per frame. @param {Result} result */
function fastStep(result) {
  const { count, startFrame } = result.trajectories;
  const steps = Float32Array.from({ length: count }, (_, i) => Math.hypot(...stepOf(result, i, startFrame[i]))).sort();
  return Math.max(0.5, steps[Math.floor(FAST_QUANTILE * (count - 1))] ?? 0);
}

/** @param {View} view @returns {Legend} */
function motionLegend({ result }) {
  return [
    [[motionColor(1, 0, 1)], 'right'],
    [[motionColor(0, 1, 1)], 'down'],
    [[motionColor(-1, 0, 1)], 'left'],
    [[motionColor(0, -1, 1)], 'up'],
    [[], `White: still. Full colour: ${number(fastStep(result), 1)} pixels per frame.`],
  ];
}

/** Returns eigenvector `k` scaled to 0 to 1, outliers clipped; `k` = 0 is the constant one. @param {Result} result */
function eigenvector({ embedding: { dimensions, vectors }, trajectories: { count } }, k) {
  const column = Float32Array.from({ length: count }, (_, i) => vectors[i * dimensions + k] ?? 0);
  const sorted = column.slice().sort();
  const low = sorted[Math.floor(OUTLIER_SHARE * (count - 1))];
  const high = sorted[Math.ceil((1 - OUTLIER_SHARE) * (count - 1))];
  return column.map((value) => Math.min(1, Math.max(0, (value - low) / (high - low || 1))));
}

/** @param {Result} result */
function componentColor(result, i, t) {
  const component = result.components.ofPoint[pointIndex(result, i, t)];
  return component < 0 ? CUT_RED : objectColor(1 + (component % 255));
}

/** Darkens the frame so that lines and points are visible. */
function dim(context, { width, height }) {
  context.fillStyle = `rgb(0 0 0 / ${DIM_OPACITY})`;
  context.fillRect(0, 0, width, height);
}

/** Strokes only the contour edges, which drawSuperpixels cannot do. */
function strokeContours(context, { edges: { kind, x0, y0, x1, y1 }, scaleX, scaleY }, width) {
  context.beginPath();
  kind.forEach((value, e) => {
    if (value !== EdgeKind.Constraint) return;
    context.moveTo((x0[e] + 0.5) * scaleX, (y0[e] + 0.5) * scaleY);
    context.lineTo((x1[e] + 0.5) * scaleX, (y1[e] + 0.5) * scaleY);
  });
  context.strokeStyle = EDGE_STYLES.Constraint.color;
  context.lineWidth = width;
  context.stroke();
}

/** Draws the scene without objects; pixels that are covered in every frame stay black. */
function drawBackground(context, { data, width, height }, size) {
  const canvas = new OffscreenCanvas(width, height);
  canvas.getContext('2d').putImageData(new ImageData(data, width, height), 0, 0);
  context.fillStyle = '#000';
  context.fillRect(0, 0, size.width, size.height);
  context.drawImage(canvas, 0, 0, size.width, size.height);
}

const heatColors = () => [0, 0.25, 0.5, 0.75, 1].map(valueColor);

function valueColor(value) {
  const rgba = new Uint8ClampedArray(4);
  heatColor(value, rgba);
  return hex([...rgba.subarray(0, 3)]);
}

function motionColor(u, v, scale) {
  const rgba = new Uint8ClampedArray(4);
  flowColor(u, v, scale, rgba);
  return hex([...rgba.subarray(0, 3)]);
}

/** @param {number[]} rgb */
function hex(rgb) {
  return `#${rgb.map((level) => Math.round(level).toString(16).padStart(2, '0')).join('')}`;
}
