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
import { optionsOf } from './settings.js';
import { EXTENSION, lookPatch } from './look.js';
import { type Source, fitTake, usualTake } from './source.js';
import { BLANK, type Store, errorPatch, phasePatch } from './store.js';
import { doing } from './words.js';
import type { Run } from './cut-off.js';
import type { AnyJob, Images } from './job.js';
import type { Project } from './library.js';
import type { About } from './slots.js';
import type { StagePlan } from './stage-clock.js';

/** A result, and its objects that are not kept. */
type Taken = { job: ClipJob; hidden: ReadonlySet<number> };

/** How often the progress of a run is shown, in milliseconds. */
const TICK_MS = 100;

/** Settings that stay as they are for so long are meant, in milliseconds. */
const SETTLED_MS = 600;

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
  changing = 0;
  /** Asks before a corrected result goes. */
  asks = async () => true;
  /** What the next result takes over from the last, as far as it applies. */
  taken: Taken | null = null;
  /** What each result has taken over. */
  carried = new WeakMap<AnyJob, ReturnType<typeof carriedOver>>();
  /** The objects of `before` that were not kept. */
  hiddenBefore: ReadonlySet<number> = new Set();

  constructor(
    readonly store: Store,
    readonly platform: Platform,
  ) {
    store.watch(['take', 'changed'], () => this.onSettings());
  }

  /** A run under way begins anew when settings have been changed, also where it ends before they are settled. */
  onSettings() {
    clearTimeout(this.changing);
    if (this.store.state.phase !== 'running') return;
    this.changing = setTimeout(() => {
      const { state } = this.store;
      const goesOn = state.phase === 'running' || state.phase === 'done';
      if (goesOn && !state.job?.isFor(state.take, optionsOf(state))) this.start();
    }, SETTLED_MS);
  }

  async openSample() {
    await this.open('Sample clip', this.platform.openSample, () => this.start());
  }

  /** Opens files and runs them; a project file is opened as it was. */
  async openFiles(files: File[]) {
    const [file] = files;
    if (files.length === 1 && file.name.endsWith(EXTENSION))
      return this.openWork(file.name, async () => (await import('./work.js')).readProjectFile(file));
    await this.open(
      files[0]?.name ?? '',
      () => this.platform.openFiles(files),
      () => this.start(),
    );
  }

  /** Opens work that was kept: frames are read again, masks and corrections are there. */
  async openWork(name: string, read: () => Promise<{ files: File[]; about: About; project: Project }>) {
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
          ...{ name: about.name, take: fitTake(about.take, source), changed: new Map(about.changed) },
          ...lookPatch(about.look, this.store.state),
        });
        const { visit, take } = this.store.state;
        const options = optionsOf(this.store.state);
        const { SavedJob } = await fetched;
        const job = new SavedJob(
          [source, { ...take }, options, SavedJob.stagesFor(), this.platform.createImages()],
          project,
          about,
        );
        this.store.set({ job, picture: { ...BLANK.picture, images: job.images } });
        await this.go(visit, job);
      },
    );
  }

  /** Runs again what was cut off, with the settings that it had. */
  async openRun({ name, files, about }: Run) {
    await this.open(
      name,
      () => this.platform.openFiles(files),
      async () => {
        const { source } = this.store.state;
        if (source) this.store.set({ take: fitTake(about.take, source), changed: new Map(about.changed) });
        await this.start();
      },
    );
  }

  /** @param name shown until the source tells its own */
  async open(name: string, opener: () => Promise<Source>, next: () => Promise<void>) {
    const visit = this.leave();
    this.taken = null;
    this.store.state.source?.close();
    this.store.set({ source: null, name, ...phasePatch('opening', 'Opening…', '') });
    try {
      const source = await opener();
      if (visit !== this.store.state.visit) return source.close();
      this.store.set({ source, name: source.name, take: usualTake(source) });
      await next();
    } catch (error) {
      this.fail(visit, error);
    }
  }

  /**
   * Ends whatever is going on.
   * @param kept what can be had back
   */
  leave(kept: AnyJob | null = null): number {
    const { job, before, visit } = this.store.state;
    this.abort?.abort();
    this.abort = null;
    for (const one of [job, before]) if (one !== kept) one?.close();
    this.store.set({ ...BLANK, before: kept, visit: visit + 1 });
    return visit + 1;
  }

  /** Runs again. Whoever has corrected is asked first, and can have that back. */
  async again() {
    if (!this.store.state.job?.isCorrected || (await this.asks())) await this.start();
  }

  /** Takes back the run that took the place of corrections. */
  async restore() {
    const { before } = this.store.state;
    if (!before) return;
    this.leave(before);
    this.taken = null;
    // There is nothing before this one any more: what it took over can be undone step by step.
    if (before.corrections) before.corrections.carried = 0;
    const picture = { ...BLANK.picture, images: before.images };
    const hidden = this.hiddenBefore;
    this.store.set({ before: null, job: before, hidden, picture, ...phasePatch('running', 'Opening…', '') });
    await showResult(this.store, before);
  }

  /** Starts, or starts anew, with the settings as they are. */
  async start() {
    if (!this.store.state.source) return;
    const { job: last, before, hidden, phase } = this.store.state;
    // A run that is begun anew still has to take it over.
    if (phase === 'done' && last instanceof ClipJob && !last.partial)
      this.taken = last.isCorrected || hidden.size > 0 ? { job: last, hidden } : null;
    const isWorth = last && this.taken?.job === last && (last.isCorrected || !before);
    if (isWorth) this.hiddenBefore = hidden;
    const visit = this.leave(isWorth ? last : before);
    const job = this.newJob(this.store.state.source);
    this.store.set({ job, picture: { ...BLANK.picture, images: job.images } });
    job.look();
    if (job.preview) job.preview.onMasks = () => showPreview(this.store, job);
    await this.go(visit, job);
  }

  newJob(source: Source): AnyJob {
    const { state } = this.store;
    const Kind = kindFor(source);
    const stages = Kind.stagesFor(state.take);
    return new Kind(
      source,
      { ...state.take },
      optionsOf(state),
      this.plans.get(stages) ?? stages,
      this.platform.createImages(),
    );
  }

  /** Goes on after a cancel where the run was; starts anew if the settings have changed since. */
  async resume() {
    const { job, visit, take } = this.store.state;
    if (!job?.isFor(take, optionsOf(this.store.state))) return this.start();
    await this.go(visit, job);
  }

  async go(visit: number, job: AnyJob) {
    this.abort = new AbortController();
    const { signal } = this.abort;
    this.store.set(phasePatch('running', doing(job.current?.id ?? ''), ''));
    if (job.settled > 0) showWindow(this.store, job);
    const progress = new Progress();
    const show = () => this.showRunning(job, progress);
    const clock = setInterval(show, TICK_MS);
    signal.addEventListener('abort', () => {
      clearInterval(clock);
      job.preview?.close();
    });
    try {
      await job.run(signal, show, () => visit === this.store.state.visit && showWindow(this.store, job));
      if (visit === this.store.state.visit) await this.conclude(job);
    } catch (error) {
      if (!signal.aborted) this.fail(visit, error);
    } finally {
      clearInterval(clock);
    }
  }

  /** Shows the result; the next run's time is estimated from this one's own. */
  async conclude(job: AnyJob) {
    const { measured } = job;
    const { visit } = this.store.state;
    if (this.taken && job instanceof ClipJob && !job.partial && !this.carried.has(job))
      this.carried.set(job, carriedOver(this.taken, job));
    const carried = await this.carried.get(job);
    // Whoever cancels meanwhile goes on here.
    if (carried && (visit !== this.store.state.visit || this.store.state.phase !== 'running')) return;
    if (carried) this.store.set({ hidden: carried });
    if (!job.partial) this.taken = null;
    if (measured) this.plans.set(kindFor(job.source).stagesFor(job.take), measured);
    await showResult(this.store, job);
  }

  showRunning(job: AnyJob, progress: Progress) {
    const { state } = this.store;
    if (job !== state.job || state.phase !== 'running') return;
    this.store.set(progress.of(job, state.headline));
    this.showArriving(job);
  }

  /** While frames arrive, the newest is shown, until there is something to see in others. */
  showArriving({ images }: AnyJob) {
    const { found, preview, picture } = this.store.state;
    const newest = images.length - 1;
    if (newest < 0 || found || preview) return;
    const { width, height } = images;
    const isFitted = picture.width === width && picture.height === height;
    this.store.set({ frame: newest, ...(isFitted ? {} : { picture: { width, height, images } }) });
  }

  /** Cancels at once; the worker stops at the end of its step. */
  cancel() {
    const { job, phase } = this.store.state;
    if (phase !== 'running' || !job) return;
    this.abort?.abort();
    if (job.stop()) return void this.conclude(job);
    const advice = 'Continue where it stopped, change the settings, or open something else.';
    this.store.set(phasePatch('stopped', 'Cancelled', advice));
  }

  fail(visit: number, error: unknown) {
    if (visit !== this.store.state.visit) return;
    this.leave(this.store.state.before);
    this.store.set(errorPatch(error));
  }
}

/** Returns the objects of the new result that are not kept. */
async function carriedOver(taken: Taken, job: ClipJob): Promise<ReadonlySet<number>> {
  const { carryOver } = await import('./carry-over.js');
  const { hidden, lost } = await carryOver(taken, job);
  if (lost.length > 0)
    job.lost = `These corrections no longer apply; undo brings back the result that has them: ${lost.join('; ')}.`;
  // It has all that the one before had, and takes its place.
  else job.id = taken.job.id;
  return hidden;
}

/** Which kind of run is made of a source. */
function kindFor({ kind }: Source) {
  return kind === 'still' ? StillJob : ClipJob;
}
