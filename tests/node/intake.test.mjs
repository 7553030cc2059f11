// The intake table in Node: frames of files by ffmpeg, masks of folders by readFrames.

import assert from 'node:assert/strict';
import { statSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { readFrames, segmentVideo } from 'tracecut';
import { framesOfVideo } from 'tracecut/node';
import { CASES, checkOutcome, maskOfRed } from '../intake/cases.mjs';
import { ensureClips, hasFfmpeg } from '../intake/clips.mjs';

const skip = hasFfmpeg() ? false : 'needs ffmpeg';

for (const row of CASES) {
  test(row.name, { skip }, async () => {
    const path = join(ensureClips(), row.file);
    const refusal = row.error ?? row.except?.node;
    if (refusal) {
      const isExpected = (error) => error.code === refusal && row.words.test(error.message);
      await assert.rejects(outcomeOf(path), isExpected);
    } else checkOutcome(row, await outcomeOf(path));
  });
}

async function outcomeOf(path) {
  if (statSync(path).isDirectory()) {
    const result = await segmentVideo(readFrames(path), { threads: 1 }).collect();
    const { width, height, numFrames } = result;
    const masks = Array.from({ length: numFrames }, (_, t) => result.labels(t));
    return { width, height, numFrames, times: null, isTruncated: false, masks };
  }
  const outcome = { times: [], masks: [], isTruncated: false };
  for await (const { frame, time, duration } of framesOfVideo(path, { onDamage: () => (outcome.isTruncated = true) })) {
    const { width, height } = frame;
    Object.assign(outcome, { width, height, lastDuration: duration });
    outcome.masks.push(maskOfRed(frame));
    outcome.times.push(time);
  }
  return { ...outcome, numFrames: outcome.times.length };
}
