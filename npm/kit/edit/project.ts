// A project file: the masks of a clip and what was changed by hand, to be opened again. A ZIP archive: `project.json`,
// masks as runs, trajectories, and files of the caller's, such as the video itself.

import { TraceCutError, checkSides, checkedOptions, illegal, isPlainObject, wholeNumber } from '../../check/errors.js';
import { type MaskSource, checkMasks, labelsOf, timesOf } from '../../check/masks.js';
import { VERSION } from '../../parameters.js';
import { part } from '../../places.js';
import { clipTrajectories } from '../../session/report.js';
import { checkRuns, encodeRuns, joinRuns, joinWords, splitRuns } from '../../session/runs.js';
import { Decoder, Encoder } from '../../text.js';
import { type ClipTrajectories, type Shot, VideoResult } from '../../video/result.js';
import { aside } from '../../worker/aside.js';
import { breath } from '../../worker/pause.js';
import type { MaskEditor, SavedEdits } from './editor.js';

/** What is saved beside the masks. */
export interface ProjectOptions {
  /** Its edits by hand, over these very masks. */
  editor?: MaskEditor;
  /** The caller's own, anything that JSON can hold. */
  about?: unknown;
  /**
   * By name, stored as they are; a name may have folders (`a/b.txt`), none of them `..`, and begins with no root or
   * drive.
   */
  files?: Record<string, Uint8Array>;
  /** Frames per second, where the masks have no times; 25 if not given. */
  frameRate?: number;
  /** Ends the work: the promise rejects with its reason. */
  signal?: AbortSignal;
}

/** A project that was opened: `masks` as they were before `edits`, which `MaskEditor.restore` does again. */
export type Project = {
  readonly masks: VideoResult;
  readonly edits: SavedEdits | null;
  readonly about: unknown;
  readonly files: Record<string, Uint8Array>;
};

const FORMAT = 2;
const FOLDER = 'files/';
/** Archives that unpack to more are refused, in bytes. */
const MOST_BYTES = 2 ** 31;
const MAX_FRAMES = 10_000_000;
/** Frames between two breaths. */
const BATCH = 8;

/**
 * Masks, and what was changed in them, as a file. The same masks and edits give the same bytes.
 * @param masks without edits
 */
export async function saveProject(masks: MaskSource, options: ProjectOptions = {}): Promise<Uint8Array<ArrayBuffer>> {
  const {
    editor,
    about = null,
    files = {},
    frameRate,
    signal,
  } = checkedOptions(options, ['editor', 'about', 'files', 'frameRate', 'signal']);
  const result = await resultOf(masks, frameRate, signal);
  const { width, height, numFrames, times, end, shots, runs, trajectories } = result;
  const json = { tracecut: VERSION, format: FORMAT, width, height, numFrames, times: [...times], end, shots };
  const text = JSON.stringify({ ...json, edits: editor?.toJSON() ?? null, about });
  const entries: Record<string, Uint8Array> = {
    'project.json': new Encoder().encode(text),
    'masks.bin': bytesOfWords(joinRuns(runs)),
    'trajectories.bin': bytesOfWords(joinWords(trajectoryWords(trajectories))),
  };
  for (const [name, bytes] of Object.entries(files)) entries[FOLDER + inside(name)] = bytes;
  const stored = Object.keys(files).map((name) => FOLDER + name);
  return aside({ kind: 'zip', files: entries, stored });
}

/**
 * Returns masks of any kind as a result of their own.
 * @param frameRate frames per second, where the masks have no times
 */
export async function resultOf(masks: MaskSource, frameRate = 25, signal?: AbortSignal): Promise<VideoResult> {
  checkMasks(masks);
  const { width, height, numFrames, end, shots } = masks;
  const times = timesOf(masks, frameRate)!;
  const runs = [];
  for (let t = 0; t < numFrames; t += 1) {
    signal?.throwIfAborted();
    runs.push(encodeRuns(labelsOf(masks, t)));
    if (t % BATCH === BATCH - 1) await breath();
  }
  return new VideoResult({
    ...{ width, height, times, end: end ?? null, runs },
    shots: shots?.map(({ first, last }) => ({ first, last })) ?? [{ first: 0, last: numFrames - 1 }],
    trajectories: clipTrajectories(masks) ?? trajectoriesOf(Uint32Array.of(0, 0, 0)),
  });
}

