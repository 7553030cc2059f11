// Masks as PNG files, in archives of one clip or of several.

import { checkFlag, checkOptions, checkWholeNumber, describe, illegal } from '../../check/errors.js';
import {
  MAX_LABEL,
  checkMasks,
  computeDurations,
  computeFrameRate,
  getEnd,
  getFirstFrame,
  getTimes,
  readLabels,
  selectLabels,
} from '../../check/masks.js';
import { type LabelColors, parseColor, toColorFunction } from '../../draw/labels.js';
import { VERSION } from '../../parameters.js';
import { Encoder } from '../../text.js';
import { encodePng, runTask } from '../../worker/aside.js';
import { yieldThread } from '../../worker/pause.js';
import { formatPngName } from './data.js';
import type { MaskSource, ObjectChoice } from '../../check/masks.js';

/** Options of a mask file. Without `object` the pixel values are the labels, shown in the colours of a palette. */
export interface MaskPngOptions {
  /** Label of one object of the clip, 0 to 255: the file is grey, 255 at that label, else 0. */
  object?: number;
  /** Colours of the labels; `objectColor`, and black for label 0, if not given. */
  palette?: LabelColors;
  /** Makes label 0, or with `object` all but that object, transparent; false if not given. */
  transparent?: boolean;
}

/** Options of an archive of masks. */
export interface MasksZipOptions {
  /**
   * True for a folder per object, `object-1/00000.png` and so on, of files that are 255 at the object and else 0; false
   * for a file per frame whose pixel values are the labels.
   */
  perObject?: boolean;
  /** Objects to keep; others become 0. All but the background if not given. */
  objects?: ObjectChoice;
  /** Colours of the labels, as for single files. */
  palette?: LabelColors;
  /** Makes the background transparent; false if not given. */
  transparent?: boolean;
  /** Frames per second, above 0, up to 1000: sets the times of masks that have none. */
  frameRate?: number;
  /** Called for each frame. */
  onProgress?: (progress: ExportProgress) => void;
  /** Aborts the work: the promise rejects with its reason. */
  signal?: AbortSignal;
}

/** Progress of an export, in frames. */
export type ExportProgress = { done: number; total: number };

/** Colour of label 0 in files: black, as readers of masks expect. */
const BLACK = '#000000';

/** Frames between two pauses for the page's thread. */
const BATCH = 4;

/**
 * Encodes the mask of frame `t` as a PNG file: in palette colours, or one object in black and white.
 * @returns the bytes of the file
 */
export async function maskPng(
  masks: MaskSource,
  t: number,
  options: MaskPngOptions = {},
): Promise<Uint8Array<ArrayBuffer>> {
  checkMasks(masks);
  const { object, palette, transparent = false } = checkOptions(options, ['object', 'palette', 'transparent']);
  checkFlag('transparent', transparent);
  if (object !== undefined) checkWholeNumber('param', 'object', object, 0, MAX_LABEL);
  const labels = readLabels(masks, t);
  const { width, height } = masks;
  if (object !== undefined) {
    await checkPresent(masks, labels, object);
    return encodePng({ pixels: extractObject(labels, object), width, height, ...makeGreyTransparent(transparent) });
  }
  return encodePng({ pixels: Uint8Array.from(labels), width, height, ...createPalette(palette, transparent) });
}

/** Throws if no frame has the object; if only this frame lacks it, the mask is empty. */
async function checkPresent(masks: MaskSource, labels: Uint8Array, object: number) {
  if (object === 0 || labels.includes(object)) return;
  const present = await findPresentLabels(masks, selectLabels(undefined));
  if (present.includes(object)) return;
  const legal = present.length > 0 ? `the label of an object: ${present.join(', ')}` : 'no object: there are none';
  throw illegal('param', 'object', object, legal);
}

/** Returns the transparency of grey files: they have no palette, but one value can be transparent, here 0. */
function makeGreyTransparent(transparent: boolean) {
  return transparent ? { alpha: Uint8Array.of(0, 0) } : {};
}

function extractObject(labels: Uint8Array, object: number) {
  return Uint8Array.from(labels, (label) => (label === object ? 255 : 0));
}

function createPalette(palette: LabelColors | undefined, transparent: boolean) {
  const color = toFileColors(palette);
  const rgb = new Uint8Array(3 * (MAX_LABEL + 1));
  for (let label = 0; label <= MAX_LABEL; label += 1) rgb.set(parseColor(color(label)), 3 * label);
  return transparent ? { palette: rgb, alpha: Uint8Array.of(0) } : { palette: rgb };
}

