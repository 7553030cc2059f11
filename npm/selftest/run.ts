// The program whose results are hashed, run, and its hashes compared with what they are everywhere else.
// `cli/src/selftest.rs` is the same program: same clips, same bytes, same order.
// It knows the package by what it exports, so that a page that has loaded it loads nothing twice.

import { illegal, isPlainObject } from '../check/errors.js';
import { EXPECTED } from './expected.js';
import type { SessionSettings, WasmSource } from '../check/options.js';
import type { CocoAnnotation } from '../kit/export/coco.js';
import type { WorkerSource } from '../places.js';
import type { Result } from '../session/result.js';
import type { ClipOptions } from '../stages/clip.js';

/**
 * One result, hashed: `hash` and `expected` are the first 64 bits of its SHA-256, in hexadecimal digits; `same` tells
 * whether they are equal.
 */
export type SelftestCheck = {
  readonly name: string;
  readonly what: string;
  readonly hash: string;
  readonly expected: string;
  readonly same: boolean;
};

/**
 * What became of a self test: `same` is true where every check is the same and the package is of the `version` that the
 * hashes are of.
 */
export type Selftest = { readonly version: string; readonly same: boolean; readonly checks: readonly SelftestCheck[] };

/** Options of `selftest`. */
export interface SelftestOptions {
  /** Told of each check as soon as it is done. */
  onCheck?: (check: SelftestCheck) => void;
  /** Ends the work: the promise rejects with its reason. */
  signal?: AbortSignal;
  /** As of a session. */
  wasm?: WasmSource;
  /** As of a session. */
  decoder?: WasmSource;
  /** As of a session. */
  worker?: boolean | WorkerSource;
  /** As of a session; the hashes are the same for any number. */
  threads?: number;
}

/** How bytes are hashed here. */
export type Digest = (bytes: Uint8Array<ArrayBuffer>) => Promise<Uint8Array>;

/** How many there are. */
const NUM_CHECKS = Object.keys(EXPECTED.hashes).length;

const LEGAL = ['onCheck', 'signal', 'wasm', 'decoder', 'worker', 'threads'];

/** Runs the self test with a package that is loaded already. */
export async function selftestOf(
  library: Library,
  options: SelftestOptions = {},
  digest: Digest = digestHere(library),
): Promise<Selftest> {
  if (!isPlainObject(options)) throw illegal('param', 'options', options, `an object of ${LEGAL.join(', ')}`);
  const unknown = Object.entries(options).find(([name]) => !LEGAL.includes(name));
  if (unknown) throw illegal('param', unknown[0], unknown[1], LEGAL.join(', '));
  const { onCheck, signal, ...settings } = options;
  const done: SelftestCheck[] = [];
  for await (const [name, what, parts] of checks(library, settings, signal)) {
    signal?.throwIfAborted();
    const hash = hexOf(await digest(joined(parts)));
    const expected = EXPECTED.hashes[name] ?? 'nothing';
    const check = { name, what, hash, expected, same: hash === expected };
    done.push(check);
    onCheck?.(check);
  }
  const { version } = library;
  const same = done.every((check) => check.same) && done.length === NUM_CHECKS && version === EXPECTED.version;
  return { version, same, checks: done };
}

function digestHere({ TraceCutError }: Library): Digest {
  const subtle = globalThis.crypto?.subtle;
  if (!subtle)
    throw new TraceCutError('unsupported', 'hashes need crypto.subtle: pages have it by https and on localhost');
  return async (bytes) => new Uint8Array(await subtle.digest('SHA-256', bytes));
}

