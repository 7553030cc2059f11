// Packs the state into a project, and reads project files.
// The job of a saved project only reads frames.

import {
  editMasks,
  type MaskSource,
  openProject,
  type Project,
  saveProject,
  type StagePlan,
  type VideoResult,
} from './library.js';
import { fileStem } from './export.js';
import { PageError } from './messages.js';
import { toViewSettings } from './view-settings.js';
import { Presence } from './presence.js';
import { ClipJob } from './clip-job.js';
import type { ProjectInfo, SavedProject } from './saved-projects.js';
import type { State } from './store.js';

/** Larger clips are not stored with the project, in bytes. */
const MAX_CLIP_BYTES = 2 ** 30;

function projectInfo(state: State): ProjectInfo {
  const { changed, name } = state;
  const { trim, id, hasEarlierCorrections, corrections } = state.job as ClipJob;
  const correctsMasks = hasEarlierCorrections || corrections.changesResult;
  return { name, trim, changed: [...changed], view: toViewSettings(state), run: id, correctsMasks };
}

/** Packs the current state; unchanged masks are packed once. */
export class Packer {
  packed: { masks: unknown; project: Uint8Array } | null = null;

  constructor(
    readonly makeThumbnail: (
      masks: MaskSource,
      frame: (t: number) => Promise<CanvasImageSource | null>,
      hidden?: readonly number[],
    ) => Promise<Blob | null> = async () => null,
  ) {}

  async pack(state: State, id: string): Promise<SavedProject> {
    const { job, timeline } = state;
    const corrections = job?.corrections!;
    const masks = corrections.target.result!;
    const edits = corrections.editor?.toJSON() ?? null;
    if (this.packed?.masks !== masks) {
      const times = timeline.times.seconds?.slice(0, masks.numFrames) ?? null;
      // With one window, trajectories have clusters; with several, objects.
      const { width, height, numFrames, shots, trajectories, clusters } = masks as VideoResult & { clusters?: unknown };
      const source = {
        ...{ width, height, numFrames, shots, times, trajectories, clusters },
        end: times && (timeline.times.seconds?.[masks.numFrames] ?? timeline.times.end),
        labels: (t: number) => masks.labels(t),
      };
      this.packed = { masks, project: await saveProject(source, { frameRate: timeline.fps }) };
    }
    const { project } = this.packed;
    const about = projectInfo(state);
    const correctedMasks = corrections.masks!;
    const picture = await this.makeThumbnail(
      correctedMasks,
      (t) => corrections.target.images.open(t),
      about.view?.hidden,
    );
    const corrected = job?.isCorrected ?? false;
    const [files, at] = [storedFiles(state), Date.now()];
    return { id, name: state.name, at, files, project, edits, about, corrected, picture, earlier: [] };
  }
}

/** Returns the files of the clip; throws if they are too large to store. */
export function storedFiles({ source, name }: State): File[] {
  const files = (source?.files ?? []).filter(Boolean);
  const bytes = files.reduce((sum, { size }) => sum + size, 0);
  if (bytes > MAX_CLIP_BYTES) throw new PageError('too-large-to-keep', fileStem(name));
  return files;
}

/** Bytes of a clip that are hashed; small clips are hashed whole. */
const MAX_HASHED_BYTES = 2 ** 24;

/** Returns an identifier of the content of files. Only the two ends of large files are hashed. */
export async function hashClip(files: File[]): Promise<string> {
  const each = Math.floor(MAX_HASHED_BYTES / Math.max(1, files.length));
  const ends = files.flatMap((file) =>
    file.size <= each
      ? [String(file.size), file]
      : [String(file.size), file.slice(0, each / 2), file.slice(file.size - each / 2)],
  );
  const bytes = await new Blob(ends).arrayBuffer();
  // Hashing needs a secure context.
  if (!crypto.subtle) return `clip-${files.map(({ name, size, lastModified }) => [name, size, lastModified]).join()}`;
  const digest = new Uint8Array(await crypto.subtle.digest('SHA-256', bytes));
  return `clip-${Array.from(digest.subarray(0, 16), (byte) => byte.toString(16).padStart(2, '0')).join('')}`;
}

/** Returns a project file: masks, edits and the clip. */
export async function createProjectFile({ files, project, edits, about }: SavedProject): Promise<Blob> {
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

export async function readProjectFile(file: File): Promise<{ files: File[]; about: ProjectInfo; project: Project }> {
  const project = await openProject(file).catch((error) => {
    throw new PageError('no-project', error.message);
  });
  const about = project.about as ProjectInfo & { types?: Record<string, string> };
  const files = Object.entries(project.files).map(
    ([name, bytes]) => new File([bytes as BlobPart], name, { type: about?.types?.[name] ?? '' }),
  );
  if (!about?.trim || files.length === 0) throw new PageError('no-project', file.name);
  return { files, about, project };
}

export async function reopenProject({
  files,
  about,
  project,
  edits,
}: Pick<SavedProject, 'files' | 'about' | 'project' | 'edits'>): Promise<{
  files: File[];
  about: ProjectInfo;
  project: Project;
}> {
  return { files, about, project: { ...(await openProject(project)), edits } };
}

export class SavedJob extends ClipJob {
  static stages: StagePlan[] = [{ id: 'frames', cost: 1 }];

  constructor(
    parts: ConstructorParameters<typeof ClipJob>,
    readonly project: Project,
    { run, correctsMasks = false }: ProjectInfo,
  ) {
    super(...parts);
    this.id = run ?? this.id;
    this.hasEarlierCorrections = correctsMasks;
  }

  async segment() {
    const { masks, edits } = this.project;
    const frames = this.source.frames(this.trim, this.abort.signal);
    for await (const { frame, time, end = null } of frames) await this.addFrame(frame, time, end);
    this.times = [...masks.times];
    this.end = masks.end;
    this.cuts = masks.shots.slice(1).map(({ first }) => first);
    this.masks = masks;
    if (edits) this.corrections.restore(edits);
    const now = this.corrections.masks ?? masks;
    const presence = new Presence(masks);
    for (let t = 0; t < masks.numFrames; t++) presence.addMask(now.labels(t));
    return { masks, presence };
  }

  /** Only reading takes time. */
  get stageOnScreen() {
    return 'frames';
  }

  get pacePerPixel() {
    return null;
  }

  get extent() {
    return `${this.masks?.numFrames ?? 0} frames of ${this.sizeText}, reopened`;
  }
}
