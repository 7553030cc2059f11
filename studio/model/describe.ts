// What is seen, in words: each object, the whole clip, one frame.

import { colourName, objectName } from './palette.js';
import { atTime, percent, plural } from './words.js';
import type { Facts, Presence, Times } from './presence.js';

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

/** Returns `Object 1 (orange)`. */
export function nameAndColour(object: number): string {
  return object === 0 ? 'Background (grey)' : `${objectName(object)} (${colourName(object)})`;
}

/**
 * @param place in parts of the picture
 * @returns `upper left`, `middle`, …
 */
export function placeName({ x, y }: { x: number; y: number }): string {
  return REGIONS[third(y)][third(x)];
}

function third(part: number) {
  return Math.min(2, Math.max(0, Math.floor(3 * part)));
}

/** Returns `at the upper left`, `in the middle`, … */
function placePhrase(place: { x: number; y: number }): string {
  return PHRASES[third(place.y)][third(place.x)];
}

/** @param words one or two, or none */
function both(words: string[]): string {
  return words.length > 1 ? `${words[0]} and ${words[1]}` : (words[0] ?? '');
}

/** Returns `moves left`, `grows`, `stays in place`, against the scene; `moves right, followed by the camera`. */
export function moveOf({ moved, followed, growth }: Facts): string {
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

/** Returns `0.0–1.6 s`, `frames 1–9`. */
export function spanOf({ first, last }: Facts, times: Times): string {
  return first < 0 ? 'never' : times.span(first, last);
}

/** Returns `Object 1 (orange) at the top moves left`. */
function clause(facts: Facts, numFrames: number, times: Times): string {
  const when = facts.frames >= numFrames - 1 ? '' : `, ${spanOf(facts, times)}`;
  return `${nameAndColour(facts.object)} ${placePhrase(facts.from)} ${moveOf(facts)}${when}`;
}

/**
 * The clip in one or two sentences, objects by size.
 * @param facts of all objects, the background among them
 * @returns empty without objects
 */
export function summaryOf(facts: Facts[], numFrames: number, times: Times): string {
  const objects = facts.filter(({ object, first }) => object > 0 && first >= 0).sort((a, b) => b.share - a.share);
  const spoken = objects.slice(0, SPOKEN_OF).map((one) => clause(one, numFrames, times));
  const rest = objects.length - spoken.length;
  if (rest > 0) spoken.push(`and ${plural(rest, 'smaller one')}`);
  return spoken.length > 0 ? `${spoken.join('; ')}.` : '';
}

/**
 * One frame, for those who do not see it.
 * @param count of objects, the background among them
 */
export function frameText(presence: Presence, count: number, frame: number, times: Times): string {
  const there = [];
  for (let object = 1; object < count; object++) {
    const part = presence.part(object, frame);
    if (part > 0)
      there.push(`${nameAndColour(object)} ${placeName(presence.middle(object, [frame]))}, ${percent(part)}`);
  }
  const seen = there.length > 0 ? there.join('; ') : 'background alone';
  return `Frame ${frame + 1} of ${presence.frames.length}${atTime(times, frame)}: ${seen}.`;
}
