// Measures how the seconds of a run grow with the frames and pixels of a clip.

const FRAMES = { size: [480, 270], counts: [20, 40, 80] };
const PIXELS = {
  sizes: [
    [240, 135],
    [480, 270],
    [960, 540],
  ],
  count: 20,
};
const ROUNDS = 2;

/**
 * Prints the exponents of all stages together and of each: 1 is linear growth.
 * @param {(width: number, height: number, frames: number) => Record<string, number>} run processor seconds of each stage
 */
export function growth(run) {
  const [width, height] = FRAMES.size;
  const along = (axis, places) => {
    const rows = places.map(([amount, ...clip]) => [amount, least(() => run(...clip))]);
    const slope = (seconds) => exponent(rows.map(([amount, row]) => [amount, seconds(row)])).toFixed(2);
    const all = slope((row) => Object.values(row).reduce((sum, seconds) => sum + seconds));
    const stages = Object.keys(rows[0][1]).map((stage) => {
      const seconds = rows.map(([, row]) => row[stage].toFixed(2));
      return `${stage} ${slope((row) => row[stage])} (${seconds.join(', ')} s)`;
    });
    console.log(`growth with ${axis}, ${rows.map(([amount]) => amount).join(', ')}: all ${all}; ${stages.join(', ')}`);
  };
  along(
    'frames',
    FRAMES.counts.map((count) => [count, width, height, count]),
  );
  along(
    'pixels',
    PIXELS.sizes.map(([width, height]) => [width * height, width, height, PIXELS.count]),
  );
}

/** Returns the minimum seconds of each stage over some runs. */
function least(run) {
  const runs = Array.from({ length: ROUNDS }, run);
  return Object.fromEntries(Object.keys(runs[0]).map((stage) => [stage, Math.min(...runs.map((row) => row[stage]))]));
}

/** Returns the slope of the least-squares line through (ln amount, ln seconds). */
function exponent(points) {
  const logs = points.map(([amount, seconds]) => [Math.log(amount), Math.log(Math.max(seconds, 1e-4))]);
  const mean = (k) => logs.reduce((sum, log) => sum + log[k], 0) / logs.length;
  const [x, y] = [mean(0), mean(1)];
  const along = logs.reduce((sum, log) => sum + (log[0] - x) * (log[1] - y), 0);
  return along / logs.reduce((sum, log) => sum + (log[0] - x) ** 2, 0);
}
