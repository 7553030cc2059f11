// Why a pixel has its label: the terms of the cut, as the session tells them, and what follows from them and from what
// the result has.

import { TraceCutError } from './errors.js';

/**
 * What a cluster would cost the superpixel, all else as it is: by its trajectories, by colours where no trajectory has a
 * say, by evidence from background and looks, by links to neighbours of other clusters, and where a stroke forbids it.
 * `total` is the sum. `label` is the cluster's label in the masks, `votes` the number of its trajectories here.
 * @typedef {{readonly cluster: number, readonly label: number, readonly votes: number, readonly trajectories: number,
 *   readonly colours: number, readonly evidence: number, readonly links: number, readonly forbidden: number,
 *   readonly total: number}} LabelCost
 */

/**
 * A superpixel that shares a border (same `t`) or is of the frame before or after, with `tracks` trajectories in common;
 * `cost` is what it costs to have another cluster than that one.
 * @typedef {{readonly t: number, readonly superpixel: number, readonly cluster: number, readonly tracks: number,
 *   readonly cost: number}} SuperpixelLink
 */

/**
 * A trajectory in a superpixel, where it is in input pixels, and its cluster, -1 where that is not known. Strangers,
 * which move like nothing around them, count for all objects.
 * @typedef {{readonly x: number, readonly y: number, readonly cluster: number, readonly stranger: boolean}} Voter
 */

/**
 * Why a pixel has its label. Costs are in units of the energy, in whole steps of 1/65536, so that their sums are exact:
 * the difference of two totals is that of the energies which the cut compared.
 * @typedef {object} Explanation
 * @property {number} label in the masks
 * @property {'superpixel' | 'border' | 'stroke'} source what gave the pixel its label: its superpixel, the step after
 *   the cut that moves borders, or a stroke. The costs are those of the superpixel in any case
 * @property {number} superpixel its number in the frame
 * @property {number} cluster that the cut gave the superpixel
 * @property {number} weight λ: how much the superpixel's trajectories count, 0 where none has a say
 * @property {{readonly background: number, readonly looks: number}} evidence for an object here, negative against one:
 *   by the background, and by what objects and the ground near them look like
 * @property {readonly LabelCost[]} costs of each cluster
 * @property {readonly SuperpixelLink[]} links what binds the superpixel to others
 * @property {readonly Voter[]} voters the trajectories in it
 * @property {number} nearest the trajectory of the result nearest to the pixel, -1 where there is none
 * @property {readonly {readonly to: number, readonly affinity: number}[]} affinities its 8 greatest affinities, and to
 *   which trajectories
 * @property {{readonly cluster: number, readonly margin: number, readonly votes: number} | null} flip the cheapest
 *   cluster of another label, what it costs more, and how many more trajectories of it here would make it as cheap
 *   (Infinity where no number would); null where there is no other label
 * @property {{readonly edges: number, readonly mean: number, readonly i: number, readonly j: number, readonly d:
 *   number} | null} border the edges of the frame that join trajectories of both labels, their mean discontinuity, and
 *   the edge with the greatest; null without any
 */

/** @typedef {import('./result.js').Result} Result */
/** @typedef {{-readonly [K in keyof LabelCost]: LabelCost[K]}} Cost */
/** @typedef {ReturnType<typeof termsOf>} Terms */

const SOURCES = /** @type {const} */ (['superpixel', 'border', 'stroke']);
const MOST_AFFINITIES = 8;

/**
 * @param {Result} result
 * @param {[t: number, x: number, y: number]} place in input pixels
 * @param {import('./requests.js').AskMap} askMap
 * @returns {Promise<Explanation>}
 */
export async function explanation(result, [t, x, y], askMap) {
  const { object } = result.clusters;
  const nearest = nearestTo(result.trajectories, t, x, y);
  const { numbers } = await askMap('terms', t, x, y, Math.max(0, nearest));
  const { weights, strangers, affinities, ...terms } = termsOf(numbers, object ?? new Uint8Array(0));
  const flip = flipOf(terms, strangers, weights);
  const [label] = result.masks?.subarray((t * result.height + y) * result.width + x) ?? [];
  if (label === undefined) throw new TraceCutError('data', 'the result has no masks');
  return {
    label,
    ...terms,
    nearest,
    affinities: affinities
      .filter(({ to }) => nearest >= 0 && to !== nearest)
      .sort((a, b) => b.affinity - a.affinity)
      .slice(0, MOST_AFFINITIES),
    flip,
    border: flip && borderOf(result, t, [terms.cluster, flip.cluster]),
  };
}

/**
 * The trajectory nearest to a pixel, the first of equals; -1 where none is in the frame.
 * @param {import('./result.js').TrajectoryList} trajectories
 * @param {number} t
 * @param {number} atX
 * @param {number} atY
 */
