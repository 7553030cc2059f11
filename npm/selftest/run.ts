// The program whose results are hashed, and the comparison with the expected hashes.
// `cli/src/selftest.rs` is the same program: same clips, same bytes, same order.
// It is given the package's exports, so that a page that has loaded the package loads nothing twice.

import { checkOptions } from '../check/errors.js';
import { EXPECTED } from './expected.js';
import type { SessionSettings, WasmSource } from '../check/options.js';
import type { CocoAnnotation } from '../kit/export/annotations.js';
import type { WorkerSource } from '../platform.js';
import type { Result } from '../session/result.js';
import type { ClipOptions } from '../stages/clip.js';

/**
 * The hash of one result: `hash` and `expected` are the first 64 bits of SHA-256 in hexadecimal digits; `same` is true if
 * they are equal.
 */
export type SelftestCheck = {
  readonly name: string;
  readonly what: string;
  readonly hash: string;
  readonly expected: string;
  readonly same: boolean;
};

/** Outcome of a self test: `same` is true if every check is and the package has the `version` that the hashes are of. */
export type Selftest = { readonly version: string; readonly same: boolean; readonly checks: readonly SelftestCheck[] };

/** Options of `selftest`. */
export interface SelftestOptions {
  /** Called for each check as soon as it is done. */
  onCheck?: (check: SelftestCheck) => void;
  /** Aborts the work: the promise rejects with its reason. */
  signal?: AbortSignal;
  /** As for a session. */
  wasm?: WasmSource;
  /** As for a session. */
  decoder?: WasmSource;
  /** As for a session. */
  worker?: boolean | WorkerSource;
  /** As for a session; the hashes do not depend on it. */
  threads?: number;
}

/** Hash function. */
export type Digest = (bytes: Uint8Array<ArrayBuffer>) => Promise<Uint8Array>;

/** Number of checks. */
const NUM_CHECKS = Object.keys(EXPECTED.hashes).length;

const LEGAL = ['onCheck', 'signal', 'wasm', 'decoder', 'worker', 'threads'];

/** Runs the self test with a loaded package. */
export async function runSelftest(
  library: Library,
  options: SelftestOptions = {},
  digest: Digest = createDigest(library),
): Promise<Selftest> {
  const { onCheck, signal, ...settings } = checkOptions(options, LEGAL);
  const results: SelftestCheck[] = [];
  for await (const [name, what, parts] of runChecks(library, settings, signal)) {
    signal?.throwIfAborted();
    const hash = toHex(await digest(concatenate(parts)));
    const expected = EXPECTED.hashes[name] ?? 'nothing';
    const check = { name, what, hash, expected, same: hash === expected };
    results.push(check);
    onCheck?.(check);
  }
  const { version } = library;
  const same = results.every((check) => check.same) && results.length === NUM_CHECKS && version === EXPECTED.version;
  return { version, same, checks: results };
}

function createDigest({ TraceCutError }: Library): Digest {
  const subtle = globalThis.crypto?.subtle;
  if (!subtle)
    throw new TraceCutError('unsupported', 'hashes need crypto.subtle: pages have it by https and on localhost');
  return async (bytes) => new Uint8Array(await subtle.digest('SHA-256', bytes));
}

function concatenate(parts: Parts) {
  const list = [...parts].map(({ buffer, byteOffset, byteLength }) => new Uint8Array(buffer, byteOffset, byteLength));
  const bytes = new Uint8Array(list.reduce((sum, { length }) => sum + length, 0));
  let offset = 0;
  for (const part of list) {
    bytes.set(part, offset);
    offset += part.length;
  }
  return bytes;
}

function toHex(hash: Uint8Array) {
  return Array.from(hash.subarray(0, 8), (byte) => byte.toString(16).padStart(2, '0')).join('');
}

/** Exports of the package that the self test uses. */
export type Library = typeof import('../index.js') & typeof import('../export.js') & typeof import('../stages.js');
export type Settings = Pick<SessionSettings, 'wasm' | 'decoder' | 'worker' | 'threads'>;

/** Bytes to hash, in order. */
export type Parts = Iterable<ArrayBufferView>;
export type Check = [name: string, what: string, parts: Parts];

const CLIP = { width: 160, height: 90, frames: 12, seed: 1 };
/** Two shots, which run window by window. */
const SHOTS = [1, 7].map((seed) => ({ width: 96, height: 64, frames: 10, seed }));
const WINDOWS = { window: 7, overlap: 3 };
/** Frames whose maps are hashed. */
const FRAMES = [0, 6, 11];

/** Yields all results, in order. */
async function* runChecks(
  library: Library,
  settings: Settings,
  signal?: AbortSignal,
): AsyncGenerator<Check, void, undefined> {
  const frames = await createFrames(library, CLIP, settings);
  yield* checkImages(library, frames, settings);
  signal?.throwIfAborted();
  const session = await library.createSession(settings);
  try {
    for (const frame of frames) await session.push(frame);
    const result = await session.run({ signal });
    yield* checkMotion(result);
    yield* checkMasks(library, result, settings);
  } finally {
    session.close();
  }
  yield ['windows', 'masks of two shots, window by window', await runWindows(library, settings, signal)];
}

