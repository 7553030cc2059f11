// A halted segmentation keeps what it has, and goes on as if it had never been halted.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { setTimeout as delay } from 'node:timers/promises';
import { segmentVideo, VideoResult } from 'tracecut';
import { framesOf, rejects } from './support.mjs';

const CLIP = { width: 160, height: 90, frames: 30, seed: 3 };
const WINDOWS = { window: 12, overlap: 4 };

const everything = (result) => ({
  times: [...result.times],
  shots: result.shots,
  labels: result.times.reduce((all, _, t) => [...all, String(result.labels(t))], []),
  tracks: result.toTracksDat(),
});

for (const threads of [1, 2]) {
  test(`paused in every stage of the second window, ${threads} threads: the same result`, async () => {
    const frames = await framesOf(CLIP);
    const expected = everything(await segmentVideo(frames, { ...WINDOWS, threads }).collect());
    const halted = new Set();
    let steps = 0;
    const video = segmentVideo(frames, {
      ...WINDOWS,
      threads,
      onProgress({ stage, window }) {
        steps += 1;
        if (window !== 1 || halted.has(stage) || video.paused) return;
        halted.add(stage);
        video.pause();
      },
    });
    const collecting = video.collect();
    /** @type {VideoResult | null} */
    let partial = null;
    let pauses = 0;
    let over = false;
    collecting.finally(() => (over = true)).catch(() => {});
    const watching = (async () => {
      while (!over) {
        await delay(5);
        if (!video.paused) continue;
        // What was under way when it was paused may still end.
        let before;
        do {
          before = steps;
          await delay(60);
        } while (steps !== before && !over);
        assert.equal(over, false, 'it went on while it was paused');
        partial ??= video.collected;
        pauses += 1;
        video.resume();
      }
    })();
    // What goes wrong while watching is told at once, as nothing would resume the video then.
    const result = await Promise.race([collecting, watching.then(() => collecting)]);
    assert.ok(pauses >= 4 && halted.has('decode'), `paused ${pauses} times in ${[...halted]}`);
    assert.deepEqual(everything(result), expected);
    assert.ok(partial instanceof VideoResult);
    assert.ok(partial.numFrames >= 6 && partial.numFrames < 30, `${partial.numFrames} frames`);
    const { labels, times } = everything(partial);
    assert.deepEqual(labels, expected.labels.slice(0, partial.numFrames));
    assert.deepEqual(times, expected.times.slice(0, partial.numFrames));
    assert.equal(partial.shots.at(-1).last, partial.numFrames - 1);
    const { startFrame, offset, count } = partial.trajectories;
    assert.ok(count > 100);
    for (let i = 0; i < count; i += 1)
      assert.ok(startFrame[i] + offset[i + 1] - offset[i] <= partial.numFrames, 'a track leads beyond the end');
  });
}

test('a paused segmentation can be closed; one that has not begun waits', async () => {
  const frames = await framesOf(CLIP);
  const video = segmentVideo(frames, WINDOWS);
  assert.equal(video.collected, null);
  video.pause();
  video.pause();
  const collecting = video.collect();
  collecting.catch(() => {});
  await delay(30);
  assert.equal(video.collected, null);
  assert.equal(video.paused, true);
  video.close();
  await rejects(collecting, 'closed');
});
