// The page's controller, a state machine: opens a source, runs it and shows the result. Its state lies in the store.
//
//     opening --> running --> done
//        |         |   ^       |
//        v         v   |       v
//      error     stopped <-- running (again)
//
// A finished result of a user's clip stays until another source is open.
// A run starts without questions. If settings change while it is running, it starts again.
//
// Every asynchronous step remembers the number of its visit and does nothing once another visit has begun.

import { progressPatch, showPreview, showResult, showWindow } from './show-result.js';
import { ClipJob, type Images } from './clip-job.js';
import { changedParameters, sessionOptions } from './settings.js';
import { PROJECT_EXTENSION, viewSettingsPatch } from './view-settings.js';
import { type Source, clampTrim, defaultTrim } from './source.js';
import { BLANK, type State, type Store, errorPatch, phasePatch } from './store.js';
import { explain, stageName } from './messages.js';
import type { InterruptedRun } from './interrupted-runs.js';
import type { Project } from './library.js';
import type { ProjectInfo } from './saved-projects.js';

/** A corrected result and its hidden objects. */
type CorrectedResult = { job: ClipJob; hidden: ReadonlySet<number> };

/** Interval between updates of the progress, in milliseconds; chosen by eye. */
const TICK_MS = 100;

/** Time without changes after which new settings restart a run, in milliseconds; chosen by eye. */
export const SETTINGS_DELAY_MS = 600;

/** Services that the model needs from the browser. */
interface Platform {
  openSample: () => Promise<Source>;
  openFiles: (files: File[]) => Promise<Source>;
  createImages: () => Images;
}

export class App {
  abort: AbortController | null = null;
  restartTimer = 0;
  /** Number of sources that were to be opened. */
  openings = 0;
  /** Asks the user before a corrected result is replaced. */
  confirmRerun = async () => true;
  /** The corrected result whose corrections the next run takes over. */
  corrected: CorrectedResult | null = null;
  /** The hidden objects that each result took over. */
  carriedHidden = new WeakMap<ClipJob, ReturnType<typeof carryHidden>>();
  /** The hidden objects of `previousJob`. */
  hiddenBefore: ReadonlySet<number> = new Set();

  constructor(
    readonly store: Store,
    readonly platform: Platform,
  ) {
    store.watch(['trim', 'changed'], () => this.onSettings());
  }

  /** Restarts a run whose settings have changed, even if it ended in the meantime. */
  onSettings() {
    clearTimeout(this.restartTimer);
    if (this.store.state.phase !== 'running') return;
    this.restartTimer = setTimeout(() => {
      const { state } = this.store;
      const isActive = state.phase === 'running' || state.phase === 'done';
      if (isActive && !state.job?.hasSettings(state.trim, sessionOptions(state))) this.start();
    }, SETTINGS_DELAY_MS);
  }

  async openSample() {
    await this.open('Sample clip', this.platform.openSample, () => this.start());
  }

  /** Opens files and runs them, or restores a project file. */
  async openFiles(files: File[]) {
    const [file] = files;
    if (files.length === 1 && file.name.endsWith(PROJECT_EXTENSION))
      return this.openProject(file.name, async () => (await import('./project-file.js')).readProjectFile(file));
    await this.open(
      files[0]?.name ?? '',
      () => this.platform.openFiles(files),
      () => this.start(),
    );
  }

  /** Opens a saved project: frames are read again, masks and corrections are restored. */
  async openProject(name: string, read: () => Promise<{ files: File[]; about: ProjectInfo; project: Project }>) {
    let savedProject: Awaited<ReturnType<typeof read>> | null = null;
    const savedJobModule = import('./project-file.js');
    await this.open(
      name,
      async () => {
        [savedProject] = await Promise.all([read(), savedJobModule]);
        return this.platform.openFiles(savedProject.files);
      },
      async () => {
        const { about, project } = savedProject!;
        const { source } = this.store.state;
        if (!source) return;
        this.store.set({
          ...{ name: about.name, trim: clampTrim(about.trim, source), changed: new Map(about.changed) },
          ...viewSettingsPatch(about.view, this.store.state),
        });
        const { visit, trim } = this.store.state;
        const options = sessionOptions(this.store.state);
        const { SavedJob } = await savedJobModule;
        const job = new SavedJob(
          [source, { ...trim }, options, SavedJob.stages, this.platform.createImages()],
          project,
          about,
        );
        this.store.set({ job, picture: { ...BLANK.picture, images: job.images } });
        await this.runJob(visit, job);
      },
    );
  }

