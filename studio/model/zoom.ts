// Which part of the clip the canvas shows: all of it, or a part enlarged that can be moved about.

/** The most that is shown enlarged, as against the whole clip in its box. */
export const MAX_SCALE = 16;

/** Enlargement of one press or of one notch of a wheel. */
export const SCALE_STEP = 1.25;

export class Zoom {
  /** As against the whole clip in its box, 1 to {@link MAX_SCALE}. */
  scale = 1;
  /** The upper left corner of what is shown, in parts of the clip's width and height. */
  x = 0;
  y = 0;

  reset() {
    this.zoomTo(1, 0.5, 0.5);
  }

  /**
   * Enlarges about a place that stays where it is on screen.
   * @param scale as against the whole
   * @param u where on the canvas, in parts of its width
   * @param v and height
   */
  zoomTo(scale: number, u: number, v: number) {
    const clamped = Math.min(MAX_SCALE, Math.max(1, scale));
    const [x, y] = [this.x + u / this.scale, this.y + v / this.scale];
    this.scale = clamped;
    this.x = x - u / clamped;
    this.y = y - v / clamped;
    this.keepInside();
  }

  /** Moves the picture by parts of the canvas. */
  pan(u: number, v: number) {
    this.x -= u / this.scale;
    this.y -= v / this.scale;
    this.keepInside();
  }

  /** Nothing but the clip is shown. */
  keepInside() {
    const limit = 1 - 1 / this.scale;
    this.x = Math.min(limit, Math.max(0, this.x));
    this.y = Math.min(limit, Math.max(0, this.y));
  }
}
