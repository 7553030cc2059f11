// The program whose results are hashed. `cli/src/selftest/checks.rs` is the same program: same clips, same bytes, same
// order.

import { synthClip } from '../clip.js';
import { cocoRle } from '../export/coco.js';
import { labelsNpy } from '../export/label-maps.js';
import { maskPng } from '../export/masks.js';
import { objectTable, objectTableCsv } from '../export/table.js';
import { createImageEngine } from '../image.js';
import { createSession } from '../session.js';
import { videoFrames } from '../video/frames.js';
import { segmentVideo } from '../video/segment.js';

/** @typedef {Pick<import('../options.js').SessionSettings, 'wasm' | 'decoder' | 'worker' | 'threads'>} Settings */
/** What is hashed: bytes, one after the other. @typedef {Iterable<ArrayBufferView>} Parts */
/** @typedef {[name: string, what: string, parts: Parts]} Check */

const CLIP = { width: 160, height: 90, frames: 12, seed: 1 };
/** Two shots, which run window by window. */
const SHOTS = [1, 7].map((seed) => ({ width: 96, height: 64, frames: 10, seed }));
const WINDOWS = { window: 7, overlap: 3 };
/** Frames whose maps are looked at. */
const FRAMES = [0, 6, 11];

/**
 * All results, one after the other.
 * @param {Settings} settings
 * @param {AbortSignal} [signal]
 * @returns {AsyncGenerator<Check, void, undefined>}
 */
export async function* checks(settings, signal) {
  const frames = await framesOf(CLIP, settings);
  yield* imageChecks(frames, settings);
  signal?.throwIfAborted();
  const session = await createSession(settings);
  try {
    for (const frame of frames) await session.push(frame);
    const result = await session.run({ signal });
    yield* motionChecks(result);
    yield* maskChecks(result, settings);
  } finally {
    session.close();
  }
  yield ['windows', 'masks of two shots, window by window', await windowParts(settings, signal)];
}

/**
 * @param {Required<Omit<import('../clip.js').ClipOptions, 'wasm'>>} options
 * @param {Settings} settings
 */
async function framesOf(options, { wasm }) {
  const clip = await synthClip({ ...options, ...(wasm ? { wasm } : {}) });
  const frames = Array.from({ length: options.frames }, (_, t) => clip.frame(t));
  clip.close();
  return frames;
}

/**
 * What single images come to.
 * @param {{data: Uint8ClampedArray<ArrayBuffer>, width: number, height: number}[]} frames
 * @param {Settings} settings
 * @returns {AsyncGenerator<Check>}
 */
async function* imageChecks(frames, { threads, ...settings }) {
  const [first, second] = /** @type {[typeof frames[0], typeof frames[0]]} */ (frames);
  yield ['frames', 'the pixels of a made clip', frames.map(({ data }) => rgb(data))];
  const engine = await createImageEngine(settings);
  try {
    const { u, v } = await engine.flow(first, second);
    yield ['flow', 'optical flow of its first two frames', [u, v]];
    const { pb, thin } = await engine.boundaries(first);
    yield ['boundaries', 'boundary probability of an image', [pb, thin]];
    yield ['superpixels', 'superpixels of an image', [(await engine.superpixels(first)).label]];
    // Eigenvectors are the same but for their last bits, which are the processor's.
    const { discontinuity } = await engine.imageDiscontinuities(first);
    const halves = Uint8Array.from(discontinuity, (d) => Math.round(2 * d));
    yield ['discontinuities', 'discontinuities of an image, to the nearest half', [halves]];
  } finally {
    engine.close();
  }
}

/**
 * What comes before the masks.
 * @param {import('../result.js').Result} result
 * @returns {AsyncGenerator<Check>}
 */
async function* motionChecks(result) {
  const { startFrame, offset, x, y } = result.trajectories;
  yield ['tracks', 'trajectories of points', [startFrame, offset, x, y]];
  const { i, j, frameOffset, frameEdges } = result.edgeTable;
  yield ['neighbours', 'which trajectories are neighbours', [i, j, frameOffset, frameEdges]];
  const maps = [];
  for (const t of FRAMES) maps.push((await result.saliencyMap(t)).saliency);
  yield ['saliency', 'saliency of pixels', maps];
  const { foreground } = there(result.saliency);
  yield ['foreground', 'which trajectories are salient', [foreground]];
  yield ['labels', 'the cluster of each trajectory', [result.clusters.label]];
  yield ['track-file', 'trajectories with their clusters as text', [bytesOf(result.toTracksDat())]];
}

/**
 * The masks, and the files that are made of them.
 * @param {import('../result.js').Result} result
 * @param {Settings} settings
 * @returns {AsyncGenerator<Check>}
 */
async function* maskChecks(result, settings) {
  yield ['objects', 'the object of each cluster', [there(result.clusters.object)]];
  yield ['masks', 'masks of all frames', [there(result.masks)]];
  const plates = [];
  for (const t of FRAMES) plates.push((await result.background(t)).data);
  yield ['background', 'frames without the objects', plates];
  const table = await objectTableCsv(await objectTable(result));
  yield ['table', 'the table of objects', [bytesOf(table)]];
  const { annotations } = cocoRle(result);
  yield ['coco', 'masks as run lengths of COCO', [bytesOf(annotations.map(cocoLine).join(''))]];
  yield ['npy', 'masks as a file for NumPy', [labelsNpy(result)]];
  const pictures = [];
  for (const t of FRAMES) pictures.push(await readBack(await maskPng(result, t, { object: 1 }), settings));
  yield ['png', "an object's masks as PNG files, read back", pictures];
}

/**
 * The pixels of a PNG file.
 * @param {Uint8Array<ArrayBuffer>} file
 * @param {Settings} settings
 */
async function readBack(file, { decoder }) {
  for await (const { frame } of videoFrames([file], decoder ? { decoder } : {})) return rgb(frame.data);
  throw new Error('a PNG file of the package has no frame');
}

/**
 * An annotation without what is only a name.
 * @param {import('../export/coco.js').CocoAnnotation} annotation
 */
function cocoLine({ image_id, track_id, area, bbox, segmentation: { size, counts } }) {
  return `${image_id} ${track_id} ${area} ${bbox} ${size} ${counts}\n`;
}

/**
 * Which windows there are, and their masks.
 * @param {Settings} settings
 * @param {AbortSignal | undefined} signal
 */
async function windowParts(settings, signal) {
  const shots = await Promise.all(SHOTS.map((shot) => framesOf(shot, settings)));
  /** @type {ArrayBufferView[]} */
  const parts = [];
  // Not as a list: where the number of frames is known, the last windows lie otherwise.
  for await (const window of segmentVideo(shots.flat().values(), { ...settings, ...WINDOWS, signal })) {
    const { index, shot, firstFrame, settled } = window;
    parts.push(Uint32Array.of(index, shot, firstFrame, settled.from, settled.to));
    for (const { labels } of window.frames()) parts.push(labels);
  }
  return parts;
}

/** @param {Uint8Array | Uint8ClampedArray} rgba */
function rgb(rgba) {
  return Uint8Array.from({ length: (rgba.length / 4) * 3 }, (_, k) => Number(rgba[Math.floor(k / 3) * 4 + (k % 3)]));
}

/** @param {string} text */
function bytesOf(text) {
  return new TextEncoder().encode(text);
}

/**
 * @template T
 * @param {T | null} found
 * @returns {T}
 */
function there(found) {
  if (found === null) throw new Error('a run with frames ended without saliency or masks');
  return found;
}
