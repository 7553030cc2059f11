// The difference between pixels and masks of one video in Chromium and by ffmpeg, which the command line, Node and Python
// decode by. `TRACECUT_LONG=1 node --test tests/browser/video-pixels.test.mjs` prints the figures of docs/determinism.md.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { segmentVideo } from '../../dist/node/index.js';
import { framesOfVideo } from '../../dist/node.js';
import { FILM, useFilms, withFfmpeg } from './video-clips.mjs';
import { giveFile, useLibrary } from './video-support.mjs';

/** Nine of a hundred pixels are the object's. The figures are those of the long clip. */
const CLIP = { ...FILM, count: process.env.TRACECUT_LONG ? 25 : 8, side: 62 };
const BT709 = ['-color_range', 'tv', '-colorspace', 'bt709', '-color_primaries', 'bt709', '-color_trc', 'bt709'];

describe(
  'one MP4 (H.264, BT.709, limited range) in Chromium and by ffmpeg',
  { timeout: 240_000, ...withFfmpeg },
  () => {
    const library = useLibrary();
    const { film } = useFilms();

    test('pixels and masks differ little', async (t) => {
      const toYuv = ['-vf', 'scale=out_color_matrix=bt709:out_range=tv,format=yuv420p'];
      const path = film('bt709.mp4', [...toYuv, '-c:v', 'libx264', '-crf', '18', ...BT709], CLIP);
      await giveFile(library.page, path);
      const seen = await library.page.evaluate(async () => {
        const text = (bytes) => Array.from(bytes, (byte) => String.fromCharCode(byte)).join('');
        const frames = [];
        for await (const { pixels } of tracecut.videoFrames(file)) frames.push(btoa(text((await pixels()).data)));
        const masks = await tracecut.segmentVideo(file).collect();
        return { pixels: frames, labels: frames.map((_, k) => btoa(text(masks.labels(k)))) };
      });
      let [sum, largest, values, differing, objects] = [0, 0, 0, 0, 0];
      const masks = await segmentVideo(framesOfVideo(path)).collect();
      let k = 0;
      for await (const { frame } of framesOfVideo(path)) {
        const [pixels, labels] = [seen.pixels[k], seen.labels[k]].map((text) => Buffer.from(text, 'base64'));
        pixels.forEach((level, at) => {
          if (at % 4 === 3) return;
          const difference = Math.abs(level - frame.data[at]);
          sum += difference;
          largest = Math.max(largest, difference);
          values += 1;
        });
        masks.labels(k).forEach((label, p) => {
          differing += Number(label !== labels[p]);
          objects += Number(label > 0);
        });
        k += 1;
      }
      assert.equal(k, CLIP.count);
      const share = (count) => `${((300 * count) / values).toFixed(2)} %`;
      t.diagnostic(`levels differ by ${(sum / values).toFixed(2)} of 255 on average, by ${largest} at most`);
      t.diagnostic(`${share(differing)} of mask pixels differ, where ${share(objects)} are an object's`);
      assert.ok(objects / (values / 3) > 0.08, 'the object is found');
      assert.ok(sum / values < 3 && differing / (values / 3) < 0.005, `${sum / values} levels, ${share(differing)}`);
    });
  },
);
