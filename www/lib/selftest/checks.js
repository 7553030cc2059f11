// The program whose results are hashed. `cli/src/selftest/checks.rs` is the same program: same clips, same bytes, same
// order. It knows the package by what it exports, so that a page that has loaded it loads nothing twice.

/**
 * The entries of the package that are needed.
 * @typedef {typeof import('../index.js') & typeof import('../export.js') & typeof import('../stages.js')} Library
 */
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
 * @param {Library} library
 * @param {Settings} settings
 * @param {AbortSignal} [signal]
 * @returns {AsyncGenerator<Check, void, undefined>}
 */
export async function* checks(library, settings, signal) {
  const frames = await framesOf(library, CLIP, settings);
  yield* imageChecks(library, frames, settings);
  signal?.throwIfAborted();
  const session = await library.createSession(settings);
  try {
    for (const frame of frames) await session.push(frame);
    const result = await session.run({ signal });
    yield* motionChecks(result);
    yield* maskChecks(library, result, settings);
  } finally {
    session.close();
  }
  yield ['windows', 'masks of two shots, window by window', await windowParts(library, settings, signal)];
}

/**
 * @param {Library} library
 * @param {Required<Omit<import('../clip.js').ClipOptions, 'wasm'>>} options
 * @param {Settings} settings
 */
async function framesOf(library, options, { wasm }) {
  const clip = await library.synthClip({ ...options, ...(wasm ? { wasm } : {}) });
  const frames = Array.from({ length: options.frames }, (_, t) => clip.frame(t));
  clip.close();
  return frames;
}

/**
 * What single images come to.
 * @param {Library} library
 * @param {{data: Uint8ClampedArray<ArrayBuffer>, width: number, height: number}[]} frames
 * @param {Settings} settings
 * @returns {AsyncGenerator<Check>}
 */
async function* imageChecks(library, frames, { threads, ...settings }) {
  const [first, second] = /** @type {[typeof frames[0], typeof frames[0]]} */ (frames);
  yield ['frames', 'the pixels of a made clip', frames.map(({ data }) => rgb(data))];
  const engine = await library.createImageEngine(settings);
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
 * @param {Library} library
 * @param {import('../result.js').Result} result
 * @param {Settings} settings
 * @returns {AsyncGenerator<Check>}
 */
async function* maskChecks(library, result, settings) {
  yield ['objects', 'the object of each cluster', [there(result.clusters.object)]];
  yield ['masks', 'masks of all frames', [there(result.masks)]];
  const plates = [];
  for (const t of FRAMES) plates.push((await result.background(t)).data);
  yield ['background', 'frames without the objects', plates];
  const table = await library.objectTableCsv(await library.objectTable(result));
  yield ['table', 'the table of objects', [bytesOf(table)]];
  const { annotations } = library.cocoRle(result);
  yield ['coco', 'masks as run lengths of COCO', [bytesOf(annotations.map(cocoLine).join(''))]];
  yield ['npy', 'masks as a file for NumPy', [library.labelsNpy(result)]];
  const pictures = [];
  for (const t of FRAMES)
    pictures.push(await readBack(library, await library.maskPng(result, t, { object: 1 }), settings));
  yield ['png', "an object's masks as PNG files, read back", pictures];
}

/**
 * The pixels of a PNG file.
 * @param {Library} library
 * @param {Uint8Array<ArrayBuffer>} file
 * @param {Settings} settings
 */
async function readBack(library, file, { decoder }) {
  for await (const { frame } of library.videoFrames([file], decoder ? { decoder } : {})) return rgb(frame.data);
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
 * @param {Library} library
 * @param {Settings} settings
 * @param {AbortSignal | undefined} signal
 */
async function windowParts(library, settings, signal) {
  const shots = await Promise.all(SHOTS.map((shot) => framesOf(library, shot, settings)));
  /** @type {ArrayBufferView[]} */
  const parts = [];
  // Not as a list: where the number of frames is known, the last windows lie otherwise.
  for await (const window of library.segmentVideo(shots.flat().values(), { ...settings, ...WINDOWS, signal })) {
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
