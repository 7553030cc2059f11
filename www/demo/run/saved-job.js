/** Work that is opened again: the frames are read, the masks are there already. @module */

import { Presence } from '../result/presence.js';
import { LongJob } from './long-job.js';
import { MaskStore } from './mask-store.js';
import { say } from '../language.js';

/** @type {import('./stage-clock.js').StagePlan[]} */
export const SAVED_STAGES = [{ id: 'frames', name: 'Reading frames', share: 1 }];

export class SavedJob extends LongJob {
  static stages = SAVED_STAGES;

  /** None: it is made from what was saved, never chosen for a source. */
  static fits() {
    return false;
  }

  /**
   * @param {ConstructorParameters<typeof LongJob>} parts
   * @param {import('../../dist/edit.js').Project} project
   */
  constructor(parts, project) {
    super(...parts);
    this.project = project;
  }

  async work() {
    const { masks, edits } = this.project;
    for await (const _ of this.frames());
    this.times = [...masks.times];
    this.end = masks.end;
    this.cuts = masks.shots.slice(1).map(({ first }) => first);
    this.masks = new MaskStore(masks.width, masks.height);
    this.presence = new Presence(masks);
    this.result = masks;
    if (edits) this.corrections.adopt(edits);
    const now = this.corrections.masks ?? masks;
    for (let t = 0; t < masks.numFrames; t++) this.presence.addMask(now.labels(t));
    this.mark('frames', this.images.length, this.images.length);
  }

  get extent() {
    return say`${this.settled} frames of ${this.size}, opened again`;
  }
}
