// Files of the intake table whose frames depend on the decoders of Chromium: frames and facts of videos, masks of folders.
// tests/node/intake.test.mjs reads the containers of all files.

import { readdirSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { CASES, CLIP, checkOutcome, ensureClips, maskOfRed } from '../intake.mjs';
import { expect, test, useLibrary } from './fixtures.mjs';
import { needsFfmpeg } from './video-clips.mjs';

needsFfmpeg();

const SIZE = { width: CLIP.width, height: CLIP.height };
const library = useLibrary((page) => page.evaluate(`globalThis.maskOfRed = ${maskOfRed}`));

/** One or two files for each codec, transform, colour space, kind of damage and kind of animated image. */
const DECODED_FILES = [
  ...['plain.mp4', 'vp9.webm', 'recording.webm', 'alpha.webm', 'alpha-vp9.webm', 'edit-list.mp4', 'cover.mkv'],
  ...['rot90.mp4', 'rot180.mp4', 'mirrored.mp4', 'sar.mp4', 'sar-high.mp4', 'size-changes.webm', 'bt709.mp4'],
  ...['cut-off.mp4', 'cut-off.webm', 'cut-off-fragments.mp4', 'hole.mp4'],
  ...['delays.png', 'delays.gif', 'delays.webp', 'exif'],
];

for (const row of CASES.filter(({ file }) => DECODED_FILES.includes(file)))
  test(row.name, async () => {
    const path = join(ensureClips(), row.file);
    const isFolder = statSync(path).isDirectory();
    await library.page.setInputFiles('#file', isFolder ? filesIn(path) : path);
    const outcome = await library.page.evaluate(readInPage, { isFolder });
    expect(outcome.error).toBeUndefined();
    checkOutcome(row, outcome);
    if (outcome.info && !row.isTruncated) checkInfo(row, outcome);
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