async function createFrames(library: Library, options: Required<Omit<ClipOptions, 'wasm'>>, { wasm }: Settings) {
  const clip = await library.synthClip({ ...options, ...(wasm ? { wasm } : {}) });
  const frames = Array.from({ length: options.frames }, (_, t) => clip.frame(t));
  clip.close();
  return frames;
}

/** Yields the results of single images. */
async function* checkImages(
  library: Library,
  frames: { data: Uint8ClampedArray<ArrayBuffer>; width: number; height: number }[],
  { threads, ...settings }: Settings,
): AsyncGenerator<Check> {
  const [first, second] = frames as [(typeof frames)[0], (typeof frames)[0]];
  yield ['frames', 'the pixels of a made clip', frames.map(({ data }) => toRgb(data))];
  const engine = await library.createImageEngine(settings);
  try {
    const { u, v } = await engine.flow(first, second);
    yield ['flow', 'optical flow of its first two frames', [u, v]];
    const { pb, thin } = await engine.boundaries(first);
    yield ['boundaries', 'boundary probability of an image', [pb, thin]];
    yield ['superpixels', 'superpixels of an image', [(await engine.superpixels(first)).label]];
    // The last bits of eigenvectors depend on the processor.
    const { discontinuity } = await engine.imageDiscontinuities(first);
    const rounded = Uint8Array.from(discontinuity, (d) => Math.round(2 * d));
    yield ['discontinuities', 'discontinuities of an image, to the nearest half', [rounded]];
  } finally {
    engine.close();
  }
}

/** Yields the results before the masks. */
async function* checkMotion(result: Result): AsyncGenerator<Check> {
  const { startFrame, offset, x, y } = result.trajectories;
  yield ['tracks', 'trajectories of points', [startFrame, offset, x, y]];
  const { i, j, frameOffset, frameEdges } = result.edgeTable;
  yield ['neighbours', 'which trajectories are neighbours', [i, j, frameOffset, frameEdges]];
  const maps = [];
  for (const t of FRAMES) maps.push((await result.saliencyMap(t)).saliency);
  yield ['saliency', 'saliency of pixels', maps];
  const { foreground } = result.saliency;
  yield ['foreground', 'which trajectories are salient', [foreground]];
  yield ['labels', 'the cluster of each trajectory', [result.clusters.label]];
  yield ['track-file', 'trajectories with their clusters as text', [encodeText(result.toTracksDat())]];
}

/** Yields the masks, and the files made from them. */
async function* checkMasks(library: Library, result: Result, settings: Settings): AsyncGenerator<Check> {
  yield ['objects', 'the object of each cluster', [result.clusters.object]];
  yield ['masks', 'masks of all frames', [result.masks]];
  const plates = [];
  for (const t of FRAMES) plates.push((await result.background(t)).data);
  yield ['background', 'frames without the objects', plates];
  const { decoder } = settings;
  const decoderOption = decoder ? { decoder } : {};
  const table = await library.objectTableCsv(await library.objectTable(result, decoderOption), decoderOption);
  yield ['table', 'the table of objects', [encodeText(table)]];
  const { annotations } = await library.cocoRle(result, decoderOption);
  yield ['coco', 'masks as run lengths of COCO', [encodeText(annotations.map(formatCocoLine).join(''))]];
  yield ['npy', 'masks as a file for NumPy', [library.labelsNpy(result)]];
  const pictures = [];
  for (const t of FRAMES)
    pictures.push(await readBack(library, await library.maskPng(result, t, { object: 1 }), settings));
  yield ['png', "an object's masks as PNG files, read back", pictures];
}

/** Returns the pixels of a PNG file. */
async function readBack(library: Library, file: Uint8Array<ArrayBuffer>, { decoder }: Settings) {
  for await (const { pixels } of library.videoFrames([file], decoder ? { decoder } : {}))
    return toRgb((await pixels()).data);
  throw new Error('a PNG file of the package has no frame');
}

/** Formats an annotation without its arbitrary names. */
function formatCocoLine({ image_id, track_id, area, bbox, segmentation: { size, counts } }: CocoAnnotation) {
  return `${image_id} ${track_id} ${area} ${bbox} ${size} ${counts}\n`;
}

/** Returns the ranges of windows, and their masks. */
async function runWindows(library: Library, settings: Settings, signal: AbortSignal | undefined) {
  const shots = await Promise.all(SHOTS.map((shot) => createFrames(library, shot, settings)));
  const parts: ArrayBufferView[] = [];
  for await (const window of library.segmentVideo(shots.flat(), { ...settings, ...WINDOWS, signal })) {
    const { index, shot, firstFrame, settled } = window;
    parts.push(Uint32Array.of(index, shot, firstFrame, settled.from, settled.to));
    for (const { labels } of window.frames()) parts.push(labels);
  }
  return parts;
}

function toRgb(rgba: Uint8Array | Uint8ClampedArray) {
  return Uint8Array.from({ length: (rgba.length / 4) * 3 }, (_, k) => Number(rgba[Math.floor(k / 3) * 4 + (k % 3)]));
}

function encodeText(text: string) {
  return new TextEncoder().encode(text);
}
