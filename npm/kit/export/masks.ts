// Masks as PNG files, in archives of one clip or of several.

import { checkFlag, checkedOptions, describe, illegal, wholeNumber } from '../../check/errors.js';
import {
  MAX_LABEL,
  averageRate,
  checkMasks,
  chosenLabels,
  durationsOf,
  endOf,
  firstOf,
  labelsOf,
  timesOf,
} from '../../check/masks.js';
import { type LabelColors, colorsOf, rgbOf } from '../../draw/palette.js';
import { VERSION } from '../../parameters.js';
import { Encoder } from '../../text.js';
import { aside, pngOf } from '../../worker/aside.js';
import { breath } from '../../worker/pause.js';
import { pngName } from './data.js';
import type { MaskSource, ObjectChoice } from '../../check/masks.js';

/**
 * How a mask is written. Without `object` the file's pixel values are the labels, shown in the colours of a palette.
 */
export interface MaskPngOptions {
  /** The label of one object, 0 to 255, that is in the clip: the file is grey, 255 where that label is, else 0. */
  object?: number;
  /** The colours that labels are shown in; `objectColor`, and black for label 0, if not given. */
  palette?: LabelColors;
  /** Whether label 0, or with `object` all but that object, is shown as nothing; false if not given. */
  transparent?: boolean;
}

/** What an archive of masks holds. */
export interface MasksZipOptions {
  /**
   * True for a folder for each object, `object-1/00000.png` and so on, of files that are 255 where it is and else 0;
   * else a file for each frame whose pixel values are the labels.
   */
  perObject?: boolean;
  /** Others are left out (they become 0); all but the background if not given. */
  objects?: ObjectChoice;
  /** The colours that labels are shown in, as of single files. */
  palette?: LabelColors;
  /** Whether what is no object is shown as nothing; false if not given. */
  transparent?: boolean;
  /** Frames per second, above 0, up to 1000: gives times to masks that have none. */
  frameRate?: number;
  /** Told of each frame. */
  onProgress?: (progress: ExportProgress) => void;
  /** Ends the work: the promise rejects with its reason. */
  signal?: AbortSignal;
}

/** How far an export is, in frames. */
export type ExportProgress = { done: number; total: number };

/** The colour of label 0 in files: black, as readers of masks expect it. */
const BLACK = '#000000';

/** Frames that are written before others may do something. */
const BATCH = 4;

/**
 * The mask of frame `t` as a PNG file: in palette colours, or of one object in black and white.
 * @returns the bytes of the file
 */
export async function maskPng(
  masks: MaskSource,
  t: number,
  options: MaskPngOptions = {},
): Promise<Uint8Array<ArrayBuffer>> {
  checkMasks(masks);
  const { object, palette, transparent = false } = checkedOptions(options, ['object', 'palette', 'transparent']);
  checkFlag('transparent', transparent);
  if (object !== undefined) wholeNumber('param', 'object', object, 0, MAX_LABEL);
  const labels = labelsOf(masks, t);
  const { width, height } = masks;
  if (object !== undefined) {
    await checkThere(masks, labels, object);
    return pngOf({ pixels: only(labels, object), width, height, ...clearGrey(transparent) });
  }
  return pngOf({ pixels: Uint8Array.from(labels), width, height, ...table(palette, transparent) });
}

/** Refuses an object that no frame has; one that this frame alone does not have gives an empty mask. */
async function checkThere(masks: MaskSource, labels: Uint8Array, object: number) {
  if (object === 0 || labels.includes(object)) return;
  const present = await presentLabels(masks, chosenLabels(undefined));
  if (present.includes(object)) return;
  const legal = present.length > 0 ? `the label of an object: ${present.join(', ')}` : 'no object: there are none';
  throw illegal('param', 'object', object, legal);
}

/** Grey files have no palette whose entries could be clear: one value is, here 0. */
function clearGrey(transparent: boolean) {
  return transparent ? { alpha: Uint8Array.of(0, 0) } : {};
}

