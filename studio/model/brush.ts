// Painting: a brush and an eraser for the object that is chosen, and things that were missed, which grow from a click. What is done in one frame is carried to the others, as far as the picture agrees.

import { plural } from './words.js';
import type { Corrections, Stroke } from './corrections.js';
import type { Painted, ToPaint } from './job.js';
import type { Region } from './library.js';
import type { Store } from './store.js';

export type BrushTool = 'paint' | 'erase' | 'add';

/** The object that is begun by painting. */
export const NEW_OBJECT = -1;

/**
 * Regions that a click may mean, the smallest first, which of them is in force, in frame t, and how: `count` steps of
 * correction are done with it.
 */
type Offer = { regions: Region[]; at: number; t: number; painted: Pick<ToPaint, 'label' | 'over'>; count?: number };

/** What a brush needs of the panel that it is in. */
interface Host {
  store: Store;
  corrector: () => Corrections | null;
  object: () => number;
  choose: (object: number) => void;
  /** Whether what is painted goes to the other frames. */
  carries: () => boolean;
  tellCarrying: (isCarrying: boolean) => void;
  /** Which other sizes the thing added last may have. */
  tellSizes: (isSmaller: boolean, isLarger: boolean) => void;
  show: (frames: number[] | null) => void;
  tell: (text: string, wrong?: boolean) => void;
}

export class Brush {
  /** One edit after the other. */
  working: Promise<unknown> = Promise.resolve();
  /** Of what is being carried. */
  carrying: AbortController | null = null;
  /** The sizes that the thing added last may have. */
  offer: Offer | null = null;

  constructor(readonly host: Host) {}

  /** Ends carrying; what was reached stays. */
  stop() {
    this.carrying?.abort();
  }

  /** Resolves when nothing is under way any more. */
  async settled() {
    this.stop();
    await this.working;
  }

  /**
   * A stroke that was painted or wiped.
   * @param stroke in clip pixels
   */
  stroke(stroke: Stroke, tool: BrushTool) {
    const object = this.host.object();
    if (tool === 'erase') this.edit({ label: 0, stroke, ...(object > 0 ? { over: [object] } : {}) });
    else this.edit({ label: object, stroke });
  }

  /**
   * A click on what was missed: the region that grows from there becomes an object, or goes to the one that is clicked or
   * was added last.
   * @param place in clip pixels
   * @param clicked the object there
   * @param away whether it is taken away
   */
  async add(place: { x: number; y: number }, clicked: number, away: boolean) {
    const { host } = this;
    const { frame, visit } = host.store.state;
    this.take(null);
    // From the background nothing is taken away.
    if (away && clicked <= 0) return;
    try {
      const grown = await host.corrector()?.grown(frame, place);
      if (!grown || visit !== host.store.state.visit) return;
      const { regions, likeliest } = grown;
      const meant = Math.max(0, clicked) || host.object();
      const painted: Pick<ToPaint, 'label' | 'over'> = away
        ? { label: 0, over: [clicked] }
        : { label: meant > 0 ? meant : NEW_OBJECT, over: [0] };
      this.offer = { regions, at: likeliest, t: frame, painted };
      this.paintOffer();
    } catch (error) {
      if (visit === host.store.state.visit) this.refuse(error);
    }
  }

  /** The thing that was added last becomes smaller or larger. */
  async resize(by: -1 | 1) {
    const { host, offer } = this;
    const corrector = host.corrector();
    if (!offer || !corrector || !offer.regions[offer.at + by]) return;
    this.take(null);
    await this.settled();
    // Something else was done since.
    if (corrector.count() !== offer.count) return;
    host.show(await corrector.undo());
    this.offer = { ...offer, at: offer.at + by };
    this.paintOffer();
  }

  paintOffer() {
    const { offer } = this;
    if (!offer) return;
    const { regions, at, t, painted } = offer;
    this.edit({ ...painted, t, region: regions[at] });
  }

  take(offer: Offer | null) {
    this.offer = offer;
    const { regions = [], at = 0 } = offer ?? {};
    this.host.tellSizes(Boolean(regions[at - 1]), Boolean(regions[at + 1]));
  }

  /** @param painted with `NEW_OBJECT` for a label that nothing has */
  edit(painted: ToPaint) {
    this.working = this.working.then(() => this.work(painted)).catch(() => {});
  }

  refuse(error: unknown) {
    this.host.tell(`That is not possible here: ${error instanceof Error ? error.message : error}.`, true);
  }

  async work(painted: ToPaint) {
    const { host } = this;
    const corrector = host.corrector();
    if (!corrector) return;
    const { visit } = host.store.state;
    const same = () => visit === host.store.state.visit;
    try {
      const label = painted.label === NEW_OBJECT ? corrector.newLabel() : painted.label;
      const edit = await corrector.paint({ ...painted, label });
      if (!same()) return;
      const { offer } = this;
      const offered = offer?.regions.some((region) => region === painted.region) ? offer : null;
      // Of another size it has the same label.
      this.take(offered && { ...offered, painted: { label, over: painted.over }, count: corrector.count() });
      host.show(edit.frames);
      if (label > 0) host.choose(label);
      if (host.carries()) await this.carry(corrector, edit, same);
      else host.tell(`In frame ${edit.frames[0] + 1}.`);
    } catch (error) {
      if (same()) this.refuse(error);
    }
  }

  /** @param same whether the clip is still the same */
  async carry(corrector: Corrections, edit: Painted, same: () => boolean) {
    const { host } = this;
    const carrying = new AbortController();
    this.carrying = carrying;
    host.tellCarrying(true);
    const reach = () => plural(edit.frames.length, 'frame');
    try {
      await corrector.carry(edit, carrying.signal, () => same() && host.tell(`Carried to ${reach()}…`));
    } catch (error) {
      if (!carrying.signal.aborted) throw error;
    } finally {
      this.carrying = null;
      host.tellCarrying(false);
      if (same()) {
        host.show(edit.frames);
        const [first, last] = [Math.min(...edit.frames), Math.max(...edit.frames)];
        host.tell(
          first === last
            ? `In frame ${first + 1} alone: the picture changes too much.`
            : `In ${reach()}, ${first + 1} to ${last + 1}.`,
        );
      }
    }
  }
}
