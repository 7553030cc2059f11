// Shared by the parts of the soak test: synthetic clips, memory samples and their slope.

import { setTimeout as pause } from 'node:timers/promises';

/** Number of points of a curve; the first half is the warm-up. */
const POINTS = 20;

/**
 * Runs `work` `count` times and measures memory in between, after collecting garbage.
 * @param {string} part
 * @param {string} unit name of one repetition
 * @param {number} count
 * @param {(k: number) => Promise<void>} work
 * @param {() => Promise<{heap: number, rss: number}>} [measure]
 * @returns {Promise<import('../soak.mjs').SoakResult>}
 */
export async function soak(part, unit, count, work, measure = processMemory) {
  const points = [];
  const every = Math.max(1, Math.floor(count / POINTS));
  const began = process.cpuUsage();
  for (let k = 1; k <= count; k += 1) {
    await work(k);
    if (k % every === 0) points.push({ done: k, ...(await measure()) });
  }
  const { user, system } = process.cpuUsage(began);
  const cpuSeconds = Math.round((user + system) / 1e5) / 10;
  const late = points.slice(points.length >> 1);
  const slope = { heap: slopeOf(late, 'heap'), rss: slopeOf(late, 'rss') };
  return { part, unit, count, cpuSeconds, points, slope };
}

/** Returns the memory of this process in bytes; `rss` includes wasm memories. */
async function processMemory() {
  // Finalizers run in a separate task.
  for (let k = 0; k < 3; k += 1) {
    globalThis.gc();
    await pause(10);
  }
  const { heapUsed, external, rss } = process.memoryUsage();
  return { heap: heapUsed + external, rss };
}

/** Returns the bytes per repetition: the median slope between any two points, which single outliers do not move. */
function slopeOf(points, key) {
  const slopes = points.flatMap((from, k) =>
    points.slice(k + 1).map((to) => (to[key] - from[key]) / (to.done - from.done)),
  );
  slopes.sort((a, b) => a - b);
  return (slopes[(slopes.length - 1) >> 1] + slopes[slopes.length >> 1]) / 2;
}

/** Returns the pixels of frame `t` of an endless clip: a square that moves to and fro over noise. */
export function madeFrame(t, width = 48, height = 36) {
  const data = new Uint8ClampedArray(4 * width * height);
  const left = 4 + Math.abs((t % 40) - 20);
  for (let p = 0; p < width * height; p += 1) {
    const [x, y] = [p % width, Math.floor(p / width)];
    const inside = x >= left && x < left + 14 && y >= 10 && y < 26;
    const value = inside ? grain(x - left, y, 2) : grain(x, y, 1);
    data.set([value, value, inside ? 255 - value : value, 255], 4 * p);
  }
  return { data, width, height };
}

function grain(x, y, salt) {
  const h = Math.imul((x >> 1) + 7, 374761393) ^ Math.imul((y >> 1) + 3, 668265263) ^ Math.imul(salt, 2246822519);
  const mixed = Math.imul(h ^ (h >>> 13), 1274126177);
  return 60 + (((mixed ^ (mixed >>> 16)) >>> 0) % 160);
}
