// The job of a saved project: only frames are read. Loaded when a project is opened.

import { Presence } from './presence.js';
import { ClipJob } from './clip-job.js';
import type { Project } from './library.js';
import type { ProjectInfo } from './saved-projects.js';
import type { StagePlan } from './library.js';

export class SavedJob extends ClipJob {
  static stages: StagePlan[] = [{ id: 'frames', cost: 1 }];

  constructor(
    parts: ConstructorParameters<typeof ClipJob>,
    readonly project: Project,
    { run, correctsMasks = false }: ProjectInfo,
  ) {
    super(...parts);
    this.id = run ?? this.id;
    this.hasEarlierCorrections = correctsMasks;
  }

  async segment() {
    const { masks, edits } = this.project;
    const frames = this.source.frames(this.trim, this.abort.signal);
    for await (const { frame, time, end = null } of frames) await this.addFrame(frame, time, end);
    this.times = [...masks.times];
    this.end = masks.end;
    this.cuts = masks.shots.slice(1).map(({ first }) => first);
    this.masks = masks;
    if (edits) this.corrections.restore(edits);
    const now = this.corrections.masks ?? masks;
    const presence = new Presence(masks);
    for (let t = 0; t < masks.numFrames; t++) presence.addMask(now.labels(t));
    return { masks, presence };
  }

  /** Only reading takes time. */
  get stageOnScreen() {
    return 'frames';
  }

  get pacePerPixel() {
    return null;
  }

  get extent() {
    return `${this.masks?.numFrames ?? 0} frames of ${this.sizeText}, reopened`;
  }
}
