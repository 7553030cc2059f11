// Other tools beside the package: mediabunny in a page, and FFmpeg with the archive of masks.

import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { cpSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { framesOfVideo, segmentVideo, synthClip } from '../../dist/node.js';
import { root } from '../../scripts/tools.mjs';
import { installed, served } from '../package/installed.mjs';
import { TASKS, codeOf } from '../readme.mjs';
import { bytesOf, useServerAndBrowser } from '../site.mjs';

const SCENE = { width: 256, height: 144, frames: 8, seed: 1 };
const SIZE = SCENE.width * SCENE.height;

const site = useServerAndBrowser();
const isThere = (program, ...args) => spawnSync(program, args).status === 0;
const skip = !(isThere('ffmpeg', '-version') && isThere('unzip', '-v')) && 'there is no ffmpeg, or no unzip';

/** Writes a video file of the scene. */
async function writeClip(path, ...codec) {
  const clip = await synthClip(SCENE);
  const input = Buffer.concat(Array.from({ length: SCENE.frames }, (_, t) => Buffer.from(clip.frame(t).data)));
  const raw = ['-f', 'rawvideo', '-pix_fmt', 'rgba', '-s', `${SCENE.width}x${SCENE.height}`, '-r', '25'];
  const args = [...raw, '-i', '-', '-pix_fmt', 'yuv420p', ...codec, path];
  execFileSync('ffmpeg', ['-v', 'error', '-y', ...args], { input });
}

/** Checks that the alpha channel of a video file is the masks of `clip`: the least overlap in a frame is above `overlap`. */
async function assertAlpha(path, clip, overlap, ...decoder) {
  const masks = await segmentVideo(framesOfVideo(clip), { size: 480 }).collect();
  const write = ['-vf', 'alphaextract,format=gray', '-fps_mode', 'passthrough', '-f', 'rawvideo', '-'];
  const alpha = execFileSync('ffmpeg', ['-v', 'error', ...decoder, '-i', path, ...write]);
  assert.equal(alpha.length, SCENE.frames * SIZE);
  for (let t = 0; t < SCENE.frames; t += 1) {
    const mask = masks.labels(t);
    let [both, either] = [0, 0];
    for (let p = 0; p < SIZE; p += 1) {
      const isOpaque = alpha[t * SIZE + p] > 127;
      both += Number(isOpaque && mask[p] > 0);
      either += Number(isOpaque || mask[p] > 0);
    }
    assert.ok(both / either > overlap, `frame ${t}: ${both / either}`);
  }
}

test('the recipe for FFmpeg gives a video the masks as its alpha channel', { skip }, async (t) => {
  const folder = installed(t);
  const clip = join(folder, 'clip.mp4');
  await writeClip(clip, '-c:v', 'mpeg4', '-q:v', '2');
  const [heading] = TASKS.long;
  writeFileSync(join(folder, 'main.mjs'), codeOf('docs/tasks.md').get(heading));
  execFileSync(process.execPath, ['main.mjs'], { cwd: folder });
  const commands = codeOf('docs/tasks.md', 'sh').get(heading);
  execFileSync('sh', ['-ec', commands], { cwd: folder, stdio: ['ignore', 'ignore', 'pipe'] });
  await assertAlpha(join(folder, 'cutout.mov'), clip, 0.99);
});

test('the example for mediabunny writes the objects with alpha', { skip }, async (t) => {
  const folder = installed(t, 'examples/mediabunny');
  cpSync(join(root, 'node_modules', 'mediabunny'), join(folder, 'node_modules', 'mediabunny'), { recursive: true });
  const clip = join(folder, 'clip.webm');
  await writeClip(clip, '-c:v', 'libvpx', '-b:v', '4M');
  const page = await site.browser.newPage();
  const wrong = [];
  page.on('pageerror', (error) => wrong.push(error.message));
  page.on('console', (message) => message.type() === 'error' && wrong.push(message.text()));
  t.after(() => page.close());
  await page.goto(await served(t, folder));
  await page.locator('input').setInputFiles(clip);
  const [download] = await Promise.all([page.waitForEvent('download'), page.locator('a').click()]);
  assert.equal(download.suggestedFilename(), 'cutout.webm');
  writeFileSync(join(folder, 'cutout.webm'), await bytesOf(download));
  // The browser decodes colours a little differently.
  await assertAlpha(join(folder, 'cutout.webm'), clip, 0.7, '-c:v', 'libvpx-vp9');
  assert.deepEqual(wrong, []);
});
