/**
 * The page's state machine: open a source, set up, run, show, and back.
 *
 *     opening --> setup --> running --> done
 *        |          ^          |  \       |
 *        v          |          v   \      v  (run again)
 *      error        +------ stopped <-- running
 *
 * Every step that waits carries the number of the visit it belongs to and does nothing once another visit has begun.
 * @module
 */

import { Compare } from './compare.js';
import { Correction } from './correct.js';
import { frameText } from './describe.js';
import { byId } from './dom.js';
import { readsAreNoisy } from './grabber.js';
import { CLIP_STAGES, Job } from './job.js';
import { createLayers } from './layers.js';
import { LONG_STAGES, LongJob, WINDOW } from './long-job.js';
import { ClipPanel } from './panel-clip.js';
import { layersPanel } from './panel-layers.js';
import { ExportPanel } from './panel-export.js';
import { clearObjects } from './panel-objects.js';
import { SettingsPanel } from './panel-settings.js';
import { showStages } from './panel-stages.js';
import { Progress } from './progress.js';
import { linkOf, readLink, recipeOf } from './recipe.js';
import { showReadout } from './readout.js';
import { Selection } from './selection.js';
import { Settings } from './settings.js';
import { Setup } from './setup.js';
import { showClipResult, showCorrectedResult, showStillResult, showWindow } from './show-result.js';
import { openFiles, sampleSource } from './source.js';
import { STILL_STAGES, StillJob } from './still.js';
import { phase, showError, showNotice, showPhase } from './status.js';
import { Timeline } from './timeline.js';
import { NOWHERE, Viewer } from './viewer.js';
import { Webcam } from './webcam.js';

/** A frame that rests this long is described in words, in milliseconds. */
const REST_MS = 250;

export class App {
  /** @param {any} library the tracecut package */
  constructor(library) {
    this.library = library;
    this.visit = 0;
    /** @type {import('./source.js').Source | null} */
    this.source = null;
    /** @type {Job | LongJob | StillJob | null} */
    this.job = null;
    /** @type {AbortController | null} */
    this.abort = null;
    /** @type {import('./points.js').Points | null} */
    this.points = null;
    /** @type {import('./presence.js').Facts[]} What is known of each object. */
    this.facts = [];
    this.resting = 0;
    this.noisy = readsAreNoisy();
    /** The stages of a run and their shares of its time, as the last one of its kind took them. */
    this.plans = { clip: CLIP_STAGES, long: LONG_STAGES, still: STILL_STAGES };
    this.selection = new Selection();
    this.layers = createLayers();
    this.compare = new Compare(() => this.viewer.fit());
    this.viewer = new Viewer({
      canvas: /** @type {HTMLCanvasElement} */ (byId('canvas')),
      box: byId('pane-result'),
      layers: this.layers,
      compare: this.compare,
      visible: (object) => this.selection.has(object),
      onDraw: (ctx, view) => this.correction?.draw(ctx, view),
      onHover: (spot) => this.tell(spot),
      onPick: (spot) => (this.correction.on ? this.correction.pick(spot) : this.pick(spot.object)),
    });
    this.timeline = new Timeline((frame) => this.onFrame(frame));
    this.panel = layersPanel(this.layers, () => this.viewer.redraw());
    this.clip = new ClipPanel(() => this.onTakeChanged());
    this.settings = new Settings(library.parameters());
    this.settingsPanel = new SettingsPanel(this.settings);
    this.settings.addEventListener('change', () => this.onSettingsChanged());
    this.setup = new Setup(this);
    this.exports = new ExportPanel({
      subject: () => this.subject(),
      visible: (object) => this.selection.has(object),
      link: () => linkOf(this.settings),
      recipe: () => this.recipe(),
    });
    this.correction = new Correction(this);
    this.webcam = new Webcam((file) => this.openRecording(file));
    readLink(this.settings, location.hash);
    this.selection.addEventListener('change', () => this.viewer.redraw());
  }

  /** Opens the sample and runs it. */
  async openSample() {
    await this.open('Sample clip', () => sampleSource(this.library.synthClip), () => this.start());
  }

  /**
   * Opens files and waits a moment for settings.
   *
   * @param {File[]} files
   */
  async openFiles(files) {
    await this.open(files[0]?.name ?? '', () => openFiles(files, this.library), (source) => (source.count < 2 ? this.start() : this.setup.begin()));
  }

