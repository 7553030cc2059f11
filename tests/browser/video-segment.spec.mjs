// Video files segmented in Chromium: nearly the masks of Node, and workers that end.

import { framesOfVideo } from '../../dist/node.js';
import { segmentVideo } from '../../dist/node/index.js';
import { expect, giveFile, test, useLibrary } from './fixtures.mjs';
import { FILM, needsFfmpeg, useFilms } from './video-clips.mjs';

const BT709 = ['-color_range', 'tv', '-colorspace', 'bt709', '-color_primaries', 'bt709', '-color_trc', 'bt709'];

const library = useLibrary();
const { film } = useFilms();

// The object covers 9% of each frame. The larger clip gives the figures of docs/determinism.md.
for (const [size, tag] of [
  [{ width: 160, height: 120, count: 6, side: 42 }, []],
  [{ ...FILM, count: 25, side: 62 }, '@long'],
]) {
  const { width, height, count: numFrames } = size;
  test(`${numFrames} frames in H.264 have nearly the pixels and masks that Node has by ffmpeg`, { tag }, async () => {
    needsFfmpeg();
    const toYuv = ['-vf', 'scale=out_color_matrix=bt709:out_range=tv,format=yuv420p'];
    const path = film(`bt709-${numFrames}.mp4`, [...toYuv, '-c:v', 'libx264', '-crf', '18', ...BT709], size);
    await giveFile(library.page, path);
    const inPage = await library.page.evaluate(async () => {
      const encode = (bytes) => btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(''));
      const pixelsOfFrames = [];
      for await (const { pixels } of tracecut.videoFrames(file)) pixelsOfFrames.push(encode((await pixels()).data));
      const masks = await tracecut.segmentVideo(file).collect();
      const labels = pixelsOfFrames.map((_, t) => encode(masks.labels(t)));
      return { pixels: pixelsOfFrames, labels, times: [...masks.times] };
    });
    const masks = await segmentVideo(framesOfVideo(path)).collect();
    expect(inPage.times).toHaveLength(numFrames);
    inPage.times.forEach((time, t) => expect(time).toBeCloseTo(masks.times[t], 5));
    const bytesOf = (text) => Buffer.from(text, 'base64');
    let [sum, largest, numDiffering, numOfObjects, t] = [0, 0, 0, 0, 0];
    for await (const { frame } of framesOfVideo(path)) {
      bytesOf(inPage.pixels[t]).forEach((level, at) => {
        if (at % 4 === 3) return;
        const difference = Math.abs(level - frame.data[at]);
        sum += difference;
        largest = Math.max(largest, difference);
      });
      const labels = bytesOf(inPage.labels[t]);
      masks.labels(t).forEach((label, p) => {
        numDiffering += Number(label !== labels[p]);
        numOfObjects += Number(label > 0);
      });
      t += 1;
    }
    expect(t).toBe(numFrames);
    const numPixels = numFrames * width * height;
    const meanDifference = sum / (3 * numPixels);
    const percent = (count) => `${((100 * count) / numPixels).toFixed(2)}%`;
    console.log(`Levels differ by ${meanDifference.toFixed(2)} of 255 on average, by ${largest} at most.`);
    console.log(`${percent(numDiffering)} of the mask pixels differ; ${percent(numOfObjects)} are of an object.`);
    expect(numOfObjects / numPixels).toBeGreaterThan(0.08);
    expect(meanDifference).toBeLessThan(3);
    expect(numDiffering / numPixels).toBeLessThan(0.005);
  });
}

test('leaving the loop, an abort and close end the worker, and the page can segment again', async () => {
  const { page } = library;
  await page.evaluate(async () => {
    const scene = await tracecut.synthClip({ width: 96, height: 64, frames: 12, seed: 1 });
    const frames = Array.from({ length: 12 }, (_, t) => scene.frame(t));
    const segment = (options) => tracecut.segmentVideo(frames, { window: 6, overlap: 3, threads: 1, ...options });
    Object.assign(globalThis, { segment });
  });
  const endings = {
    leave: async () => {
      for await (const { index } of segment()) if (index === 1) break;
    },
    abort: () => {
      const controller = new AbortController();
      const onProgress = ({ window }) => window === 1 && controller.abort(new Error('enough'));
      return failure(segment({ signal: controller.signal, onProgress }).collect());
    },
    close: () => {
      const video = segment({ onProgress: ({ window }) => window === 1 && video.close() });
      return failure(video.collect());
    },
    // The worker may still be starting.
    closeAtOnce: () => {
      const video = segment();
      const collecting = failure(video.collect());
      video.close();
      return collecting;
    },
    collect: async () => (await segment().collect()).numFrames,
  };
  const outcomes = {};
  for (const [name, run] of Object.entries(endings)) {
    outcomes[name] = await page.evaluate(run);
    await expect.poll(() => page.workers().length, name).toBe(0);
  }
  expect(outcomes).toMatchObject({
    abort: { message: 'enough' },
    close: { code: 'closed' },
    closeAtOnce: { code: 'closed' },
    collect: 12,
  });
});
