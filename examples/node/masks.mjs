// Segments a folder of frames: `node masks.mjs FRAMES MASKS`. Frames are PNG or JPEG files, taken in name order; each
// gets a palette PNG whose pixel values are the labels. Frames are read on demand, so the clip may be long.

import { mkdir, readFile, readdir, writeFile } from 'node:fs/promises';
import { join, parse } from 'node:path';
import { maskPng, segmentVideo } from 'tracecut';

const [input, output] = process.argv.slice(2);
if (!output) {
  console.error('Usage: node masks.mjs FRAMES MASKS');
  process.exit(2);
}
const files = (await readdir(input))
  .filter((name) => /\.(png|jpe?g)$/i.test(name))
  .sort((a, b) => a.localeCompare(b, 'en', { numeric: true }));
await mkdir(output, { recursive: true });

async function* frames() {
  for (const name of files) yield await readFile(join(input, name));
}

for await (const window of segmentVideo(frames())) {
  for (const { t, index } of window.frames()) {
    await writeFile(join(output, `${parse(files[index]).name}.png`), await maskPng(window, t));
  }
  console.log(`${window.firstFrame + window.settled.to} of ${files.length} frames, ${window.objects.length} objects`);
}
