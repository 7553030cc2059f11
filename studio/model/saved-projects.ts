// Works in a storage: each clip has one place. When there are too many, the oldest that nobody has corrected
// go; what was corrected goes by the user's hand alone.

import type { InterruptedRun } from './interrupted-runs.js';
import type { SavedEdits } from './library.js';
import type { ViewSettings } from './view-settings.js';
import type { Trim } from './source.js';

/** A clip's work as it is kept. */
export interface SavedProject {
  /** Of the clip: kept again it takes its own place. */
  id: string;
  name: string;
  /** When it was kept, milliseconds since 1970. */
  at: number;
  /** That the clip was opened from. */
  files: File[];
  /** Masks before edits, as `saveProject` made them. */
  project: Uint8Array;
  edits: SavedEdits | null;
  about: ProjectInfo;
  corrected: boolean;
  /** A small one: a frame with its masks. */
  picture: Blob | null;
  /** Runs of the clip that were corrected, the newest first. */
  earlier: ProjectVersion[];
}

/** One of several results of a clip. */
export type ProjectVersion = Omit<SavedProject, 'id' | 'name' | 'files' | 'corrected' | 'earlier'>;

/**
 * What it takes to open the clip as it was, and to show the result as it was; works of earlier versions have no `look`.
 * `run` says which run the result is of, `within` that there are corrections in the masks themselves.
 */
export type ProjectInfo = {
  name: string;
  trim: Trim;
  changed: [string, number | boolean | string][];
  view?: ViewSettings;
  run?: string;
  correctsMasks?: boolean;
};

/** Where works are kept: under their ids, the newest first. */
export interface ProjectStorage {
  put: (record: SavedProject | InterruptedRun) => Promise<void>;
  /** Works, and runs that go on or were cut off; none where there is no storage. */
  list: () => Promise<SavedProject[]>;
  remove: (id: string) => Promise<void>;
}

/** Names of runs that go on begin so. */
export const RUN_PREFIX = 'run-';

/** Works that are kept, and how many bytes of all together. */
const MAX_PROJECTS = 8;
const MAX_TOTAL_BYTES = 2 ** 31;

/** Keeps a work, unless only corrected works could make room; returns whether it did. */
export async function saveProject(storage: ProjectStorage, saved: SavedProject): Promise<boolean> {
  const works = await listProjects(storage);
  const before = works.find(({ id }) => id === saved.id);
  const slot = before ? mergeVersions(before, saved) : saved;
  const otherProjects = works.filter(({ id }) => id !== saved.id);
  const evicted = chooseEvicted(slot, otherProjects);
  if (!evicted) return false;
  const removable = otherProjects.filter((project) => !holdsCorrections(project) && !evicted.includes(project));
  for (;;) {
    try {
      await storage.put(slot);
      break;
    } catch (error) {
      // The browser may give less room.
      const oldest = evicted.pop() ?? removable.pop();
      if ((error as Error).name !== 'QuotaExceededError') throw error;
      if (!oldest) return false;
      await storage.remove(oldest.id);
    }
  }
  for (const { id } of evicted) await storage.remove(id);
  return true;
}

/** A clip's newest result takes the place of the one before. What was corrected of another run stays beside it. */
function mergeVersions(
  { at, project, edits, about, corrected, picture, earlier }: SavedProject,
  saved: SavedProject,
): SavedProject {
  const last = corrected ? [{ at, project, edits, about, picture }] : [];
  const versions = [...last, ...earlier].filter((version) => version.about.run !== saved.about.run);
  // A clip that was closed meanwhile has no frames to draw.
  return { ...saved, picture: saved.picture ?? picture, earlier: versions };
}

/**
 * @param otherProjects the newest first
 * @returns those that make room; null where that would have to be a corrected one
 */
function chooseEvicted(work: SavedProject, otherProjects: SavedProject[]): SavedProject[] | null {
  let [count, bytes] = [1, projectBytes(work)];
  const evicted: SavedProject[] = [];
  for (const project of [
    ...otherProjects.filter(holdsCorrections),
    ...otherProjects.filter((candidate) => !holdsCorrections(candidate)),
  ]) {
    count += 1;
    bytes += projectBytes(project);
    if (count <= MAX_PROJECTS && bytes <= MAX_TOTAL_BYTES) continue;
    if (holdsCorrections(project)) return null;
    evicted.push(project);
  }
  return evicted;
}

function holdsCorrections({ corrected, earlier }: SavedProject) {
  return corrected || earlier.length > 0;
}

/** Returns what is stored, the newest first; nothing where there is no storage. */
export async function listProjects(storage: ProjectStorage): Promise<SavedProject[]> {
  const works = (await storage.list()).filter(({ id }) => !id.startsWith(RUN_PREFIX));
  // Earlier versions of the page kept less.
  return works.map((work) => ({ ...work, ...addDefaults(work) }));
}

function addDefaults({
  edits,
  corrected = (edits?.edits.length ?? 0) > 0,
  earlier = [],
  picture = null,
}: SavedProject) {
  return { corrected, earlier, picture };
}

export function projectBytes({ files, project, earlier }: Pick<SavedProject, 'files' | 'project' | 'earlier'>) {
  return [...files.map(({ size }) => size), ...earlier.map((version) => version.project.byteLength)].reduce(
    (sum, size) => sum + size,
    project.byteLength,
  );
}
