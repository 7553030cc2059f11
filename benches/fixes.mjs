// `node benches/fixes.mjs FOLDER...`: measures the effect of a fix of one frame on the others. Each folder is a clip with true
// masks: frames in `frames/` or `JPEGImages/`, masks in `masks/` or `Annotations/` (255 for objects, 128 for pixels that are not
// scored). Needs ffmpeg and a built package. Options:
//   --frames N    only the first N frames (50)
//   --fixes N     frames of each clip that are fixed, evenly spaced (4)
//   --json FILE   also writes the figures
//
// In each of these frames the largest missing part of the objects is painted, and the largest wrong part is erased, both as the
// true mask has it, without slivers. The edit is then carried. Scored are the other frames that it changes: by how much the
// intersection over union with the true mask, all objects as one, rises.

import { execFileSync } from 'node:child_process';
import { existsSync, readdirSync, writeFileSync } from 'node:fs';
import { basename, join } from 'node:path';
import { parseArgs } from 'node:util';
import { createSession, fitSize } from 'tracecut';
import { editMasks, encodeRuns } from 'tracecut/edit';
import { createImageEngine } from 'tracecut/stages';

const { values: options, positionals: folders } = parseArgs({
  allowPositionals: true,
  options: {
    frames: { type: 'string', default: '50' },
    fixes: { type: 'string', default: '4' },
    json: { type: 'string' },
  },
});

/** Largest side of the frames, as on the page. */
const MAX_SIDE = 480;
/** Errors of fewer pixels, after slivers are removed, are not fixed: share of the frame. */
const MIN_ERROR_SHARE = 0.001;
/** Half the side of the square that a part must contain; thinner parts are slivers along borders. */
const SLIVER_RADIUS_PX = 2;

/** Reads a clip: RGBA frames, and for each the true mask, 0, 128 or 255, or null. */
function readClip(/** @type {string} */ folder) {
  const isDavis = existsSync(join(folder, 'JPEGImages'));
  const [imageFolder, maskFolder] = (isDavis ? ['JPEGImages', 'Annotations'] : ['frames', 'masks']).map((part) =>
    join(folder, part),
  );
  const list = (/** @type {string} */ dir) =>
    readdirSync(dir)
      .filter((name) => /\.(png|jpe?g)$/i.test(name))
      .sort();
  const images = list(imageFolder).slice(0, Number(options.frames));
  const stem = (/** @type {string} */ name) => name.replace(/\.\w+$/, '');
  const maskOf = new Map(list(maskFolder).map((name) => [stem(name), join(maskFolder, name)]));
  const [inputWidth, inputHeight] = probe(join(imageFolder, images[0]));
  const { width, height } = fitSize({ width: inputWidth, height: inputHeight }, MAX_SIDE);
  const frames = images.map((name) => decode(join(imageFolder, name), width, height, 'area', 'rgba'));
  const truth = images.map((name) => {
    const file = maskOf.get(stem(name));
    return file ? decode(file, width, height, 'neighbor', 'gray') : null;
  });
  return { width, height, frames, truth };
}

function probe(/** @type {string} */ file) {
  const text = execFileSync('ffprobe', ['-v', 'error', '-show_entries', 'stream=width,height', '-of', 'csv=p=0', file]);
  return text.toString().trim().split(',').map(Number);
}

function decode(file, width, height, scaler, format) {
  const filter = `scale=${width}:${height}:flags=${scaler}`;
  const arguments_ = ['-v', 'error', '-i', file, '-vf', filter, '-f', 'rawvideo', '-pix_fmt', format, '-'];
  return new Uint8Array(execFileSync('ffmpeg', arguments_, { maxBuffer: 2 ** 28 }));
}

/** Segments a clip with all defaults; one mask after the other. */
async function segment({ width, height, frames }) {
  const session = await createSession();
  for (const data of frames) await session.push({ data, width, height });
  const result = await session.run();
  const masks = new Uint8Array(frames.length * width * height);
  for (let t = 0; t < frames.length; t += 1) masks.set(result.labels(t), t * width * height);
  session.close();
  return masks;
}

/** Intersection over union with the true mask, all objects as one. */
function overlap(labels, truth) {
  let [both, either] = [0, 0];
  labels.forEach((label, p) => {
    if (truth[p] === 128) return;
    both += Number(label > 0 && truth[p] === 255);
    either += Number(label > 0 || truth[p] === 255);
  });
  return either === 0 ? 1 : both / either;
}

/** Minimum (`best` = Math.min) or maximum over squares around each pixel. */
function squares(pixels, width, height, best) {
  const pass = (from, [dx, dy]) =>
    from.map((_, p) => {
      let value = from[p];
      for (let k = -SLIVER_RADIUS_PX; k <= SLIVER_RADIUS_PX; k += 1) {
        const [x, y] = [(p % width) + k * dx, Math.floor(p / width) + k * dy];
        if (x >= 0 && y >= 0 && x < width && y < height) value = best(value, from[y * width + x]);
      }
      return value;
    });
  return pass(pass(pixels, [1, 0]), [0, 1]);
}

