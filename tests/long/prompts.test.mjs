// Prompts on real clips: that a model which is given them is shown the true object.

import assert from 'node:assert/strict';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { basename, join } from 'node:path';
import { test } from 'node:test';
import { readFrames, segmentVideo } from 'tracecut';
import { prompts } from 'tracecut/export';
import { root } from '../../scripts/tools.mjs';
import { readPng } from '../png.mjs';

/** Clips with their true masks; they are not part of the project. */
const CLIPS = join(process.env.TRACECUT_SHARED ?? join(root, '..', 'shared'), 'data', 'davis');

/** Frames that are taken of each: a second. */
const FRAMES = 24;

/** Least share of the objects that were found. */
const LEAST = 0.9;

/** A box may reach over the true one where the object throws a shadow: this share of it has to lie inside. */
const LEAST_OF_BOX = 0.66;

const skip = existsSync(CLIPS) ? false : `${CLIPS} is not there`;

test('points and boxes lie in the true object, in nine of ten objects', { skip }, async () => {
  const clips = readdirSync(CLIPS, { withFileTypes: true }).filter((entry) => entry.isDirectory());
  assert.equal(clips.length, 8);
  const objects = [];
  for (const { name } of clips) objects.push(...(await promptsOf(join(CLIPS, name))));
  for (const { clip, object, frame, points, box } of objects)
    console.log(`${clip} ${object}: frame ${frame}, ${points} of 3 points, ${(100 * box).toFixed(0)} % of the box`);
  const right = objects.filter(({ points, box }) => points === 3 && box >= LEAST_OF_BOX);
  console.log(`${right.length} of ${objects.length} objects`);
  assert.ok(objects.length >= clips.length, 'an object in each clip');
  assert.ok(right.length >= LEAST * objects.length, `${right.length} of ${objects.length}`);
});

/** Returns the prompts of each object of a clip, with the true masks. */
async function promptsOf(folder) {
  const frames = [];
  for await (const frame of readFrames(join(folder, 'JPEGImages'))) if (frames.push(frame) === FRAMES) break;
  const masks = await segmentVideo(frames).collect();
  const { width, height, prompts: list } = await prompts(masks);
  return list.map(({ obj_id, frame_idx, box, points, labels }) => {
    const truth = readPng(readFileSync(join(folder, 'Annotations', frames[frame_idx].name.replace('.jpg', '.png'))));
    assert.deepEqual([truth.width, truth.height], [width, height]);
    const isTrue = ([x, y]) => truth.pixels[y * width + x] === 255;
    const inside = points.filter((_, k) => labels[k] === 1);
    return {
      clip: basename(folder),
      object: obj_id,
      frame: frame_idx,
      points: inside.filter(isTrue).length,
      box: share(box, boundsOf(truth.pixels, width)),
    };
  });
}

/** Left, top, right and bottom of the pixels that are 255. */
function boundsOf(pixels, width) {
  const bounds = [Infinity, Infinity, -1, -1];
  pixels.forEach((value, k) => {
    const [x, y] = [k % width, Math.floor(k / width)];
    if (value === 255)
      bounds.splice(
        0,
        4,
        ...[x, y].map((v, i) => Math.min(v, bounds[i])),
        ...[x, y].map((v, i) => Math.max(v, bounds[2 + i])),
      );
  });
  return bounds;
}

/** Returns the share of a box inside another. */
function share(box, container) {
  const length = (a, b, axis) => Math.max(0, Math.min(a[2 + axis], b[2 + axis]) - Math.max(a[axis], b[axis]) + 1);
  const area = (a, b) => length(a, b, 0) * length(a, b, 1);
  return area(box, container) / area(box, box);
}