function toFileColors(palette: LabelColors | undefined): (label: number) => string {
  const color = toColorFunction(palette);
  return (label) => (label === 0 && palette === undefined ? BLACK : color(label));
}

/**
 * Packs all masks in one ZIP archive: PNG files, and `masks.json` with the frames' times and files, the labels and their
 * colours. The same masks give the same bytes.
 * @returns the bytes of the archive
 */
export async function masksZip(masks: MaskSource, options: MasksZipOptions = {}): Promise<Uint8Array<ArrayBuffer>> {
  const files = await encodeFiles(masks, options);
  // PNG files are compressed already.
  const bytes = Object.values(files).map(({ buffer }) => buffer);
  return runTask({ kind: 'zip', files, stored: Object.keys(files) }, bytes);
}

/** Encodes the files of the archive, by name. */
async function encodeFiles(
  masks: MaskSource,
  options: MasksZipOptions,
): Promise<Record<string, Uint8Array<ArrayBuffer>>> {
  checkMasks(masks);
  const legal = ['perObject', 'objects', 'palette', 'transparent', 'frameRate', 'onProgress', 'signal'];
  const {
    perObject = false,
    objects,
    palette,
    transparent = false,
    frameRate,
    onProgress,
    signal,
  } = checkOptions(options, legal);
  checkFlag('perObject', perObject);
  checkFlag('transparent', transparent);
  const times = getTimes(masks, frameRate);
  const selected = selectLabels(objects);
  const colors = createPalette(palette, transparent);
  const { width, height, numFrames } = masks;
  const size = { width, height, ...makeGreyTransparent(transparent) };
  const first = getFirstFrame(masks);
  const present = await findPresentLabels(masks, selected);
  const files: Record<string, Uint8Array<ArrayBuffer>> = {};
  for (let t = 0; t < numFrames; t += 1) {
    signal?.throwIfAborted();
    const labels = readLabels(masks, t);
    if (perObject)
      for (const label of present)
        files[formatObjectName(label, first + t)] = await encodePng({ pixels: extractObject(labels, label), ...size });
    else {
      const pixels = new Uint8Array(labels.length);
      for (let p = 0; p < pixels.length; p += 1) if (selected[Number(labels[p])]) pixels[p] = Number(labels[p]);
      files[formatPngName(first + t)] = await encodePng({ pixels, width, height, ...colors });
    }
    onProgress?.({ done: t + 1, total: numFrames });
    if (t % BATCH === BATCH - 1) await yieldThread();
  }
  const description = describeMasks(masks, computeTiming(masks, times, frameRate), present, { palette, perObject });
  files['masks.json'] = new Encoder().encode(`${JSON.stringify(description, null, 2)}\n`);
  return files;
}

/** Frame rate of a single frame, which has no duration of its own. */
const DEFAULT_FRAME_RATE = 25;

/** Frame times of `masks.json`, in seconds: when each frame is shown and for how long, and the average frame rate. */
type Timing = { times: number[] | null; durations?: number[]; frameRate?: number };

function computeTiming(masks: MaskSource, times: Float64Array | null, frameRate: number = DEFAULT_FRAME_RATE): Timing {
  if (!times) return { times: null };
  const end = getEnd(masks, times, frameRate);
  // A single frame has no average.
  const average = computeFrameRate(times.length, end - Number(times[0])) || frameRate;
  return { times: [...times], durations: computeDurations(times, end), frameRate: average };
}

/** Returns the contents of `masks.json`. */
function describeMasks(
  masks: MaskSource,
  timing: Timing,
  labels: number[],
  { palette, perObject }: { palette: LabelColors | undefined; perObject: boolean },
) {
  const { width, height, numFrames, shots } = masks;
  const color = toFileColors(palette);
  const first = getFirstFrame(masks);
  const listNames = (name: (t: number) => string) => Array.from({ length: numFrames }, (_, t) => name(first + t));
  return {
    generator: 'tracecut',
    version: VERSION,
    width,
    height,
    numFrames,
    ...(first > 0 ? { firstFrame: first } : {}),
    ...timing,
    ...(Array.isArray(shots) ? { shots: shots.map(({ first, last }) => ({ first, last })) } : {}),
    labels,
    palette: Object.fromEntries([0, ...labels].map((label) => [label, color(label)])),
    files: perObject
      ? Object.fromEntries(labels.map((label) => [label, listNames((t) => formatObjectName(label, t))]))
      : listNames(formatPngName),
  };
}

