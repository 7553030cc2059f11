/**
 * Why a pixel has its label: clicked in the picture, or under a cursor that the arrow keys move. Says what each label
 * would cost there, who votes, what holds it and what would change it. Fetched when it is first opened.
 * @module
 */

import { byId, h } from '../dom.js';
import { Fetched, picture, valueAt } from '../layers/fetched.js';
import { objectColor, objectName } from '../result/palette.js';
import { count, explain, percent } from '../words.js';

/** @typedef {import('../library.js').Explanation} Explanation */
/** @typedef {{t: number, x: number, y: number}} Place in pixels of the clip */

/** Pixels that an arrow key goes, alone and with Shift. */
const STEP = 1;
const STRIDE = 10;
/** @type {Record<string, [number, number]>} */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

export class WhyPanel {
  /** @param {Pick<import('../page.js').Page, 'store' | 'viewer'>} page */
  constructor({ store, viewer }) {
    this.store = store;
    this.viewer = viewer;
    /** @type {Place | null} */
    this.place = null;
    /** @type {Explanation | null} of the place, once it is there */
    this.why = null;
    /** Grows with each question: answers to earlier ones are void. */
    this.asked = 0;
    this.title = h('p', { class: 'why-title', role: 'status' });
    // It scrolls where there are many labels.
    this.words = h('div', { class: 'why-words', role: 'group', 'aria-label': 'Reasons', tabindex: 0 });
    this.sureness = h('p', { class: 'why-sure' });
    this.shows = h('input', { type: 'checkbox', id: 'why-sure', change: () => viewer.redraw() });
    this.sure = new Fetched('confidence', (map) => ({ map, canvas: picture(map, (ctx) => drawUnsure(ctx, map)) }));
    const sure = h('label', {}, this.shows, ' ', 'Show where labels are unsure');
    const close = h('button', { type: 'button', click: () => this.close() }, 'Done');
    const section = h(
      'section',
      { class: 'block why', id: 'why', 'aria-label': 'Why?' },
      this.title,
      close,
      this.sureness,
      sure,
      this.words,
    );
    byId('panel').prepend(section);
    this.section = section;
    viewer.painters.push((ctx, view) => this.draw(ctx, view));
    viewer.onPick(({ x, y }) => this.ask({ t: store.state.frame, x: Math.round(x), y: Math.round(y) }));
    viewer.canvas.addEventListener('keydown', (event) => this.press(event));
    store.watch(['asking'], () => this.show());
    store.watch(['visit', 'found', 'correcting'], ({ found, correcting }) => this.leave(!found || correcting));
    store.watch(
      ['frame'],
      ({ frame }) => this.place && this.place.t !== frame && this.ask({ ...this.place, t: frame }),
    );
  }

  get on() {
    return this.store.state.asking;
  }

  /** What the button does. */
  open() {
    if (this.on) return this.close();
    const { found } = this.store.state;
    if (!found?.answers.explain) return;
    if (this.store.state.correcting) byId('correct-done').click();
    this.store.set({ asking: true, playing: false });
    const { width, height } = this.viewer.view;
    this.viewer.canvas.focus();
    this.ask({ t: this.store.state.frame, x: width >> 1, y: height >> 1 });
  }

  close() {
    this.store.set({ asking: false });
    byId('why-open').focus();
  }

  /** The result is another one: what was said is void. @param {boolean} over */
  leave(over) {
    this.asked += 1;
    this.sure.reset();
    if (this.on && over) this.store.set({ asking: false });
    else if (this.on && this.place) this.ask(this.place);
  }

  show() {
    const { on } = this;
    this.section.hidden = !on;
    byId('why-open').setAttribute('aria-pressed', String(on));
    if (on) this.viewer.canvas.tabIndex = 0;
    else this.viewer.canvas.removeAttribute('tabindex');
    if (!on) [this.place, this.why] = [null, null];
    this.viewer.redraw();
  }