function joined(parts: Parts) {
  const list = [...parts].map(({ buffer, byteOffset, byteLength }) => new Uint8Array(buffer, byteOffset, byteLength));
  const all = new Uint8Array(list.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const part of list) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

function hexOf(hash: Uint8Array) {
  return Array.from(hash.subarray(0, 8), (byte) => byte.toString(16).padStart(2, '0')).join('');
}

/** The entries of the package that are needed. */
export type Library = typeof import('../index.js') & typeof import('../export.js') & typeof import('../stages.js');
export type Settings = Pick<SessionSettings, 'wasm' | 'decoder' | 'worker' | 'threads'>;

/** What is hashed: bytes, one after the other. */
export type Parts = Iterable<ArrayBufferView>;
export type Check = [name: string, what: string, parts: Parts];

const CLIP = { width: 160, height: 90, frames: 12, seed: 1 };
/** Two shots, which run window by window. */
const SHOTS = [1, 7].map((seed) => ({ width: 96, height: 64, frames: 10, seed }));
const WINDOWS = { window: 7, overlap: 3 };
/** Frames whose maps are looked at. */
const FRAMES = [0, 6, 11];

/** All results, one after the other. */
export async function* checks(
  library: Library,
  settings: Settings,
  signal?: AbortSignal,
): AsyncGenerator<Check, void, undefined> {
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

async function framesOf(library: Library, options: Required<Omit<ClipOptions, 'wasm'>>, { wasm }: Settings) {
  const clip = await library.synthClip({ ...options, ...(wasm ? { wasm } : {}) });
  const frames = Array.from({ length: options.frames }, (_, t) => clip.frame(t));
  clip.close();
  return frames;
}

/** What single images come to. */
async function* imageChecks(
  library: Library,
  frames: { data: Uint8ClampedArray<ArrayBuffer>; width: number; height: number }[],
  { threads, ...settings }: Settings,
): AsyncGenerator<Check> {
  const [first, second] = frames as [(typeof frames)[0], (typeof frames)[0]];
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

/** What comes before the masks. */
async function* motionChecks(result: Result): AsyncGenerator<Check> {
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

/** The masks, and the files that are made of them. */
async function* maskChecks(library: Library, result: Result, settings: Settings): AsyncGenerator<Check> {
  yield ['objects', 'the object of each cluster', [there(result.clusters.object)]];
  yield ['masks', 'masks of all frames', [there(result.masks)]];
  const plates = [];
  for (const t of FRAMES) plates.push((await result.background(t)).data);
  yield ['background', 'frames without the objects', plates];
  const { decoder } = settings;
  const given = decoder ? { decoder } : {};
  const table = await library.objectTableCsv(await library.objectTable(result, given), given);
  yield ['table', 'the table of objects', [bytesOf(table)]];
  const { annotations } = await library.cocoRle(result, given);
  yield ['coco', 'masks as run lengths of COCO', [bytesOf(annotations.map(cocoLine).join(''))]];
  yield ['npy', 'masks as a file for NumPy', [library.labelsNpy(result)]];
  const pictures = [];
  for (const t of FRAMES)
    pictures.push(await readBack(library, await library.maskPng(result, t, { object: 1 }), settings));
  yield ['png', "an object's masks as PNG files, read back", pictures];
}

/** The pixels of a PNG file. */
async function readBack(library: Library, file: Uint8Array<ArrayBuffer>, { decoder }: Settings) {
  for await (const { pixels } of library.videoFrames([file], decoder ? { decoder } : {}))
    return rgb((await pixels()).data);
  throw new Error('a PNG file of the package has no frame');
}

/** An annotation without what is only a name. */
function cocoLine({ image_id, track_id, area, bbox, segmentation: { size, counts } }: CocoAnnotation) {
  return `${image_id} ${track_id} ${area} ${bbox} ${size} ${counts}\n`;
}

/** Which windows there are, and their masks. */
async function windowParts(library: Library, settings: Settings, signal: AbortSignal | undefined) {
  const shots = await Promise.all(SHOTS.map((shot) => framesOf(library, shot, settings)));
  const parts: ArrayBufferView[] = [];
  // Not as a list: where the number of frames is known, the last windows lie otherwise.
  for await (const window of library.segmentVideo(shots.flat().values(), { ...settings, ...WINDOWS, signal })) {
    const { index, shot, firstFrame, settled } = window;
    parts.push(Uint32Array.of(index, shot, firstFrame, settled.from, settled.to));
    for (const { labels } of window.frames()) parts.push(labels);
  }
  return parts;
}

function rgb(rgba: Uint8Array | Uint8ClampedArray) {
  return Uint8Array.from({ length: (rgba.length / 4) * 3 }, (_, k) => Number(rgba[Math.floor(k / 3) * 4 + (k % 3)]));
}

function bytesOf(text: string) {
  return new TextEncoder().encode(text);
}

function there<T>(found: T | null): T {
  if (found === null) throw new Error('a run with frames ended without saliency or masks');
  return found;
}
