/** Pictures of labelled pixels: a colour for each region, and lines between regions that are half a pixel wide. @module */

/** Pixels of the picture along a pixel of the labels: lines take the outermost of them. */
const FINE = 3;

/**
 * @param {number} r 0..255
 * @param {number} g
 * @param {number} b
 * @param {number} a
 * @returns {number} the colour as four bytes in memory order
 */
export function packed(r, g, b, a) {
  return new Uint32Array(new Uint8ClampedArray([r, g, b, a]).buffer)[0];
}

/**
 * @param {ArrayLike<number>} label of each pixel, row by row
 * @param {number} width
 * @param {number} height
 * @param {ArrayLike<number>} fill packed colour of each label
 * @param {ArrayLike<number>} line packed colour of each label's pixels along other labels; 0 for no line
 * @returns {OffscreenCanvas} to be drawn over `width` × `height` pixels
 */
export function paintRegions(label, width, height, fill, line) {
  const image = new ImageData(FINE * width, FINE * height);
  const pixels = new Uint32Array(image.data.buffer);
  const stride = FINE * width;
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      const at = y * width + x;
      const own = label[at];
      const corner = FINE * (y * stride + x);
      const inside = fill[own];
      for (let row = 0; row < FINE; row++) pixels.fill(inside, corner + row * stride, corner + row * stride + FINE);
      const edge = line[own];
      if (edge === 0) continue;
      if (x > 0 && label[at - 1] !== own) for (let k = 0; k < FINE; k++) pixels[corner + k * stride] = edge;
      if (x + 1 < width && label[at + 1] !== own) for (let k = 0; k < FINE; k++) pixels[corner + k * stride + FINE - 1] = edge;
      if (y > 0 && label[at - width] !== own) pixels.fill(edge, corner, corner + FINE);
      if (y + 1 < height && label[at + width] !== own) {
        pixels.fill(edge, corner + (FINE - 1) * stride, corner + (FINE - 1) * stride + FINE);
      }
    }
  }
  const canvas = new OffscreenCanvas(FINE * width, FINE * height);
  canvas.getContext('2d')?.putImageData(image, 0, 0);
  return canvas;
}
