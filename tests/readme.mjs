// Extracts the code of README.md, docs/guide.md and docs/tasks.md, which tests run unchanged; makes the clip of its recipe for
// FFmpeg and compares a video's alpha channel with the masks of that clip.

import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { framesOfVideo, segmentVideo, synthClip } from '../dist/node.js';
import { root } from '../scripts/tools.mjs';

/** Returns blocks of JavaScript, or of another language, by the heading above them; several below one heading are numbered. */
export function codeOf(file, language = 'js') {
  const text = readFileSync(join(root, file), 'utf8').replaceAll('\r', '');
  const blocks = new Map();
  let heading = '';
  const pattern = new RegExp(`^#+ (.+)$|^( *)\`\`\`${language}\\n([^]*?)^ *\`\`\`$`, 'gm');
  for (const [, title, indent, code] of text.matchAll(pattern)) {
    if (title) heading = title;
    else {
      const name = [heading, `${heading} 2`, `${heading} 3`].find((candidate) => !blocks.has(candidate));
      blocks.set(name, code.replace(new RegExp(`^${indent}`, 'gm'), ''));
    }
  }
  return blocks;
}

/** The blocks of README.md and of docs/guide.md, which continues it. */
export const readmeCode = () => new Map([...codeOf('README.md'), ...codeOf('docs/guide.md')]);

/** Returns the page that the README begins with. */
export const readmePage = () => [...codeOf('README.md', 'html').values()][0];

/** Blocks of docs/tasks.md that do not run in Node: in a browser, or by the long tests. */
export const TASKS = {
  browser: ['Effects: blurred, dimmed or other backgrounds'],
  long: ['A video with alpha, by FFmpeg'],
};

const SCENE = { width: 256, height: 144, frames: 8, seed: 1 };
const NUM_PIXELS = SCENE.width * SCENE.height;

/** Writes a video file of a synthetic scene. @param {string[]} codec options of ffmpeg */
export async function writeSceneVideo(path, codec) {
  const clip = await synthClip(SCENE);
  const input = Buffer.concat(Array.from({ length: SCENE.frames }, (_, t) => Buffer.from(clip.frame(t).data)));
  const raw = ['-f', 'rawvideo', '-pix_fmt', 'rgba', '-s', `${SCENE.width}x${SCENE.height}`, '-r', '25'];
  const args = [...raw, '-i', '-', '-pix_fmt', 'yuv420p', ...codec, path];
  execFileSync('ffmpeg', ['-v', 'error', '-y', ...args], { input });
}

/** Returns the intersection over union of opaque pixels of a video and masks of `clip`, for each frame. */
export async function alphaOverlaps(path, clip, decoder = []) {
  const masks = await segmentVideo(framesOfVideo(clip), { size: 480 }).collect();
  const write = ['-vf', 'alphaextract,format=gray', '-fps_mode', 'passthrough', '-f', 'rawvideo', '-'];
  const alpha = execFileSync('ffmpeg', ['-v', 'error', ...decoder, '-i', path, ...write]);
  if (alpha.length !== SCENE.frames * NUM_PIXELS) throw new Error(`${alpha.length} bytes of alpha`);
  return Array.from({ length: SCENE.frames }, (_, t) => {
    let [intersection, union] = [0, 0];
    masks.labels(t).forEach((label, p) => {
      const isOpaque = alpha[t * NUM_PIXELS + p] > 127;
      intersection += Number(isOpaque && label > 0);
      union += Number(isOpaque || label > 0);
    });
    return intersection / union;
  });
}
