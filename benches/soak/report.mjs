// A soak as a table for the documentation.

/**
 * What came of one part: memory in bytes after a number of them was done, and what one more costs after the warm-up.
 * @typedef {object} Soaked
 * @property {string} part
 * @property {string} unit
 * @property {number} count
 * @property {number | null} cpuSeconds
 * @property {number} [frames]
 * @property {{done: number, heap: number, rss: number}[]} points
 * @property {{heap: number, rss: number}} slope
 */

const MB = 1e6;
const megabytes = (/** @type {number} */ bytes) => (bytes / MB).toFixed(1);

/**
 * @param {Soaked[]} results
 * @param {{node: string, cores: number}} machine
 */
export function table(results, { node, cores }) {
  const lines = [
    `Node ${node} on ${cores} cores. Heap is \`heapUsed\` + \`external\` after collecting garbage (of the page: scripts and objects of the browser that are`,
    'alive), RSS what the process holds (of the page: without what it shares); the slope is measured over the second half: the median between any two',
    'of its points, for each session, window or clip.',
    '',
    '| what | done | heap at first, half, end (MB) | RSS at first, half, end (MB) | slope of heap, RSS (bytes) |',
    '|---|---|---|---|---|',
  ];
  for (const { part, unit, count, frames, points, slope } of results) {
    const three = [points[0], points[points.length >> 1], points.at(-1)];
    const of = (/** @type {'heap' | 'rss'} */ key) => three.map((point) => megabytes(point[key])).join(', ');
    const done = `${count} × a ${unit}${frames ? `, ${frames} frames` : ''}`;
    lines.push(
      `| ${part} | ${done} | ${of('heap')} | ${of('rss')} | ${slope.heap.toFixed(0)}, ${slope.rss.toFixed(0)} |`,
    );
  }
  return `${lines.join('\n')}\n`;
}
