// Saved projects: one per clip, saved as it changes. The oldest are removed when there are too many, except corrected ones,
// which only the user deletes.

import { SavedJob } from './project-file.js';
import type { InterruptedRun, RunMemory } from './interrupted-runs.js';
import type { SavedEdits } from './library.js';
import type { ViewSettings } from './view-settings.js';
import type { Trim } from './source.js';
import type { State, Store } from './store.js';

export interface SavedProject {
  /** Identifies the clip; saving again replaces the project. */
  id: string;
  name: string;
  /** Time of saving, milliseconds since 1970. */
  at: number;
  /** Files of the clip. */
  files: File[];
  /** Masks before edits, as `saveProject` made them. */
  project: Uint8Array;
  edits: SavedEdits | null;
  about: ProjectInfo;
  corrected: boolean;
  picture: Blob | null;
  /** Corrected results of earlier runs, newest first. */
  earlier: ProjectVersion[];
}

/** One of several results of a clip. */
export type ProjectVersion = Omit<SavedProject, 'id' | 'name' | 'files' | 'corrected' | 'earlier'>;

/**
 * Settings that restore the clip and its result. `run` identifies the run; `correctsMasks` is true if the masks
 * contain corrections.
 */
export type ProjectInfo = {
  name: string;
  trim: Trim;
  changed: [string, number | boolean | string][];
  view?: ViewSettings;
  run?: string;
  correctsMasks?: boolean;
};

/** Stores records by their ids. */
export interface ProjectStorage {
  put: (record: SavedProject | InterruptedRun) => Promise<void>;
  /** Returns projects and runs, newest first; empty without storage. */
  list: () => Promise<SavedProject[]>;
  remove: (id: string) => Promise<void>;
}

/** Prefix of the ids of runs. */
export const RUN_PREFIX = 'run-';

/** Limits of the storage; chosen by eye. */
const MAX_PROJECTS = 8;
const MAX_TOTAL_BYTES = 2 ** 31;

/** Saves a project. Returns false if only corrected projects could make room. */
export async function saveProject(storage: ProjectStorage, saved: SavedProject): Promise<boolean> {
  const projects = await listProjects(storage);
  const existing = projects.find(({ id }) => id === saved.id);
  const slot = existing ? mergeVersions(existing, saved) : saved;
  const otherProjects = projects.filter(({ id }) => id !== saved.id);
  const evicted = chooseEvicted(slot, otherProjects);
  if (!evicted) return false;
  const removable = otherProjects.filter((project) => !hasCorrections(project) && !evicted.includes(project));
  for (;;) {
    try {
      await storage.put(slot);
      break;
    } catch (error) {
      // The browser's quota may be smaller.
      const oldest = evicted.pop() ?? removable.pop();
      if ((error as Error).name !== 'QuotaExceededError') throw error;
      if (!oldest) return false;
      await storage.remove(oldest.id);
    }
  }
  for (const { id } of evicted) await storage.remove(id);
  return true;
}

/** Replaces a project and keeps corrected results of other runs as earlier versions. */
function mergeVersions(
  { at, project, edits, about, corrected, picture, earlier }: SavedProject,
  saved: SavedProject,
): SavedProject {
  const last = corrected ? [{ at, project, edits, about, picture }] : [];
  const versions = [...last, ...earlier].filter((version) => version.about.run !== saved.about.run);
  // A clip closed in the meantime has no frames to draw.
  return { ...saved, picture: saved.picture ?? picture, earlier: versions };
}

/**
 * @param otherProjects newest first
 * @returns projects to remove; null if a corrected one would have to go
 */
