// The intake table: what each file of tests/intake/clips.mjs has to give on every surface, by the contract of
// docs/frames.md. The tests of the command line, of Node, of Python and of the page all read it.
// `node tests/intake/cases.mjs` makes the files and prints the table as JSON, for Python.

import assert from 'node:assert/strict';
import { fileURLToPath } from 'node:url';
import { CLIP, DELAYS_MS, NUM_FRAMES_BT709, ensureClips, placeOf, recordedMs } from './clips.mjs';

/**
 * A row of the table.
 * @typedef {object} Case
 * @property {string} name
 * @property {string} file file or folder
 * @property {number} numFrames pictures before the damage, if there is any
 * @property {number[] | null} times of the pictures in seconds; null for images in a folder
 * @property {number} [lastDuration] seconds that the last picture is shown
 * @property {number} first number of the first picture in the clip of the moving square
 * @property {boolean} masks whether motion is found, so that masks show the square
 * @property {boolean} [isTruncated] the file is cut off or damaged after these pictures
 * @property {'no-video' | 'truncated' | 'unsupported'} [error] nothing can be had of the file, and the error has this code
 * @property {RegExp} [words] that the error has on every surface
 * @property {Record<string, string>} [except] surfaces that cannot give this, and why
 */

const steady = (rate, count = CLIP.numFrames, start = 0) => Array.from({ length: count }, (_, k) => start + k / rate);
const paused = Array.from({ length: CLIP.numFrames }, (_, k) => (k + (k >= 6 ? 9 : 0) + (k >= 11 ? 3 : 0)) / 30);
const recorded = Array.from({ length: CLIP.numFrames }, (_, k) => recordedMs(k) / 1000);
const delayed = DELAYS_MS.map((_, k) => DELAYS_MS.slice(0, k).reduce((sum, delay) => sum + delay, 0) / 1000);

/** A file with all pictures of the clip. */
const readable = (name, file, more = {}) => ({
  name,
  file,
  numFrames: CLIP.numFrames,
  times: steady(25),
  lastDuration: 0.04,
  first: 0,
  masks: true,
  ...more,
});

/** A file that ends, or is wrong, after some pictures. */
const damaged = (name, file, more = {}) =>
  readable(name, file, { isTruncated: true, lastDuration: undefined, ...more });

/** A file of which nothing can be had. */
const unreadable = (name, file, error, message, more = {}) => ({
  ...readable(name, file),
  error,
  words: message,
  ...more,
});

/** Pictures in a folder. */
const folder = (name, file, numFrames, more = {}) =>
  readable(name, file, { numFrames, times: null, lastDuration: undefined, ...more });

/** @type {Case[]} */
export const CASES = [
  readable('an MP4', 'plain.mp4'),
  readable('a transport stream of a camcorder', 'CAM0001.MTS', { times: steady(25, 16, 1.48) }),
  readable('a file without an ending', 'no-ending', { times: steady(25, 16, 1.48) }),
  readable('a video that is called a JPEG', 'wrong-ending.jpg'),
  readable('five frames a second', 'fps5.mp4', { times: steady(5), lastDuration: 0.2 }),
  readable('seven frames a second', 'fps7.mp4', { times: steady(7), lastDuration: 1 / 7 }),
  readable('pauses', 'vfr.mp4', { times: paused, lastDuration: 1 / 30 }),
  readable('a recording of a browser', 'recording.webm', { times: recorded, lastDuration: undefined }),
  readable('a transparent recording, VP8', 'alpha.webm', { times: recorded, lastDuration: undefined }),
  readable('a transparent clip, VP9', 'alpha-vp9.webm'),
  readable('an edit list that begins at the fifth picture', 'edit-list.mp4', {
    numFrames: 12,
    times: steady(25, 12),
    first: 4,
  }),
  readable('two sound tracks', 'two-sounds.mp4'),
  readable('turned by 90 degrees', 'rot90.mp4'),
  readable('turned by 180 degrees', 'rot180.mp4'),
  readable('turned by 270 degrees', 'rot270.mp4'),
  readable('mirrored', 'mirrored.mp4'),
  readable('pixels of 4:3', 'sar.mp4'),
  readable('pixels of 22:45', 'sar-high.mp4'),
  readable('a size that changes on the way', 'size-changes.webm'),
  readable('BT.709', 'bt709.mp4', { numFrames: NUM_FRAMES_BT709, times: steady(25, NUM_FRAMES_BT709) }),
  readable('VP9', 'vp9.webm'),
  readable('HEVC', 'hevc.mp4', { except: { page: 'Chromium decodes no HEVC' } }),
  readable('a poster before the video', 'cover.mkv'),
  readable('an attached picture', 'attached.mp4'),
  readable('a small track before the default one', 'two-tracks.mp4'),
  damaged('an MP4 that is cut off', 'cut-off.mp4', { numFrames: 8, times: steady(25, 8) }),
  damaged('a WebM that is cut off', 'cut-off.webm', { numFrames: 8, times: steady(25, 8) }),
  damaged('a Matroska file that is cut off', 'cut-off.mkv', { numFrames: 8, times: steady(25, 8) }),
  damaged('a fragmented MP4 that is cut off', 'cut-off-fragments.mp4', { numFrames: 8, times: steady(25, 8, 0.08) }),
  damaged('a Matroska file that has lost pictures which others are shown after', 'cut-off-order.mkv', {
    numFrames: 5,
    times: steady(25, 5),
    masks: false,
    except: { page: 'gives one of the pictures that are shown after lost ones' },
  }),
  damaged('a hole in an MP4', 'hole.mp4', { numFrames: 8, times: steady(25, 8) }),
  readable('an animated PNG', 'delays.png', { times: delayed, lastDuration: 0.3 }),
  readable('an animated GIF', 'delays.gif', { times: delayed, lastDuration: undefined, masks: false }),
  readable('an animated WebP', 'delays.webp', {
    times: delayed,
    lastDuration: undefined,
    except: { node: 'unsupported', python: 'unsupported' },
    words: /animated WebP/,
  }),
  folder('photos with an EXIF orientation', 'exif', 12),
  folder('hidden files beside the frames', 'copied', 4, { masks: false }),
  folder('names in the order of persons', 'order', 12),
  readable('camouflage', 'camouflage.mp4', { masks: false }),
  unreadable('only sound', 'only-sound.m4a', 'no-video', /no video track/),
  unreadable('words that are called a video', 'not-a-video.mp4', 'no-video', /not a video/),
  unreadable('an empty file', 'empty.mp4', 'no-video', /empty/),
  unreadable('an MP4 whose index is cut off', 'no-index.mp4', 'truncated', /cut off/),
];

