// `npm run soak`: memory over a thousand sessions in one process, a hundred at once, hours of windows, a page left running:
// each in its own process, measured after collecting garbage. `npm run soak -- sessions=200 page=50` runs only these two,
// 200 and 50 times; `--write` updates `docs/reliability.md`. `npm run soak -- long=18000` segments ten minutes of 1080p with the
// package in Node, and `pipe=18000` with the command line, and prints memory and seconds of a frame for each tenth, and how
// true the time left was; `long=1200` takes a fifteenth of the time.

import { spawn } from 'node:child_process';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { availableParallelism } from 'node:os';
import { join } from 'node:path';
import { build } from '../scripts/build.mjs';
import { fail, root } from '../scripts/tools.mjs';

/**
 * The result of one part: memory in bytes after a number of repetitions, and the growth per repetition after the warm-up.
 * @typedef {object} SoakResult
 * @property {string} part
 * @property {string} unit
 * @property {number} count
 * @property {number | null} cpuSeconds
 * @property {number} [frames]
 * @property {{done: number, heap: number, rss: number}[]} points
 * @property {{heap: number, rss: number}} slope
 */

/** Default number of repetitions. */
const DEFAULT_COUNTS = { sessions: 1000, crowd: 20, windows: 12000, page: 2000 };
/** Parts that segment one long clip; run only if they are asked for. */
const LONG_PARTS = ['long', 'pipe'];
/** Maximum growth per session or window, in bytes. */
const MAX_SLOPE = 1024;

const megabytes = (/** @type {number} */ bytes) => (bytes / 1e6).toFixed(1);
const args = process.argv.slice(2);
const asked = Object.fromEntries(args.filter((arg) => !arg.startsWith('-')).map((arg) => arg.split('=')));

/**
 * Runs one part.
 * @param {string} part
 * @param {number} count
 * @returns {Promise<SoakResult>}
 */
function runPart(part, count) {
  const name = LONG_PARTS.includes(part) ? 'long.mjs' : 'parts.mjs';
  const script = join(root, 'benches', 'soak', name);
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

const chosen = Object.keys(asked).length > 0 ? Object.keys(asked) : Object.keys(DEFAULT_COUNTS);
const parts = [...Object.keys(DEFAULT_COUNTS), ...LONG_PARTS];
const unknown = chosen.find((part) => !parts.includes(part));
if (unknown) fail(`There is no part "${unknown}" (expected ${parts.join(', ')}).`);
await build();
for (const part of LONG_PARTS.filter((name) => name in asked))
  console.log(formatLong(await runPart(part, Number(asked[part]))));
if (chosen.every((part) => LONG_PARTS.includes(part))) process.exit();
const results = [];
for (const part of chosen.filter((name) => !LONG_PARTS.includes(name)))
  results.push(await runPart(part, Number(asked[part] ?? DEFAULT_COUNTS[part])));
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
// The memory of a process fluctuates by megabytes, so slopes mean something only over many repetitions.
const steep = results.filter(({ count, slope: { heap, rss } }) => Math.max(heap, count < 1000 ? 0 : rss) > MAX_SLOPE);
if (steep.length > 0) fail(`Memory grows: ${steep.map(({ part }) => part).join(', ')}.`);

/**
 * @param {SoakResult[]} results
 * @param {{node: string, cores: number}} machine
 */
function table(results, { node, cores }) {
  const lines = [
    `Node ${node} on ${cores} cores. Heap is \`heapUsed\` + \`external\` after garbage collection (for the page: live objects of scripts and browser),`,
    'RSS the resident memory of the process (for the page: without shared memory). The slope is per session, window or clip: the median between any',
    'two points of the second half.',
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

/** Formats the tenths of a long clip. */
function formatLong({ part, count, tenths, left }) {
  const [first, last] = [tenths[0], tenths.at(-1)];
  const lines = [`${part}: ${count} frames of 1920 × 1080`];
  for (const { frames, memory, wall, processor } of tenths) {
    const times = `${wall.toFixed(3)} s a frame${processor === undefined ? '' : `, ${processor.toFixed(3)} s of processors`}`;
    lines.push(`${frames} frames: heap ${megabytes(memory.heap)} MB, RSS ${megabytes(memory.rss)} MB, ${times}`);
  }
  for (const [id, before] of Object.entries(first.stages))
    lines.push(
      `${id}: ${(1000 * before).toFixed(1)} ms a frame in the first tenth, ${(1000 * (last.stages[id] ?? 0)).toFixed(1)} in the last`,
    );
  for (const { share, secondsLeft, truth } of left)
    lines.push(`at ${(100 * share).toFixed(0)}%: ${secondsLeft.toFixed(0)} s left, ${truth.toFixed(0)} in truth`);
  return lines.join('\n');
}
