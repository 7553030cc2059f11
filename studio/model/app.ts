// What can be done, as a state machine: open a source, run, show, and back. All it knows lies in the store.
//
//     opening --> running --> done
//        |         |   ^       |
//        v         v   |       v
//      error     stopped <-- running (again)
//
// Nothing is asked before a run. Settings may be changed while it is under way: then it begins anew.
//
// Every step that waits carries the number of the visit it belongs to and does nothing once another visit has begun.

import { Progress } from './progress.js';
import { showPreview, showResult, showWindow } from './show-result.js';
import { ClipJob } from './clip-job.js';
import { StillJob } from './still-job.js';
import { sessionOptions } from './settings.js';
import { PROJECT_EXTENSION, viewSettingsPatch } from './view-settings.js';
import { type Source, clampTrim, defaultTrim } from './source.js';
import { BLANK, type Store, errorPatch, phasePatch } from './store.js';
import { stageName } from './messages.js';
import type { InterruptedRun } from './interrupted-runs.js';
import type { AnyJob, Images } from './job.js';
import type { Project } from './library.js';
import type { ProjectInfo } from './saved-projects.js';
import type { StagePlan } from './stage-clock.js';

/** A result, and its objects that are not kept. */
type CorrectedResult = { job: ClipJob; hidden: ReadonlySet<number> };

/** How often the progress of a run is shown, in milliseconds. */
const TICK_MS = 100;

/** Settings that stay as they are for so long are meant, in milliseconds. */
const SETTINGS_DELAY_MS = 600;

/** What the model needs of the browser. */
interface Platform {
  openSample: () => Promise<Source>;
  openFiles: (files: File[]) => Promise<Source>;
  createImages: () => Images;
}

export class App {
  abort: AbortController | null = null;
  /** The stages of a run with the shares of its time as the last one took them, by those as they usually are. */
  plans = new Map<StagePlan[], StagePlan[]>();
  restartTimer = 0;
  /** Asks before a corrected result goes. */
  confirmRerun = async () => true;
  /** What the next result takes over from the last, as far as it applies. */
  corrected: CorrectedResult | null = null;
  /** What each result has taken over. */
  carriedHidden = new WeakMap<AnyJob, ReturnType<typeof carryHidden>>();
  /** The objects of `before` that were not kept. */
  hiddenBefore: ReadonlySet<number> = new Set();

  constructor(
    readonly store: Store,
    readonly platform: Platform,
  ) {
    store.watch(['trim', 'changed'], () => this.onSettings());
  }

  /** A run under way begins anew when settings have been changed, also where it ends before they are settled. */
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

  /** Opens files and runs them; a project file is opened as it was. */
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

  /** Opens work that was kept: frames are read again, masks and corrections are there. */
  async openProject(name: string, read: () => Promise<{ files: File[]; about: ProjectInfo; project: Project }>) {
    let work: Awaited<ReturnType<typeof read>> | null = null;
    const fetched = import('./saved-job.js');
    await this.open(
      name,
      async () => {
        [work] = await Promise.all([read(), fetched]);
        return this.platform.openFiles(work.files);
      },
      async () => {
        const { about, project } = work!;
        const { source } = this.store.state;
        if (!source) return;
        this.store.set({
          ...{ name: about.name, trim: clampTrim(about.trim, source), changed: new Map(about.changed) },
          ...viewSettingsPatch(about.view, this.store.state),
        });
        const { visit, trim } = this.store.state;
        const options = sessionOptions(this.store.state);
        const { SavedJob } = await fetched;
        const job = new SavedJob(
          [source, { ...trim }, options, SavedJob.stagesFor(), this.platform.createImages()],
          project,
          about,
        );
        this.store.set({ job, picture: { ...BLANK.picture, images: job.images } });
        await this.runJob(visit, job);
      },
    );
  }

  /** Runs again what was cut off, with the settings that it had. */
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

  /** @param name shown until the source tells its own */
  async open(name: string, opener: () => Promise<Source>, next: () => Promise<void>) {
    const visit = this.reset();
    this.corrected = null;
    this.store.state.source?.close();
    this.store.set({ source: null, name, ...phasePatch('opening', 'Opening…', '') });
    try {
      const source = await opener();
      if (visit !== this.store.state.visit) return source.close();
      this.store.set({ source, name: source.name, trim: defaultTrim(source) });
      await next();
    } catch (error) {
      this.fail(visit, error);
    }
  }

  /**
   * Ends whatever is going on.
   * @param keptJob what can be had back
   */
  reset(keptJob: AnyJob | null = null): number {
    const { job, previousJob, visit } = this.store.state;
    this.abort?.abort();
    this.abort = null;
    for (const run of [job, previousJob]) if (run !== keptJob) run?.close();
    this.store.set({ ...BLANK, previousJob: keptJob, visit: visit + 1 });
    return visit + 1;
  }