/** Times differ by less than this, in seconds. */
const TIME_TOLERANCE_S = 0.001;
const LEAST_OVERLAP = 0.8;

/**
 * What a surface gave for a file.
 * @typedef {object} Outcome
 * @property {number} width
 * @property {number} height
 * @property {number} numFrames
 * @property {ArrayLike<number> | null} times
 * @property {number | null} [lastDuration]
 * @property {boolean} isTruncated
 * @property {ArrayLike<number>[]} masks those that were computed, or of the red pixels where frames alone were read
 */

/**
 * Holds what a surface gave against the table.
 * @param {Case} row
 * @param {Outcome} outcome
 */
export function checkOutcome(row, outcome) {
  const { width, height, numFrames } = outcome;
  assert.deepEqual({ width, height, numFrames }, { width: CLIP.width, height: CLIP.height, numFrames: row.numFrames });
  assert.equal(outcome.isTruncated, row.isTruncated ?? false, 'is truncated');
  checkTimes(row, outcome);
  if (!row.masks) return;
  for (const k of [0, row.numFrames - 1]) {
    const overlap = overlapWithSquare(outcome.masks[k], placeOf(row.first + k));
    assert.ok(overlap >= LEAST_OVERLAP, `the mask of picture ${k} overlaps with the square by ${overlap.toFixed(2)}`);
  }
}

function checkTimes(row, { times, lastDuration }) {
  if (!row.times) return assert.equal(times ?? null, null);
  assert.equal(times?.length, row.times.length);
  row.times.forEach((time, k) =>
    assert.ok(Math.abs(times[k] - time) < TIME_TOLERANCE_S, `picture ${k} is at ${times[k]} s (expected ${time})`),
  );
  if (row.lastDuration !== undefined)
    assert.ok(Math.abs(lastDuration - row.lastDuration) < TIME_TOLERANCE_S, `the last picture lasts ${lastDuration} s`);
}

/** The mask of a frame's red pixels, which are the square's. @param {{data: ArrayLike<number>}} frame RGBA */
export function maskOfRed({ data }) {
  const mask = new Uint8Array(data.length / 4);
  for (let p = 0; p < mask.length; p += 1) mask[p] = Number(data[4 * p] - data[4 * p + 1] > 40);
  return mask;
}

/** Intersection over union of what a mask labels with the square. */
function overlapWithSquare(mask, { x, y }) {
  let [both, either] = [0, 0];
  for (let p = 0; p < mask.length; p += 1) {
    const [column, row] = [p % CLIP.width, Math.floor(p / CLIP.width)];
    const isSquare = column >= x && column < x + CLIP.side && row >= y && row < y + CLIP.side;
    if (isSquare && mask[p]) both += 1;
    if (isSquare || mask[p]) either += 1;
  }
  return either === 0 ? 0 : both / either;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const cases = CASES.map((row) => ({ ...row, words: row.words?.source ?? null, place: placeOf(row.first) }));
  console.log(JSON.stringify({ folder: ensureClips(), clip: CLIP, cases }));
}
