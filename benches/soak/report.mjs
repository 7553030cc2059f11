// A soak in words and lines: tables for the documentation, curves as SVG.

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
export function tables(results, { node, cores }) {
  const lines = [
    `Node ${node} on ${cores} cores. Heap is \`heapUsed\` + \`external\` after collecting garbage (of the page: scripts and objects of the browser that are`,
    'alive), RSS what the process holds (of the page: without what it shares); the slope is that of the second half: the median between any two',
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

const [WIDTH, HEIGHT, LEFT, TOP] = [360, 160, 50, 24];

/** @param {Soaked[]} results */
export function curves(results) {
  const rows = results.map((result, k) => panel(result, k * (HEIGHT + 56)));
  const height = results.length * (HEIGHT + 56) + 10;
  const style =
    'text{font:12px sans-serif;fill:#555}path{fill:none;stroke-width:1.5}.heap{stroke:#2b6cb0}.rss{stroke:#b7791f}';
  const open = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${WIDTH + LEFT + 60} ${height}">`;
  return `${open}<style>${style}</style>\n${rows.join('\n')}\n</svg>\n`;
}

/** @param {Soaked} result @param {number} down */
function panel({ part, unit, count, points }, down) {
  const most = Math.max(...points.map(({ rss, heap }) => Math.max(rss, heap)));
  const line = (/** @type {'heap' | 'rss'} */ key) => {
    const at = points.map((point) => [LEFT + (point.done / count) * WIDTH, TOP + HEIGHT * (1 - point[key] / most)]);
    return `<path class="${key}" d="M${at.map((place) => place.map((v) => v.toFixed(1)).join(' ')).join('L')}"/>`;
  };
  const text = (/** @type {number} */ x, /** @type {number} */ y, /** @type {string} */ words) =>
    `<text x="${x}" y="${y}">${words}</text>`;
  const frame = `<path stroke="#ccc" d="M${LEFT} ${TOP}V${TOP + HEIGHT}H${LEFT + WIDTH}"/>`;
  return `<g transform="translate(0 ${down})">${[
    text(LEFT, 16, `${part}: MB over ${count} × a ${unit}; heap blue, RSS brown`),
    text(4, TOP + 8, megabytes(most)),
    text(4, TOP + HEIGHT, '0'),
    frame,
    line('heap'),
    line('rss'),
  ].join('')}</g>`;
}
