// A long clip of 1080p, made while it is read: `node --expose-gc benches/soak/long.mjs FRAMES PART`, with the part `long` for
// the package in Node, window by window, or `pipe` for the command line, which reads it from a pipe as y4m. Prints, for each
// tenth of the clip, memory, seconds and, for the package, the time left against the truth.

import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { root } from '../../scripts/tools.mjs';

const SIZE = { width: 1920, height: 1080 };
const FRAME_RATE = 30;
const NUM_TENTHS = 10;
/** Frames until the scene repeats itself, and the width and side of its parts in pixels. */
const PERIOD = 240;
const MARGIN_PX = 480;
const OBJECT_PX = 360;

/** Returns a brightness at each pixel of a texture that has details of several sizes. */
function texture(width, height, salt) {
  const values = new Uint8Array(width * height);
  for (let p = 0; p < values.length; p += 1) {
    const [x, y] = [p % width, Math.floor(p / width)];
    const hash = Math.imul((x >> 2) + 7, 374761393) ^ Math.imul((y >> 2) + 3, 668265263) ^ Math.imul(salt, 2246822519);
    const grain = (Math.imul(hash ^ (hash >>> 13), 1274126177) >>> 24) / 4;
    values[p] = 90 + grain + 30 * Math.sin(x / (31 + salt)) + 30 * Math.sin(y / (47 - salt));
  }
  return values;
}

/** Makes the brightness of frames: an object moves one way over a background that moves the other. */
function createScene() {
  const { width, height } = SIZE;
  const backdropWidth = width + MARGIN_PX;
  const [backdrop, object] = [texture(backdropWidth, height, 1), texture(OBJECT_PX, OBJECT_PX, 9)];
  return (t, luma) => {
    // To and fro, so that the last frame of a period is next to the first.
    const place = Math.abs((t % PERIOD) - PERIOD / 2) / (PERIOD / 2);
    const shift = Math.round(MARGIN_PX * place);
    const [left, top] = [Math.round((width - OBJECT_PX) * (0.2 + 0.6 * place)), 340];
    for (let y = 0; y < height; y += 1)
      luma.set(backdrop.subarray(y * backdropWidth + shift, y * backdropWidth + shift + width), y * width);
    for (let y = 0; y < OBJECT_PX; y += 1) {
      const row = object.subarray(y * OBJECT_PX, (y + 1) * OBJECT_PX);
      luma.set(row, (top + y) * width + left);
    }
    return luma;
  };
}

/** Returns a list of frames whose pixels are made when they are read. */
function listFrames(count) {
  const { width, height } = SIZE;
  const makeLuma = createScene();
  const luma = new Uint8Array(width * height);
  const pixels = new Uint32Array(width * height);
  let made = -1;
  const read = (t) => {
    if (made !== t) {
      makeLuma(t, luma);
      for (let p = 0; p < pixels.length; p += 1) pixels[p] = 0xff000000 + 0x10101 * luma[p];
    }
    made = t;
    return new Uint8Array(pixels.buffer);
  };
  return Array.from({ length: count }, (_, t) => ({
    ...SIZE,
    get data() {
      return read(t);
    },
  }));
}

const seconds = () => performance.now() / 1000;

/** Segments the clip with the package. */
async function runPackage(count) {
  const { segmentVideo } = await import('tracecut');
  const begun = seconds();
  const stages = {};
  const estimates = [];
  let last = { stage: 'decode', at: begun };
  const onProgress = ({ stage, frames, share, secondsLeft }) => {
    const now = seconds();
    // The time since the last report belongs to its stage.
    stages[last.stage] = (stages[last.stage] ?? 0) + now - last.at;
    last = { stage, at: now };
    const tenth = Math.floor(NUM_TENTHS * share);
    if (secondsLeft !== null && estimates[tenth] === undefined) estimates[tenth] = { now, share, secondsLeft, frames };
  };
  const tenths = [];
  let [numFrames, from, stagesBefore, cpuBefore] = [0, begun, {}, process.cpuUsage()];
  let framesBefore = 0;
  for await (const window of segmentVideo(listFrames(count), { frameRate: FRAME_RATE, onProgress })) {
    for (const { labels } of window.frames()) numFrames += Number(labels.length > 0);
    if (numFrames < (count * (tenths.length + 1)) / NUM_TENTHS && numFrames < count) continue;
    globalThis.gc();
    const { heapUsed, external, rss } = process.memoryUsage();
    const { user, system } = process.cpuUsage(cpuBefore);
    const each = (value) => value / (numFrames - framesBefore);
    const ofStages = Object.entries(stages).map(([id, sum]) => [id, each(sum - (stagesBefore[id] ?? 0))]);
    tenths.push({
      frames: numFrames,
      memory: { heap: heapUsed + external, rss },
      wall: each(seconds() - from),
      processor: each((user + system) / 1e6),
      stages: Object.fromEntries(ofStages),
    });
    [from, stagesBefore, cpuBefore, framesBefore] = [seconds(), { ...stages }, process.cpuUsage(), numFrames];
  }
  const end = seconds();
  const left = estimates.flatMap(({ now, share, secondsLeft }) => [{ share, secondsLeft, truth: end - now }]);
  return { tenths, left };
}

/** Pipes the clip to the command line. */
async function runPipe(count) {
  const program = ['release', 'quick'].map((kind) => join(root, 'target', kind, 'tracecut')).find(existsSync);
  if (!program) throw new Error('There is no command line yet: cargo build --release --package tracecut-cli.');
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-'));
  const args = ['segment', '-', '--out', join(folder, 'masks')];
  const child = spawn(program, args, { stdio: ['pipe', 'ignore', 'pipe'] });
  let complaint = '';
  child.stderr.on('data', (text) => (complaint = `${complaint}${text}`.slice(-2000)));
  const ended = once(child, 'exit');
  const { width, height } = SIZE;
  const makeLuma = createScene();
  const head = `YUV4MPEG2 W${width} H${height} F${FRAME_RATE}:1 Ip A1:1 Cmono\n`;
  const status = (key) =>
    1024 *
    Number(new RegExp(`^${key}:\\s+(\\d+) kB$`, 'm').exec(readFileSync(`/proc/${child.pid}/status`, 'utf8'))?.[1]);
  child.stdin.on('error', () => {});
  child.stdin.write(head);
  const tenths = [];
  let [from, framesBefore] = [seconds(), 0];
  for (let t = 0; t < count && child.exitCode === null; t += 1) {
    const frame = Buffer.alloc(6 + width * height);
    frame.write('FRAME\n');
    makeLuma(t, frame.subarray(6));
    // The pipe takes a frame only when the program reads it.
    if (!child.stdin.write(frame)) await Promise.race([once(child.stdin, 'drain'), ended]);
    if (t + 1 < (count * (tenths.length + 1)) / NUM_TENTHS || child.exitCode !== null) continue;
    const memory = { heap: status('RssAnon'), rss: status('VmHWM') };
    tenths.push({ frames: t + 1, memory, wall: (seconds() - from) / (t + 1 - framesBefore), stages: {} });
    [from, framesBefore] = [seconds(), t + 1];
  }
  child.stdin.end();
  const [code] = await ended;
  rmSync(folder, { recursive: true, force: true });
  if (code !== 0) throw new Error(`The command line ended with ${code}: ${complaint}`);
  return { tenths, left: [] };
}

const [count, part] = [Number(process.argv[2]), process.argv[3]];
const { tenths, left } = await { long: runPackage, pipe: runPipe }[part](count);
console.log(JSON.stringify({ part, count, tenths, left }));