/** The largest connected part of `pixels` without slivers; null if it is too small. */
function largestPart(pixels, width, height) {
  const opened = squares(squares(pixels, width, height, Math.min), width, height, Math.max);
  const left = opened.map((inside, p) => inside & pixels[p]);
  let largest = [];
  for (let seed = 0; seed < left.length; seed += 1) {
    if (!left[seed]) continue;
    const part = [seed];
    left[seed] = 0;
    for (let k = 0; k < part.length; k += 1) {
      const [x, y] = [part[k] % width, Math.floor(part[k] / width)];
      for (const [i, j] of [
        [x - 1, y],
        [x + 1, y],
        [x, y - 1],
        [x, y + 1],
      ]) {
        const p = j * width + i;
        if (i < 0 || j < 0 || i >= width || j >= height || !left[p]) continue;
        left[p] = 0;
        part.push(p);
      }
    }
    if (part.length > largest.length) largest = part;
  }
  if (largest.length < MIN_ERROR_SHARE * width * height) return null;
  const region = new Uint8Array(width * height);
  for (const p of largest) region[p] = 1;
  return region;
}

/** The label that a missing part gets: that of the object with most of the frame's true pixels; a new one without any. */
function labelFor(labels, truth) {
  const counts = new Map();
  labels.forEach((label, p) => label > 0 && truth[p] === 255 && counts.set(label, (counts.get(label) ?? 0) + 1));
  return [...counts].sort((a, b) => b[1] - a[1])[0]?.[0] ?? 1;
}

const rows = [];
const engine = await createImageEngine();
for (const folder of folders) {
  const clip = readClip(folder);
  const { width, height, frames, truth } = clip;
  const size = width * height;
  const name = basename(folder);
  const masks = await segment(clip);
  const labels = (t) => masks.slice(t * size, (t + 1) * size);
  const picture = (t) => ({ data: frames[t], width, height });
  for (let k = 0; k < Number(options.fixes); k += 1) {
    const t = Math.floor(((k + 0.5) * frames.length) / Number(options.fixes));
    if (!truth[t]) continue;
    const mask = labels(t);
    const kinds = {
      painted: mask.map((label, p) => Number(label === 0 && truth[t][p] === 255)),
      erased: mask.map((label, p) => Number(label > 0 && truth[t][p] === 0)),
    };
    for (const [kind, error] of Object.entries(kinds)) {
      const region = largestPart(error, width, height);
      if (!region) continue;
      const editor = editMasks(
        { width, height, numFrames: frames.length, labels },
        { picture, engine: async () => engine },
      );
      const paint = kind === 'painted' ? { label: labelFor(mask, truth[t]) } : { label: 0 };
      const edit = await editor.paint({ ...paint, t, region: encodeRuns(region) });
      const before = Date.now();
      const range = await editor.carry(edit);
      const seconds = (Date.now() - before) / 1000;
      const gains = [];
      for (let s = 0; s < frames.length; s += 1) {
        if (s === t || !truth[s]) continue;
        const [old, now] = [labels(s), editor.labels(s)];
        if (now.every((label, p) => label > 0 === old[p] > 0)) continue;
        gains.push({ s, gain: overlap(now, truth[s]) - overlap(old, truth[s]) });
      }
      rows.push({ name, kind, t, range, gains, seconds });
    }
  }
}
engine.close();

/** Prints the figures of some fixes. */
function report(title, list) {
  const gains = list.flatMap((row) => row.gains.map(({ gain }) => gain));
  const raised = gains.filter((gain) => gain > 0).length;
  const lowered = gains.filter((gain) => gain < -0.02).length;
  const sum = gains.reduce((total, gain) => total + gain, 0);
  console.log(
    title.padEnd(20),
    `${list.length} fixes`.padStart(9),
    `${gains.length} frames`.padStart(12),
    `raised ${((100 * raised) / Math.max(1, gains.length)).toFixed(1)} %`.padStart(15),
    `by more than .02 lower ${lowered}`.padStart(28),
    `least ${Math.min(0, ...gains).toFixed(3)}`.padStart(13),
    `gain of a fix ${(sum / Math.max(1, list.length)).toFixed(3)} frames`.padStart(26),
  );
}
for (const key of ['name', 'kind'])
  for (const value of new Set(rows.map((row) => row[key])))
    report(
      value,
      rows.filter((row) => row[key] === value),
    );
report('all', rows);
const frames = rows.reduce((sum, { range }) => sum + range.last - range.first, 0);
console.log(
  `${(rows.reduce((sum, { seconds }) => sum + seconds, 0) / Math.max(1, frames)).toFixed(2)} s a frame reached`,
);
if (options.json) writeFileSync(options.json, JSON.stringify(rows, null, 1));
