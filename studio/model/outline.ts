// Outlines of regions as closed lines, which can be dashed.

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
