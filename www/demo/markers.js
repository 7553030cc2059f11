/** Points of trajectories, and the ways that they came. @module */

/** @typedef {import('./layer.js').View} View */
/** @typedef {import('./points.js').Points} Points */

/** Radius of a point against the distance between points, and its bounds in CSS pixels. */
const RADIUS = { share: 0.17, least: 1.1, most: 4 };

/**
 * @param {View} view with a result
 * @returns {number} radius of a point in clip pixels
 */
export function markerRadius(view) {
  const wanted = (RADIUS.share * /** @type {Points} */ (view.points).spacing(view.frame)) / view.unit;
  return Math.min(RADIUS.most, Math.max(RADIUS.least, wanted)) * view.unit;
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {View} view with a result
 * @param {Iterable<number>} ids trajectories alive in the frame
 * @param {{color: string, strength: number, width: number}} style opacity at the point, width in CSS pixels
 * @param {number} length frames back
 */
export function drawTrails(ctx, view, ids, { color, strength, width }, length) {
  const points = /** @type {Points} */ (view.points);
  const { x, y } = points.result.trajectories;
  ctx.lineCap = 'round';
  ctx.strokeStyle = color;
  ctx.lineWidth = width * view.unit;
  // One path per age: each step back in time is a little fainter.
  for (let back = length; back >= 1; back--) {
    ctx.globalAlpha = strength * (1 - back / (length + 1));
    ctx.beginPath();
    for (const id of ids) {
      const from = points.index(id, view.frame - back);
      if (from < 0) continue;
      ctx.moveTo(x[from], y[from]);
      ctx.lineTo(x[from + 1], y[from + 1]);
    }
    ctx.stroke();
  }
  ctx.globalAlpha = 1;
}

/**
 * Points, with a dark rim that keeps their colours legible on bright footage unless they may be faint.
 *
 * @param {CanvasRenderingContext2D} ctx
 * @param {View} view with a result
 * @param {Iterable<number>} ids trajectories alive in the frame
 * @param {{color: string, radius: number, shape?: import('./palette.js').Shape, rim?: boolean}} style radius in clip pixels
 */
export function drawMarkers(ctx, view, ids, { color, radius, shape = 'disc', rim = true }) {
  if (rim) {
    ctx.fillStyle = 'rgb(0 0 0 / 0.5)';
    fillMarkers(ctx, view, ids, shape, radius + 0.6 * view.unit);
  }
  ctx.fillStyle = color;
  fillMarkers(ctx, view, ids, shape, radius);
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {View} view
 * @param {Iterable<number>} ids
 * @param {import('./palette.js').Shape} shape
 * @param {number} radius clip pixels
 */
function fillMarkers(ctx, view, ids, shape, radius) {
  const points = /** @type {Points} */ (view.points);
  const { x, y } = points.result.trajectories;
  ctx.beginPath();
  for (const id of ids) {
    const at = points.index(id, view.frame);
    if (shape === 'disc') {
      ctx.moveTo(x[at] + radius, y[at]);
      ctx.arc(x[at], y[at], radius, 0, 2 * Math.PI);
    } else if (shape === 'square') {
      ctx.rect(x[at] - radius, y[at] - radius, 2 * radius, 2 * radius);
    } else {
      addDiamond(ctx, x[at], y[at], 1.3 * radius);
    }
  }
  ctx.fill();
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {number} x
 * @param {number} y
 * @param {number} radius
 */
function addDiamond(ctx, x, y, radius) {
  ctx.moveTo(x, y - radius);
  ctx.lineTo(x + radius, y);
  ctx.lineTo(x, y + radius);
  ctx.lineTo(x - radius, y);
  ctx.closePath();
}
