/** Which objects are shown. @module */

export class Selection extends EventTarget {
  constructor() {
    super();
    this.count = 0;
    /** @type {Set<number>} */
    this.hidden = new Set();
  }

  /** @param {number} count number of objects; all are shown again */
  reset(count) {
    this.count = count;
    this.hidden.clear();
    this.tell();
  }

  /** @param {number} count number of objects; what is hidden stays hidden */
  resize(count) {
    this.count = count;
    for (const object of [...this.hidden]) if (object >= count) this.hidden.delete(object);
    this.tell();
  }

  /** @param {number} object */
  has(object) {
    return !this.hidden.has(object);
  }

  /** @param {number} object */
  toggle(object) {
    if (!this.hidden.delete(object)) this.hidden.add(object);
    this.tell();
  }

  /**
   * Shows this object alone, or all again when it already is alone.
   *
   * @param {number} object
   */
  isolate(object) {
    const wasAlone = this.isAlone(object);
    this.hidden.clear();
    if (!wasAlone) for (let k = 0; k < this.count; k++) if (k !== object) this.hidden.add(k);
    this.tell();
  }

  /** @param {number} object */
  isAlone(object) {
    return this.count > 1 && this.has(object) && this.hidden.size === this.count - 1;
  }

  tell() {
    this.dispatchEvent(new Event('change'));
  }
}
