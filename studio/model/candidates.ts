// The regions that a click with Add may take: grown where the pointer rests, and one of them outlined before the click.

import { decodeRuns, type Region } from './library.js';
import type { Corrections } from './corrections.js';
import type { Store } from './store.js';

/** Time that the pointer rests before regions are grown, in milliseconds; chosen by eye. */
const REST_MS = 40;

/** The place of the next click: its frame, in clip pixels, and the object there. */
export type Aim = { t: number; x: number; y: number; object: number; isRemoving: boolean };

/** One of the regions of a place: its number, smallest first, and its pixels that a click would change. */
export type Candidate = { rank: number; region: Region; pixels: Uint8Array; area: number };

/** The candidates of a place; `at` is the index of the outlined one, `isResized` if the user chose it. */
export type Outlined = { aim: Aim; list: Candidate[]; at: number; isResized: boolean };

interface Host {
  store: Store;
  corrector: () => Corrections | null;
  /** Called when another region is outlined, or none. */
  onChange: () => void;
}

export class Candidates {
  /** True while the tool Add is selected. */
  isOn = false;
  aim: Aim | null = null;
  outlined: Outlined | null = null;
  /** The place where regions are grown; null if none are wanted. */
  wanted: Aim | null = null;
  /** Settles when the features of the frame on screen are computed; null if none are. */
  preparing: Promise<void> | null = null;
  timer: ReturnType<typeof setTimeout> | undefined = undefined;

  constructor(readonly host: Host) {
    host.store.watch(['frame', 'isPlaying'], () => void this.prepare());
    // Only pixels that would change are outlined.
    host.store.watch(['analysis'], () => this.aim && this.outlined && void this.grow(this.aim, this.outlined));
  }

  turn(isOn: boolean) {
    if (this.isOn === isOn) return;
    this.isOn = isOn;
    this.aimAt(null);
    void this.prepare();
  }

  /** Computes the features of the frame on screen, and of the next one if it changes meanwhile. */
  prepare(): Promise<void> {
    if (!this.isWatching) return Promise.resolve();
    this.preparing ??= this.prepareFrames();
    return this.preparing;
  }

  get isWatching() {
    return this.isOn && !this.host.store.state.isPlaying;
  }

  async prepareFrames() {
    const { host } = this;
    try {
      for (let t = -1; this.isWatching && t !== host.store.state.frame;) {
        t = host.store.state.frame;
        await host.corrector()?.frameFeatures(t);
      }
    } catch {
      // A click says what is wrong.
    } finally {
      this.preparing = null;
    }
  }

  /** @param aim null where a click does nothing */
  aimAt(aim: Aim | null) {
    const last = this.aim;
    // The object may have changed below a resting pointer.
    if (aim && last && isSamePlace(aim, last) && aim.isRemoving === last.isRemoving)
      return void Object.assign(last, aim);
    this.aim = this.wanted = aim;
    clearTimeout(this.timer);
    const { outlined } = this;
    const isInside = aim !== null && outlined !== null && this.isOutlinedAt(aim, outlined);
    // A size that was chosen stays while the pointer is inside.
    if (isInside && outlined.isResized) return;
    if (!isInside) this.show(null);
    const before = aim && outlined && isSamePlace(aim, outlined.aim) ? outlined : null;
    if (aim) this.timer = setTimeout(() => void this.grow(aim, before), REST_MS);
  }

  isOutlinedAt(aim: Aim, { aim: { t, object, isRemoving }, list, at }: Outlined): boolean {
    const width = this.host.store.state.analysis?.segmentation.result.width ?? 0;
    const isSameKind = aim.t === t && aim.object === object && aim.isRemoving === isRemoving;
    return isSameKind && list[at].pixels[Math.round(aim.y) * width + Math.round(aim.x)] > 0;
  }

