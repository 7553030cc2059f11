// Painting: a brush and an eraser for the selected object, and missing objects that grow from a click. Edits of one
// frame are propagated to the others as far as the image supports them.

import { formatPlural } from './messages.js';
import type { Corrections, Stroke } from './corrections.js';
import type { PaintedEdit, PaintRequest } from './job.js';
import type { Region } from './library.js';
import type { Store } from './store.js';

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

  constructor(readonly host: Host) {}

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
      host.showFrames(edit.frames);
      if (label > 0) host.choose(label);
      if (host.appliesToOthers()) await this.carry(corrector, edit, isCurrent);
      else host.showStatus(`Applied to frame ${edit.frames[0] + 1}.`);
    } catch (error) {
      if (isCurrent()) this.showError(error);
    }
  }

  /** @param isCurrent returns false once another clip is open */
  async carry(corrector: Corrections, edit: PaintedEdit, isCurrent: () => boolean) {
    const { host } = this;
    const abort = new AbortController();
    this.abort = abort;
    host.onCarrying(true);
    try {
      await corrector.carry(
        edit,
        abort.signal,
        () => isCurrent() && host.showStatus(`Applied to ${formatPlural(edit.frames.length, 'frame')}…`),
      );
    } catch (error) {
      if (!abort.signal.aborted) throw error;
    } finally {
      this.abort = null;
      host.onCarrying(false);
      if (isCurrent()) {
        host.showFrames(edit.frames);
        const [first, last] = [Math.min(...edit.frames), Math.max(...edit.frames)];
        host.showStatus(
          first === last
            ? `Applied to frame ${first + 1} only: the picture changes too much.`
            : `Applied to frames ${first + 1}–${last + 1}.`,
        );
      }
    }
  }
}
