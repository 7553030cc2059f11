// Clips longer than a window, in a worker: bounded memory, labels that last, cuts.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { describe, test } from 'node:test';
import { launchBrowser } from '../../scripts/browser.mjs';
import { serve } from '../../scripts/serve.mjs';
import { onlyLong } from './support.mjs';
import { openLibrary, useLibrary } from './video-support.mjs';

/**
 * Runs `work` in a page of a browser of its own; `peak` is the most memory that the page's process ever took, null
 * where that cannot be known.
 */
async function alone(work, argument) {
  const server = await serve();
  // What is garbage is collected when the page says so: a late collection is no memory that is held.
  const browser = await launchBrowser({ args: ['--js-flags=--expose-gc'] });
  try {
    const { page, faults } = await openLibrary({ url: server.url, browser });
    page.setDefaultTimeout(900_000);
    const seen = await page.evaluate(work, argument);
    return { ...seen, faults, peak: await peakOfRenderers(browser) };
  } finally {
    await browser.close();
    await server.close();
  }
}

async function peakOfRenderers(browser) {
  const session = await browser.newBrowserCDPSession();
  const { processInfo } = await session.send('SystemInfo.getProcessInfo');
  try {
    const peaks = processInfo
      .filter(({ type }) => type === 'renderer')
      .map(({ id }) => /VmHWM:\s+(\d+)/.exec(readFileSync(`/proc/${id}/status`, 'utf8'))[1]);
    return Math.max(...peaks.map(Number)) * 1024;
  } catch {
    return null;
  }
}

/** Runs in the page: segments a synthetic clip frame by frame, keeps nothing but counts. */
async function segmentLong(frames) {
  const made = await tracecut.synthClip({ width: 320, height: 180, frames, seed: 0 });
  async function* stream() {
    for (let t = 0; t < frames; t += 1) yield made.frame(t);
  }
  const windows = [];
  const indices = [];
  for await (const window of tracecut.segmentVideo(stream())) {
    // votes[object][label]: pixels of the object that have the label.
    const votes = Array.from({ length: made.numObjects + 1 }, () => ({}));
    for (const { index, labels } of window.frames()) {
      indices.push(index);
      const mask = made.mask(index);
      mask.forEach((object, at) => (votes[object][labels[at]] = (votes[object][labels[at]] ?? 0) + 1));
    }
    windows.push({ votes, shot: window.shot, memoryBytes: window.memoryBytes });
    globalThis.gc();
  }
  return { windows, indices };
}

/**
 * Of an object's pixels in a window: its label, the share of the pixels that have it, and whether it was found at all.
 */
function verdict(votes) {
  const total = Object.values(votes).reduce((sum, count) => sum + count, 0);
  const [label, count] = Object.entries(votes).sort(([, a], [, b]) => b - a)[0];
  return { label: Number(label), share: count / total };
}

describe('a clip of 320 frames', { timeout: 1_200_000, ...onlyLong }, () => {
  test('takes hardly more memory than one of 100, and its objects keep their labels', async (t) => {
    const short = await alone(segmentLong, 100);
    const long = await alone(segmentLong, 320);
    assert.deepEqual(
      long.indices,
      Array.from({ length: 320 }, (_, k) => k),
    );
    assert.deepEqual([...short.faults, ...long.faults], []);

    const most = ({ windows }) => Math.max(...windows.map(({ memoryBytes }) => memoryBytes));
    const ratio = most(long) / most(short);
    t.diagnostic(
      `wasm memory of 320 frames against 100: ${megabytes(most(long))} against ${megabytes(most(short))}, ${ratio.toFixed(3)}`,
    );
    assert.ok(ratio <= 1.3, `${ratio} times the memory`);
    if (long.peak && short.peak) {
      t.diagnostic(
        `peak of the whole process: ${megabytes(long.peak)} against ${megabytes(short.peak)}, ${(long.peak / short.peak).toFixed(3)}`,
      );
      assert.ok(long.peak <= 1.3 * short.peak, `${long.peak} bytes against ${short.peak}`);
    }

    assert.deepEqual([...new Set(long.windows.map(({ shot }) => shot))], [0], 'a cut is seen where there is none');
    const seen = [1, 2, 3].map((object) =>
      long.windows.map(({ votes }) => verdict(votes[object])).filter(({ label }) => label > 0),
    );
    seen.forEach((verdicts, k) => {
      const shares = verdicts.map(({ label, share }) => `${label} (${(100 * share).toFixed(0)} %)`).join(', ');
      t.diagnostic(`object ${k + 1} is found in ${verdicts.length} of ${long.windows.length} windows, as ${shares}`);
      assert.ok(verdicts.length >= 4, `object ${k + 1} is found in ${verdicts.length} windows`);
    });
    const labels = seen.map((verdicts) => new Set(verdicts.map(({ label }) => label)));
    // The first and the third are in sight all the time. The second goes behind another twice, where no trajectory
    // survives.
    assert.deepEqual([labels[0].size, labels[2].size], [1, 1]);
    assert.ok(labels[1].size <= 2, `${labels[1].size} labels`);
    const all = labels.flatMap((set) => [...set]);
    assert.equal(new Set(all).size, all.length, 'two objects share a label');
  });
});