  /**
   * Opens what the camera recorded, and runs it.
   *
   * @param {File} file
   */
  async openRecording(file) {
    await this.open('Camera', () => openFiles([file], this.library), () => this.start());
  }

  /**
   * @param {string} name shown until the source tells its own
   * @param {() => Promise<import('./source.js').Source>} opener
   * @param {(source: import('./source.js').Source) => Promise<void>} next
   */
  async open(name, opener, next) {
    const visit = this.leave();
    this.setSource(null);
    byId('clip-name').textContent = name;
    showPhase('opening', 'Opening…', '');
    try {
      const source = await opener();
      if (visit !== this.visit) return source.close();
      this.setSource(source);
      await next(source);
    } catch (error) {
      this.fail(visit, error);
    }
  }

  /** @param {import('./source.js').Source | null} source */
  setSource(source) {
    this.source?.close();
    this.source = source;
    if (source) {
      document.body.dataset.source = source.kind;
      this.clip.setSource(source);
      this.settingsPanel.setKind(source.kind === 'still' ? 'still' : 'clip');
    } else {
      delete document.body.dataset.source;
    }
    this.updatePanel();
  }

  /**
   * Ends whatever is going on.
   *
   * @returns {number} the new visit
   */
  leave() {
    this.visit += 1;
    this.setup.leave();
    this.correction.leave();
    this.abort?.abort();
    this.abort = null;
    this.job?.close();
    this.job = null;
    this.points = null;
    this.facts = [];
    document.body.removeAttribute('data-streaming');
    this.viewer.setClip(16, 9);
    this.timeline.setClip(0, 25);
    clearObjects(this.selection);
    this.updatePanel();
    showReadout(null, NOWHERE);
    showNotice('');
    byId('canvas').setAttribute('aria-label', 'No result yet');
    this.updatePending();
    return this.visit;
  }

  /** @returns {import('./run.js').Options} the settings that count for this source */
  get options() {
    return this.settings.tree(this.settingsPanel.wanted);
  }

  onTakeChanged() {
    this.setup.hold();
    if (phase() === 'setup') this.setup.preview().catch((error) => this.fail(this.visit, error));
    this.updatePending();
  }

  onSettingsChanged() {
    this.setup.hold();
    this.updatePending();
  }

  /** Says whether the result on screen was made with other settings than those chosen now. */
  updatePending() {
    const pending = phase() === 'done' && this.job !== null && !this.job.isFor(this.clip.take, this.options);
    byId('pending').hidden = !pending;
    document.body.toggleAttribute('data-pending', pending);
  }

  /** Starts, or starts anew, with the settings as they are. */
  async start() {
    const { source } = this;
    if (!source) return;
    const visit = this.leave();
    const kind = kindOf(source, this.clip.take);
    this.job = new KINDS[kind](this.library, source, { ...this.clip.take }, this.options, this.plans[kind]);
    this.viewer.setClip(16, 9, this.job.images);
    await this.go(visit, this.job);
  }

  /** Goes on after a cancel where the run was; starts anew if the settings have changed since. */
  async resume() {
    const { job, visit } = this;
    if (!job?.isFor(this.clip.take, this.options)) return this.start();
    await this.go(visit, job);
  }

  /**
   * @param {number} visit
   * @param {Job | LongJob | StillJob} job
   */
  async go(visit, job) {
    this.abort = new AbortController();
    const { signal } = this.abort;
    showPhase('running', job.current?.name ?? '', '');
    const progress = new Progress();
    const show = () => this.showRunning(job, progress);
    const clock = setInterval(show, 100);
    signal.addEventListener('abort', () => clearInterval(clock));
    try {
      await job.run(signal, show, (/** @type {LongJob} */ long) => visit === this.visit && showWindow(this, long));
      if (visit !== this.visit) return;
      if (job instanceof StillJob) showStillResult(this, job);
      else showClipResult(this, job);
    } catch (error) {
      if (!signal.aborted) this.fail(visit, error);
    } finally {
      clearInterval(clock);
    }
  }

  /**
   * @param {Job | LongJob | StillJob} job
   * @param {Progress} progress
   */
  showRunning(job, progress) {
    if (job !== this.job || phase() !== 'running') return;
    progress.show(job);
    this.showArriving(job);
  }