  /** Restarts an interrupted run with its settings. */
  async openInterruptedRun({ name, files, about }: InterruptedRun) {
    await this.open(
      name,
      () => this.platform.openFiles(files),
      async () => {
        const { source } = this.store.state;
        if (source) this.store.set({ trim: clampTrim(about.trim, source), changed: new Map(about.changed) });
        await this.start();
      },
    );
  }

  /**
   * Opens a source and goes on with `next`. Finished work stays until the source is open, and if it cannot be opened.
   * @param name shown until the source is open
   */
  async open(name: string, opener: () => Promise<Source>, next: () => Promise<void>) {
    const keepsWork = hasWork(this.store.state);
    let visit = keepsWork ? this.store.state.visit : this.leave(name);
    const opening = (this.openings += 1);
    if (keepsWork) this.store.set({ isOpening: true, announcement: 'Opening…' });
    try {
      const source = await opener();
      if (visit !== this.store.state.visit || opening !== this.openings) return source.close();
      if (keepsWork) visit = this.leave(name);
      this.store.set({ source, name: source.name, trim: defaultTrim(source) });
      await next();
    } catch (error) {
      if (opening !== this.openings) return;
      if (this.store.state.isOpening) this.store.set(notOpenedPatch(name, error));
      else this.fail(visit, error);
    }
  }

  /** Closes the source for another one. */
  leave(name: string): number {
    const visit = this.reset();
    this.corrected = null;
    this.store.state.source?.close();
    this.store.set({ source: null, name, ...phasePatch('opening', 'Opening…', '') });
    return visit;
  }

  /**
   * Ends the current job.
   * @param keptJob a job that stays open for undo
   */
  reset(keptJob: ClipJob | null = null): number {
    const { job, previousJob, visit } = this.store.state;
    this.abort?.abort();
    this.abort = null;
    for (const run of [job, previousJob]) if (run !== keptJob) run?.close();
    this.store.set({ ...BLANK, previousJob: keptJob, visit: visit + 1 });
    return visit + 1;
  }

  /** Runs again. Asks first if the result has corrections; undo restores it. */
  async rerun() {
    if (!this.store.state.job?.isCorrected || (await this.confirmRerun())) await this.start();
  }

  /** Restores the result that a new run replaced, and its settings. */
  async restore() {
    const { previousJob } = this.store.state;
    if (!previousJob) return;
    this.reset(previousJob);
    this.store.set({
      trim: { ...previousJob.trim },
      changed: changedParameters(previousJob.options),
    });
    this.corrected = null;
    // Its own corrections can be undone step by step again.
    previousJob.corrections.carriedCount = 0;
    const picture = { ...BLANK.picture, images: previousJob.images };
    const hidden = this.hiddenBefore;
    this.store.set({ previousJob: null, job: previousJob, hidden, picture, ...phasePatch('running', 'Opening…', '') });
    await showResult(this.store, previousJob);
  }

  /** Starts a run with the current settings. */
  async start() {
    if (!this.store.state.source) return;
    const { job: last, previousJob, hidden, phase } = this.store.state;
    const isFinished = phase === 'done' && last && !last.isPartial;
    // A restarted run still has to take over the corrections.
    if (isFinished) this.corrected = last.isCorrected || hidden.size > 0 ? { job: last, hidden } : null;
    // One result is kept for undo; corrected ones come first.
    const keepsLast = isFinished && (last.isCorrected || !previousJob?.isCorrected);
    if (keepsLast) this.hiddenBefore = hidden;
    const visit = this.reset(keepsLast ? last : previousJob);
    const job = this.createJob(this.store.state.source);
    this.store.set({ job, picture: { ...BLANK.picture, images: job.images } });
    job.startPreview();
    if (job.preview) job.preview.onMasks = () => showPreview(this.store, job);
    await this.runJob(visit, job);
  }

