// Synthetic frames for tests in the browser and in Node.

/** Returns a frame of one colour, or with the colours `color(x, y)`. */
export function plainFrame(width, height, color = () => [0, 0, 0]) {
  const data = new Uint8ClampedArray(4 * width * height);
  for (let p = 0; p < width * height; p += 1) {
    [data[4 * p], data[4 * p + 1], data[4 * p + 2]] = color(p % width, Math.floor(p / width));
    data[4 * p + 3] = 255;
  }
  return { data, width, height };
}

/** Grey value of a texture of 2x2 blocks; another texture for each `salt`. */
export function textureAt(x, y, salt = 0) {
  const h = Math.imul((x >> 1) + 7, 374761393) ^ Math.imul((y >> 1) + 3, 668265263) ^ Math.imul(salt, 2246822519);
  const mixed = Math.imul(h ^ (h >>> 13), 1274126177);
  return 60 + (((mixed ^ (mixed >>> 16)) >>> 0) % 160);
}

/** A textured background that stands still, a moving square, and a resting disc: 110 frames are three windows. */
export function movingFrames(count, [width, height]) {
  return Array.from({ length: count }, (_, t) => {
    const squareX = 10 + (t % 80 < 40 ? t % 40 : 40 - (t % 40));
    return plainFrame(width, height, (x, y) => {
      if ((x - 76) ** 2 + (y - 14) ** 2 < 64) return [230, 40, 40];
      const inside = x >= squareX && x < squareX + 26 && y >= 24 && y < 52;
      const value = inside ? textureAt(x - squareX, y, 2) : textureAt(x, y, 1);
      return [value, value, inside ? 255 - value : value];
    });
  });
}

/** A textured picture that shifts by `speed` pixels a frame as a whole. */
export function shiftingFrames(count, speed, [width, height]) {
  return Array.from({ length: count }, (_, t) =>
    plainFrame(width, height, (x, y) => {
      const value = textureAt(x + speed * t, y);
      return [value, value, value];
    }),
  );
}