function nearestTo({ count, startFrame, offset, x, y }, t, atX, atY) {
  let [nearest, least] = [-1, Infinity];
  for (let i = 0; i < count; i += 1) {
    const point = Number(offset[i]) + t - Number(startFrame[i]);
    if (t < Number(startFrame[i]) || point >= Number(offset[i + 1])) continue;
    const [dx, dy] = [Number(x[point]) - atX, Number(y[point]) - atY];
    const away = dx * dx + dy * dy;
    if (away < least) [nearest, least] = [i, away];
  }
  return nearest;
}

/**
 * @param {Float64Array} numbers as `src/wasm/why.rs` writes them
 * @param {Uint8Array} object the mask label of each cluster
 */
function termsOf(numbers, object) {
  let place = 0;
  const next = () => Number(numbers[place++]);
  const steps = next();
  const units = () => next() / steps;
  /** @type {<T>(read: (k: number) => T) => T[]} */
  const list = (read) => Array.from({ length: next() }, (_, k) => read(k));
  const source = /** @type {Explanation['source']} */ (SOURCES[next()]);
  const [superpixel, cluster, strangers] = [next(), next(), next()];
  const weights = { trajectories: next(), stranger: next() };
  const [weight, background, looks] = [next(), next(), next()];
  const costs = list((k) => ownCost(k, object[k] ?? 0, units));
  const links = list(() => ({ t: next(), superpixel: next(), cluster: next(), tracks: next(), cost: units() }));
  for (const cost of costs) {
    for (const link of links) if (link.cluster !== cost.cluster) cost.links += link.cost;
    cost.total += cost.links;
  }
  const voters = list(() => voter(next(), next(), next(), costs));
  const affinities = [];
  while (place < numbers.length) affinities.push({ to: next(), affinity: next() });
  const evidence = { background, looks };
  return { source, superpixel, cluster, weight, evidence, costs, links, voters, strangers, weights, affinities };
}

/**
 * @param {number} cluster
 * @param {number} label
 * @param {() => number} units
 * @returns {Cost} but for links and votes
 */
function ownCost(cluster, label, units) {
  const [trajectories, colours, evidence, forbidden] = [units(), units(), units(), units()];
  const total = trajectories + colours + evidence + forbidden;
  return { cluster, label, votes: 0, trajectories, colours, evidence, links: 0, forbidden, total };
}

/**
 * Reads a voter, and counts its vote.
 * @param {number} x
 * @param {number} y
 * @param {number} of its cluster, or -1, or -2 of a stranger
 * @param {Cost[]} costs
 * @returns {Voter}
 */
function voter(x, y, of, costs) {
  const own = costs[of];
  if (own) own.votes += 1;
  return { x, y, cluster: Math.max(-1, of), stranger: of === -2 };
}

/**
 * The cheapest cluster of another label, the first of equals, and what would make it as cheap.
 * @param {Pick<Terms, 'costs' | 'cluster' | 'weight'>} terms
 * @param {number} strangers
 * @param {Terms['weights']} weights
 * @returns {Explanation['flip']}
 */
function flipOf({ costs, cluster, weight }, strangers, weights) {
  const own = /** @type {Cost} */ (costs[cluster]);
  const others = costs.filter(({ label }) => label !== own.label);
  const [first] = others;
  if (!first) return null;
  const other = others.reduce((best, one) => (one.total < best.total ? one : best), first);
  const total = costs.reduce((sum, { votes }) => sum + votes, weights.stranger * strangers);
  const rest = (unheard(other) - unheard(own)) / weights.trajectories;
  const ahead = ((other.trajectories - own.trajectories) / weights.trajectories) * total;
  // n more votes part the costs by (ahead − n) / (total + n), at most by −1.
  const needed = Math.max(1, Math.ceil((ahead + rest * total) / (1 - rest)) || 1);
  const isDeaf = weight === 0 && total > 0;
  const votes = !isDeaf && rest < 1 ? needed : Infinity;
  return { cluster: other.cluster, margin: other.total - own.total, votes };
}

/**
 * What of a cost more trajectories would not change.
 * @param {Cost} cost
 */
function unheard({ total, trajectories, colours }) {
  return total - trajectories - colours;
}

/**
 * The edges of frame `t` between the objects of two clusters.
 * @param {Result} result
 * @param {number} t
 * @param {[number, number]} clusters
 * @returns {Explanation['border']}
 */
function borderOf(result, t, clusters) {
  const [own, other] = clusters.map((cluster) => result.clusters.object?.[cluster] ?? 0);
  const labelOf = (/** @type {number} */ i) => result.clusters.object?.[Number(result.clusters.label[i])] ?? 0;
  const border = { edges: 0, mean: 0, i: 0, j: 0, d: -1 };
  const edges = result.edges(t);
  for (const [k, d] of edges.d.entries()) {
    const [i, j] = [Number(edges.i[k]), Number(edges.j[k])];
    const [a, b] = [labelOf(i), labelOf(j)];
    if (!((a === own && b === other) || (a === other && b === own))) continue;
    border.edges += 1;
    border.mean += d;
    if (d > border.d) Object.assign(border, { i, j, d });
  }
  border.mean /= border.edges;
  return border.edges > 0 ? border : null;
}