const megabytes = (bytes) => `${(bytes / 2 ** 20).toFixed(1)} MB`;

describe('a video file in windows', { timeout: 600_000 }, () => {
  const library = useLibrary();

  test('a cut is found at its frame; both sides have objects, and none in common', async () => {
    const { shots, objects, times } = await library.page.evaluate(async () => {
      const parts = await Promise.all(
        [0, 4].map((seed) => tracecut.synthClip({ width: 192, height: 108, frames: 12, seed })),
      );
      const media = await import('/dist/vendor/media.js');
      const output = new media.Output({ format: new media.WebMOutputFormat(), target: new media.BufferTarget() });
      const source = new media.VideoSampleSource({ codec: 'vp8', bitrate: 4e6 });
      output.addVideoTrack(source);
      await output.start();
      const context = new OffscreenCanvas(192, 108).getContext('2d');
      for (let k = 0; k < 24; k += 1) {
        const { data } = parts[k < 12 ? 0 : 1].frame(k % 12);
        context.putImageData(new ImageData(data, 192, 108), 0, 0);
        const sample = new media.VideoSample(context.canvas, { timestamp: k / 10, duration: 0.1 });
        await source.add(sample);
        sample.close();
      }
      await output.finalize();
      const result = await tracecut.segmentVideo(new Blob([output.target.buffer]), { window: 9, overlap: 3 }).collect();
      return {
        shots: result.shots,
        objects: result.objects.map(({ areas, ...facts }) => facts),
        times: [...result.times],
      };
    });
    assert.deepEqual(shots, [
      { first: 0, last: 11 },
      { first: 12, last: 23 },
    ]);
    times.forEach((time, k) => assert.ok(Math.abs(time - k / 10) < 0.001, `frame ${k} at ${time} s`));
    assert.ok(
      objects.some(({ lastFrame }) => lastFrame < 12) && objects.some(({ firstFrame }) => firstFrame >= 12),
      JSON.stringify(objects),
    );
    assert.deepEqual(
      objects.filter(({ firstFrame, lastFrame }) => firstFrame < 12 && lastFrame >= 12),
      [],
    );
  });

  test('leaving early, an abort and close end the worker, and the page can segment again', async () => {
    const seen = await library.page.evaluate(async () => {
      const made = await tracecut.synthClip({ width: 96, height: 64, frames: 24, seed: 1 });
      const frames = Array.from({ length: 24 }, (_, t) => made.frame(t));
      const options = { window: 8, overlap: 3, threads: 1 };
      const { Worker } = globalThis;
      const workers = { open: 0 };
      globalThis.Worker = class extends Worker {
        constructor(...given) {
          super(...given);
          workers.open += 1;
        }
        terminate() {
          super.terminate();
          workers.open -= 1;
        }
      };
      const counts = [];
      for await (const window of tracecut.segmentVideo(frames, options)) {
        counts.push(workers.open);
        if (window.index === 1) break;
      }
      const controller = new AbortController();
      const onProgress = ({ window }) => window === 1 && controller.abort(new Error('enough'));
      const aborted = await failure(
        tracecut.segmentVideo(frames, { ...options, signal: controller.signal, onProgress }).collect(),
      );
      counts.push(workers.open);
      const video = tracecut.segmentVideo(frames, options);
      const collecting = failure(video.collect());
      setTimeout(() => video.close(), 100);
      const closed = await collecting;
      // A worker that was still being started when it was closed ends as soon as it has started.
      while (workers.open > 0) await new Promise((resolve) => setTimeout(resolve, 10));
      counts.push(workers.open);
      const result = await tracecut.segmentVideo(frames, options).collect();
      counts.push(workers.open);
      globalThis.Worker = Worker;
      return { counts, aborted, closed, numFrames: result.numFrames };
    });
    assert.deepEqual(seen.counts, [1, 1, 0, 0, 0]);
    assert.equal(seen.aborted.message, 'enough');
    assert.equal(seen.closed.code, 'closed');
    assert.equal(seen.numFrames, 24);
    assert.deepEqual(library.faults, []);
  });
});
