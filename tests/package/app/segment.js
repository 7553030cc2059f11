// Calls of a user's project: tests run them in Node and, through each bundler, in a browser, and compare the results.

import { createSession, encodeVideo, maskPng, masksZip, segmentVideo, synthClip } from 'tracecut';

/** The smallest scene of its kind in which all objects are found. */
const SCENE = { width: 192, height: 108, frames: 6, seed: 3 };

/** A file of one red pixel. */
const PNG = 'iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg==';

export async function outcome() {
  const clip = await synthClip(SCENE);
  const session = await createSession();
  for (let t = 0; t < clip.numFrames; t += 1) await session.push(clip.frame(t));
  const result = await session.run();
  session.close();
  return {
    objects: result.objects.length,
    ...compareWithScene(result, clip),
    decoded: await decodedSize(),
    png: sumOf(await maskPng(result, 0)),
    zip: sumOf(await masksZip(result)),
  };
}

/** Writes a video file and segments it; needs WebCodecs, which Node does not have. */
export async function throughVideo() {
  const clip = await synthClip(SCENE);
  const frames = Array.from({ length: clip.numFrames }, (_, t) => clip.frame(t));
  const truth = { width: clip.width, height: clip.height, numFrames: clip.numFrames, labels: (t) => clip.mask(t) };
  const file = await encodeVideo(truth, frames, { opacity: 0, outline: false, frameRate: 10 });
  const masks = await segmentVideo(file).collect();
  return {
    type: file.type,
    times: [...masks.times].map((time) => Math.round(1000 * time)),
    overlap: compareWithScene(masks, clip).overlap,
  };
}

/** Returns the overlap of the masks with the true objects, and checksums of the masks. */
function compareWithScene(result, clip) {
  let [intersection, union] = [0, 0];
  const sums = [];
  for (let t = 0; t < clip.numFrames; t += 1) {
    const [mask, truth] = [result.labels(t), clip.mask(t)];
    for (let p = 0; p < mask.length; p += 1) {
      intersection += mask[p] && truth[p] ? 1 : 0;
      union += mask[p] || truth[p] ? 1 : 0;
    }
    sums.push(sumOf(mask));
  }
  return { overlap: intersection / union, sums };
}

function sumOf(bytes) {
  return bytes.reduce((sum, byte) => (Math.imul(sum, 31) + byte) >>> 0, bytes.length);
}

/** Returns the size of an image file, whose decoder is another wasm file. */
async function decodedSize() {
  const session = await createSession();
  await session.push(Uint8Array.from(atob(PNG), (letter) => letter.charCodeAt(0)));
  const size = [session.width, session.height];
  session.close();
  return size;
}
