// Why a pixel has its label: the costs that the cut compared in its superpixel, and what they come from.

import { objectColor } from 'tracecut/draw';
import { byId, h, number } from './dom.js';
import { nameOf } from './layers.js';

/** @typedef {import('tracecut').Explanation} Explanation */
/** @typedef {import('./run.js').Run} Run */

/** Labels and affinities that are listed, at most. */
const MAX_LABELS = 5;
const MAX_AFFINITIES = 3;

/** Sizes of the cross and of the points of trajectories, in pixels of the canvas. */
const CROSS = { inner: 8, outer: 24 };
const POINT_RADIUS = 7;

export class WhyPanel {
  /** @type {{t: number, x: number, y: number} | null} */
  place = null;
  /** @type {Explanation | null} */
  #why = null;
  #asked = 0;
  #answer = byId('why-answer');
  #x = /** @type {HTMLInputElement} */ (byId('why-x'));
  #y = /** @type {HTMLInputElement} */ (byId('why-y'));

  /**
   * @param {object} page
   * @param {(x: number, y: number) => void} page.onPlace called with the place that the user entered
   * @param {() => void} page.redraw
   */
  constructor({ onPlace, redraw }) {
    this.redraw = redraw;
    byId('why-form').addEventListener('submit', (event) => {
      event.preventDefault();
      onPlace(this.#x.valueAsNumber, this.#y.valueAsNumber);
    });
  }

  clear() {
    this.#asked += 1;
    [this.place, this.#why] = [null, null];
    this.#answer.replaceChildren();
  }

  /**
   * Explains pixel `x`, `y` of frame `t`.
   * @param {Run} run
   * @param {number} t
   * @param {number} x
   * @param {number} y
   */
  async ask(run, t, x, y) {
    const { result } = run;
    this.#asked += 1;
    const mine = this.#asked;
    [this.place, this.#why] = [{ t, x, y }, null];
    for (const [input, value, size] of /** @type {const} */ ([
      [this.#x, x, result.width],
      [this.#y, y, result.height],
    ])) {
      input.max = String(size - 1);
      input.value = String(value);
    }
    const why = await result.explain(t, x, y);
    const confidence = await run.map('confidence', t);
    if (mine !== this.#asked) return;
    this.#why = why;
    const [column, row] = [Math.floor(x / confidence.scaleX), Math.floor(y / confidence.scaleY)];
    this.#show(why, Number(confidence.confidence[row * confidence.width + column]));
    this.redraw();
  }

  /**
   * @param {Explanation} why
   * @param {number} confidence
   */
  #show(why, confidence) {
    const { t, x, y } = /** @type {{t: number, x: number, y: number}} */ (this.place);
    this.#answer.replaceChildren(
      h(
        'p',
        { class: 'why-title' },
        `${nameOf(why.label)} at (${x}, ${y}) in frame ${t + 1}, ${number(100 * confidence)}% confident`,
      ),
      h('ul', {}, ...reasonsOf(why).map((reason) => h('li', {}, reason))),
      costTable(why),
    );
  }

  /**
   * Marks the pixel, and the trajectories that vote in its superpixel.
   * @param {CanvasRenderingContext2D} context
   * @param {number} t
   * @param {number} unit
   */
  draw(context, t, unit) {
    if (!this.place || this.place.t !== t) return;
    for (const { x, y, cluster } of this.#why?.voters ?? []) {
      const label = this.#why?.costs.find((cost) => cost.cluster === cluster)?.label ?? 0;
      context.beginPath();
      context.arc(x + 0.5, y + 0.5, POINT_RADIUS * unit, 0, 2 * Math.PI);
      context.fillStyle = objectColor(label);
      context.fill();
      context.strokeStyle = '#000';
      context.lineWidth = 2 * unit;
      context.stroke();
    }
    drawCross(context, this.place.x + 0.5, this.place.y + 0.5, unit);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} x
 * @param {number} y
 * @param {number} unit
 */
function drawCross(context, x, y, unit) {
  const [inner, outer] = [CROSS.inner * unit, CROSS.outer * unit];
  context.beginPath();
  for (const [dx, dy] of /** @type {const} */ ([
    [1, 0],
    [-1, 0],
    [0, 1],
    [0, -1],
  ])) {
    context.moveTo(x + dx * inner, y + dy * inner);
    context.lineTo(x + dx * outer, y + dy * outer);
  }
  for (const [style, width] of /** @type {const} */ ([
    ['#000', 6],
    ['#fff', 3],
  ])) {
    context.strokeStyle = style;
    context.lineWidth = width * unit;
    context.stroke();
  }
}

/**
 * Lists the reasons, a sentence each.
 * @param {Explanation} why
 * @returns {string[]}
 */
function reasonsOf(why) {
  return [sourceOf(why), votersOf(why), flipOf(why), ...borderOf(why), ...affinitiesOf(why)];
}

/** @param {Explanation} why */
function sourceOf({ source, superpixel, cluster }) {
  if (source === 'border')
    return `The cut labels its superpixel (${superpixel}) otherwise: the border was moved here afterwards.`;
  if (source === 'stroke') return 'A stroke decides.';
  return `The cut gives its superpixel (${superpixel}) to cluster ${cluster}.`;
}

/** @param {Explanation} why */
function votersOf({ voters, weight }) {
  if (voters.length === 0) return 'No trajectory crosses the superpixel: colours and neighbours decide.';
  const unlike = voters.filter(({ stranger }) => stranger).length;
  const outliers = unlike > 0 ? ` (${unlike} move like none around them and count for every object)` : '';
  return `${voters.length} trajectories in it vote${outliers}, with weight λ = ${number(weight, 2)}.`;
}

/** @param {Explanation} why */
function flipOf({ flip, costs }) {
  if (!flip) return 'There is no other label.';
  const other = nameOf(labelOf(costs, flip.cluster));
  const votes =
    flip.votes === Infinity
      ? 'no number of trajectories alone would change it'
      : `${number(flip.votes)} more trajectories of it would change it`;
  return `${other} would cost ${number(flip.margin, 2)} more; ${votes}.`;
}

/** @param {Explanation} why */
function borderOf({ border }) {
  if (!border) return [];
  return [
    `${border.edges} edges join the two labels in this frame, with discontinuity ${number(border.mean, 2)} on average and ${number(border.d, 2)} at most.`,
  ];
}

/** @param {Explanation} why */
function affinitiesOf({ nearest, affinities }) {
  if (nearest < 0 || affinities.length === 0) return [];
  const list = affinities.slice(0, MAX_AFFINITIES).map(({ to, affinity }) => `${to} (${number(affinity, 2)})`);
  return [`The nearest trajectory, ${nearest}, has the largest affinities A to ${list.join(', ')}.`];
}

/**
 * @param {Explanation['costs']} costs
 * @param {number} cluster
 */
function labelOf(costs, cluster) {
  return costs.find((cost) => cost.cluster === cluster)?.label ?? 0;
}

/**
 * Lists what the cheapest labels would cost, each by its cheapest cluster.
 * @param {Explanation} why
 */
function costTable({ costs, cluster }) {
  const sorted = [...costs].sort((a, b) => a.total - b.total);
  const cheapest = sorted.filter(({ label }, k) => sorted.findIndex((other) => other.label === label) === k);
  const columns = /** @type {const} */ (['trajectories', 'colours', 'evidence', 'links', 'total']);
  const head = ['Label', 'Votes', ...columns.map((name) => `${String(name[0]).toUpperCase()}${name.slice(1)}`)];
  return h(
    'div',
    { class: 'scroll', tabindex: 0, role: 'group', 'aria-label': 'Costs of each label' },
    h(
      'table',
      {},
      h('caption', {}, 'Cost of each label here; the cut looks for the least in sum'),
      h('thead', {}, h('tr', {}, ...head.map((text) => h('th', { scope: 'col' }, text)))),
      h(
        'tbody',
        {},
        ...cheapest
          .slice(0, MAX_LABELS)
          .map((cost) =>
            h(
              'tr',
              { class: cost.cluster === cluster ? 'is-chosen' : '' },
              h('th', { scope: 'row' }, nameOf(cost.label)),
              h('td', {}, number(cost.votes)),
              ...columns.map((name) => h('td', {}, number(cost[name], 2))),
            ),
          ),
      ),
    ),
  );
}
