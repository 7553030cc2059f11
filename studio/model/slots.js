/**
 * Works in a storage: each clip has one place. When there are too many, the oldest that nobody has corrected
 * go; what was corrected goes by the user's hand alone.
 * @module
 */

/**
 * A clip's work as it is kept.
 *
 * @typedef {object} Saved
 * @property {string} id of the clip: kept again it takes its own place
 * @property {string} name of the clip
 * @property {number} at when it was kept, milliseconds since 1970
 * @property {File[]} files that the clip was opened from
 * @property {Uint8Array} project masks before edits, as `saveProject` made them
 * @property {import('./library.js').SavedEdits | null} edits
 * @property {About} about
 * @property {boolean} corrected
 * @property {Blob | null} picture a small one: a frame with its masks
 * @property {Version[]} earlier runs of the clip that were corrected, the newest first
 */

/** One of several results of a clip. @typedef {Omit<Saved, 'id' | 'name' | 'files' | 'corrected' | 'earlier'>} Version */

/**
 * What it takes to open the clip as it was, and to show the result as it was; works of earlier versions have no `look`.
 * `run` says which run the result is of, `within` that there are corrections in the masks themselves.
 *
 * @typedef {{name: string, take: import('./source.js').Take, changed: [string, number | boolean | string][],
 *   look?: import('./look.js').Look, run?: string, within?: boolean}} About
 */

/**
 * Where works are kept: under their ids, the newest first.
 *
 * @typedef {object} Storage
 * @property {(record: Saved | import('./cut-off.js').Run) => Promise<void>} put
 * @property {() => Promise<Saved[]>} stored works, and runs that go on or were cut off; none where there is no storage
 * @property {(id: string) => Promise<void>} forget
 */

/** Names of runs that go on begin so. */
export const RUN = 'run-';

/** Works that are kept, and how many bytes of all together. */
const MOST_WORKS = 8;
const MOST_BYTES = 2 ** 31;

/**
 * @param {Storage} storage
 * @param {Saved} saved
 * @returns {Promise<boolean>} whether it is kept: not where only corrected works could make room
 */
export async function keep(storage, saved) {
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
      if (/** @type {Error} */ (error).name !== 'QuotaExceededError') throw error;
      if (!oldest) return false;
      await storage.forget(oldest.id);
    }
  }
  for (const { id } of going) await storage.forget(id);
  return true;
}

/**
 * A clip's newest result takes the place of the one before. What was corrected of another run stays beside it.
 *
 * @param {Saved} before
 * @param {Saved} saved
 * @returns {Saved}
 */
function inPlaceOf({ at, project, edits, about, corrected, picture, earlier }, saved) {
  const last = corrected ? [{ at, project, edits, about, picture }] : [];
  const others = [...last, ...earlier].filter((one) => one.about.run !== saved.about.run);
  // A clip that was closed meanwhile has no frames to draw.
  return { ...saved, picture: saved.picture ?? picture, earlier: others };
}

/**
 * @param {Saved} work that is to be kept
 * @param {Saved[]} others the newest first
 * @returns {Saved[] | null} those that make room; null where that would have to be a corrected one
 */
function leaving(work, others) {
  let [count, bytes] = [1, bytesOf(work)];
  /** @type {Saved[]} */
  const going = [];
  for (const one of [...others.filter(holdsCorrections), ...others.filter((other) => !holdsCorrections(other))]) {
    count += 1;
    bytes += bytesOf(one);
    if (count <= MOST_WORKS && bytes <= MOST_BYTES) continue;
    if (holdsCorrections(one)) return null;
    going.push(one);
  }
  return going;
}

/** @param {Saved} work */
function holdsCorrections({ corrected, earlier }) {
  return corrected || earlier.length > 0;
}

/**
 * @param {Storage} storage
 * @returns {Promise<Saved[]>} the newest first; none where there is no storage
 */
export async function kept(storage) {
  const works = (await storage.stored()).filter(({ id }) => !id.startsWith(RUN));
  // Earlier versions of the page kept less.
  return works.map((work) => ({ ...work, ...upgraded(work) }));
}

/** @param {Saved} work */
function upgraded({ edits, corrected = (edits?.edits.length ?? 0) > 0, earlier = [], picture = null }) {
  return { corrected, earlier, picture };
}

/** @param {Pick<Saved, 'files' | 'project' | 'earlier'>} saved */
export function bytesOf({ files, project, earlier }) {
  return [...files.map(({ size }) => size), ...earlier.map((one) => one.project.byteLength)].reduce(
    (sum, size) => sum + size,
    project.byteLength,
  );
}
