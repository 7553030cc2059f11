/** What is seen, in words: each object, the whole clip, one frame. @module */

import { colourName, objectName } from './palette.js';
import { atTime, percent, plural } from './words.js';

/** @typedef {import('./presence.js').Facts} Facts */
/** @typedef {import('./presence.js').Presence} Presence */

/** Part of the picture's height or width that counts as a move. */
const MOVE = 0.04;

/** Thirds of the picture, downwards and across. */
const REGIONS = [
  ['upper left', 'top', 'upper right'],
  ['left', 'middle', 'right'],
  ['lower left', 'bottom', 'lower right'],
];
const PHRASES = [
  ['at the upper left', 'at the top', 'at the upper right'],
  ['on the left', 'in the middle', 'on the right'],
  ['at the lower left', 'at the bottom', 'at the lower right'],
];

/** Objects that the summary speaks of one by one. */
const SPOKEN_OF = 3;

/**
 * @param {number} object
 * @returns {string} `Object 1 (orange)`
 */
export function nameAndColour(object) {
  return object === 0 ? 'Background (grey)' : `${objectName(object)} (${colourName(object)})`;
}

/**
 * @param {{x: number, y: number}} place in parts of the picture
 * @returns {string} `upper left`, `middle`, …
 */
export function placeName({ x, y }) {
  return REGIONS[third(y)][third(x)];
}

/** @param {number} part */
function third(part) {
  return Math.min(2, Math.max(0, Math.floor(3 * part)));
}

/**
 * @param {{x: number, y: number}} place
 * @returns {string} `at the upper left`, `in the middle`, …
 */
function placePhrase(place) {
  return PHRASES[third(place.y)][third(place.x)];
}

/**
 * @param {string[]} words one or two, or none
 * @returns {string}
 */
function both(words) {
  return words.length > 1 ? `${words[0]} and ${words[1]}` : (words[0] ?? '');
}

/**
 * @param {Facts} facts
 * @returns {string} `moves left`, `grows`, `stays in place`, against the scene; `moves right, followed by the camera`
 */
export function moveOf({ moved, followed, growth }) {
  const { x: right, y: down } = moved;
  const ways = [];
  // A slant is named only where it is one.
  if (Math.abs(right) >= MOVE && Math.abs(right) > 0.4 * Math.abs(down)) ways.push(right > 0 ? 'right' : 'left');
  if (Math.abs(down) >= MOVE && Math.abs(down) > 0.4 * Math.abs(right)) ways.unshift(down > 0 ? 'down' : 'up');
  const size = growth > 1.5 ? 'grows' : growth < 0.67 ? 'shrinks' : '';
  const move = ways.length > 0 ? `moves ${both(ways)}` : '';
  const words = both([move, size].filter(Boolean)) || 'stays in place';
  return move && followed ? `${words}, followed by the camera` : words;
}

/**
 * @param {Facts} facts
 * @param {import('./presence.js').Times} times
 * @returns {string} `0.0–1.6 s`, `frames 1–9`
 */
export function spanOf({ first, last }, times) {
  return first < 0 ? 'never' : times.span(first, last);
}

/**
 * @param {Facts} facts
 * @param {number} numFrames
 * @param {import('./presence.js').Times} times
 * @returns {string} `Object 1 (orange) at the top moves left`
 */
function clause(facts, numFrames, times) {
  const when = facts.frames >= numFrames - 1 ? '' : `, ${spanOf(facts, times)}`;
  return `${nameAndColour(facts.object)} ${placePhrase(facts.from)} ${moveOf(facts)}${when}`;
}

/**
 * The clip in one or two sentences, objects by size.
 *
 * @param {Facts[]} facts of all objects, the background among them
 * @param {number} numFrames
 * @param {import('./presence.js').Times} times
 * @returns {string} empty without objects
 */
export function summaryOf(facts, numFrames, times) {
  const objects = facts.filter(({ object, first }) => object > 0 && first >= 0).sort((a, b) => b.share - a.share);
  const spoken = objects.slice(0, SPOKEN_OF).map((one) => clause(one, numFrames, times));
  const rest = objects.length - spoken.length;
  if (rest > 0) spoken.push(`and ${plural(rest, 'smaller one')}`);
  return spoken.length > 0 ? `${spoken.join('; ')}.` : '';
}

/**
 * One frame, for those who do not see it.
 *
 * @param {Presence} presence
 * @param {number} count of objects, the background among them
 * @param {number} frame
 * @param {import('./presence.js').Times} times
 * @returns {string}
 */
export function frameText(presence, count, frame, times) {
  const there = [];
  for (let object = 1; object < count; object++) {
    const part = presence.part(object, frame);
    if (part > 0)
      there.push(`${nameAndColour(object)} ${placeName(presence.middle(object, [frame]))}, ${percent(part)}`);
  }
  const seen = there.length > 0 ? there.join('; ') : 'background alone';
  return `Frame ${frame + 1} of ${presence.frames.length}${atTime(times, frame)}: ${seen}.`;
}
