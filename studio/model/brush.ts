// Painting: a brush and an eraser for the selected object, and missing objects that grow from a click. Edits of one
// frame are propagated to the others as far as the image supports them.

import { formatPlural } from './messages.js';
import { type Corrections, type Stroke, framesOf } from './corrections.js';
import type { PaintRequest } from './clip-job.js';
import type { Edit, Region } from './library.js';
import type { Store } from './store.js';

/** Time between updates of the picture while a correction spreads, in milliseconds; chosen by eye. */
const SHOW_INTERVAL_MS = 400;

export type BrushTool = 'paint' | 'erase' | 'add';

/** Stands for an object that does not exist yet. */
export const NEW_OBJECT = -1;

/**
 * Candidate regions of a click in frame `t`, smallest first, and the index of the applied one; `count` is the number
 * of corrections once it is applied.
 */
type Offer = {
  regions: Region[];
  at: number;
  t: number;
  request: Pick<PaintRequest, 'label' | 'over'>;
  count?: number;
};

/** Callbacks of the panel around the brush. */
interface Host {
  store: Store;
  corrector: () => Corrections | null;
  object: () => number;
  choose: (object: number) => void;
  /** True if edits are propagated to other frames. */
  appliesToOthers: () => boolean;
  onCarrying: (isCarrying: boolean) => void;
  /** Tells whether the last added object can become smaller or larger. */
  onSizes: (isSmaller: boolean, isLarger: boolean) => void;
  showFrames: (frames: number[] | null) => void;
  showStatus: (text: string, isError?: boolean) => void;
}

export class Brush {
  /** Serialises edits. */
  queue: Promise<unknown> = Promise.resolve();
  /** Stops the current propagation. */
  abort: AbortController | null = null;
  /** The candidate regions of the last added object. */
  offer: Offer | null = null;
  /** True if the last click had no outlined region: its size is chosen afterwards. */
  offersSizes = false;

  constructor(readonly host: Host) {
    const { store } = host;
    store.watch(['analysis'], ({ fix }) => {
      if (fix && host.corrector()?.edits.at(-1) !== fix.edit) store.set({ fix: null });
    });
  }

  /** Stops propagation; frames reached so far stay edited. */
  stop() {
    this.abort?.abort();
  }

  /** Stops propagation and waits for all edits. */
  async finish() {
    this.stop();
    await this.queue;
  }

  /**
   * Applies a stroke of the brush or the eraser.
   * @param stroke in clip pixels
   */
  stroke(stroke: Stroke, tool: BrushTool) {
    const object = this.host.object();
    if (tool === 'erase') this.queuePaint({ label: 0, stroke, ...(object > 0 ? { over: [object] } : {}) });
    else this.queuePaint({ label: object, stroke });
  }

  /**
   * Adds the region at a place; it becomes an object, or part of the clicked or last added one.
   * @param place in clip pixels
   * @param clicked the object there
   * @param isRemoving removes the region from the clicked object
   * @param region the outlined one; if null, the likeliest is grown, and can become smaller or larger
   */
  async add(place: { x: number; y: number }, clicked: number, isRemoving: boolean, region: Region | null = null) {
    const { host } = this;
    const { frame, visit } = host.store.state;
    this.offersSizes = region === null;
    this.setOffer(null);
    // Nothing can be removed from the background.
    if (isRemoving && clicked <= 0) return;
    const label = Math.max(0, clicked) || host.object();
    const request: Pick<PaintRequest, 'label' | 'over'> = isRemoving
      ? { label: 0, over: [clicked] }
      : { label: label > 0 ? label : NEW_OBJECT, over: [0] };
    if (region) return this.queuePaint({ ...request, t: frame, region });
    try {
      const growth = await host.corrector()?.growRegions(frame, place);
      if (!growth || visit !== host.store.state.visit) return;
      const { regions, likeliest } = growth;
      this.offer = { regions, at: likeliest, t: frame, request };
      this.paintOffer();
    } catch (error) {
      if (visit === host.store.state.visit) this.showError(error);
    }
  }

  /** Makes the last added object smaller or larger. */
  async resize(by: -1 | 1) {
    const { host, offer } = this;
    const corrector = host.corrector();
    if (!offer || !corrector || !offer.regions[offer.at + by]) return;
    this.setOffer(null);
    await this.finish();
    // Another correction came in between.
    if (corrector.undoCount() !== offer.count) return;
    host.showFrames(await corrector.undo());
    this.offer = { ...offer, at: offer.at + by };
    this.paintOffer();
  }

  paintOffer() {
    const { offer } = this;
    if (!offer) return;
    const { regions, at, t, request } = offer;
    this.queuePaint({ ...request, t, region: regions[at] });
  }

  /** Ends the choice of sizes after a click. */
  endOffer() {
    this.offersSizes = false;
    this.setOffer(null);
  }