function only(labels: Uint8Array, object: number) {
  return Uint8Array.from(labels, (label) => (label === object ? 255 : 0));
}

function table(palette: LabelColors | undefined, transparent: boolean) {
  const color = fileColors(palette);
  const rgb = new Uint8Array(3 * (MAX_LABEL + 1));
  for (let label = 0; label <= MAX_LABEL; label += 1) rgb.set(rgbOf(color(label)), 3 * label);
  return transparent ? { palette: rgb, alpha: Uint8Array.of(0) } : { palette: rgb };
}

function fileColors(palette: LabelColors | undefined): (label: number) => string {
  const color = colorsOf(palette);
  return (label) => (label === 0 && palette === undefined ? BLACK : color(label));
}

/**
 * All masks in one ZIP archive: PNG files, and `masks.json`, which says the frames' times and files, the labels and
 * their colours. The same masks give the same bytes.
 * @returns the bytes of the archive
 */
export async function masksZip(masks: MaskSource, options: MasksZipOptions = {}): Promise<Uint8Array<ArrayBuffer>> {
  const files = await filesOfMasks(masks, options);
  // PNG files are compressed already.
  const bytes = Object.values(files).map(({ buffer }) => buffer);
  return aside({ kind: 'zip', files, stored: Object.keys(files) }, bytes);
}

/** What the archive holds, by name. */
async function filesOfMasks(
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
  } = checkedOptions(options, legal);
  checkFlag('perObject', perObject);
  checkFlag('transparent', transparent);
  const times = timesOf(masks, frameRate);
  const chosen = chosenLabels(objects);
  const colors = table(palette, transparent);
  const { width, height, numFrames } = masks;
  const size = { width, height, ...clearGrey(transparent) };
  const first = firstOf(masks);
  const present = await presentLabels(masks, chosen);
  const files: Record<string, Uint8Array<ArrayBuffer>> = {};
  for (let t = 0; t < numFrames; t += 1) {
    signal?.throwIfAborted();
    const labels = labelsOf(masks, t);
    if (perObject)
      for (const label of present)
        files[objectFile(label, first + t)] = await pngOf({ pixels: only(labels, label), ...size });
    else {
      const pixels = new Uint8Array(labels.length);
      for (let p = 0; p < pixels.length; p += 1) if (chosen[Number(labels[p])]) pixels[p] = Number(labels[p]);
      files[pngName(first + t)] = await pngOf({ pixels, width, height, ...colors });
    }
    onProgress?.({ done: t + 1, total: numFrames });
    if (t % BATCH === BATCH - 1) await breath();
  }
  const about = description(masks, timingOf(masks, times, frameRate), present, { palette, perObject });
  files['masks.json'] = new Encoder().encode(`${JSON.stringify(about, null, 2)}\n`);
  return files;
}

/** Frames a second where a single frame does not say how long it lasts. */
const USUAL_RATE = 25;

/** Frame times of `masks.json`, in seconds: when each is shown and for how long, and their average rate. */
export type Timing = { times: number[] | null; durations?: number[]; frameRate?: number };

function timingOf(masks: MaskSource, times: Float64Array | null, frameRate: number = USUAL_RATE): Timing {
  if (!times) return { times: null };
  const end = endOf(masks, times, frameRate);
  // One frame has no average.
  const average = averageRate(times.length, end - Number(times[0])) || frameRate;
  return { times: [...times], durations: durationsOf(times, end), frameRate: average };
}

/** What `masks.json` says. */
function description(
  masks: MaskSource,
  timing: Timing,
  labels: number[],
  { palette, perObject }: { palette: LabelColors | undefined; perObject: boolean },
) {
  const { width, height, numFrames, shots } = masks;
  const color = fileColors(palette);
  const first = firstOf(masks);
  const named = (name: (t: number) => string) => Array.from({ length: numFrames }, (_, t) => name(first + t));
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
      ? Object.fromEntries(labels.map((label) => [label, named((t) => objectFile(label, t))]))
      : named(pngName),
  };
}

