/** Masks of a long clip as runs of equal labels: a few kilobytes a frame. @module */

export class MaskStore {
  /**
   * @param {number} width in pixels
   * @param {number} height
   */
  constructor(width, height) {
    this.width = width;
    this.height = height;
    /** @type {Uint32Array[]} For each frame the runs: label in the lowest byte, above it where the run ends. */
    this.runs = [];
  }

  /**
   * @param {Uint8Array} labels of a frame
   * @param {number} [t] which one; the next if not given
   */
  add(labels, t = this.runs.length) {
    const runs = [];
    for (let p = 1; p <= labels.length; p++) {
      if (p === labels.length || labels[p] !== labels[p - 1]) runs.push(p * 256 + labels[p - 1]);
    }
    // Places are below 2^24: frames have at most 640 pixels on a side.
    this.runs[t] = Uint32Array.from(runs);
  }

  /**
   * @param {number} t
   * @returns {Uint8Array}
   */
  labels(t) {
    const labels = new Uint8Array(this.width * this.height);
    let from = 0;
    for (const run of this.runs[t] ?? []) {
      const to = run >>> 8;
      labels.fill(run & 255, from, to);
      from = to;
    }
    return labels;
  }
}
