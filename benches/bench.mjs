// `npm run bench`: seconds per stage in Node, one thread, wasm with SIMD; peak wasm memory; size of the wasm files.
// "Dense" is the half from superpixels to masks. Options, after `--`:
//   --quick          the smallest size only
//   --clip DIR       the PNG and JPEG files of a folder, in name order, instead of synthetic clips
//   --frames N       only the first N of them
//   --threads N      also runs the package on 1 and on N threads: wall and processor seconds, the minimum of three
//   --json FILE      also writes the figures

import { readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { parseArgs } from 'node:util';
import { gzipSync } from 'node:zlib';
import { build } from '../scripts/build.mjs';

const SIZES = [
  [320, 180, 30],
  [480, 270, 30],
  [640, 360, 30],
];
const LARGEST = [640, 480, 50];
/** Maximum number of pixels of a frame of a file. */
const MAX_PIXELS = 2 ** 26;

const { values: options } = parseArgs({
  options: {
    quick: { type: 'boolean', default: false },
    clip: { type: 'string' },
    frames: { type: 'string', default: 'Infinity' },
    threads: { type: 'string' },
    json: { type: 'string' },
  },
});
await build();
const wasm = readFileSync(new URL('../dist/tracecut_bg.wasm', import.meta.url));
const glue = await import('../dist/tracecut.js');
const { STAGE_COSTS } = await import('../dist/parameters.js');
const STAGES = STAGE_COSTS.map(([stage]) => stage);
const DENSE = STAGES.slice(STAGES.indexOf('superpixels'));
const rows = [];
glue.initSync({ module: wasm });

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
if (options.clip) report(measure(...(await read(options.clip, Number(options.frames)))));
else
  for (const size of options.quick ? SIZES.slice(0, 1) : [...SIZES, LARGEST])
    report(measure(render(...size), size[0], size[1]));
console.log('');
for (const name of ['tracecut_bg.wasm', 'decoder_bg.wasm']) {
  const bytes = readFileSync(new URL(`../dist/${name}`, import.meta.url));
  console.log(`${name}: ${bytes.length} bytes, ${gzipSync(bytes, { level: 9 }).length} gzipped`);
}
if (options.threads) await share(Number(options.threads));
if (options.json) writeFileSync(options.json, `${JSON.stringify(rows, null, 2)}\n`);

/** Runs one clip in a new instance, so that its memory can be measured. */
function measure(clip, width, height) {
  const frames = clip.length;
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
  return row;
}

/** Returns the frames of a clip; the generator's memory is freed with its instance. */
function render(width, height, frames) {
  glue.initSync({ module: wasm });
  const scene = new glue.Scene(width, height, frames, 1);
  return Array.from({ length: frames }, (_, t) => scene.frame(t));
}

/** Returns the frames of a folder and their size. */
async function read(folder, most) {
  const decoder = await import('../dist/decoder.js');
  decoder.initSync({ module: readFileSync(new URL('../dist/decoder_bg.wasm', import.meta.url)) });
  const names = readdirSync(folder).filter((name) => /\.(png|jpe?g)$/i.test(name));
  const decoded = names.sort().slice(0, most);
  const frames = decoded.map((name) => decoder.decode(readFileSync(join(folder, name)), MAX_PIXELS));
  const [, width, height] = frames[0];
  return [frames.map(([data]) => ({ data })), width, height];
}

/** Measures wall and processor seconds from the first frame to the masks, on one thread and on several. */
async function share(threads) {
  const { createSession } = await import('../dist/node.js');
  const [clip, width, height] = options.clip
    ? await read(options.clip, Number(options.frames))
    : [render(...SIZES[1]), ...SIZES[1]];
  const least = { 1: [Infinity, Infinity], [threads]: [Infinity, Infinity] };
  // In turns, so that other load on the machine affects all alike.
  for (let round = 0; round < 3; round += 1) {
    for (const count of [1, threads]) {
      const session = await createSession({ threads: count });
      const [before, processors] = [performance.now(), process.cpuUsage()];
      for (const { data } of clip) await session.push({ data, width, height });
      await session.run();
      const { user, system } = process.cpuUsage(processors);
      const seconds = [(performance.now() - before) / 1000, (user + system) / 1e6];
      least[count] = least[count].map((value, k) => Math.min(value, seconds[k]));
      session.close();
    }
  }
  for (const [count, [seconds, processors]] of Object.entries(least))
    console.log(`${count} threads: ${seconds.toFixed(2)} s wall, ${processors.toFixed(2)} s of all processors`);
  const ratio = least[threads][0] / least[1][0];
  console.log(`wall: ${ratio.toFixed(3)} of one thread's`);
  rows.push({ width, height, frames: clip.length, threads, wall: least, ratio });
}

function report(row) {
  rows.push(row);
  const { width, height, frames, seconds, trajectories, clusters, objects, memoryBytes } = row;
  const total = (stages) => stages.reduce((sum, stage) => sum + seconds[stage], 0);
  const [sum, dense] = [total(STAGES), total(DENSE)];
  const perField = (1000 * seconds.flow) / (2 * (frames - 1));
  const numbers = [...STAGES.map((stage) => seconds[stage]), sum, sum - dense - seconds.flow, dense].map((s) =>
    s.toFixed(3),
  );
  const counts = [trajectories, clusters, objects, (memoryBytes / 2 ** 20).toFixed(1)];
  console.log([`${width}x${height}`, frames, ...numbers, perField.toFixed(1), ...counts].join('\t'));
}