  /** @param {KeyboardEvent} event */
  press(event) {
    const arrow = ARROWS[event.key];
    if (!this.on || !this.place || !arrow || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    event.stopPropagation();
    const by = event.shiftKey ? STRIDE : STEP;
    this.ask({ ...this.place, x: this.place.x + arrow[0] * by, y: this.place.y + arrow[1] * by });
  }

  /** @param {Place} place is brought into the picture */
  async ask({ t, x, y }) {
    const answer = this.store.state.found?.answers.explain;
    if (!this.on || !answer) return;
    const { width, height } = this.viewer.view;
    const within = (/** @type {number} */ value, /** @type {number} */ size) => Math.min(size - 1, Math.max(0, value));
    const place = { t, x: within(x, width), y: within(y, height) };
    this.asked += 1;
    const { asked } = this;
    this.place = place;
    this.viewer.redraw();
    try {
      const why = await answer(place.t, place.x, place.y);
      if (asked === this.asked) this.tell(place, why);
    } catch (error) {
      if (asked === this.asked) this.title.textContent = explain(error).title;
    }
  }

  /**
   * @param {Place} place
   * @param {Explanation} why
   */
  tell(place, why) {
    this.why = why;
    const { x, y, t } = place;
    this.title.textContent = `${objectName(why.label)} at ${count(x)}, ${count(y)} in frame ${count(t + 1)}`;
    const points = this.store.state.found?.points;
    const shown = points?.objectAt(t, x, y) ?? why.label;
    const reasons = reasonsOf(why, shown).map((text) => h('li', {}, text));
    this.words.replaceChildren(h('ul', {}, ...reasons), costTable(why));
    this.viewer.redraw();
  }

  /**
   * Draws the voters in the colours of their objects, strangers hollow; the edge that holds most; and the cursor.
   *
   * @param {CanvasRenderingContext2D} ctx scaled to clip pixels
   * @param {import('../layers/layer.js').View} view
   */
  draw(ctx, view) {
    const { place, why } = this;
    const sure = this.on ? this.sure.get(view, view.frame) : undefined;
    if (sure && this.shows.checked) ctx.drawImage(sure.canvas, -0.5, -0.5, view.width, view.height);
    if (!this.on || !place || place.t !== view.frame) return;
    const p = sure && valueAt(sure.map, sure.map.confidence, view, place);
    this.sureness.textContent = p === undefined ? '' : `This label is right with ${percent(p)}.`;
    ctx.save();
    if (why) this.drawEdge(ctx, view, why);
    for (const voter of why?.voters ?? []) drawVoter(ctx, view, voter, why);
    drawCross(ctx, view, place);
    ctx.restore();
  }

  /**
   * @param {CanvasRenderingContext2D} ctx
   * @param {import('../layers/layer.js').View} view
   * @param {Explanation} why
   */
  drawEdge(ctx, { points, frame, unit }, { border }) {
    if (!points || !border) return;
    const { startFrame, offset, x, y } = points.result.trajectories;
    const [from, to] = [border.i, border.j].map((i) => offset[i] + frame - startFrame[i]);
    ctx.lineWidth = 3 * unit;
    ctx.strokeStyle = '#fff';
    ctx.beginPath();
    ctx.moveTo(x[from], y[from]);
    ctx.lineTo(x[to], y[to]);
    ctx.stroke();
  }
}

/**
 * Red, the more opaque the less sure.
 *
 * @param {OffscreenCanvasRenderingContext2D} ctx
 * @param {import('../layers/layer.js').Confidence} map
 */
function drawUnsure(ctx, { width, height, confidence }) {
  const image = new ImageData(width, height);
  confidence.forEach((p, k) => image.data.set([214, 0, 0, Math.round(255 * (1 - p))], 4 * k));
  ctx.putImageData(image, 0, 0);
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('../layers/layer.js').View} view
 * @param {Explanation['voters'][number]} voter
 * @param {Explanation | null} why
 */
function drawVoter(ctx, { unit }, { x, y, cluster }, why) {
  const cost = why?.costs[cluster];
  ctx.beginPath();
  ctx.arc(x, y, 4 * unit, 0, 2 * Math.PI);
  ctx.lineWidth = 1.5 * unit;
  ctx.strokeStyle = '#fff';
  ctx.fillStyle = cost?.label ? objectColor(cost.label) : '#000';
  if (cost) ctx.fill();
  ctx.stroke();
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('../layers/layer.js').View} view
 * @param {Place} place
 */
function drawCross(ctx, { unit }, { x, y }) {
  const [near, far] = [5 * unit, 14 * unit];
  for (const [width, colour] of /** @type {[number, string][]} */ ([
    [4, '#000'],
    [2, '#fff'],
  ])) {
    ctx.lineWidth = width * unit;
    ctx.strokeStyle = colour;
    ctx.beginPath();
    for (const [dx, dy] of Object.values(ARROWS)) {
      ctx.moveTo(x + dx * near, y + dy * near);
      ctx.lineTo(x + dx * far, y + dy * far);
    }
    ctx.stroke();
  }
}

/** Affinities that are told. */
const TOLD = 3;

/**
 * @param {Explanation} why
 * @param {number} shown the label that the mask on screen has there
 * @returns {string[]} a sentence each
 */
function reasonsOf(why, shown) {
  return [
    sourceOf(why, shown),
    flipOf(why),
    votersOf(why),
    evidenceOf(why),
    linksOf(why),
    ...borderOf(why),
    ...nearOf(why),
  ];
}

/**
 * @param {Explanation} why
 * @param {number} shown
 */
function sourceOf({ label, source, superpixel, cluster, costs }, shown) {
  if (shown !== label) return `The mask on screen has ${objectName(shown)} here: it was changed by hand.`;
  if (source === 'stroke') return 'A stroke over it decides.';
  const own = objectName(costs[cluster]?.label ?? 0);
  if (source === 'border')
    return `Its superpixel ${superpixel} is ${own}; the step after the cut has moved the border over it.`;
  return `Its superpixel ${superpixel} has this label by the cut.`;
}

/** @param {Explanation} why */
function flipOf({ flip, costs }) {
  if (!flip) return 'There is no other label that it could have.';
  const other = objectName(costs[flip.cluster]?.label ?? 0);
  const more = cost(flip.margin);
  return flip.votes === Infinity
    ? `It would be ${other} for a cost of ${more} more; no number of trajectories alone would make it that.`
    : `It would be ${other} for a cost of ${more} more: ${count(flip.votes)} more trajectories of it here would do.`;
}

/** @param {Explanation} why */
function votersOf({ voters, weight }) {
  const strange = voters.filter(({ stranger }) => stranger).length;
  if (voters.length === 0) return 'No trajectory votes here; colours and neighbours decide.';
  return `Trajectories that vote here: ${count(voters.length)}, of them strangers: ${count(strange)}. Their weight is ${weight.toFixed(2)}.`;
}

/** @param {Explanation} why */
function evidenceOf({ evidence: { background, looks } }) {
  return `For an object speak the background with ${cost(background)} and looks with ${cost(looks)}; less than 0 is against.`;
}

/** @param {Explanation} why */
function linksOf({ links, costs, cluster }) {
  const own = costs[cluster]?.label;
  const sum = (/** @type {boolean} */ same) =>
    links.filter((link) => (costs[link.cluster]?.label === own) === same).reduce((total, link) => total + link.cost, 0);
  return `Links to neighbours of its own label hold it with ${cost(sum(true))}, those to others pull with ${cost(sum(false))}.`;
}

/** @param {Explanation} why */
function borderOf({ border }) {
  if (!border) return [];
  const { edges, mean, d } = border;
  return [
    `Edges between the two in this frame: ${count(edges)}, of discontinuity ${mean.toFixed(2)} on average and ${d.toFixed(2)} at most.`,
  ];
}

/** @param {Explanation} why */
function nearOf({ nearest, affinities }) {
  if (nearest < 0 || affinities.length === 0) return [];
  const told = affinities.slice(0, TOLD).map(({ to, affinity }) => `${count(to)} (${affinity.toFixed(2)})`);
  return [`The nearest trajectory is ${count(nearest)}; it moves most like ${told.join(', ')}.`];
}

/**
 * What each label costs: a column for each cluster, a row for each term.
 *
 * @param {Explanation} why
 */
function costTable({ costs, cluster }) {
  const cells = (/** @type {(one: Explanation['costs'][number]) => string} */ text) =>
    costs.map((one) => h('td', { class: one.cluster === cluster ? 'is-own' : '' }, text(one)));
  const heads = costs.map((one) => h('th', { scope: 'col' }, objectName(one.label)));
  const scope = { scope: 'row' };
  return h(
    'table',
    {},
    h('caption', {}, 'What each label would cost here; the least is taken'),
    h('thead', {}, h('tr', {}, h('td', {}), ...heads)),
    h(
      'tbody',
      {},
      h('tr', {}, h('th', scope, 'Votes'), ...cells(({ votes }) => count(votes))),
      h('tr', {}, h('th', scope, 'Trajectories'), ...cells(({ trajectories }) => cost(trajectories))),
      h('tr', {}, h('th', scope, 'Colours'), ...cells(({ colours }) => cost(colours))),
      h('tr', {}, h('th', scope, 'Evidence'), ...cells(({ evidence }) => cost(evidence))),
      h('tr', {}, h('th', scope, 'Links'), ...cells(({ links }) => cost(links))),
      h('tr', {}, h('th', scope, 'Forbidden'), ...cells(({ forbidden }) => cost(forbidden))),
      h('tr', { class: 'why-sum' }, h('th', scope, 'Sum'), ...cells(({ total }) => cost(total))),
    ),
  );
}

/** @param {number} value */
function cost(value) {
  return value.toFixed(2);
}