  /**
   * While frames arrive, the newest is shown.
   *
   * @param {Job | LongJob | StillJob} job
   */
  showArriving(job) {
    const newest = job.images.length - 1;
    if (newest < 0 || document.body.hasAttribute('data-streaming')) return;
    const { width, height } = job.images;
    const { view } = this.viewer;
    if (view.width !== width || view.height !== height) this.viewer.setClip(width, height, job.images);
    if (view.frame !== newest) this.viewer.show(newest);
  }

  /** Cancels at once; the worker stops at the end of its step. */
  cancel() {
    this.setup.hold();
    const { job } = this;
    if (phase() !== 'running' || !job) return;
    this.abort?.abort();
    if (job instanceof LongJob && job.settled > 1) {
      // What is settled by now is a result too.
      job.stop();
      return showClipResult(this, job);
    }
    showStages(job, 'stopped');
    showPhase('stopped', 'Cancelled', 'Continue where it stopped, change the settings, or open something else.');
  }

  /** Shows what a correction made of the result. */
  showCorrected() {
    const { job } = this;
    if (job instanceof Job || job instanceof LongJob) showCorrectedResult(this, job);
  }

  /** @returns {string} what is seen, in a few words */
  get headline() {
    return byId('headline').textContent ?? '';
  }

  /** @param {import('./run.js').Run} job that has ended: the next one's time is estimated from its own */
  learn(job) {
    if (!(job instanceof LongJob)) this.plans[kindOf(job.source, job.take)] = job.measured;
  }

  /** @param {number} frame */
  onFrame(frame) {
    this.viewer.show(frame);
    clearTimeout(this.resting);
    this.resting = window.setTimeout(() => this.describeFrame(), REST_MS);
  }

  /** Puts the frame on screen into words, for those who do not see it. */
  describeFrame() {
    const { points, timeline } = this;
    byId('frame-text').textContent = points ? frameText(points.presence, points.count, timeline.frame, timeline.times) : '';
  }

  /**
   * @param {number} visit
   * @param {unknown} error
   */
  fail(visit, error) {
    if (visit !== this.visit) return;
    this.leave();
    showError(error);
  }

  /** Shows in the panel which layers there are to show. */
  updatePanel() {
    this.panel.update(this.viewer.view, this.source?.kind);
    document.body.toggleAttribute('data-masks', this.points?.hasMasks ?? false);
  }

  /** @returns {Omit<import('./exports.js').Subject, 'objects'> | null} what there is to save */
  subject() {
    const { points, job, library, timeline } = this;
    if (!points?.hasMasks || !job) return null;
    const { width, height, numFrames } = points.result;
    const labels = (/** @type {number} */ t) => /** @type {Uint8Array} */ (points.mask(t));
    return {
      library,
      masks: { width, height, numFrames, labels, times: timeline.times.seconds },
      frames: () => job.images,
      frame: timeline.frame,
      name: job.source.name,
      fps: timeline.fps,
      tracks: () => points.result.toTracksDat(),
    };
  }

  /** @returns {Promise<string>} what it takes to get the same result again */
  async recipe() {
    const { job, library } = this;
    const masks = this.subject()?.masks;
    return masks && job ? recipeOf({ version: library.version, job, masks, corrections: job.corrector?.count() ?? 0 }) : '';
  }

  /** @param {import('./layer.js').Spot} spot */
  tell(spot) {
    const { view } = this.viewer;
    const more = this.layers.filter((layer) => layer.on && !layer.missing?.(view)).map((layer) => layer.readout?.(view, spot) ?? '');
    showReadout(this.points, spot, spot === NOWHERE ? [] : more);
  }

  /** @param {number} object is shown alone; the background brings all back */
  pick(object) {
    if (object > 0) this.selection.isolate(object);
    else if (object === 0) this.selection.reset(this.selection.count);
  }
}

/** Runs by the kind of clip. */
const KINDS = { clip: Job, long: LongJob, still: StillJob };

/**
 * @param {import('./source.js').Source} source
 * @param {import('./source.js').Take} take
 * @returns {'clip' | 'long' | 'still'}
 */
function kindOf(source, take) {
  if (source.kind === 'still') return 'still';
  return take.frames > WINDOW ? 'long' : 'clip';
}
