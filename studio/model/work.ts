// What is on screen as work that can be opened again, and back.

import { type MaskSource, type Project, type VideoResult, editMasks, openProject, saveProject } from './library.js';
import { stemOf } from './export.js';
import { PageError } from './words.js';
import { lookOf } from './look.js';
import type { ClipJob } from './clip-job.js';
import type { About, Saved } from './slots.js';
import type { State } from './store.js';

/** Clips that are larger are not kept with the work, in bytes. */
const MOST_BYTES = 2 ** 30;

function aboutOf(state: State): About {
  const { changed, name } = state;
  const { take, id, holdsOthers, corrections } = state.job as ClipJob;
  const within = holdsOthers || corrections.changesResult;
  return { name, take, changed: [...changed], look: lookOf(state), run: id, within };
}

/** Makes work of what is on screen; masks that have not changed since are not packed again. */
export class Packer {
  packed: { masks: unknown; project: Uint8Array } | null = null;

  constructor(
    readonly smallPicture: (
      masks: MaskSource,
      frame: (t: number) => Promise<CanvasImageSource | null>,
      hidden?: readonly number[],
    ) => Promise<Blob | null> = async () => null,
  ) {}

  async pack(state: State, id: string): Promise<Saved> {
    const { job, film } = state;
    const corrections = job?.corrections!;
    const masks = corrections.of.result!;
    const edits = corrections.editor?.toJSON() ?? null;
    if (this.packed?.masks !== masks) {
      const times = film.times.seconds?.slice(0, masks.numFrames) ?? null;
      // A result of one window has labels of clusters, a result of many has labels of objects.
      const { width, height, numFrames, shots, trajectories, clusters } = masks as VideoResult & { clusters?: unknown };
      const source = {
        ...{ width, height, numFrames, shots, times, trajectories, clusters },
        end: times && (film.times.seconds?.[masks.numFrames] ?? film.times.end),
        labels: (t: number) => masks.labels(t),
      };
      this.packed = { masks, project: await saveProject(source, { frameRate: film.fps }) };
    }
    const { project } = this.packed;
    const about = aboutOf(state);
    const shown = corrections.masks!;
    const picture = await this.smallPicture(shown, (t) => corrections.of.images.open(t), about.look?.hidden);
    const corrected = job?.isCorrected ?? false;
    const [files, at] = [filesOf(state), Date.now()];
    return { id, name: state.name, at, files, project, edits, about, corrected, picture, earlier: [] };
  }
}

/** Returns the files of the clip, unless they are too large to be kept. */
export function filesOf({ source, name }: State): File[] {
  const files = (source?.files ?? []).filter(Boolean);
  const bytes = files.reduce((sum, { size }) => sum + size, 0);
  if (bytes > MOST_BYTES) throw new PageError('too-large-to-keep', stemOf(name));
  return files;
}

/** What is read of a clip to know it again, in bytes: all of a small one. */
const MOST_READ = 2 ** 24;

/**
 * Which clip files are: the same for the same content, whatever their names. Of large ones the two ends are looked at.
 */
export async function clipId(files: File[]): Promise<string> {
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

/** A file of one's work: masks, edits, and the clip itself. */
export async function projectFile({ files, project, edits, about }: Saved): Promise<Blob> {
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

export async function readProjectFile(file: File): Promise<{ files: File[]; about: About; project: Project }> {
  const project = await openProject(file);
  const about = project.about as About & { types?: Record<string, string> };
  const files = Object.entries(project.files).map(
    ([name, bytes]) => new File([bytes as BlobPart], name, { type: about?.types?.[name] ?? '' }),
  );
  if (!about?.take || files.length === 0) throw new PageError('no-project', file.name);
  return { files, about, project };
}

export async function reopened({
  files,
  about,
  project,
  edits,
}: Pick<Saved, 'files' | 'about' | 'project' | 'edits'>): Promise<{ files: File[]; about: About; project: Project }> {
  return { files, about, project: { ...(await openProject(project)), edits } };
}
