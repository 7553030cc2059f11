// The intake table in Chromium, by the package alone: frames and facts of files, masks of folders.

import assert from 'node:assert/strict';
import { readdirSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { before, describe, test } from 'node:test';
import { CASES, checkOutcome, maskOfRed } from '../intake/cases.mjs';
import { CLIP, ensureClips, hasFfmpeg } from '../intake/clips.mjs';
import { useLibrary } from './video-support.mjs';

const skip = hasFfmpeg() ? false : 'needs ffmpeg';
const SIZE = { width: CLIP.width, height: CLIP.height };

describe('the intake table in Chromium', () => {
  const library = useLibrary();
  before(() => library.page.evaluate(`globalThis.maskOfRed = ${maskOfRed}`));

  for (const row of CASES) {
    test(row.name, { skip: skip || (row.except?.page ?? false) }, async () => {
      const path = join(ensureClips(), row.file);
      const isFolder = statSync(path).isDirectory();
      await library.page.setInputFiles('#file', isFolder ? filesIn(path) : path);
      const outcome = await library.page.evaluate(outcomeOf, { isFolder });
      if (row.error) {
        assert.equal(outcome.error?.code, row.error, outcome.error?.message ?? 'no error');
        assert.match(outcome.error.message, row.words);
      } else {
        assert.equal(outcome.error, undefined, outcome.error?.message);
        checkOutcome(row, outcome);
        if (outcome.info && !row.isTruncated) checkInfo(row, outcome);
      }
    });
  }
});

/** The facts of a file are those of its frames. */
function checkInfo(row, { info, times, lastDuration }) {
  const { width, height, numFrames, decodable } = info;
  assert.deepEqual({ width, height, numFrames, decodable }, { ...SIZE, numFrames: row.numFrames, decodable: true });
  assert.deepEqual(info.times, times);
  const duration = times.at(-1) + lastDuration - times[0];
  assert.ok(Math.abs(info.duration - duration) < 1e-6, `${info.duration} s, not ${duration} s`);
  assert.ok(Math.abs(info.frameRate - numFrames / duration) < 1e-5, `${info.frameRate} frames a second`);
}

const filesIn = (folder) =>
  readdirSync(folder, { withFileTypes: true })
    .filter((entry) => entry.isFile())
    .map(({ name }) => join(folder, name));

/** Runs in the page: frames and facts of a file, the masks of a folder. */
async function outcomeOf({ isFolder }) {
  const { readFrames, segmentVideo, videoFrames, videoInfo } = globalThis.tracecut;
  const { files } = document.querySelector('#file');
  const outcome = { times: null, masks: [], isTruncated: false };
  const onDamage = () => (outcome.isTruncated = true);
  // The masks that are looked at: more take long on their way here.
  const ends = (count, maskOf) => Object.fromEntries([0, count - 1].map((t) => [t, [...maskOf(t)]]));
  try {
    if (isFolder) {
      const result = await segmentVideo(readFrames([...files])).collect();
      const { width, height, numFrames } = result;
      return { ...outcome, width, height, numFrames, masks: ends(numFrames, (t) => result.labels(t)) };
    }
    outcome.times = [];
    for await (const { pixels, width, height, time, duration } of videoFrames(files[0], { onDamage })) {
      Object.assign(outcome, { width, height, lastDuration: duration });
      outcome.masks.push(globalThis.maskOfRed(await pixels()));
      outcome.times.push(time);
    }
    const info = await videoInfo(files[0], { onDamage });
    const masks = ends(outcome.masks.length, (t) => outcome.masks[t]);
    return { ...outcome, masks, numFrames: outcome.times.length, info: { ...info, times: [...info.times] } };
  } catch (error) {
    return { error: { code: error.code ?? error.name, message: error.message } };
  }
}
