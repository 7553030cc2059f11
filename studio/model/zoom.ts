// Which part of the clip the canvas shows: all of it, or a part enlarged that can be moved about.

/** The most that is shown enlarged, as against the whole clip in its box. */
export const MOST = 16;

/** Enlargement of one press or of one notch of a wheel. */
export const STEP = 1.25;

export class Zoom {
  /** As against the whole clip in its box, 1 to {@link MOST}. */
  by = 1;
  /** The upper left corner of what is shown, in parts of the clip's width and height. */
  x = 0;
  y = 0;

  reset() {
    this.to(1, 0.5, 0.5);
  }

  /**
   * Enlarges about a place that stays where it is on screen.
   * @param by as against the whole
   * @param u where on the canvas, in parts of its width
   * @param v and height
   */
  to(by: number, u: number, v: number) {
    const now = Math.min(MOST, Math.max(1, by));
    const [x, y] = [this.x + u / this.by, this.y + v / this.by];
    this.by = now;
    this.x = x - u / now;
    this.y = y - v / now;
    this.keepInside();
  }

  /** Moves the picture by parts of the canvas. */
  move(u: number, v: number) {
    this.x -= u / this.by;
    this.y -= v / this.by;
    this.keepInside();
  }

  /** Nothing but the clip is shown. */
  keepInside() {
    const most = 1 - 1 / this.by;
    this.x = Math.min(most, Math.max(0, this.x));
    this.y = Math.min(most, Math.max(0, this.y));
  }
}