  /** Runs again. Whoever has corrected is asked first, and can have that back. */
  async rerun() {
    if (!this.store.state.job?.isCorrected || (await this.confirmRerun())) await this.start();
  }

  /** Takes back the run that took the place of corrections. */
  async restore() {
    const { previousJob } = this.store.state;
    if (!previousJob) return;
    this.reset(previousJob);
    this.corrected = null;
    // There is nothing before this one any more: what it took over can be undone step by step.
    if (previousJob.corrections) previousJob.corrections.carriedCount = 0;
    const picture = { ...BLANK.picture, images: previousJob.images };
    const hidden = this.hiddenBefore;
    this.store.set({ previousJob: null, job: previousJob, hidden, picture, ...phasePatch('running', 'Opening…', '') });
    await showResult(this.store, previousJob);
  }

  /** Starts, or starts anew, with the settings as they are. */
  async start() {
    if (!this.store.state.source) return;
    const { job: last, previousJob, hidden, phase } = this.store.state;
    // A run that is begun anew still has to take it over.
    if (phase === 'done' && last instanceof ClipJob && !last.isPartial)
      this.corrected = last.isCorrected || hidden.size > 0 ? { job: last, hidden } : null;
    const keepsLast = last && this.corrected?.job === last && (last.isCorrected || !previousJob);
    if (keepsLast) this.hiddenBefore = hidden;
    const visit = this.reset(keepsLast ? last : previousJob);
    const job = this.createJob(this.store.state.source);
    this.store.set({ job, picture: { ...BLANK.picture, images: job.images } });
    job.startPreview();
    if (job.preview) job.preview.onMasks = () => showPreview(this.store, job);
    await this.runJob(visit, job);
  }

  createJob(source: Source): AnyJob {
    const { state } = this.store;
    const JobClass = jobClassFor(source);
    const stages = JobClass.stagesFor(state.trim);
    return new JobClass(
      source,
      { ...state.trim },
      sessionOptions(state),
      this.plans.get(stages) ?? stages,
      this.platform.createImages(),
    );
  }

  /** Goes on after a cancel where the run was; starts anew if the settings have changed since. */
  async resume() {
    const { job, visit, trim } = this.store.state;
    if (!job?.hasSettings(trim, sessionOptions(this.store.state))) return this.start();
    await this.runJob(visit, job);
  }

  async runJob(visit: number, job: AnyJob) {
    this.abort = new AbortController();
    const { signal } = this.abort;
    this.store.set(phasePatch('running', stageName(job.current?.id ?? ''), ''));
    if (job.settledFrames > 0) showWindow(this.store, job);
    const progress = new Progress();
    const showProgress = () => this.showRunning(job, progress);
    const clock = setInterval(showProgress, TICK_MS);
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

  /** Shows the result; the next run's time is estimated from this one's own. */
  async finish(job: AnyJob) {
    const { measured } = job;
    const { visit } = this.store.state;
    if (this.corrected && job instanceof ClipJob && !job.isPartial && !this.carriedHidden.has(job))
      this.carriedHidden.set(job, carryHidden(this.corrected, job));
    const hidden = await this.carriedHidden.get(job);
    // Whoever cancels meanwhile goes on here.
    if (hidden && (visit !== this.store.state.visit || this.store.state.phase !== 'running')) return;
    if (hidden) this.store.set({ hidden });
    if (!job.isPartial) this.corrected = null;
    if (measured) this.plans.set(jobClassFor(job.source).stagesFor(job.trim), measured);
    await showResult(this.store, job);
  }

  showRunning(job: AnyJob, progress: Progress) {
    const { state } = this.store;
    if (job !== state.job || state.phase !== 'running') return;
    this.store.set(progress.patch(job, state.headline));
    this.showNewestFrame(job);
  }

  /** While frames arrive, the newest is shown, until there is something to see in others. */
  showNewestFrame({ images }: AnyJob) {
    const { analysis, preview, picture } = this.store.state;
    const newest = images.length - 1;
    if (newest < 0 || analysis || preview) return;
    const { width, height } = images;
    const isFitted = picture.width === width && picture.height === height;
    this.store.set({ frame: newest, ...(isFitted ? {} : { picture: { width, height, images } }) });
  }

  /** Cancels at once; the worker stops at the end of its step. */
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

/** Returns the objects of the new result that are not kept. */
async function carryHidden(previous: CorrectedResult, job: ClipJob): Promise<ReadonlySet<number>> {
  const { carryOver } = await import('./carry-over.js');
  const { hidden, dropped } = await carryOver(previous, job);
  if (dropped.length > 0)
    job.droppedCorrections = `These corrections no longer apply (undo restores them): ${dropped.join('; ')}.`;
  // It has all that the one before had, and takes its place.
  else job.id = previous.job.id;
  return hidden;
}

/** Which kind of run is made of a source. */
function jobClassFor({ kind }: Source) {
  return kind === 'still' ? StillJob : ClipJob;
}
