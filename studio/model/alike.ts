// Which objects look like one thing: they touch, and they move alike.

interface Seen {
  width: number;
  height: number;
  numFrames: number;
  /** The object of each pixel. */
  labels: (t: number) => ArrayLike<number>;
  trajectories: {
    count: number;
    startFrame: ArrayLike<number>;
    offset: ArrayLike<number>;
    x: ArrayLike<number>;
    y: ArrayLike<number>;
  };
  /** Where the background is in each frame. */
  scene: { x: ArrayLike<number>; y: ArrayLike<number> };
}

/** Frames that are looked at. */
const MOST_FRAMES = 24;

/** Objects nearly touch across this part of the picture's long side. */
const NEAR = 0.01;

/** Motions are alike that differ by less than this part of what the slower object moves against the background. */
const PART = 0.25;

/** What moves less against the background says nothing, in pixels a frame. */
const LEAST = 0.2;

/** Of what the trajectories of an object move. */
type Sum = { n: number; x: number; y: number };
type Pair = { both: number; near: number; moves: number; differ: number; a: number; b: number };

/** Returns groups of two or more objects, the largest object of each first; the largest group first. */
export function alikeObjects(seen: Seen): number[][] {
  const { width, height, numFrames, labels, scene } = seen;
  const near = Math.max(2, Math.round(NEAR * Math.max(width, height)));
  const pairs = new Map<number, Pair>();
  const sizes = new Map<number, number>();
  const every = Math.max(1, Math.ceil(numFrames / MOST_FRAMES));
  for (let t = 0; t < numFrames; t += every) {
    const mask = labels(t);
    const areas = areasOf(mask);
    for (const [object, area] of areas) sizes.set(object, (sizes.get(object) ?? 0) + area);
    const close = closePairs(mask, width, height, near);
    const moved = motions(seen, mask, t);
    const ground = { x: scene.x[t + 1] - scene.x[t], y: scene.y[t + 1] - scene.y[t] };
    for (const a of areas.keys())
      for (const b of areas.keys()) if (a < b) count(pairOf(pairs, keyOf(a, b)), moved.get(a), moved.get(b), ground);
    for (const key of close) pairOf(pairs, key).near += 1;
  }
  const links = [...pairs].filter(([, pair]) => isOne(pair)).map(([key]) => [key >> 8, key & 255]);
  return groups(links, sizes);
}

function keyOf(a: number, b: number) {
  return (Math.min(a, b) << 8) | Math.max(a, b);
}

function pairOf(pairs: Map<number, Pair>, key: number) {
  const pair = pairs.get(key) ?? { both: 0, near: 0, moves: 0, differ: 0, a: 0, b: 0 };
  pairs.set(key, pair);
  return pair;
}

function count(pair: Pair, a: Sum | undefined, b: Sum | undefined, ground: { x: number; y: number }) {
  pair.both += 1;
  if (!a || !b || Number.isNaN(ground.x)) return;
  const square = (x: number, y: number) => x * x + y * y;
  const [ax, ay, bx, by] = [a.x / a.n, a.y / a.n, b.x / b.n, b.y / b.n];
  pair.moves += 1;
  pair.differ += square(ax - bx, ay - by);
  pair.a += square(ax - ground.x, ay - ground.y);
  pair.b += square(bx - ground.x, by - ground.y);
}

function isOne({ both, near, moves, differ, a, b }: Pair) {
  const own = Math.min(a, b);
  return near > both / 2 && moves > both / 2 && own > LEAST ** 2 * moves && differ < PART ** 2 * own;
}

function areasOf(mask: ArrayLike<number>) {
  const areas = new Uint32Array(256);
  for (let p = 0; p < mask.length; p += 1) areas[mask[p]] += 1;
  return new Map([...areas.entries()].filter(([object, area]) => object > 0 && area > 0));
}

/** @param near in pixels, along a row or a column */
function closePairs(mask: ArrayLike<number>, width: number, height: number, near: number): Set<number> {
  const close = new Set<number>();
  // What was met last, and where: along each row, and down each column.
  const row = { object: 0, at: 0 };
  const columns = Array.from({ length: width }, () => ({ object: 0, at: 0 }));
  const meet = (last: typeof row, object: number, at: number) => {
    if (last.object > 0 && last.object !== object && at - last.at <= near) close.add(keyOf(last.object, object));
    last.object = object;
    last.at = at;
  };
  for (let y = 0; y < height; y += 1) {
    row.object = 0;
    for (let x = 0; x < width; x += 1) {
      const object = mask[y * width + x];
      if (object === 0) continue;
      meet(row, object, x);
      meet(columns[x], object, y);
    }
  }
  return close;
}

/** Returns the motion of each object to the next frame. */
function motions({ width, height, trajectories }: Seen, mask: ArrayLike<number>, t: number): Map<number, Sum> {
  const { count, startFrame, offset, x, y } = trajectories;
  const sums = new Map<number, Sum>();
  for (let i = 0; i < count; i += 1) {
    const at = offset[i] + t - startFrame[i];
    if (at < offset[i] || at + 1 >= offset[i + 1]) continue;
    const [px, py] = [Math.round(x[at]), Math.round(y[at])];
    const object = px >= 0 && py >= 0 && px < width && py < height ? mask[py * width + px] : 0;
    if (object === 0) continue;
    const sum = sums.get(object) ?? { n: 0, x: 0, y: 0 };
    sums.set(object, { n: sum.n + 1, x: sum.x + x[at + 1] - x[at], y: sum.y + y[at + 1] - y[at] });
  }
  return sums;
}

function groups(links: number[][], sizes: Map<number, number>) {
  const of = new Map<number, Set<number>>();
  for (const [a, b] of links) {
    const joined = new Set([...(of.get(a) ?? [a]), ...(of.get(b) ?? [b])]);
    for (const object of joined) of.set(object, joined);
  }
  const bySize = (a: number, b: number) => (sizes.get(b) ?? 0) - (sizes.get(a) ?? 0);
  return [...new Set(of.values())].map((group) => [...group].sort(bySize)).sort((a, b) => b.length - a.length);
}
