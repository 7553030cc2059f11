// `npm run soak`: memory over a thousand sessions in one process, a hundred at once, hours of windows, a page left running:
// each in a process of its own, measured after collecting garbage. `npm run soak -- sessions=200 page=50` runs these
// two, 200 and 50 times; results go into `docs/reliability.md` with `--write`.

import { spawn } from 'node:child_process';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { availableParallelism } from 'node:os';
import { join } from 'node:path';
import { build } from '../scripts/build.mjs';
import { fail, root } from '../scripts/tools.mjs';

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

/** How many times each is done. */
const USUALLY = { sessions: 1000, crowd: 20, windows: 12000, page: 2000 };
/** Bytes that a session or a window may leave behind. */
const MOST_SLOPE = 1024;

const megabytes = (/** @type {number} */ bytes) => (bytes / 1e6).toFixed(1);
const args = process.argv.slice(2);
const asked = Object.fromEntries(args.filter((arg) => !arg.startsWith('-')).map((arg) => arg.split('=')));

/**
 * Runs one part to its end.
 * @param {string} part
 * @param {number} count
 * @returns {Promise<Soaked>}
 */
function soaked(part, count) {
  const script = join(root, 'benches', 'soak', part === 'page' ? 'page.mjs' : 'node.mjs');
  return new Promise((done, failed) => {
    const child = spawn(process.execPath, ['--expose-gc', script, String(count), part], {
      stdio: ['ignore', 'pipe', 'inherit'],
    });
    let text = '';
    child.stdout.on('data', (data) => (text += data));
    child.on('close', (code) =>
      code === 0 ? done(JSON.parse(text)) : failed(new Error(`${part} ended with ${code}`)),
    );
  });
}

const chosen = Object.keys(asked).length > 0 ? Object.keys(asked) : Object.keys(USUALLY);
const unknown = chosen.find((part) => !(part in USUALLY));
if (unknown) fail(`There is no part "${unknown}" (expected ${Object.keys(USUALLY).join(', ')}).`);
await build();
const results = [];
for (const part of chosen) results.push(await soaked(part, Number(asked[part] ?? USUALLY[part])));
mkdirSync(join(root, 'out'), { recursive: true });
writeFileSync(join(root, 'out', 'soak.json'), JSON.stringify(results, null, 2));
const text = table(results, { node: process.version, cores: availableParallelism() });
console.log(text);
if (args.includes('--write')) {
  const file = join(root, 'docs', 'reliability.md');
  const place = /(<!-- soak: npm run soak -- --write -->\n)[\s\S]*?(<!-- \/soak -->)/;
  writeFileSync(
    file,
    readFileSync(file, 'utf8').replace(place, (_, from, to) => `${from}\n${text}\n${to}`),
  );
}
// What a process holds goes up and down by megabytes: only over many does that tell anything.
const steep = results.filter(({ count, slope: { heap, rss } }) => Math.max(heap, count < 1000 ? 0 : rss) > MOST_SLOPE);
if (steep.length > 0) fail(`Memory grows: ${steep.map(({ part }) => part).join(', ')}.`);

/**
 * @param {Soaked[]} results
 * @param {{node: string, cores: number}} machine
 */
function table(results, { node, cores }) {
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
