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

import { ClipPanel } from './panel-clip.js';
import { byId } from './dom.js';
import { readsAreNoisy } from './grabber.js';
import { Job } from './job.js';
import { createLayers } from './layers.js';
import { fillObjects } from './panel-objects.js';
import { layersPanel } from './panel-layers.js';
import { showStages } from './panel-stages.js';
import { Points } from './points.js';
import { showReadout } from './readout.js';
import { Selection } from './selection.js';
import { openFiles, sampleSource } from './source.js';
import { StillJob } from './still.js';
import { phase, say, showError, showNotice, showPhase, showProgress, showSubline } from './status.js';
import { Timeline } from './timeline.js';
import { NOWHERE, Viewer } from './viewer.js';
import { STILL, count, headline, plural, remark, seconds } from './words.js';

/** How long a freshly opened clip waits for a change of settings before it starts by itself. */
const HOLD_SECONDS = 4;

const NOISE_REMARK =
  'This browser alters pixels that a page reads, against tracking. Results may differ a little from run to run.';

const CALM = matchMedia('(prefers-reduced-motion: reduce)');

export class App {
  /** @param {any} library the tracecut package */
  constructor(library) {
    this.library = library;
    this.visit = 0;
    /** @type {import('./source.js').Source | null} */
    this.source = null;
    /** @type {Job | StillJob | null} */
    this.job = null;
    /** @type {AbortController | null} */
    this.abort = null;
    /** @type {Points | null} */
    this.points = null;
    this.hold = 0;
    /** The visit for which a preview is being fetched, 0 for none. */
    this.previewing = 0;
    this.noisy = readsAreNoisy();
    this.selection = new Selection();
    this.layers = createLayers(library.EdgeKind);
    this.viewer = new Viewer({
      canvas: /** @type {HTMLCanvasElement} */ (byId('canvas')),
      box: byId('screen'),
      layers: this.layers,
      visible: (object) => this.selection.has(object),
      onHover: (spot) => this.tell(spot),
      onPick: (spot) => this.pick(spot.object),
    });
    this.timeline = new Timeline((frame) => this.viewer.show(frame));
    this.panel = layersPanel(this.layers, () => this.viewer.redraw());
    this.clip = new ClipPanel(() => this.onTakeChanged());
    this.selection.addEventListener('change', () => this.viewer.redraw());
  }

  /** Opens the sample and runs it. */
  async openSample() {
    await this.open('Sample clip', () => sampleSource(this.library.synthClip), (source) => this.start(source));
  }

  /**
   * Opens files and waits a moment for settings.
   *
   * @param {File[]} files
   */
  async openFiles(files) {
    await this.open(files[0]?.name ?? '', () => openFiles(files), (source) => this.setUp(source));
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
    clearInterval(this.hold);
    this.abort?.abort();
    this.abort = null;
    this.job?.close();
    this.job = null;
    this.points = null;
    this.viewer.setClip(16, 9, []);
    this.timeline.setClip(0, 25);
    fillObjects(null, this.selection);
    this.updatePanel();
    showReadout(null, NOWHERE);
    showNotice('');
    byId('canvas').setAttribute('aria-label', 'No result yet');
    return this.visit;
  }

  /** @param {import('./source.js').Source} source */
  async setUp(source) {
    if (source.count < 2) return this.start(source);
    await this.preview();
    let left = HOLD_SECONDS;
    const tell = () => showSubline(`Starts in ${left} s with the settings under “Clip”. Changing one holds it.`);
    showPhase('setup', 'Ready to segment', '');
    tell();
    this.hold = window.setInterval(() => {
      left -= 1;
      if (left > 0) tell();
      else this.start(source);
    }, 1000);
  }

  onTakeChanged() {
    clearInterval(this.hold);
    if (phase() === 'setup') {
      showSubline('Press “Start” when the settings under “Clip” are right.');
      this.preview().catch((error) => this.fail(this.visit, error));
    }
  }

  /** Shows the first frame of what is chosen; while one is fetched, only the newest wish is kept. */
  async preview() {
    const { source, visit } = this;
    if (!source || this.previewing === visit) return;
    const { start, side } = this.clip.take;
    this.previewing = visit;
    try {
      const image = await createImageBitmap(await source.preview(start, side));
      if (visit === this.visit && phase() !== 'running') this.viewer.setClip(image.width, image.height, [image]);
    } finally {
      if (this.previewing === visit) this.previewing = 0;
    }
    const now = this.clip.take;
    if (visit === this.visit && phase() === 'setup' && (now.start !== start || now.side !== side)) await this.preview();
  }

  /** Starts, or starts anew, with the settings as they are. */
  async start(source = this.source) {
    if (!source) return;
    const visit = this.leave();
    const Kind = source.kind === 'still' ? StillJob : Job;
    this.job = new Kind(this.library, source, { ...this.clip.take });
    this.viewer.setClip(16, 9, this.job.images);
    await this.go(visit, this.job);
  }

