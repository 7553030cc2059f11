/**
 * Outlines of labelled regions by marching squares: straight lines between the middles of neighbouring pixels of
 * different labels, so that stairs become slopes. They stay open along the rim.
 */

/** Middles of the sides of a square between four pixel centres, clockwise from the upper one. */
const MIDDLES = /** @type {const} */ ([
  [0.5, 0],
  [1, 0.5],
  [0.5, 1],
  [0, 0.5],
]);

/**
 * @param {Uint8Array} labels row by row
 * @param {number} width
 * @param {number} height
 * @param {Uint8Array} chosen 1 for each label that is to have an outline
 * @returns {Map<number, number[]>} for each label its pieces, each as x0, y0, x1, y1; pixel centres have whole
 *   coordinates
 */
export function outlines(labels, width, height, chosen) {
  /** @type {Map<number, number[]>} */
  const pieces = new Map();
  for (let y = 0; y + 1 < height; y += 1) {
    for (let x = 0; x + 1 < width; x += 1) {
      const at = y * width + x;
      const a = Number(labels[at]);
      const b = Number(labels[at + 1]);
      const c = Number(labels[at + width + 1]);
      const d = Number(labels[at + width]);
      if (a === b && b === c && c === d) continue;
      const corners = [a, b, c, d];
      corners.forEach((own, k) => {
        if (!chosen[own] || corners.indexOf(own) !== k) return;
        const known = pieces.get(own) ?? [];
        pieces.set(own, known);
        addSquare(
          known,
          x,
          y,
          corners.map((other) => other === own),
        );
      });
    }
  }
  return pieces;
}

/**
 * @param {number[]} pieces
 * @param {number} x of the upper left pixel
 * @param {number} y
 * @param {boolean[]} inside clockwise from the upper left
 */
function addSquare(pieces, x, y, inside) {
  const crossed = [0, 1, 2, 3].filter((side) => inside[side] !== inside[(side + 1) % 4]);
  // Where two opposite corners are inside, each is cut off from the other.
  if (crossed.length === 4 && !inside[0]) crossed.push(Number(crossed.shift()));
  for (let k = 0; k < crossed.length; k += 2) {
    const [from, to] = crossed.length === 4 ? [crossed[(k + 3) % 4], crossed[k]] : crossed;
    const [[x0, y0], [x1, y1]] = [MIDDLES[Number(from)] ?? MIDDLES[0], MIDDLES[Number(to)] ?? MIDDLES[0]];
    pieces.push(x + x0, y + y0, x + x1, y + y1);
  }
}

/**
 * Strokes pieces of lines in one go.
 * @param {import('./canvas.js').Context2D} context
 * @param {ArrayLike<number>} pieces each x0, y0, x1, y1
 */
export function strokePieces(context, pieces) {
  context.beginPath();
  for (let k = 0; k < pieces.length; k += 4) {
    context.moveTo(Number(pieces[k]), Number(pieces[k + 1]));
    context.lineTo(Number(pieces[k + 2]), Number(pieces[k + 3]));
  }
  context.stroke();
}
