// A clip written by ffmpeg, and the comparison of a video's alpha channel with the masks of the clip that it was made from.

import { execFileSync } from 'node:child_process';
import { framesOfVideo, segmentVideo, synthClip } from '../dist/node.js';

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
