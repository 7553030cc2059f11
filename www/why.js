// Explains why a pixel has its label: the costs that the cut compared in its superpixel, and their sources.

import { objectColor } from 'tracecut/draw';
import { byId, h, number } from './dom.js';
import { nameOf, pointIndex } from './layers.js';

/** @typedef {import('tracecut').Explanation} Explanation */

/** Maximum number of listed labels. */
const MAX_LABELS = 5;

/** Sizes on the canvas, in pixels. */
const POINT_RADIUS = 7;
const CROSS = { inner: 8, outer: 24 };

const form = byId('why-form');
const answer = byId('why-answer');

export class Why {
  /** The explained pixel: frame `t`, `x` and `y`; null if there is none. */
  pixel = null;
  /** @type {Explanation} */
  #explanation = null;

  /** Empties the panel. */
  clear() {
    this.pixel = this.#explanation = null;
    answer.replaceChildren();
  }

  /** Explains pixel `x`, `y` of frame `t`. @param {import('./clip.js').Run} run */
  async ask(run, t, x, y) {
    const pixel = (this.pixel = { t, x, y });
    this.#explanation = null;
    [form.x.value, form.y.value] = [x, y];
    const explanation = await run.result.explain(t, x, y);
    if (pixel !== this.pixel) return;
    this.#explanation = explanation;
    const title = `${nameOf(explanation.label)} at (${x}, ${y}) in frame ${t + 1}`;
    const reasons = h('ul', {}, ...reasonsOf(explanation).map((reason) => h('li', {}, reason)));
    answer.replaceChildren(h('p', { class: 'why-title' }, title), reasons, costTable(explanation));
  }

  /**
   * Draws the pixel, the trajectories that vote for its superpixel, and the strongest affinities of the nearest one.
   * @param {CanvasRenderingContext2D} context
   * @param {import('./layers.js').View} view
   */
  draw(context, { result, t, unit }) {
    if (this.pixel?.t !== t) return;
    if (this.#explanation) {
      drawAffinities(context, result, t, this.#explanation, 3 * unit);
      for (const voter of this.#explanation.voters) drawVoter(context, voter, this.#explanation, unit);
    }
    drawCross(context, this.pixel, unit);
  }
}

/** Lists the reasons, one sentence each. @param {Explanation} explanation */
function reasonsOf({ source, superpixel, cluster, costs, voters, weight, flip, border, affinities }) {
  const runnerUp = flip && nameOf(costs.find((cost) => cost.cluster === flip.cluster).label);
  return [
    {
      superpixel: `The cut assigned its superpixel (${superpixel}) to cluster ${cluster}.`,
      border: `The cut gave its superpixel (${superpixel}) another label; border refinement changed it.`,
      stroke: 'A stroke set it.',
    }[source],
    voters.length > 0
      ? `${voters.length} trajectories in the superpixel vote, with weight λ = ${number(weight, 2)}.`
      : 'No trajectory crosses the superpixel: colours and neighbours decide.',
    flip
      ? `${runnerUp} would cost ${number(flip.margin, 2)} more: ${flip.votes === Infinity ? 'votes alone cannot change the label' : `${number(flip.votes)} more votes would change the label`}.`
      : 'There is no other label.',
    border &&
      `${border.edges} edges in this frame join the two labels, with discontinuity ${number(border.mean, 2)} on average.`,
    affinities.length > 0 && `White lines: the ${affinities.length} largest affinities of the nearest trajectory.`,
  ].filter(Boolean);
}

/** Builds the table of the cheapest labels, each with the cost of its cheapest cluster. @param {Explanation} explanation */
function costTable({ costs, cluster }) {
  const sorted = [...costs].sort((a, b) => a.total - b.total);
  const rows = sorted.filter(({ label }, k) => sorted.findIndex((cost) => cost.label === label) === k);
  const columns = ['total', 'trajectories', 'evidence', 'links'];
  const heads = ['label', 'votes', ...columns].map((name) => h('th', { scope: 'col' }, name));
  const body = rows.slice(0, MAX_LABELS).map((cost) => {
    const cells = [number(cost.votes), ...columns.map((name) => number(cost[name], 2))];
    const isChosen = cost.cluster === cluster ? 'is-chosen' : '';
    return h(
      'tr',
      { class: isChosen },
      h('th', { scope: 'row' }, nameOf(cost.label)),
      ...cells.map((text) => h('td', {}, text)),
    );
  });
  const caption = h('caption', {}, 'Cost of each label here; the cut minimizes the sum over all superpixels');
  const table = h('table', {}, caption, h('thead', {}, h('tr', {}, ...heads)), h('tbody', {}, ...body));
  return h('div', { class: 'scroll', tabindex: 0, role: 'group', 'aria-label': 'Costs of each label' }, table);
}

function drawAffinities(context, result, t, { nearest, affinities }, width) {
  const { x, y } = result.trajectories;
  const from = nearest < 0 ? -1 : pointIndex(result, nearest, t);
  const ends = affinities.map(({ to }) => pointIndex(result, to, t)).filter((to) => from >= 0 && to >= 0);
  const lines = ends.map((to) => [x[from], y[from], x[to], y[to]]);
  stroke(context, lines, '#fff', width);
}

function drawVoter(context, { x, y, cluster }, { costs }, unit) {
  context.beginPath();
  context.arc(x + 0.5, y + 0.5, POINT_RADIUS * unit, 0, 2 * Math.PI);
  context.fillStyle = objectColor(costs.find((cost) => cost.cluster === cluster)?.label ?? 0);
  context.fill();
  context.strokeStyle = '#000';
  context.lineWidth = 2 * unit;
  context.stroke();
}

function drawCross(context, { x, y }, unit) {
  const [inner, outer] = [CROSS.inner * unit, CROSS.outer * unit];
  const lines = [-1, 1].flatMap((side) => [
    [x + side * inner, y, x + side * outer, y],
    [x, y + side * inner, x, y + side * outer],
  ]);
  stroke(context, lines, '#000', 6 * unit);
  stroke(context, lines, '#fff', 3 * unit);
}

/** Strokes lines between pixel centres, each x, y, x, y. */
function stroke(context, lines, color, width) {
  context.beginPath();
  for (const [x0, y0, x1, y1] of lines) {
    context.moveTo(x0 + 0.5, y0 + 0.5);
    context.lineTo(x1 + 0.5, y1 + 0.5);
  }
  context.strokeStyle = color;
  context.lineWidth = width;
  context.stroke();
}
