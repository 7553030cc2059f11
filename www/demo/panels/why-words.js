/** An explanation in words and numbers. @module */

import { h } from '../dom.js';
import { say } from '../language.js';
import { objectName } from '../result/palette.js';
import { count } from '../words.js';

/** @typedef {import('../../dist/index.js').Explanation} Explanation */

/** Affinities that are told. */
const TOLD = 3;

/**
 * @param {Explanation} why
 * @param {number} shown the label that the mask on screen has there
 * @returns {string[]} a sentence each
 */
export function reasonsOf(why, shown) {
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
  if (shown !== label) return say`The mask on screen has ${objectName(shown)} here: it was changed by hand.`;
  if (source === 'stroke') return say('A stroke over it decides.');
  const own = objectName(costs[cluster]?.label ?? 0);
  if (source === 'border')
    return say`Its superpixel ${superpixel} is ${own}; the step after the cut has moved the border over it.`;
  return say`Its superpixel ${superpixel} has this label by the cut.`;
}

/** @param {Explanation} why */
function flipOf({ flip, costs }) {
  if (!flip) return say('There is no other label that it could have.');
  const other = objectName(costs[flip.cluster]?.label ?? 0);
  const more = cost(flip.margin);
  return flip.votes === Infinity
    ? say`It would be ${other} for a cost of ${more} more; no number of trajectories alone would make it that.`
    : say`It would be ${other} for a cost of ${more} more: ${count(flip.votes)} more trajectories of it here would do.`;
}

/** @param {Explanation} why */
function votersOf({ voters, weight }) {
  const strange = voters.filter(({ stranger }) => stranger).length;
  if (voters.length === 0) return say('No trajectory votes here; colours and neighbours decide.');
  return say`Trajectories that vote here: ${count(voters.length)}, of them strangers: ${count(strange)}. Their weight is ${weight.toFixed(2)}.`;
}

/** @param {Explanation} why */
function evidenceOf({ evidence: { background, looks } }) {
  return say`For an object speak the background with ${cost(background)} and looks with ${cost(looks)}; less than 0 is against.`;
}

/** @param {Explanation} why */
function linksOf({ links, costs, cluster }) {
  const own = costs[cluster]?.label;
  const sum = (/** @type {boolean} */ same) =>
    links.filter((link) => (costs[link.cluster]?.label === own) === same).reduce((total, link) => total + link.cost, 0);
  return say`Links to neighbours of its own label hold it with ${cost(sum(true))}, those to others pull with ${cost(sum(false))}.`;
}

/** @param {Explanation} why */
function borderOf({ border }) {
  if (!border) return [];
  const { edges, mean, d } = border;
  return [
    say`Edges between the two in this frame: ${count(edges)}, of discontinuity ${mean.toFixed(2)} on average and ${d.toFixed(2)} at most.`,
  ];
}

/** @param {Explanation} why */
function nearOf({ nearest, affinities }) {
  if (nearest < 0 || affinities.length === 0) return [];
  const told = affinities.slice(0, TOLD).map(({ to, affinity }) => `${count(to)} (${affinity.toFixed(2)})`);
  return [say`The nearest trajectory is ${count(nearest)}; it moves most like ${told.join(', ')}.`];
}

/**
 * What each label costs: a column for each cluster, a row for each term.
 *
 * @param {Explanation} why
 */
export function costTable({ costs, cluster }) {
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
