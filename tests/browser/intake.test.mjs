// The intake table in Chromium, by the package alone.

import assert from 'node:assert/strict';
import { readdirSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { describe, test } from 'node:test';
import { CASES, checkOutcome } from '../intake/cases.mjs';
import { ensureClips, hasFfmpeg } from '../intake/clips.mjs';
import { useLibrary } from './video-support.mjs';

const skip = hasFfmpeg() ? false : 'needs ffmpeg';
describe('the intake table in Chromium', () => {
  const library = useLibrary();

  for (const row of CASES) {
    test(row.name, { skip: skip || (row.except?.page ?? false) }, async () => {
      const path = join(ensureClips(), row.file);
      const isFolder = statSync(path).isDirectory();
      await library.page.setInputFiles('#file', isFolder ? filesIn(path) : path);
      const outcome = await library.page.evaluate(segmentFiles, { isFolder });
      if (row.error) {
        assert.equal(outcome.error?.code, row.error, outcome.error?.message ?? 'no error');
        assert.match(outcome.error.message, row.words);
      } else {
        assert.equal(outcome.error, undefined, outcome.error?.message);
        checkOutcome(row, outcome);
      }
    });
  }
});

const filesIn = (folder) =>
  readdirSync(folder, { withFileTypes: true })
    .filter((entry) => entry.isFile())
    .map(({ name }) => join(folder, name));

/** Runs in the page. */
async function segmentFiles({ isFolder }) {
  const { readFrames, segmentVideo } = globalThis.tracecut;
  const { files } = document.querySelector('#file');
  let isTruncated = false;
  const onDamage = () => (isTruncated = true);
  try {
    const source = isFolder ? readFrames([...files]) : files[0];
    const result = await segmentVideo(source, { onDamage }).collect();
    const times = [...result.times];
    const last = times.length - 1;
    return {
      width: result.width,
      height: result.height,
      numFrames: times.length,
      times: isFolder ? null : times,
      lastDuration: result.end - times[last],
      isTruncated,
      masks: { 0: [...result.labels(0)], [last]: [...result.labels(last)] },
    };
  } catch (error) {
    return { error: { code: error.code ?? error.name, message: error.message } };
  }
}
