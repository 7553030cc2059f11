// Work that is opened again: the frames are read, the masks are there already. Fetched when some is.

import { Presence } from './presence.js';
import { ClipJob } from './clip-job.js';
import type { Project } from './library.js';
import type { About } from './slots.js';
import type { StagePlan } from './stage-clock.js';

export class SavedJob extends ClipJob {
  static stagesFor(): StagePlan[] {
    return [{ id: 'frames', share: 1 }];
  }

  constructor(
    parts: ConstructorParameters<typeof ClipJob>,
    readonly project: Project,
    { run, within = false }: About,
  ) {
    super(...parts);
    this.id = run ?? this.id;
    this.holdsOthers = within;
  }

  async work() {
    const { masks, edits } = this.project;
    const frames = this.source.frames(this.take, this.life.signal);
    for await (const { frame, time, end = null } of frames) await this.show(frame, time, end);
    this.times = [...masks.times];
    this.end = masks.end;
    this.cuts = masks.shots.slice(1).map(({ first }) => first);
    this.masks = masks;
    if (edits) this.corrections.adopt(edits);
    const now = this.corrections.masks ?? masks;
    const presence = new Presence(masks);
    for (let t = 0; t < masks.numFrames; t++) presence.addMask(now.labels(t));
    return { masks, presence };
  }

  get measured(): null {
    return null;
  }

  get extent() {
    return `${this.masks?.numFrames ?? 0} frames of ${this.size}, opened again`;
  }
}
