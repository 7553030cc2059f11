// A project file: the masks of a clip and their manual edits. A ZIP archive of `project.json`, masks as runs,
// trajectories, and files of the caller, such as the video itself.

import {
  TraceCutError,
  checkOptions,
  checkSides,
  checkWholeNumber,
  illegal,
  isPlainObject,
} from '../../check/errors.js';
import { MAX_FRAMES, type MaskSource, checkMasks, getTimes, readLabels } from '../../check/masks.js';
import { VERSION } from '../../parameters.js';
import { loadPart } from '../../platform.js';
import { getTrajectories } from '../../session/report.js';
import { checkRuns, encodeRuns, joinRuns, joinWords, splitRuns } from '../../session/serialize.js';
import { Decoder, Encoder } from '../../text.js';
import { type ClipTrajectories, type Shot, VideoResult } from '../../video/result.js';
import { runTask } from '../../worker/aside.js';
import { yieldThread } from '../../worker/pause.js';
import type { FrameRange } from '../../session/result.js';
import type { MaskEditor, SavedEdits } from './editor.js';

/** Further contents of a project. */
export interface ProjectOptions {
  /** The editor whose edits are saved; it must be over these masks. */
  editor?: MaskEditor;
  /** The caller's own data, for JSON. */
  about?: unknown;
  /** Files by name, stored as they are. A name may have folders (`a/b.txt`), but no `..`, root or drive. */
  files?: Record<string, Uint8Array>;
  /** Frames per second, if the masks have no times; 25 if not given. */
  frameRate?: number;
  /** Aborts the work: the promise rejects with its reason. */
  signal?: AbortSignal;
}

/** An opened project: `masks` before the `edits`, which `MaskEditor.restore` applies again. */
export type Project = {
  readonly masks: VideoResult;
  readonly edits: SavedEdits | null;
  readonly about: unknown;
  readonly files: Record<string, Uint8Array>;
};

/** Version of the file format; other versions are refused. */
const FORMAT = 2;
/** Folder of the caller's files in the archive. */
const FOLDER = 'files/';
/** Largest size of an unpacked archive. */
const MAX_UNPACKED_BYTES = 2 ** 31;
/** Frames between two pauses for the page's thread. */
const BATCH = 8;

/**
 * Saves masks and their edits as a file. The same masks and edits give the same bytes.
 * @param masks without edits
 */
export async function saveProject(masks: MaskSource, options: ProjectOptions = {}): Promise<Uint8Array<ArrayBuffer>> {
  const {
    editor,
    about = null,
    files = {},
    frameRate,
    signal,
  } = checkOptions(options, ['editor', 'about', 'files', 'frameRate', 'signal']);
  const result = await toVideoResult(masks, frameRate, signal);
  const { width, height, numFrames, times, end, shots, doubts, runs, trajectories } = result;
  const json = { tracecut: VERSION, format: FORMAT, width, height, numFrames, times: [...times], end, shots, doubts };
  const text = JSON.stringify({ ...json, edits: editor?.toJSON() ?? null, about });
  const entries: Record<string, Uint8Array> = {
    'project.json': new Encoder().encode(text),
    'masks.bin': wordsToBytes(joinRuns(runs)),
    'trajectories.bin': wordsToBytes(joinWords(encodeTrajectories(trajectories))),
  };
  for (const [name, bytes] of Object.entries(files)) entries[FOLDER + checkFileName(name)] = bytes;
  const stored = Object.keys(files).map((name) => FOLDER + name);
  return runTask({ kind: 'zip', files: entries, stored });
}

/**
 * Converts masks of any kind to a result of their own.
 * @param frameRate frames per second, if the masks have no times
 */
export async function toVideoResult(masks: MaskSource, frameRate = 25, signal?: AbortSignal): Promise<VideoResult> {
  checkMasks(masks);
  const { width, height, numFrames, end, shots, doubts } = masks;
  const times = getTimes(masks, frameRate)!;
  const runs = [];
  for (let t = 0; t < numFrames; t += 1) {
    signal?.throwIfAborted();
    runs.push(encodeRuns(readLabels(masks, t)));
    if (t % BATCH === BATCH - 1) await yieldThread();
  }
  return new VideoResult({
    ...{ width, height, times, end: end ?? null, runs },
    shots: shots?.map(({ first, last }) => ({ first, last })) ?? [{ first: 0, last: numFrames - 1 }],
    doubts: doubts?.map(({ from, to }) => ({ from, to })) ?? [],
    trajectories: getTrajectories(masks) ?? decodeTrajectories(Uint32Array.of(0, 0, 0)),
  });
}

