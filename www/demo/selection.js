/** Which clusters are shown. @module */

export class Selection extends EventTarget {
  constructor() {
    super();
    this.count = 0;
    /** @type {Set<number>} */
    this.hidden = new Set();
  }

  /** @param {number} count number of clusters; all are shown again */
  reset(count) {
    this.count = count;
    this.hidden.clear();
    this.tell();
  }

  /** @param {number} cluster */
  has(cluster) {
    return !this.hidden.has(cluster);
  }

  /** @param {number} cluster */
  toggle(cluster) {
    if (!this.hidden.delete(cluster)) this.hidden.add(cluster);
    this.tell();
  }

  /**
   * Shows this cluster alone, or all again when it already is alone.
   *
   * @param {number} cluster
   */
  isolate(cluster) {
    const wasAlone = this.isAlone(cluster);
    this.hidden.clear();
    if (!wasAlone) for (let k = 0; k < this.count; k++) if (k !== cluster) this.hidden.add(k);
    this.tell();
  }

  /** @param {number} cluster */
  isAlone(cluster) {
    return this.count > 1 && this.has(cluster) && this.hidden.size === this.count - 1;
  }

  tell() {
    this.dispatchEvent(new Event('change'));
  }
}