  /** @param before an outlined region of the same place, whose size is kept */
  async grow(aim: Aim, before: Outlined | null) {
    this.wanted = aim;
    await this.prepare();
    if (this.wanted !== aim) return;
    const growth = await this.host
      .corrector()
      ?.growRegions(aim.t, aim)
      .catch(() => null);
    if (!growth || this.wanted !== aim) return;
    const candidates = growth.regions.map((region, rank) => this.candidateOf(region, rank, aim));
    const list = candidates.filter(({ area }) => area > 0);
    const rank = before ? before.list[before.at].rank : growth.likeliest;
    const at = Math.max(0, list.indexOf(candidates[rank]));
    this.show(list.length > 0 ? { aim: { ...aim }, list, at, isResized: before?.isResized ?? false } : null);
  }

  candidateOf(region: Region, rank: number, { t, object, isRemoving }: Aim): Candidate {
    const mask = this.host.store.state.analysis?.segmentation.mask(t);
    const replaced = isRemoving ? object : 0;
    // Nothing can be removed from the background.
    const isPossible = !isRemoving || object > 0;
    const pixels = decodeRuns(region).map((inside, p) => Number(isPossible && inside > 0 && mask?.[p] === replaced));
    return { rank, region, pixels, area: pixels.reduce((sum, inside) => sum + inside, 0) };
  }

  /** Outlines the next smaller or larger region. */
  resize(by: -1 | 1) {
    const { outlined } = this;
    if (!outlined?.list[outlined.at + by]) return;
    this.show({ ...outlined, at: outlined.at + by, isResized: true });
  }

  /**
   * Returns the outlined region for a click, and outlines nothing until the pointer moves.
   * @returns null if another or no region is outlined
   */
  take(t: number, isRemoving: boolean): Region | null {
    const { outlined } = this;
    clearTimeout(this.timer);
    this.wanted = null;
    this.show(null);
    if (outlined?.aim.t !== t || outlined.aim.isRemoving !== isRemoving) return null;
    return outlined.list[outlined.at].region;
  }

  show(outlined: Outlined | null) {
    if (outlined === this.outlined) return;
    this.outlined = outlined;
    this.host.onChange();
  }
}

function isSamePlace(a: Aim, b: Aim): boolean {
  return a.t === b.t && a.x === b.x && a.y === b.y;
}

/**
 * Traces the borders of a region, also along the border of the frame. Lines pass through the middles of pixel sides, so
 * that stairs become slopes.
 * @param pixels 1 inside, row by row
 * @returns closed lines, each as x, y, x, y, …; pixel centres have whole coordinates
 */
export function traceRegion(pixels: ArrayLike<number>, width: number, height: number): number[][] {
  const sides = collectSides(pixels, width, height);
  const lines: number[][] = [];
  for (const start of sides.keys()) {
    const line: number[] = [];
    for (let corner = start, ends = sides.get(corner); ends?.length; ends = sides.get(corner)) {
      const end = ends.pop()!;
      line.push(...middleOf(corner, end, width + 1));
      corner = end;
    }
    if (line.length > 0) lines.push(line);
  }
  return lines;
}

/** Returns the sides of pixels along the border, with the region on their right: from each corner the corners they lead to. */
function collectSides(pixels: ArrayLike<number>, width: number, height: number): Map<number, number[]> {
  const sides = new Map<number, number[]>();
  const add = (from: number, to: number) => sides.set(from, [...(sides.get(from) ?? []), to]);
  const isInside = (x: number, y: number) => x >= 0 && y >= 0 && x < width && y < height && pixels[y * width + x] > 0;
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++) {
      if (!isInside(x, y)) continue;
      const upperLeft = y * (width + 1) + x;
      const [upperRight, lowerLeft] = [upperLeft + 1, upperLeft + width + 1];
      const lowerRight = lowerLeft + 1;
      if (!isInside(x, y - 1)) add(upperLeft, upperRight);
      if (!isInside(x + 1, y)) add(upperRight, lowerRight);
      if (!isInside(x, y + 1)) add(lowerRight, lowerLeft);
      if (!isInside(x - 1, y)) add(lowerLeft, upperLeft);
    }
  return sides;
}

/** @param columns corners in a row */
function middleOf(from: number, to: number, columns: number): [x: number, y: number] {
  const middle = (a: number, b: number) => (a + b) / 2 - 0.5;
  return [middle(from % columns, to % columns), middle(Math.floor(from / columns), Math.floor(to / columns))];
}
