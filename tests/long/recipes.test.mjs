// The recipe for FFmpeg with the archive of masks.

import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { framesOfVideo, segmentVideo, synthClip } from '../../dist/node.js';
import { installed } from '../package/installed.mjs';
import { TASKS, codeOf } from '../readme.mjs';

const SCENE = { width: 256, height: 144, frames: 8, seed: 1 };
const SIZE = SCENE.width * SCENE.height;

const isInstalled = (program, ...args) => spawnSync(program, args).status === 0;
const skip = !(isInstalled('ffmpeg', '-version') && isInstalled('unzip', '-v')) && 'ffmpeg or unzip is not installed';

/** Writes a video file of the scene. */
async function writeClip(path, codec) {
  const clip = await synthClip(SCENE);
  const input = Buffer.concat(Array.from({ length: SCENE.frames }, (_, t) => Buffer.from(clip.frame(t).data)));
  const raw = ['-f', 'rawvideo', '-pix_fmt', 'rgba', '-s', `${SCENE.width}x${SCENE.height}`, '-r', '25'];
  const args = [...raw, '-i', '-', '-pix_fmt', 'yuv420p', ...codec, path];
  execFileSync('ffmpeg', ['-v', 'error', '-y', ...args], { input });
}

/** Checks that the alpha channel of each frame overlaps the masks of `clip`. */
async function assertAlpha(path, clip) {
  const masks = await segmentVideo(framesOfVideo(clip), { size: 480 }).collect();
  const write = ['-vf', 'alphaextract,format=gray', '-fps_mode', 'passthrough', '-f', 'rawvideo', '-'];
  const alpha = execFileSync('ffmpeg', ['-v', 'error', '-i', path, ...write]);
  assert.equal(alpha.length, SCENE.frames * SIZE);
  for (let t = 0; t < SCENE.frames; t += 1) {
    const mask = masks.labels(t);
    let [intersection, union] = [0, 0];
    for (let p = 0; p < SIZE; p += 1) {
      const isOpaque = alpha[t * SIZE + p] > 127;
      intersection += Number(isOpaque && mask[p] > 0);
      union += Number(isOpaque || mask[p] > 0);
    }
    assert.ok(intersection / union > 0.99, `frame ${t}: ${intersection / union}`);
  }
}

test('the recipe for FFmpeg gives a video the masks as its alpha channel', { skip }, async (t) => {
  const folder = installed(t);
  const clip = join(folder, 'clip.mp4');
  await writeClip(clip, ['-c:v', 'mpeg4', '-q:v', '2']);
  const [heading] = TASKS.long;
  writeFileSync(join(folder, 'main.mjs'), codeOf('docs/tasks.md').get(heading));
  execFileSync(process.execPath, ['main.mjs'], { cwd: folder });
  const commands = codeOf('docs/tasks.md', 'sh').get(heading);
  execFileSync('sh', ['-ec', commands], { cwd: folder, stdio: ['ignore', 'ignore', 'pipe'] });
  await assertAlpha(join(folder, 'cutout.mov'), clip);
});
