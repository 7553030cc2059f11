// What is seen, in words: each object, the whole clip, one frame.

import { colourName, objectName } from './palette.js';
import { formatFrameTime, formatPercent, formatPlural } from './messages.js';
import type { ObjectFacts, Presence, Times } from './presence.js';

/** Part of the picture's height or width that counts as a move. */
const MIN_MOVE_SHARE = 0.04;

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
const MAX_DESCRIBED_OBJECTS = 3;

/** Returns `Object 1 (orange)`. */
export function nameAndColour(object: number): string {
  return object === 0 ? 'Background (grey)' : `${objectName(object)} (${colourName(object)})`;
}

/**
 * @param place in parts of the picture
 * @returns `upper left`, `middle`, …
 */
export function describePosition({ x, y }: { x: number; y: number }): string {
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
function joinWithAnd(words: string[]): string {
  return words.length > 1 ? `${words[0]} and ${words[1]}` : (words[0] ?? '');
}

/** Returns `moves left`, `grows`, `stays in place`, against the scene; `moves right, followed by the camera`. */
export function describeMotion({ motion, isFollowed, growth }: ObjectFacts): string {
  const { x: right, y: down } = motion;
  const directions = [];
  // A slant is named only where it is one.
  if (Math.abs(right) >= MIN_MOVE_SHARE && Math.abs(right) > 0.4 * Math.abs(down))
    directions.push(right > 0 ? 'right' : 'left');
  if (Math.abs(down) >= MIN_MOVE_SHARE && Math.abs(down) > 0.4 * Math.abs(right))
    directions.unshift(down > 0 ? 'down' : 'up');
  const size = growth > 1.5 ? 'grows' : growth < 0.67 ? 'shrinks' : '';
  const move = directions.length > 0 ? `moves ${joinWithAnd(directions)}` : '';
  const text = joinWithAnd([move, size].filter(Boolean)) || 'stays in place';
  return move && isFollowed ? `${text}, followed by the camera` : text;
}

/** Returns `0.0–1.6 s`, `frames 1–9`. */
export function describeSpan({ first, last }: ObjectFacts, times: Times): string {
  return first < 0 ? 'never' : times.formatSpan(first, last);
}

/** Returns `Object 1 (orange) at the top moves left`. */
function describeObject(facts: ObjectFacts, numFrames: number, times: Times): string {
  const when = facts.frames >= numFrames - 1 ? '' : `, ${describeSpan(facts, times)}`;
  return `${nameAndColour(facts.object)} ${placePhrase(facts.from)} ${describeMotion(facts)}${when}`;
}

/**
 * The clip in one or two sentences, objects by size.
 * @param facts of all objects, the background among them
 * @returns empty without objects
 */
export function describeObjects(facts: ObjectFacts[], numFrames: number, times: Times): string {
  const objects = facts.filter(({ object, first }) => object > 0 && first >= 0).sort((a, b) => b.share - a.share);
  const clauses = objects
    .slice(0, MAX_DESCRIBED_OBJECTS)
    .map((objectFacts) => describeObject(objectFacts, numFrames, times));
  const rest = objects.length - clauses.length;
  if (rest > 0) clauses.push(`and ${formatPlural(rest, 'smaller one')}`);
  return clauses.length > 0 ? `${clauses.join('; ')}.` : '';
}

/**
 * One frame, for those who do not see it.
 * @param count of objects, the background among them
 */
export function describeFrame(presence: Presence, count: number, frame: number, times: Times): string {
  const objects = [];
  for (let object = 1; object < count; object++) {
    const part = presence.shareOf(object, frame);
    if (part > 0)
      objects.push(
        `${nameAndColour(object)} ${describePosition(presence.centreOf(object, [frame]))}, ${formatPercent(part)}`,
      );
  }
  const content = objects.length > 0 ? objects.join('; ') : 'background only';
  return `Frame ${frame + 1} of ${presence.frames.length}${formatFrameTime(times, frame)}: ${content}.`;
}