function chooseEvicted(newProject: SavedProject, otherProjects: SavedProject[]): SavedProject[] | null {
  let [count, bytes] = [1, projectBytes(newProject)];
  const evicted: SavedProject[] = [];
  for (const project of [
    ...otherProjects.filter(hasCorrections),
    ...otherProjects.filter((candidate) => !hasCorrections(candidate)),
  ]) {
    count += 1;
    bytes += projectBytes(project);
    if (count <= MAX_PROJECTS && bytes <= MAX_TOTAL_BYTES) continue;
    if (hasCorrections(project)) return null;
    evicted.push(project);
  }
  return evicted;
}

function hasCorrections({ corrected, earlier }: SavedProject) {
  return corrected || earlier.length > 0;
}

/** Returns the saved projects, newest first. */
export async function listProjects(storage: ProjectStorage): Promise<SavedProject[]> {
  const records = (await storage.list()).filter(({ id }) => !id.startsWith(RUN_PREFIX));
  // Earlier versions of the page stored fewer fields.
  return records.map((record) => ({ ...record, ...addDefaults(record) }));
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

/** Time without changes after which a project is saved, in milliseconds; chosen by eye. */
const SAVE_DELAY_MS = 700;

/** Shorter runs are not remembered, in milliseconds; chosen by eye. */
const MIN_RUN_MS = 1000;

export class Autosave {
  timer: ReturnType<typeof setTimeout> | undefined = undefined;
  /** The newest state that is not saved yet; another clip may be on screen by then. */
  unsaved: State | null = null;
  /** Serialises saving. */
  saving: Promise<void> = Promise.resolve();

  /**
   * @param save resolves to false if storage is full
   * @param onPending called when there are unsaved changes and when they are saved
   */
  constructor(
    readonly store: Store,
    readonly save: (state: State) => Promise<boolean>,
    readonly onPending: (isPending: boolean) => void,
  ) {
    store.watch(['phase', 'analysis', 'edges', 'hidden', 'backdrop'], (state) => this.show(state));
  }

  show(state: State) {
    if (!isSavable(state)) return;
    if (this.unsaved && this.unsaved.job !== state.job) this.saveSoon();
    this.unsaved = state;
    this.onPending(true);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.saveSoon(), SAVE_DELAY_MS);
  }

  saveSoon() {
    const { unsaved } = this;
    if (unsaved) this.saving = this.saving.then(() => this.saveNow(unsaved));
  }

  async saveNow(state: State) {
    // No or full storage: the page asks before it is closed.
    if (!(await this.save(state).catch(() => false))) return;
    // Changes made while it was saved are saved next.
    const isPending = this.unsaved !== state;
    if (!isPending) this.unsaved = null;
    this.onPending(isPending);
  }

  /** True if closing the page would lose work. */
  get hasUnsaved() {
    const { phase, job, source } = this.store.state;
    const isRunning = phase === 'running' && (job?.settledFrames ?? 0) > 0 && source?.files;
    return Boolean(this.unsaved || isRunning);
  }
}

/** Returns whether the state has masks of a user's clip. */
function isSavable({ phase, analysis, source, job }: State): boolean {
  return phase === 'done' && Boolean(analysis && job?.corrections.target.result && source?.files);
}

/** Remembers the current run until it ends. */
export function rememberRuns(store: Store, memory: () => Promise<Pick<RunMemory, 'remember' | 'forget'>>) {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let isRemembered = false;
  /** Serialises access; without storage nothing is remembered. */
  let queue: Promise<unknown> = Promise.resolve();
  const enqueue = (act: (runs: Awaited<ReturnType<typeof memory>>) => unknown) => {
    queue = queue.then(() => memory().then(act)).catch(() => {});
  };
  store.watch(['phase', 'job'], ({ phase, job, source }) => {
    clearTimeout(timer);
    const isRunning = phase === 'running' && source?.files && !(job instanceof SavedJob);
    if (isRunning)
      timer = setTimeout(() => {
        isRemembered = true;
        const { state } = store;
        enqueue((runs) => runs.remember(state));
      }, MIN_RUN_MS);
    else if (isRemembered) {
      isRemembered = false;
      enqueue((runs) => runs.forget());
    }
  });
}
