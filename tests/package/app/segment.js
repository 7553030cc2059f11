// What a user's project may ask of the installed package; the tests run it in Node and, through each bundler, in a
// browser, and compare.

import { createSession, encodeVideo, maskPng, masksZip, segmentVideo, synthClip } from 'tracecut';

/** Large enough for all objects to be found, and to outlast a codec. */
const SCENE = { width: 192, height: 108, frames: 6, seed: 5 };

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
    ...compared(result, clip),
    decoded: await decodedSize(),
    png: sumOf(await maskPng(result, 0)),
    zip: sumOf(await masksZip(result)),
  };
}

/** A video file written and read again; where there is no WebCodecs, as in Node, there is none. */
export async function throughVideo() {
  const clip = await synthClip(SCENE);
  const frames = Array.from({ length: clip.numFrames }, (_, t) => clip.frame(t));
  const truth = { width: clip.width, height: clip.height, numFrames: clip.numFrames, labels: (t) => clip.mask(t) };
  const file = await encodeVideo(truth, frames, { opacity: 0, outline: false, frameRate: 10 });
  const found = await segmentVideo(file).collect();
  return {
    type: file.type,
    times: [...found.times].map((time) => Math.round(1000 * time)),
    overlap: compared(found, clip).overlap,
  };
}

/** How well the masks cover the true objects, and sums that any other mask would change. */
function compared(result, clip) {
  let [both, either] = [0, 0];
  const sums = [];
  for (let t = 0; t < clip.numFrames; t += 1) {
    const [found, truth] = [result.labels(t), clip.mask(t)];
    for (let p = 0; p < found.length; p += 1) {
      both += found[p] && truth[p] ? 1 : 0;
      either += found[p] || truth[p] ? 1 : 0;
    }
    sums.push(sumOf(found));
  }
  return { overlap: both / either, sums };
}

function sumOf(bytes) {
  return bytes.reduce((sum, byte) => (Math.imul(sum, 31) + byte) >>> 0, bytes.length);
}

/** The decoder of image files comes in a wasm file of its own. */
async function decodedSize() {
  const session = await createSession();
  await session.push(Uint8Array.from(atob(PNG), (letter) => letter.charCodeAt(0)));
  const size = [session.width, session.height];
  session.close();
  return size;
}
