// The intake table in Node: files by ffmpeg, folders by readFrames.

import assert from 'node:assert/strict';
import { statSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { readFrames, segmentVideo } from 'tracecut';
import { framesOfVideo } from 'tracecut/node';
import { CASES, checkOutcome } from '../intake/cases.mjs';
import { ensureClips, hasFfmpeg } from '../intake/clips.mjs';

const skip = hasFfmpeg() ? false : 'needs ffmpeg';

for (const row of CASES) {
  test(row.name, { skip }, async () => {
    const path = join(ensureClips(), row.file);
    const refusal = row.error ?? row.except?.node;
    if (refusal) {
      const isExpected = (error) => error.code === refusal && row.words.test(error.message);
      await assert.rejects(segmentFile(path), isExpected);
    } else checkOutcome(row, await segmentFile(path));
  });
}

async function segmentFile(path) {
  const isFolder = statSync(path).isDirectory();
  let isTruncated = false;
  const onDamage = () => (isTruncated = true);
  const frames = isFolder ? readFrames(path) : framesOfVideo(path, { onDamage });
  const result = await segmentVideo(frames, { threads: 1 }).collect();
  return {
    width: result.width,
    height: result.height,
    numFrames: result.numFrames,
    times: isFolder ? null : result.times,
    lastDuration: result.end - result.times.at(-1),
    isTruncated,
    masks: result.times.length ? Array.from(result.times, (_, t) => result.labels(t)) : [],
  };
}
