// Painting: a brush and an eraser for the object that is chosen, and things that were missed, which grow from a click. What is done in one frame is carried to the others, as far as the picture agrees.

import { formatPlural } from './messages.js';
import type { Corrections, Stroke } from './corrections.js';
import type { PaintedEdit, PaintRequest } from './job.js';
import type { Region } from './library.js';
import type { Store } from './store.js';

export type BrushTool = 'paint' | 'erase' | 'add';

/** The object that is begun by painting. */
export const NEW_OBJECT = -1;

/**
 * Regions that a click may mean, the smallest first, which of them is in force, in frame t, and how: `count` steps of
 * correction are done with it.
 */
type Offer = {
  regions: Region[];
  at: number;
  t: number;
  request: Pick<PaintRequest, 'label' | 'over'>;
  count?: number;
};

/** What a brush needs of the panel that it is in. */
interface Host {
  store: Store;
  corrector: () => Corrections | null;
  object: () => number;
  choose: (object: number) => void;
  /** Whether what is painted goes to the other frames. */
  appliesToOthers: () => boolean;
  onCarrying: (isCarrying: boolean) => void;
  /** Which other sizes the thing added last may have. */
  onSizes: (isSmaller: boolean, isLarger: boolean) => void;
  showFrames: (frames: number[] | null) => void;
  showStatus: (text: string, wrong?: boolean) => void;
}

export class Brush {
  /** One edit after the other. */
  queue: Promise<unknown> = Promise.resolve();
  /** Of what is being carried. */
  abort: AbortController | null = null;
  /** The sizes that the thing added last may have. */
  offer: Offer | null = null;

  constructor(readonly host: Host) {}

  /** Ends carrying; what was reached stays. */
  stop() {
    this.abort?.abort();
  }

  /** Resolves when nothing is under way any more. */
  async finish() {
    this.stop();
    await this.queue;
  }

  /**
   * A stroke that was painted or wiped.
   * @param stroke in clip pixels
   */
  stroke(stroke: Stroke, tool: BrushTool) {
    const object = this.host.object();
    if (tool === 'erase') this.queuePaint({ label: 0, stroke, ...(object > 0 ? { over: [object] } : {}) });
    else this.queuePaint({ label: object, stroke });
  }

  /**
   * A click on what was missed: the region that grows from there becomes an object, or goes to the one that is clicked or
   * was added last.
   * @param place in clip pixels
   * @param clicked the object there
   * @param isRemoving whether it is taken away
   */
  async add(place: { x: number; y: number }, clicked: number, isRemoving: boolean) {
    const { host } = this;
    const { frame, visit } = host.store.state;
    this.setOffer(null);
    // From the background nothing is taken away.
    if (isRemoving && clicked <= 0) return;
    try {
      const growth = await host.corrector()?.growRegions(frame, place);
      if (!growth || visit !== host.store.state.visit) return;
      const { regions, likeliest } = growth;
      const label = Math.max(0, clicked) || host.object();
      const request: Pick<PaintRequest, 'label' | 'over'> = isRemoving
        ? { label: 0, over: [clicked] }
        : { label: label > 0 ? label : NEW_OBJECT, over: [0] };
      this.offer = { regions, at: likeliest, t: frame, request };
      this.paintOffer();
    } catch (error) {
      if (visit === host.store.state.visit) this.showError(error);
    }
  }

  /** The thing that was added last becomes smaller or larger. */
  async resize(by: -1 | 1) {
    const { host, offer } = this;
    const corrector = host.corrector();
    if (!offer || !corrector || !offer.regions[offer.at + by]) return;
    this.setOffer(null);
    await this.finish();
    // Something else was done since.
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

  setOffer(offer: Offer | null) {
    this.offer = offer;
    const { regions = [], at = 0 } = offer ?? {};
    this.host.onSizes(Boolean(regions[at - 1]), Boolean(regions[at + 1]));
  }

  /** @param request with `NEW_OBJECT` for a label that nothing has */
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
      // Of another size it has the same label.
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

  /** @param isCurrent whether the clip is still the same */
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