function objectFile(label: number, t: number) {
  return `object-${label}/${pngName(t)}`;
}

/** Returns the chosen labels that are in any frame, 0 left out. */
async function presentLabels(masks: MaskSource, chosen: Uint8Array): Promise<number[]> {
  const seen = new Uint8Array(MAX_LABEL + 1);
  for (let t = 0; t < masks.numFrames; t += 1) {
    const labels = labelsOf(masks, t);
    for (let p = 0; p < labels.length; p += 1) seen[Number(labels[p])] = 1;
    if (t % BATCH === BATCH - 1) await breath();
  }
  return [...seen.keys()].filter((label) => label > 0 && seen[label] && chosen[label]);
}

/** A clip of the archive: its masks, or the error for which there are none. */
export interface ZippedClip {
  /** What its folder is called after. */
  name: string;
  /** Null where there are none. */
  masks: MaskSource | null;
  /** Why there are none. */
  error?: unknown;
  /** The caller's own, for the report. */
  about?: Record<string, unknown>;
}

/** As of `masksZip`; `onProgress` counts the frames of all clips. */
export type ClipsZipOptions = Omit<MasksZipOptions, 'objects'>;

/**
 * The masks of several clips in one ZIP archive: a folder for each, with what `masksZip` puts into one, and
 * `report.json`, which says what became of each. The same masks give the same bytes.
 * @returns the bytes of the archive
 */
export async function clipsZip(clips: ZippedClip[], options: ClipsZipOptions = {}): Promise<Uint8Array<ArrayBuffer>> {
  if (!Array.isArray(clips)) throw illegal('data', 'clips', clips, 'a list of {name, masks}');
  const legal = ['perObject', 'palette', 'transparent', 'frameRate', 'onProgress', 'signal'];
  const { onProgress, ...each } = checkedOptions(options, legal);
  const total = clips.reduce((sum, { masks }) => sum + (masks?.numFrames ?? 0), 0);
  const files: Record<string, Uint8Array<ArrayBuffer>> = {};
  const folders = new Set();
  const report = [];
  let before = 0;
  for (const [k, { name, masks, error, about }] of clips.entries()) {
    if (typeof name !== 'string') throw illegal('data', `clips[${k}].name`, name, 'a text');
    if (!masks) {
      report.push({ name, error: wordsOf(error), ...about });
      continue;
    }
    const folder = folderOf(name, folders);
    const done = before;
    const counted = (progress: { done: number }) => onProgress?.({ done: done + progress.done, total });
    const made = await filesOfMasks(masks, { ...each, onProgress: counted });
    for (const [path, bytes] of Object.entries(made)) files[`${folder}/${path}`] = bytes;
    before += masks.numFrames;
    const { width, height, numFrames } = masks;
    report.push({ name, folder, width, height, numFrames, ...about });
  }
  const json = JSON.stringify({ generator: 'tracecut', version: VERSION, clips: report }, null, 2);
  files['report.json'] = new Encoder().encode(`${json}\n`);
  // PNG files are compressed already.
  const bytes = Object.values(files).map(({ buffer }) => buffer);
  return aside({ kind: 'zip', files, stored: Object.keys(files) }, bytes);
}

function wordsOf(error: unknown) {
  if (error instanceof Error) return 'code' in error ? `${String(error.code)}: ${error.message}` : error.message;
  return error === undefined || error === null ? 'no masks' : describe(error);
}

/** A folder for a clip: what every file system takes, and no other clip has. */
function folderOf(name: string, taken: Set<unknown>) {
  const stem = name
    .replace(/\.[a-z0-9]{2,5}$/i, '')
    .replace(/[^\p{L}\p{N}_-]+/gu, '-')
    .replace(/^-+|-+$/g, '')
    .slice(0, 80);
  let folder = stem || 'clip';
  for (let k = 2; taken.has(folder.toLowerCase()); k += 1) folder = `${stem || 'clip'}-${k}`;
  taken.add(folder.toLowerCase());
  return folder;
}
