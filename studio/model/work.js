/** What is on screen as work that can be opened again, and back. @module */

import { editMasks, openProject, saveProject } from './library.js';
import { stemOf } from './export.js';
import { PageError } from './words.js';
import { lookOf } from './look.js';

/** @typedef {import('./slots.js').About} About */
/** @typedef {import('./slots.js').Saved} Saved */
/** @typedef {import('./library.js').MaskSource} MaskSource */

/** Clips that are larger are not kept with the work, in bytes. */
const MOST_BYTES = 2 ** 30;

/**
 * @param {import('./store.js').State} state with work
 * @returns {About}
 */
function aboutOf(state) {
  const { changed, name } = state;
  const { take, id, holdsOthers, corrections } = /** @type {import('./clip-job.js').ClipJob} */ (state.job);
  const within = holdsOthers || corrections.changesResult;
  return { name, take, changed: [...changed], look: lookOf(state), run: id, within };
}

/** Makes work of what is on screen; masks that have not changed since are not packed again. */
export class Packer {
  /** @param {(masks: MaskSource, frame: (t: number) => Promise<any>, hidden?: readonly number[]) => Promise<Blob | null>} [smallPicture] */
  constructor(smallPicture = async () => null) {
    this.smallPicture = smallPicture;
    /** @type {{masks: unknown, project: Uint8Array} | null} */
    this.packed = null;
  }

  /**
   * @param {import('./store.js').State} state with work
   * @param {string} id of the work
   * @returns {Promise<Saved>}
   */
  async pack(state, id) {
    const { job, film } = state;
    const corrections = /** @type {import('./corrections.js').Corrections} */ (job?.corrections);
    const masks = /** @type {import('./library.js').VideoResult} */ (corrections.of.result);
    const edits = corrections.editor?.toJSON() ?? null;
    if (this.packed?.masks !== masks) {
      const times = film.times.seconds?.slice(0, masks.numFrames) ?? null;
      // A result of one window has labels of clusters, a result of many has labels of objects.
      const { width, height, numFrames, shots, trajectories, clusters } =
        /** @type {import('./library.js').VideoResult & {clusters?: unknown}} */ (masks);
      const source = {
        ...{ width, height, numFrames, shots, times, trajectories, clusters },
        end: times && (film.times.seconds?.[masks.numFrames] ?? film.times.end),
        labels: (/** @type {number} */ t) => masks.labels(t),
      };
      this.packed = { masks, project: await saveProject(source, { frameRate: film.fps }) };
    }
    const { project } = this.packed;
    const about = aboutOf(state);
    const shown = /** @type {import('./library.js').MaskSource} */ (corrections.masks);
    const picture = await this.smallPicture(shown, (t) => corrections.of.images.open(t), about.look?.hidden);
    const corrected = job?.isCorrected ?? false;
    const [files, at] = [filesOf(state), Date.now()];
    return { id, name: state.name, at, files, project, edits, about, corrected, picture, earlier: [] };
  }
}

/**
 * @param {import('./store.js').State} state
 * @returns {File[]} of the clip, unless they are too large to be kept
 */
export function filesOf({ source, name }) {
  const files = (source?.files ?? []).filter(Boolean);
  const bytes = files.reduce((sum, { size }) => sum + size, 0);
  if (bytes > MOST_BYTES) throw new PageError('too-large-to-keep', stemOf(name));
  return files;
}

/** What is read of a clip to know it again, in bytes: all of a small one. */
const MOST_READ = 2 ** 24;

/**
 * Which clip files are: the same for the same content, whatever their names. Of large ones the two ends are looked at.
 *
 * @param {File[]} files
 * @returns {Promise<string>}
 */
export async function clipId(files) {
  const each = Math.floor(MOST_READ / Math.max(1, files.length));
  const ends = files.flatMap((file) =>
    file.size <= each
      ? [String(file.size), file]
      : [String(file.size), file.slice(0, each / 2), file.slice(file.size - each / 2)],
  );
  const bytes = await new Blob(ends).arrayBuffer();
  // Only pages that came safely may ask for it.
  if (!crypto.subtle) return `clip-${files.map(({ name, size, lastModified }) => [name, size, lastModified]).join()}`;
  const digest = new Uint8Array(await crypto.subtle.digest('SHA-256', bytes));
  return `clip-${Array.from(digest.subarray(0, 16), (byte) => byte.toString(16).padStart(2, '0')).join('')}`;
}

/**
 * A file of one's work: masks, edits, and the clip itself.
 *
 * @param {Saved} saved
 * @returns {Promise<Blob>}
 */
export async function projectFile({ files, project, edits, about }) {
  const { masks } = await openProject(project);
  const editor = editMasks(masks);
  if (edits) editor.restore(edits);
  const clip = await Promise.all(files.map(async (file) => [file.name, new Uint8Array(await file.arrayBuffer())]));
  const types = Object.fromEntries(files.map(({ name, type }) => [name, type]));
  const bytes = await saveProject(masks, {
    editor,
    about: { ...about, types },
    files: Object.fromEntries(clip),
  });
  return new Blob([bytes], { type: 'application/zip' });
}

/**
 * @param {File} file
 * @returns {Promise<{files: File[], about: About, project: import('./library.js').Project}>}
 */
export async function readProjectFile(file) {
  const project = await openProject(file);
  const about = /** @type {About & {types?: Record<string, string>}} */ (project.about);
  const files = Object.entries(project.files).map(
    ([name, bytes]) => new File([/** @type {BlobPart} */ (bytes)], name, { type: about?.types?.[name] ?? '' }),
  );
  if (!about?.take || files.length === 0) throw new PageError('no-project', file.name);
  return { files, about, project };
}

/**
 * @param {Pick<Saved, 'files' | 'about' | 'project' | 'edits'>} saved
 * @returns {Promise<{files: File[], about: About, project: import('./library.js').Project}>}
 */
export async function reopened({ files, about, project, edits }) {
  return { files, about, project: { ...(await openProject(project)), edits } };
}