  setOffer(offer: Offer | null) {
    this.offer = offer;
    const { regions = [], at = 0 } = offer ?? {};
    this.host.onSizes(Boolean(regions[at - 1]), Boolean(regions[at + 1]));
  }

  /** @param request its label may be `NEW_OBJECT` */
  queuePaint(request: PaintRequest) {
    this.queue = this.queue.then(() => this.paint(request)).catch(() => {});
  }

  showError(error: unknown) {
    this.host.showStatus(`Not possible here: ${error instanceof Error ? error.message : error}.`, true);
  }

  async paint(request: PaintRequest) {
    const { host } = this;
    const corrector = host.corrector();
    if (!corrector) return;
    const { visit } = host.store.state;
    const isCurrent = () => visit === host.store.state.visit;
    try {
      const label = request.label === NEW_OBJECT ? corrector.newLabel() : request.label;
      const edit = await corrector.paint({ ...request, label });
      if (!isCurrent()) return;
      const { offer } = this;
      const currentOffer = offer?.regions.some((region) => region === request.region) ? offer : null;
      // Resizing keeps the label.
      this.setOffer(
        currentOffer && { ...currentOffer, request: { label, over: request.over }, count: corrector.undoCount() },
      );
      this.setFix(edit, false);
      host.showFrames(framesOf(edit));
      if (label > 0) host.choose(label);
      if (host.appliesToOthers()) await this.carry(corrector, edit, isCurrent);
      else this.showRange(edit);
    } catch (error) {
      if (isCurrent()) this.showError(error);
    }
  }

  /**
   * @param isCurrent returns false once another clip is open
   * @param limits the frames to reach; as far as the picture supports it if not given
   */
  async carry(
    corrector: Corrections,
    edit: Edit,
    isCurrent: () => boolean,
    limits?: { first: number; last: number; minEvidence: number },
  ) {
    const { host } = this;
    const abort = new AbortController();
    this.abort = abort;
    host.onCarrying(true);
    this.setFix(edit, true);
    let pending: number[] = [];
    let lastShown = performance.now();
    const show = () => {
      host.showFrames(pending);
      pending = [];
      lastShown = performance.now();
    };
    const onFrame = (t: number) => {
      if (!isCurrent()) return;
      pending.push(t);
      this.setFix(edit, true);
      host.showStatus(`Applied to ${formatPlural(framesOf(edit).length, 'frame')}…`);
      if (performance.now() - lastShown > SHOW_INTERVAL_MS || t === host.store.state.frame) show();
    };
    try {
      await corrector.carry(edit, abort.signal, onFrame, limits);
    } catch (error) {
      if (!abort.signal.aborted) throw error;
    } finally {
      this.abort = null;
      host.onCarrying(false);
      if (isCurrent()) {
        show();
        this.setFix(edit, false);
        this.showRange(edit, !limits && !abort.signal.aborted);
      }
    }
  }

  /**
   * Removes the last painted correction from the frames outside of a range, or carries it on to its ends, although the
   * picture changes there.
   */
  async moveEnds(range: { first: number; last: number }) {
    const { fix, visit } = this.host.store.state;
    if (!fix) return;
    this.stop();
    this.queue = this.queue.then(() => this.applyEnds(fix.edit, range, visit)).catch(() => {});
    await this.queue;
  }

  async applyEnds(edit: Edit, { first, last }: { first: number; last: number }, visit: number) {
    const { host } = this;
    const corrector = host.corrector();
    const isCurrent = () => visit === host.store.state.visit;
    // Another correction came in between.
    if (!isCurrent() || !corrector || corrector.edits.at(-1) !== edit) return;
    try {
      const removed = corrector.trim(edit, { first, last });
      this.setFix(edit, false);
      if (removed.length > 0) host.showFrames(removed);
      const now = rangeOf(edit);
      if (first < now.first || last > now.last)
        await this.carry(corrector, edit, isCurrent, { first, last, minEvidence: 0 });
      else this.showRange(edit);
    } catch (error) {
      if (isCurrent()) this.showError(error);
    }
  }

  setFix(edit: Edit, isSpreading: boolean) {
    const [{ label, over }] = edit.paints;
    const [t] = framesOf(edit);
    this.host.store.set({ fix: { edit, object: label || (over?.[0] ?? 0), t, ...rangeOf(edit), isSpreading } });
  }

  /**
   * Tells the frames that a correction changes.
   * @param isWhole true if it was carried as far as the picture supports it
   */
  showRange(edit: Edit, isWhole = false) {
    const { first, last } = rangeOf(edit);
    const frame = isWhole
      ? `frame ${first + 1} only: other frames are uncertain; drag the ends of the range to add some`
      : `frame ${first + 1}`;
    this.host.showStatus(`Applied to ${first === last ? frame : `frames ${first + 1}–${last + 1}`}.`);
  }
}

/** Returns the first and the last frame that an edit paints. */
function rangeOf(edit: Edit): { first: number; last: number } {
  const frames = framesOf(edit);
  return { first: Math.min(...frames), last: Math.max(...frames) };
}