  /** Goes on after a cancel where the run was; starts anew if the settings have changed since. */
  async resume() {
    const { job, visit } = this;
    if (!job || JSON.stringify(job.take) !== JSON.stringify(this.clip.take)) return this.start();
    await this.go(visit, job);
  }

  /**
   * @param {number} visit
   * @param {Job | StillJob} job
   */
  async go(visit, job) {
    this.abort = new AbortController();
    const { signal } = this.abort;
    showPhase('running', job.current?.name ?? '', '');
    const clock = setInterval(() => this.showRunning(job), 100);
    signal.addEventListener('abort', () => clearInterval(clock));
    try {
      await job.run(signal, () => this.showRunning(job));
      if (visit !== this.visit) return;
      if (job instanceof StillJob) this.finishStill(job);
      else this.finish(job);
    } catch (error) {
      if (!signal.aborted) this.fail(visit, error);
    } finally {
      clearInterval(clock);
    }
  }

  /** @param {Job | StillJob} job */
  showRunning(job) {
    const stage = job.current;
    if (!stage || job !== this.job || phase() !== 'running') return;
    if (byId('headline').textContent !== stage.name) {
      byId('headline').textContent = stage.name;
      say(stage.name);
    }
    const many = stage.total > 1 ? `${count(stage.done)} of ${count(stage.total)}, ` : '';
    showSubline(`${many}${seconds(job.ms + performance.now() - job.markedAt)} so far`);
    showProgress(job.share);
    showStages(job, 'running');
    this.showArriving(job);
  }

  /**
   * While frames arrive, the newest is shown.
   *
   * @param {Job | StillJob} job
   */
  showArriving(job) {
    const newest = job.images.length - 1;
    if (newest < 0) return;
    const { width, height } = job.images[newest];
    const { view } = this.viewer;
    if (view.width !== width || view.height !== height) this.viewer.setClip(width, height, job.images);
    if (view.frame !== newest) this.viewer.show(newest);
  }

  /** Cancels at once; the worker stops at the end of its step. */
  cancel() {
    if (phase() === 'setup') {
      clearInterval(this.hold);
      showSubline('Press “Start” when the settings under “Clip” are right.');
    }
    if (phase() !== 'running' || !this.job) return;
    this.abort?.abort();
    showStages(this.job, 'stopped');
    showPhase('stopped', 'Cancelled', 'Continue where it stopped, change the settings, or open something else.');
  }

  /** @param {Job} job */
  finish(job) {
    const { result, images, session } = job;
    const { width, height } = images[0];
    this.points = new Points(result);
    this.viewer.setClip(width, height, images);
    this.viewer.setResult(this.points, {
      flow: (t) => session.flow(t),
      boundaries: (t) => result.boundaries(t),
      superpixels: result.objects && remembered((/** @type {number} */ t) => result.superpixels(t)),
      saliencyMap: (t) => result.saliencyMap(t),
    });
    this.updatePanel();
    fillObjects(this.points, this.selection);
    this.timeline.setClip(result.numFrames, job.source.fps / job.take.step);
    this.timeline.setPresence(this.points);
    this.clip.setPace(job.ms / (width * height * images.length));
    showStages(job, 'done');
    showProgress(1);
    showNotice(remark(result) || (this.noisy && job.source.kind !== 'sample' ? NOISE_REMARK : ''));
    const facts = [
      plural(result.trajectories.count, 'trajectory', 'trajectories'),
      `${plural(images.length, 'frame')} of ${width} × ${height}`,
      `computed in ${seconds(job.ms)}`,
    ];
    byId('canvas').setAttribute('aria-label', `${job.source.name}: ${headline(result)}`);
    showPhase('done', headline(result), facts.join(' · '));
    this.viewer.draw();
    if (!CALM.matches) this.timeline.play();
  }

  /** @param {StillJob} job */
  finishStill(job) {
    const { found, images } = job;
    const { width, height } = images[0];
    const answer = async (/** @type {keyof typeof found} */ what) => /** @type {any} */ (found[what]);
    this.viewer.setClip(width, height, images);
    this.viewer.setResult(null, {
      boundaries: () => answer('boundaries'),
      superpixels: () => answer('superpixels'),
      imageEdges: () => answer('imageEdges'),
    });
    this.updatePanel();
    this.clip.setPace(job.ms / (width * height));
    showStages(job, 'done');
    showProgress(1);
    showNotice(STILL.remark);
    const facts = [plural(found.superpixels?.count ?? 0, 'superpixel'), `${width} × ${height}`, `computed in ${seconds(job.ms)}`];
    byId('canvas').setAttribute('aria-label', `${job.source.name}: ${STILL.headline}`);
    showPhase('done', STILL.headline, facts.join(' · '));
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

/**
 * Superpixels serve two layers; each frame's are fetched once.
 *
 * @template T
 * @param {(frame: number) => Promise<T>} ask
 * @returns {(frame: number) => Promise<T>}
 */
function remembered(ask) {
  /** @type {Map<number, Promise<T>>} */
  const known = new Map();
  return (frame) => {
    const answer = known.get(frame) ?? ask(frame);
    known.set(frame, answer);
    return answer;
  };
}