/** Opens a file saved by `saveProject`. */
export async function openProject(file: Uint8Array | ArrayBuffer | Blob): Promise<Project> {
  const bytes = await readBytes(file);
  const { unzipSync } = await loadPart(import('../../vendor/zip.js'));
  let entries: Record<string, Uint8Array>;
  let total = 0;
  try {
    entries = unzipSync(bytes, {
      filter({ originalSize }) {
        total += originalSize;
        if (total > MAX_UNPACKED_BYTES)
          throw illegal('data', 'the size of the project', total, `up to ${MAX_UNPACKED_BYTES} bytes`);
        return true;
      },
    });
  } catch (cause) {
    if (cause instanceof TraceCutError) throw cause;
    throw new TraceCutError('data', 'not a project file, or a damaged one', { cause });
  }
  const { 'project.json': json, 'masks.bin': masks, 'trajectories.bin': tracks } = entries;
  if (!json || !masks || !tracks) throw new TraceCutError('data', 'the archive is not a project file');
  const { width, height, times, end, shots, doubts, edits, about, format } = parseProject(json);
  if (format !== FORMAT) throw illegal('data', 'the format of the project', format, `${FORMAT}`);
  const files = Object.entries(entries).filter(([name]) => name.startsWith(FOLDER));
  return {
    masks: new VideoResult({
      width,
      height,
      times: Float64Array.from(times),
      end: typeof end === 'number' ? end : null,
      shots,
      doubts: doubts ?? [],
      runs: splitRuns(bytesToWords(masks, 'masks.bin'), times.length).map((runs, t) =>
        checkRuns(`the mask of frame ${t}`, runs, width * height),
      ),
      trajectories: decodeTrajectories(bytesToWords(tracks, 'trajectories.bin')),
    }),
    edits,
    about,
    files: Object.fromEntries(files.map(([name, content]) => [checkFileName(name.slice(FOLDER.length)), content])),
  };
}

/** Throws unless the name of a file stays within the folder that it is unpacked to. */
function checkFileName(name: string) {
  const parts = name.split(/[\\/]/);
  if (parts.some((segment) => ['', '.', '..'].includes(segment)) || /^[a-z]:|\0/i.test(name))
    throw illegal('data', 'the name of a file', name, 'a name without "..", a root or a drive, such as "clip.webm"');
  return name;
}

async function readBytes(file: unknown) {
  if (file instanceof Uint8Array) return file;
  if (file instanceof ArrayBuffer) return new Uint8Array(file);
  if (typeof Blob !== 'undefined' && file instanceof Blob) return new Uint8Array(await file.arrayBuffer());
  throw illegal('data', 'file', file, 'the bytes of a project: a Uint8Array, an ArrayBuffer or a Blob');
}

/** The contents of `project.json`, checked where they are used. */
interface SavedProject {
  format: unknown;
  width: number;
  height: number;
  times: number[];
  end: unknown;
  shots: Shot[];
  doubts?: FrameRange[];
  edits: SavedEdits | null;
  about: unknown;
}

function parseProject(bytes: Uint8Array): SavedProject {
  let json: unknown;
  try {
    json = JSON.parse(new Decoder().decode(bytes));
  } catch (cause) {
    throw new TraceCutError('data', 'project.json is damaged', { cause });
  }
  if (!isPlainObject(json) || !Array.isArray(json.times)) throw new TraceCutError('data', 'project.json is damaged');
  checkSides('data', '', json);
  checkWholeNumber('data', 'the number of frames', json.times.length, 1, MAX_FRAMES);
  return json as unknown as SavedProject;
}

/** Converts trajectories to words: their number and the number of points, first frames, offsets, places, labels. */
function encodeTrajectories({ count, startFrame, offset, x, y, label }: ClipTrajectories) {
  const places = [x, y].map((values) => new Uint32Array(Float32Array.from(values).buffer));
  return [Uint32Array.of(count, x.length), startFrame, offset, ...places, Uint32Array.from(label)];
}

function decodeTrajectories(words: Uint32Array<ArrayBuffer>): ClipTrajectories {
  const [count = 0, points = 0] = words;
  let offsetInWords = 2;
  const take = (length: number) => words.slice(offsetInWords, (offsetInWords += length));
  const [startFrame, offset] = [take(count), take(count + 1)];
  const [x, y] = [take(points), take(points)].map((places) => new Float32Array(places.buffer));
  const label = Uint8Array.from(take(count));
  if (offsetInWords !== words.length || offset[count] !== points || !x || !y)
    throw new TraceCutError('data', 'the trajectories of the project are damaged');
  return { count, startFrame, offset, x, y, label };
}

const wordsToBytes = (words: Uint32Array<ArrayBuffer>) => new Uint8Array(words.buffer);

function bytesToWords(bytes: Uint8Array, name: string) {
  if (bytes.length % 4 !== 0) throw new TraceCutError('data', `${name} is cut off`);
  return new Uint32Array(bytes.slice().buffer);
}
