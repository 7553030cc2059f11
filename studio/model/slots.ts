// Works in a storage: each clip has one place. When there are too many, the oldest that nobody has corrected
// go; what was corrected goes by the user's hand alone.

import type { Run } from './cut-off.js';
import type { SavedEdits } from './library.js';
import type { Look } from './look.js';
import type { Take } from './source.js';

/** A clip's work as it is kept. */
export interface Saved {
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
  about: About;
  corrected: boolean;
  /** A small one: a frame with its masks. */
  picture: Blob | null;
  /** Runs of the clip that were corrected, the newest first. */
  earlier: Version[];
}

/** One of several results of a clip. */
export type Version = Omit<Saved, 'id' | 'name' | 'files' | 'corrected' | 'earlier'>;

/**
 * What it takes to open the clip as it was, and to show the result as it was; works of earlier versions have no `look`.
 * `run` says which run the result is of, `within` that there are corrections in the masks themselves.
 */
export type About = {
  name: string;
  take: Take;
  changed: [string, number | boolean | string][];
  look?: Look;
  run?: string;
  within?: boolean;
};

/** Where works are kept: under their ids, the newest first. */
export interface Storage {
  put: (record: Saved | Run) => Promise<void>;
  /** Works, and runs that go on or were cut off; none where there is no storage. */
  stored: () => Promise<Saved[]>;
  forget: (id: string) => Promise<void>;
}

/** Names of runs that go on begin so. */
export const RUN = 'run-';

/** Works that are kept, and how many bytes of all together. */
const MOST_WORKS = 8;
const MOST_BYTES = 2 ** 31;

/** Keeps a work, unless only corrected works could make room; returns whether it did. */
export async function keep(storage: Storage, saved: Saved): Promise<boolean> {
  const works = await kept(storage);
  const before = works.find(({ id }) => id === saved.id);
  const slot = before ? inPlaceOf(before, saved) : saved;
  const others = works.filter(({ id }) => id !== saved.id);
  const going = leaving(slot, others);
  if (!going) return false;
  const left = others.filter((one) => !holdsCorrections(one) && !going.includes(one));
  for (;;) {
    try {
      await storage.put(slot);
      break;
    } catch (error) {
      // The browser may give less room.
      const oldest = going.pop() ?? left.pop();
      if ((error as Error).name !== 'QuotaExceededError') throw error;
      if (!oldest) return false;
      await storage.forget(oldest.id);
    }
  }
  for (const { id } of going) await storage.forget(id);
  return true;
}

/** A clip's newest result takes the place of the one before. What was corrected of another run stays beside it. */
function inPlaceOf({ at, project, edits, about, corrected, picture, earlier }: Saved, saved: Saved): Saved {
  const last = corrected ? [{ at, project, edits, about, picture }] : [];
  const others = [...last, ...earlier].filter((one) => one.about.run !== saved.about.run);
  // A clip that was closed meanwhile has no frames to draw.
  return { ...saved, picture: saved.picture ?? picture, earlier: others };
}

/**
 * @param others the newest first
 * @returns those that make room; null where that would have to be a corrected one
 */
function leaving(work: Saved, others: Saved[]): Saved[] | null {
  let [count, bytes] = [1, bytesOf(work)];
  const going: Saved[] = [];
  for (const one of [...others.filter(holdsCorrections), ...others.filter((other) => !holdsCorrections(other))]) {
    count += 1;
    bytes += bytesOf(one);
    if (count <= MOST_WORKS && bytes <= MOST_BYTES) continue;
    if (holdsCorrections(one)) return null;
    going.push(one);
  }
  return going;
}

function holdsCorrections({ corrected, earlier }: Saved) {
  return corrected || earlier.length > 0;
}

/** Returns what is stored, the newest first; nothing where there is no storage. */
export async function kept(storage: Storage): Promise<Saved[]> {
  const works = (await storage.stored()).filter(({ id }) => !id.startsWith(RUN));
  // Earlier versions of the page kept less.
  return works.map((work) => ({ ...work, ...upgraded(work) }));
}

function upgraded({ edits, corrected = (edits?.edits.length ?? 0) > 0, earlier = [], picture = null }: Saved) {
  return { corrected, earlier, picture };
}

export function bytesOf({ files, project, earlier }: Pick<Saved, 'files' | 'project' | 'earlier'>) {
  return [...files.map(({ size }) => size), ...earlier.map((one) => one.project.byteLength)].reduce(
    (sum, size) => sum + size,
    project.byteLength,
  );
}
