// `npm run bench`: seconds per stage in Node, one thread, wasm with SIMD; peak wasm memory; size of the wasm files.
// "Dense" is the half from superpixels to masks. Options: `-- --quick` takes the smallest size only, `-- --json FILE`
// also writes the figures.

import { readFileSync, writeFileSync } from 'node:fs';
import { parseArgs } from 'node:util';
import { gzipSync } from 'node:zlib';
import { build } from '../scripts/build.mjs';

const SPARSE = [
  'flow',
  'trajectories',
  'affinities',
  'embedding',
  'discontinuities',
  'saliency',
  'connectedness',
  'clusters',
];
const DENSE = ['superpixels', 'cut', 'masks'];
const STAGES = [...SPARSE, ...DENSE];
const SIZES = [
  [320, 180, 30],
  [480, 270, 30],
  [640, 360, 30],
];
const LARGEST = [640, 480, 50];

const { values: options } = parseArgs({
  options: { quick: { type: 'boolean', default: false }, json: { type: 'string' } },
});
await build({ overBudget: 'warn' });
const wasm = readFileSync(new URL('../dist/tracecut_bg.wasm', import.meta.url));
const glue = await import('../dist/tracecut.js');
const rows = [];

console.log(
  `\nNode ${process.versions.node}, ${process.platform} ${process.arch}, one thread; seconds of the process's own time`,
);
console.log(
  [
    'size',
    'frames',
    ...STAGES,
    'sum',
    'after flow',
    'dense',
    'ms a field',
    'tracks',
    'clusters',
    'objects',
    'MiB',
  ].join('\t'),
);
for (const size of options.quick ? SIZES.slice(0, 1) : [...SIZES, LARGEST]) report(measure(...size));
console.log('');
for (const name of ['tracecut_bg.wasm', 'decoder_bg.wasm']) {
  const bytes = readFileSync(new URL(`../dist/${name}`, import.meta.url));
  console.log(`${name}: ${bytes.length} bytes, ${gzipSync(bytes, { level: 9 }).length} gzipped`);
}
if (options.json) writeFileSync(options.json, `${JSON.stringify(rows, null, 2)}\n`);

/** Runs one clip in an instance of its own, so that its memory is its own. */
function measure(width, height, frames) {
  const clip = render(width, height, frames);
  glue.__wbg_reset_state();
  const { memory } = glue.initSync();
  const session = new glue.Session({});
  for (const { data } of clip) session.pushRgba(data, width, height);
  const seconds = Object.fromEntries(STAGES.map((stage) => [stage, 0]));
  let before = process.cpuUsage();
  for (let progress = session.step(); progress; progress = session.step()) {
    const { user, system } = process.cpuUsage(before);
    seconds[progress.stage] += (user + system) / 1e6;
    before = process.cpuUsage();
  }
  const row = {
    width,
    height,
    frames,
    seconds,
    trajectories: session.trajectories().count,
    clusters: session.clusters().count,
    objects: session.objects().count,
    memoryBytes: memory.buffer.byteLength,
  };
  session.free();
  rows.push(row);
  return row;
}

/** The frames of a clip; the generator's memory goes with its instance. */
function render(width, height, frames) {
  glue.initSync({ module: wasm });
  const scene = new glue.Scene(width, height, frames, 1);
  return Array.from({ length: frames }, (_, t) => scene.frame(t));
}

function report({ width, height, frames, seconds, trajectories, clusters, objects, memoryBytes }) {
  const total = (stages) => stages.reduce((sum, stage) => sum + seconds[stage], 0);
  const [sum, dense] = [total(STAGES), total(DENSE)];
  const perField = (1000 * seconds.flow) / (2 * (frames - 1));
  const numbers = [...STAGES.map((stage) => seconds[stage]), sum, total(SPARSE) - seconds.flow, dense].map((s) =>
    s.toFixed(3),
  );
  const counts = [trajectories, clusters, objects, (memoryBytes / 2 ** 20).toFixed(1)];
  console.log([`${width}x${height}`, frames, ...numbers, perField.toFixed(1), ...counts].join('\t'));
}