function formatObjectName(label: number, t: number) {
  return `object-${label}/${formatPngName(t)}`;
}

/** Returns the selected labels that are in any frame, without 0. */
async function findPresentLabels(masks: MaskSource, selected: Uint8Array): Promise<number[]> {
  const isPresent = new Uint8Array(MAX_LABEL + 1);
  for (let t = 0; t < masks.numFrames; t += 1) {
    const labels = readLabels(masks, t);
    for (let p = 0; p < labels.length; p += 1) isPresent[Number(labels[p])] = 1;
    if (t % BATCH === BATCH - 1) await yieldThread();
  }
  return [...isPresent.keys()].filter((label) => label > 0 && isPresent[label] && selected[label]);
}

/** A clip of the archive: its masks, or the error why there are none. */
export interface ZippedClip {
  /** Name of its folder. */
  name: string;
  /** Null if there are none. */
  masks: MaskSource | null;
  /** The error why there are none. */
  error?: unknown;
  /** The caller's own data, for the report. */
  about?: Record<string, unknown>;
}

/** Options as of `masksZip`; `onProgress` counts the frames of all clips. */
export type ClipsZipOptions = Omit<MasksZipOptions, 'objects'>;

/**
 * Packs the masks of several clips in one ZIP archive: a folder for each with the files of `masksZip`, and `report.json`
 * with the outcome of each. The same masks give the same bytes.
 * @returns the bytes of the archive
 */
export async function clipsZip(clips: ZippedClip[], options: ClipsZipOptions = {}): Promise<Uint8Array<ArrayBuffer>> {
  if (!Array.isArray(clips)) throw illegal('data', 'clips', clips, 'a list of {name, masks}');
  const legal = ['perObject', 'palette', 'transparent', 'frameRate', 'onProgress', 'signal'];
  const { onProgress, ...each } = checkOptions(options, legal);
  const total = clips.reduce((sum, { masks }) => sum + (masks?.numFrames ?? 0), 0);
  const files: Record<string, Uint8Array<ArrayBuffer>> = {};
  const folders = new Set();
  const report = [];
  let numFramesBefore = 0;
  for (const [k, { name, masks, error, about }] of clips.entries()) {
    if (typeof name !== 'string') throw illegal('data', `clips[${k}].name`, name, 'a text');
    if (!masks) {
      report.push({ name, error: getMessage(error), ...about });
      continue;
    }
    const folder = chooseFolder(name, folders);
    const offset = numFramesBefore;
    const reportProgress = (progress: { done: number }) => onProgress?.({ done: offset + progress.done, total });
    const clipFiles = await encodeFiles(masks, { ...each, onProgress: reportProgress });
    for (const [path, bytes] of Object.entries(clipFiles)) files[`${folder}/${path}`] = bytes;
    numFramesBefore += masks.numFrames;
    const { width, height, numFrames } = masks;
    report.push({ name, folder, width, height, numFrames, ...about });
  }
  const json = JSON.stringify({ generator: 'tracecut', version: VERSION, clips: report }, null, 2);
  files['report.json'] = new Encoder().encode(`${json}\n`);
  // PNG files are compressed already.
  const bytes = Object.values(files).map(({ buffer }) => buffer);
  return runTask({ kind: 'zip', files, stored: Object.keys(files) }, bytes);
}

function getMessage(error: unknown) {
  if (error instanceof Error) return 'code' in error ? `${String(error.code)}: ${error.message}` : error.message;
  return error === undefined || error === null ? 'no masks' : describe(error);
}

/** Returns a folder name that every file system accepts and no other clip has. */
function chooseFolder(name: string, usedNames: Set<unknown>) {
  const stem = name
    .replace(/\.[a-z0-9]{2,5}$/i, '')
    .replace(/[^\p{L}\p{N}_-]+/gu, '-')
    .replace(/^-+|-+$/g, '')
    .slice(0, 80);
  let folder = stem || 'clip';
  for (let k = 2; usedNames.has(folder.toLowerCase()); k += 1) folder = `${stem || 'clip'}-${k}`;
  usedNames.add(folder.toLowerCase());
  return folder;
}
