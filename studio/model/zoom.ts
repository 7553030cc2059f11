// The visible part of the clip on the canvas.

/** Largest scale relative to the whole clip; chosen by eye. */
export const MAX_SCALE = 16;

/** Scale factor of one key press or wheel notch; chosen by eye. */
export const SCALE_STEP = 1.25;

export class Zoom {
  /** Scale relative to the whole clip, 1 to {@link MAX_SCALE}. */
  scale = 1;
  /** Upper left corner of the visible part, as shares of the clip's width and height. */
  x = 0;
  y = 0;

  reset() {
    this.zoomTo(1, 0.5, 0.5);
  }

  /**
   * Zooms about a fixed point of the canvas.
   * @param scale relative to the whole clip
   * @param u as a share of the canvas's width
   * @param v as a share of its height
   */
  zoomTo(scale: number, u: number, v: number) {
    const clamped = Math.min(MAX_SCALE, Math.max(1, scale));
    const [x, y] = [this.x + u / this.scale, this.y + v / this.scale];
    this.scale = clamped;
    this.x = x - u / clamped;
    this.y = y - v / clamped;
    this.keepInside();
  }

  /** Moves the picture by shares of the canvas. */
  pan(u: number, v: number) {
    this.x -= u / this.scale;
    this.y -= v / this.scale;
    this.keepInside();
  }

  /** Keeps the visible part inside the clip. */
  keepInside() {
    const limit = 1 - 1 / this.scale;
    this.x = Math.min(limit, Math.max(0, this.x));
    this.y = Math.min(limit, Math.max(0, this.y));
  }
}
