// `tracks.dat`, the track file of the Moseg benchmark, written.

/**
 * Trajectories to write, as `trajectories` gives them and `setTrajectories` takes them; `label` holds a label for each,
 * 0 if not given.
 * @typedef {object} TracksToWrite
 * @property {number} numFrames
 * @property {Uint32Array | readonly number[]} startFrame
 * @property {Uint32Array | readonly number[]} offset
 * @property {Float32Array | Float64Array | readonly number[]} x
 * @property {Float32Array | Float64Array | readonly number[]} y
 * @property {ArrayLike<number>} [label]
 */

/**
 * Trajectories as a track file of the Moseg benchmark: number of frames, number of tracks, then for each track its label
 * and length and, line by line, `x y frame`.
 * @param {TracksToWrite} tracks
 * @returns {string}
 */
export function tracksDat({ numFrames, startFrame, offset, x, y, label }) {
  const lines = [`${numFrames}`, `${startFrame.length}`];
  for (let i = 0; i < startFrame.length; i += 1) {
    const [begin, end, start] = [Number(offset[i]), Number(offset[i + 1]), Number(startFrame[i])];
    lines.push(`${label?.[i] ?? 0} ${end - begin}`);
    for (let p = begin; p < end; p += 1)
      lines.push(`${Number(x[p]).toFixed(3)} ${Number(y[p]).toFixed(3)} ${start + p - begin}`);
  }
  return `${lines.join('\n')}\n`;
}