/** Opens what `saveProject` made. */
export async function openProject(file: Uint8Array | ArrayBuffer | Blob): Promise<Project> {
  const bytes = await bytesOf(file);
  const { unzipSync } = await part(import('../../vendor/zip.js'));
  let entries: Record<string, Uint8Array>;
  let total = 0;
  try {
    entries = unzipSync(bytes, {
      filter({ originalSize }) {
        total += originalSize;
        if (total > MOST_BYTES) throw illegal('data', 'the size of the project', total, `up to ${MOST_BYTES} bytes`);
        return true;
      },
    });
  } catch (cause) {
    if (cause instanceof TraceCutError) throw cause;
    throw new TraceCutError('data', 'this is no project file, or it is damaged', { cause });
  }
  const { 'project.json': json, 'masks.bin': masks, 'trajectories.bin': tracks } = entries;
  if (!json || !masks || !tracks) throw new TraceCutError('data', 'this archive is no project file');
  const { width, height, times, end, shots, edits, about, format } = parsed(json);
  if (format !== FORMAT) throw illegal('data', 'the format of the project', format, `${FORMAT}`);
  const files = Object.entries(entries).filter(([name]) => name.startsWith(FOLDER));
  return {
    masks: new VideoResult({
      width,
      height,
      times: Float64Array.from(times),
      end: typeof end === 'number' ? end : null,
      shots,
      runs: splitRuns(wordsOf(masks, 'masks.bin'), times.length).map((runs, t) =>
        checkRuns(`the mask of frame ${t}`, runs, width * height),
      ),
      trajectories: trajectoriesOf(wordsOf(tracks, 'trajectories.bin')),
    }),
    edits,
    about,
    files: Object.fromEntries(files.map(([name, content]) => [inside(name.slice(FOLDER.length)), content])),
  };
}

/** The name of a file: whoever writes it into a folder writes it there and nowhere else. */
function inside(name: string) {
  const parts = name.split(/[\\/]/);
  if (parts.some((one) => ['', '.', '..'].includes(one)) || /^[a-z]:|\0/i.test(name))
    throw illegal('data', 'the name of a file', name, 'a name without "..", a root or a drive, such as "clip.webm"');
  return name;
}

async function bytesOf(file: unknown) {
  if (file instanceof Uint8Array) return file;
  if (file instanceof ArrayBuffer) return new Uint8Array(file);
  if (typeof Blob !== 'undefined' && file instanceof Blob) return new Uint8Array(await file.arrayBuffer());
  throw illegal('data', 'file', file, 'the bytes of a project: a Uint8Array, an ArrayBuffer or a Blob');
}

/** A project's description; what it says is checked where it is used. */
interface SavedProject {
  format: unknown;
  width: number;
  height: number;
  times: number[];
  end: unknown;
  shots: Shot[];
  edits: SavedEdits | null;
  about: unknown;
}

function parsed(bytes: Uint8Array): SavedProject {
  let json: unknown;
  try {
    json = JSON.parse(new Decoder().decode(bytes));
  } catch (cause) {
    throw new TraceCutError('data', 'project.json is damaged', { cause });
  }
  if (!isPlainObject(json) || !Array.isArray(json.times)) throw new TraceCutError('data', 'project.json is damaged');
  checkSides('data', '', json);
  wholeNumber('data', 'the number of frames', json.times.length, 1, MAX_FRAMES);
  return json as unknown as SavedProject;
}

/** Trajectories as words: their number and the number of their points, first frames, offsets, places, labels. */
function trajectoryWords({ count, startFrame, offset, x, y, label }: ClipTrajectories) {
  const places = [x, y].map((values) => new Uint32Array(Float32Array.from(values).buffer));
  return [Uint32Array.of(count, x.length), startFrame, offset, ...places, Uint32Array.from(label)];
}

function trajectoriesOf(words: Uint32Array<ArrayBuffer>): ClipTrajectories {
  const [count = 0, points = 0] = words;
  let from = 2;
  const take = (length: number) => words.slice(from, (from += length));
  const [startFrame, offset] = [take(count), take(count + 1)];
  const [x, y] = [take(points), take(points)].map((places) => new Float32Array(places.buffer));
  const label = Uint8Array.from(take(count));
  if (from !== words.length || offset[count] !== points || !x || !y)
    throw new TraceCutError('data', 'the trajectories of the project are damaged');
  return { count, startFrame, offset, x, y, label };
}

const bytesOfWords = (words: Uint32Array<ArrayBuffer>) => new Uint8Array(words.buffer);

function wordsOf(bytes: Uint8Array, name: string) {
  if (bytes.length % 4 !== 0) throw new TraceCutError('data', `${name} is cut off`);
  return new Uint32Array(bytes.slice().buffer);
}