  createJob(source: Source): ClipJob {
    const { state } = this.store;
    return new ClipJob(
      source,
      { ...state.trim },
      sessionOptions(state),
      ClipJob.stages,
      this.platform.createImages(),
      state.pace,
    );
  }

  /** Continues a cancelled run, or starts again if the settings have changed. */
  async resume() {
    const { job, visit, trim } = this.store.state;
    if (!job?.hasSettings(trim, sessionOptions(this.store.state))) return this.start();
    await this.runJob(visit, job);
  }

  async runJob(visit: number, job: ClipJob) {
    this.abort = new AbortController();
    const { signal } = this.abort;
    this.store.set(phasePatch('running', stageName(job.stageOnScreen), ''));
    if (job.settledFrames > 0) showWindow(this.store, job);
    const showProgress = () => this.showRunning(job);
    // Drawing each frame that is read would slow down the run.
    const clock = setInterval(() => {
      showProgress();
      this.showNewestFrame(job);
    }, TICK_MS);
    signal.addEventListener('abort', () => {
      clearInterval(clock);
      job.preview?.close();
    });
    try {
      await job.run(signal, showProgress, () => visit === this.store.state.visit && showWindow(this.store, job));
      if (visit === this.store.state.visit) await this.finish(job);
    } catch (error) {
      if (!signal.aborted) this.fail(visit, error);
    } finally {
      clearInterval(clock);
    }
  }

  /** Shows the result. */
  async finish(job: ClipJob) {
    const { visit } = this.store.state;
    if (this.corrected && !job.isPartial && !this.carriedHidden.has(job))
      this.carriedHidden.set(job, carryHidden(this.corrected, job));
    const hidden = await this.carriedHidden.get(job);
    // A run cancelled in the meantime continues here.
    if (hidden && (visit !== this.store.state.visit || this.store.state.phase !== 'running')) return;
    if (hidden) this.store.set({ hidden });
    if (!job.isPartial) this.corrected = null;
    await showResult(this.store, job);
  }

  showRunning(job: ClipJob) {
    const { state } = this.store;
    if (job !== state.job || state.phase !== 'running') return;
    this.store.set(progressPatch(job, state.headline));
  }

  /** Shows the newest frame until there is a preview or a result. */
  showNewestFrame(job: ClipJob) {
    const { images } = job;
    const { analysis, preview, picture, ...state } = this.store.state;
    const newest = images.length - 1;
    if (job !== state.job || state.phase !== 'running' || newest < 0 || analysis || preview) return;
    const { width, height } = images;
    const isFitted = picture.width === width && picture.height === height;
    this.store.set({ frame: newest, ...(isFitted ? {} : { picture: { width, height, images } }) });
  }

  /** Cancels the run; its worker stops at the end of the current step. */
  cancel() {
    const { job, phase } = this.store.state;
    if (phase !== 'running' || !job) return;
    this.abort?.abort();
    if (job.stop()) return void this.finish(job);
    const advice = 'Continue, change the settings, or open another file.';
    this.store.set(phasePatch('stopped', 'Cancelled', advice));
  }

  fail(visit: number, error: unknown) {
    if (visit !== this.store.state.visit) return;
    this.reset(this.store.state.previousJob);
    this.store.set(errorPatch(error));
  }
}

/** Carries corrections over to the new result and returns its hidden objects. */
async function carryHidden(previous: CorrectedResult, job: ClipJob): Promise<ReadonlySet<number>> {
  const { carryOver } = await import('./carry-over.js');
  const { hidden, dropped } = await carryOver(previous, job);
  if (dropped.length > 0)
    job.droppedCorrections = `These corrections no longer apply (undo restores them): ${dropped.join('; ')}.`;
  // Nothing was lost: it replaces the previous run in storage.
  else job.id = previous.job.id;
  return hidden;
}

/** Returns whether the page shows masks of a user's clip, or corrected ones of the sample. */
function hasWork({ phase, analysis, source, job }: State): boolean {
  return phase === 'done' && Boolean(analysis && (source?.kind !== 'sample' || job?.isCorrected));
}

/** Returns the changes after a file that cannot be opened beside finished work. */
function notOpenedPatch(name: string, error: unknown): Partial<State> {
  const notice = `Couldn’t open ${name}. ${explain(error).title}.`;
  return { isOpening: false, notice, announcement: notice };
}
