// How seconds grow: the exponent of frames, pixels and objects for each stage, and what more threads would give.

/** Stages that other threads take work of; the rest is done by one. Masks and flow wait for nothing else. */
const SHARED = new Set(['flow', 'superpixels', 'masks']);
const THREADS = [2, 4, 8, 16];

/**
 * The slope of the line through (ln size, ln seconds) by least squares: 1 is linear growth.
 * @param {{size: number, seconds: number}[]} points at least two sizes
 */
export function exponent(points) {
  const logs = points.map(({ size, seconds }) => [Math.log(size), Math.log(Math.max(seconds, 1e-6))]);
  const mean = (k) => logs.reduce((sum, log) => sum + log[k], 0) / logs.length;
  const [x, y] = [mean(0), mean(1)];
  const slope = logs.reduce((sum, log) => sum + (log[0] - x) * (log[1] - y), 0);
  return slope / logs.reduce((sum, log) => sum + (log[0] - x) ** 2, 0);
}

/**
 * The share of a run that one thread does alone, and the least time on more threads as a part of that on one (Amdahl).
 * Superpixels also fill the time in which the first thread is alone, which makes no difference to this bound.
 * @param {Record<string, number>} seconds of each stage on one thread
 */
export function bound(seconds) {
  const all = Object.values(seconds).reduce((sum, s) => sum + s, 0);
  const shared = Object.entries(seconds).reduce((sum, [stage, s]) => sum + (SHARED.has(stage) ? s : 0), 0);
  const serial = 1 - shared / all;
  return { serial, wall: THREADS.map((threads) => [threads, Math.max(serial, 1 / threads)]) };
}

/**
 * Prints how the stages grow along one axis.
 * @param {string} axis what grows
 * @param {string[]} stages
 * @param {{size: number, row: {seconds: Record<string, number>, memoryBytes: number}}[]} runs
 */
export function printGrowth(axis, stages, runs) {
  const slope = (secondsOf) => exponent(runs.map(({ size, row }) => ({ size, seconds: secondsOf(row) }))).toFixed(2);
  const sum = ({ seconds }) => stages.reduce((total, stage) => total + seconds[stage], 0);
  const of = stages.map((stage) => `${stage} ${slope(({ seconds }) => seconds[stage])}`);
  const sizes = runs.map(({ size }) => size).join(', ');
  const memory = slope(({ memoryBytes }) => memoryBytes);
  console.log(`growth in ${axis} (${sizes}): all ${slope(sum)}, memory ${memory}; ${of.join(', ')}`);
}
