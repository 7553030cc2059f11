// The intake table in Chromium, by the package: frames and facts of files, masks of folders.

import { readdirSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { CASES, checkOutcome, maskOfRed } from '../intake/cases.mjs';
import { CLIP, ensureClips } from '../intake/clips.mjs';
import { expect, test, useLibrary } from './fixtures.mjs';
import { needsFfmpeg } from './video-clips.mjs';

needsFfmpeg();

const SIZE = { width: CLIP.width, height: CLIP.height };
const library = useLibrary((page) => page.evaluate(`globalThis.maskOfRed = ${maskOfRed}`));

for (const row of CASES.filter(({ except }) => !except?.page))
  test(row.name, async () => {
    const path = join(ensureClips(), row.file);
    const isFolder = statSync(path).isDirectory();
    await library.page.setInputFiles('#file', isFolder ? filesIn(path) : path);
    const outcome = await library.page.evaluate(readInPage, { isFolder });
    if (row.error) {
      expect(outcome.error).toMatchObject({ code: row.error, message: expect.stringMatching(row.words) });
    } else {
      expect(outcome.error).toBeUndefined();
      checkOutcome(row, outcome);
      if (outcome.info && !row.isTruncated) checkInfo(row, outcome);
    }
  });

/** Checks the facts of a file against its frames. */
function checkInfo(row, { info, times, lastDuration }) {
  expect(info).toMatchObject({ ...SIZE, numFrames: row.numFrames, decodable: true });
  expect(info.times).toEqual(times);
  const duration = times.at(-1) + lastDuration - times[0];
  expect(info.duration).toBeCloseTo(duration, 6);
  expect(info.frameRate).toBeCloseTo(info.numFrames / duration, 5);
}

const filesIn = (folder) =>
  readdirSync(folder, { withFileTypes: true })
    .filter((entry) => entry.isFile())
    .map(({ name }) => join(folder, name));

/** Runs in the page: reads frames and facts of a file, or segments a folder. */
async function readInPage({ isFolder }) {
  const { readFrames, segmentVideo, videoFrames, videoInfo } = globalThis.tracecut;
  const { files } = document.querySelector('#file');
  const outcome = { times: null, masks: [], isTruncated: false };
  const onDamage = () => (outcome.isTruncated = true);
  // The masks that are checked: more of them take long to transfer.
  const endMasks = (count, maskOf) => Object.fromEntries([0, count - 1].map((t) => [t, [...maskOf(t)]]));
  try {
    if (isFolder) {
      const result = await segmentVideo(readFrames([...files])).collect();
      const { width, height, numFrames } = result;
      return { ...outcome, width, height, numFrames, masks: endMasks(numFrames, (t) => result.labels(t)) };
    }
    outcome.times = [];
    for await (const { pixels, width, height, time, duration } of videoFrames(files[0], { onDamage })) {
      Object.assign(outcome, { width, height, lastDuration: duration });
      outcome.masks.push(globalThis.maskOfRed(await pixels()));
      outcome.times.push(time);
    }
    const info = await videoInfo(files[0], { onDamage });
    const masks = endMasks(outcome.masks.length, (t) => outcome.masks[t]);
    return { ...outcome, masks, numFrames: outcome.times.length, info: { ...info, times: [...info.times] } };
  } catch (error) {
    return { error: { code: error.code ?? error.name, message: error.message } };
  }
}
