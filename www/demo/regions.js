/** Pictures of labelled pixels: a colour for each label, lines between regions, outlines. @module */

/** Pixels of a picture with lines along one pixel of the labels: lines take the outermost of them. */
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
 * @returns {OffscreenCanvas} of `width` × `height` pixels
 */
export function paintLabels(label, width, height, fill) {
  const image = new ImageData(width, height);
  const pixels = new Uint32Array(image.data.buffer);
  for (let p = 0; p < pixels.length; p++) pixels[p] = fill[label[p]];
  return toCanvas(image);
}

/**
 * As `paintLabels`, with a line around each region.
 *
 * @param {ArrayLike<number>} label
 * @param {number} width
 * @param {number} height
 * @param {ArrayLike<number>} fill
 * @param {number} line packed colour
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
      if (x > 0 && label[at - 1] !== own) for (let k = 0; k < FINE; k++) pixels[corner + k * stride] = line;
      if (x + 1 < width && label[at + 1] !== own) for (let k = 0; k < FINE; k++) pixels[corner + k * stride + FINE - 1] = line;
      if (y > 0 && label[at - width] !== own) pixels.fill(line, corner, corner + FINE);
      if (y + 1 < height && label[at + width] !== own) {
        pixels.fill(line, corner + (FINE - 1) * stride, corner + (FINE - 1) * stride + FINE);
      }
    }
  }
  return toCanvas(image);
}

/**
 * @param {{width: number, height: number}} size of the map, whose pixels may be larger than those of the clip
 * @param {Float32Array} values
 * @param {{width: number, height: number}} clip
 * @param {{x: number, y: number}} place in clip pixels
 * @returns {number | undefined} the map's value there; undefined outside of the frame
 */
export function valueAt(size, values, clip, place) {
  const x = Math.floor(((place.x + 0.5) / clip.width) * size.width);
  const y = Math.floor(((place.y + 0.5) / clip.height) * size.height);
  return x >= 0 && y >= 0 && x < size.width && y < size.height ? values[y * size.width + x] : undefined;
}

/** @param {ImageData} image */
export function toCanvas(image) {
  const canvas = new OffscreenCanvas(image.width, image.height);
  canvas.getContext('2d')?.putImageData(image, 0, 0);
  return canvas;
}

/**
 * The outlines of labelled regions by marching squares: straight lines between the middles of neighbouring pixels of different labels,
 * so that stairs become slopes. They stay open along the rim.
 *
 * @param {ArrayLike<number>} label of each pixel, row by row
 * @param {number} width
 * @param {number} height
 * @param {number} count number of labels
 * @returns {Path2D[]} for each label, pixel centres at whole coordinates; none for label 0
 */
export function outlines(label, width, height, count) {
  const paths = Array.from({ length: count }, () => new Path2D());
  for (let y = 0; y + 1 < height; y++) {
    for (let x = 0; x + 1 < width; x++) {
      const at = y * width + x;
      const corners = [label[at], label[at + 1], label[at + width + 1], label[at + width]];
      const [a, b, c, d] = corners;
      if (a === b && b === c && c === d) continue;
      corners.forEach((own, k) => {
        if (own > 0 && corners.indexOf(own) === k) addSquare(paths[own], x, y, corners.map((other) => other === own));
      });
    }
  }
  return paths;
}

/** Middles of the sides of a square between four pixel centres, clockwise from the upper one. */
const MIDDLES = [[0.5, 0], [1, 0.5], [0.5, 1], [0, 0.5]];

/**
 * @param {Path2D} path
 * @param {number} x of the upper left pixel
 * @param {number} y
 * @param {boolean[]} inside clockwise from the upper left
 */
function addSquare(path, x, y, inside) {
  const crossed = [0, 1, 2, 3].filter((side) => inside[side] !== inside[(side + 1) % 4]);
  // Where two opposite corners are inside, each is cut off from the other.
  if (crossed.length === 4 && !inside[0]) crossed.push(crossed.shift() ?? 0);
  for (let k = 0; k < crossed.length; k += 2) {
    const [from, to] = crossed.length === 4 ? [crossed[(k + 3) % 4], crossed[k]] : crossed;
    path.moveTo(x + MIDDLES[from][0], y + MIDDLES[from][1]);
    path.lineTo(x + MIDDLES[to][0], y + MIDDLES[to][1]);
  }
}
