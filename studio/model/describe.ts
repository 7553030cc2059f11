// Descriptions of objects, clips and frames, for the summary and for screen readers.

import { colourName, objectName } from './palette.js';
import { formatFrameTime, formatPercent, formatPlural } from './messages.js';
import type { ObjectFacts, Presence, Times } from './presence.js';

/** Smallest motion that is mentioned, as a share of the picture's size; chosen by eye. */
const MIN_MOVE_SHARE = 0.04;

/** Names of the thirds of the picture, by row and column. */
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

/** Objects that the summary describes one by one. */
const MAX_DESCRIBED_OBJECTS = 3;

/** Returns `Object 1 (orange)`. */
export function nameAndColour(object: number): string {
  return `${objectName(object)} (${colourName(object)})`;
}

/**
 * @param place as shares of the picture's size
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

/** @param words at most two */
function joinWithAnd(words: string[]): string {
  return words.length > 1 ? `${words[0]} and ${words[1]}` : (words[0] ?? '');
}

/**
 * Returns the motion against the scene: `moves left`, `grows`, `stays in place`, `moves right, followed by the
 * camera`.
 */
export function describeMotion({ motion, isFollowed, growth }: ObjectFacts): string {
  const { x: right, y: down } = motion;
  const directions = [];
  // A diagonal is named only if both directions matter.
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
 * Describes the largest objects of a clip.
 * @param facts of all objects, including the background
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
 * Describes a frame for screen readers.
 * @param count of objects, including the background
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
