// The trajectories of all windows joined to those of the clip.

/**
 * Trajectories of a whole clip, shaped as `Result.trajectories`: the points of trajectory `i` are `offset[i]` to
 * `offset[i + 1]`, one for each of the consecutive frames from `startFrame[i]` on. `label[i]` is the object that most
 * of its points were on, 0 for the background.
 * @typedef {{readonly count: number, readonly startFrame: Uint32Array, readonly offset: Uint32Array, readonly x:
 *   Float32Array, readonly y: Float32Array, readonly label:
 *   Uint8Array}} ClipTrajectories
 */

/** @typedef {{start: number, x: number[], y: number[], votes: Map<number, number>}} Track */

/** Collects the trajectories of window after window. */
export class TrackCollector {
  /** @type {Map<number, Track>} */
  #tracks = new Map();

  /** @param {import('./window.js').WindowResult} window */
  add({ trajectories, clusters, firstFrame }) {
    for (let i = 0; i < trajectories.count; i += 1) {
      const [begin, end] = [at(trajectories.offset, i), at(trajectories.offset, i + 1)];
      const start = firstFrame + at(trajectories.startFrame, i);
      const track = this.#trackOf(at(trajectories.id, i), start);
      // The frames that an earlier window had are there already.
      const known = track.start + track.x.length - start;
      for (let p = begin + Math.max(0, known); p < end; p += 1) {
        track.x.push(at(trajectories.x, p));
        track.y.push(at(trajectories.y, p));
      }
      const label = clusters.object ? at(clusters.object, at(clusters.label, i)) : 0;
      track.votes.set(label, (track.votes.get(label) ?? 0) + end - begin);
    }
  }

  /**
   * @param {number} id
   * @param {number} start
   */
  #trackOf(id, start) {
    let track = this.#tracks.get(id);
    if (!track) this.#tracks.set(id, (track = { start, x: [], y: [], votes: new Map() }));
    return track;
  }

  /**
   * @param {number} numFrames what lies beyond is left out
   * @returns {ClipTrajectories} in the order of their first frames
   */
  finish(numFrames) {
    const tracks = [...this.#tracks.values()]
      .filter(({ start }) => start < numFrames)
      .map((track) => ({
        ...track,
        x: track.x.slice(0, numFrames - track.start),
        y: track.y.slice(0, numFrames - track.start),
      }))
      .sort((a, b) => a.start - b.start);
    const offset = new Uint32Array(tracks.length + 1);
    tracks.forEach((track, i) => (offset[i + 1] = at(offset, i) + track.x.length));
    const points = at(offset, tracks.length);
    const joined = {
      count: tracks.length,
      startFrame: Uint32Array.from(tracks, ({ start }) => start),
      offset,
      x: new Float32Array(points),
      y: new Float32Array(points),
      label: Uint8Array.from(tracks, ({ votes }) => majority(votes)),
    };
    tracks.forEach((track, i) => {
      joined.x.set(track.x, offset[i]);
      joined.y.set(track.y, offset[i]);
    });
    return joined;
  }
}

/**
 * The label with most votes, the lowest of equals.
 * @param {Map<number, number>} votes
 */
function majority(votes) {
  let best = 0;
  let most = -1;
  for (const [label, count] of votes) {
    if (count > most || (count === most && label < best)) [best, most] = [label, count];
  }
  return best;
}

/**
 * @param {Uint32Array | Uint8Array | Float32Array} values
 * @param {number} index
 */
function at(values, index) {
  return /** @type {number} */ (values[index]);
}
