// The intake table on the command line.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { CASES, checkOutcome } from '../intake/cases.mjs';
import { ensureClips, hasFfmpeg } from '../intake/clips.mjs';
import { commandLine } from '../native.mjs';
import { readPng } from '../png.mjs';

/** Exit code for data that cannot be read, or only in part. */
const BAD_INPUT = 3;

const skip = hasFfmpeg() ? (commandLine() ? false : 'needs the command line that Cargo built') : 'needs ffmpeg';

for (const row of CASES) {
  test(row.name, { skip }, (t) => {
    const folder = mkdtempSync(join(tmpdir(), 'tracecut-intake-'));
    t.after(() => rmSync(folder, { recursive: true }));
    const out = join(folder, 'out');
    const args = ['segment', join(ensureClips(), row.file), '--out', out, '--format', 'png', '--quiet'];
    const { status, stderr } = spawnSync(commandLine(), args, { encoding: 'utf8' });
    if (row.error) {
      assert.equal(status, BAD_INPUT, stderr);
      assert.match(stderr, row.words);
    } else {
      assert.equal(status, row.isTruncated ? BAD_INPUT : 0, stderr);
      checkOutcome(row, outcomeIn(out));
    }
  });
}

function outcomeIn(out) {
  const report = JSON.parse(readFileSync(join(out, 'result.json'), 'utf8'));
  const masks = readdirSync(join(out, 'masks'))
    .sort()
    .map((name) => readPng(readFileSync(join(out, 'masks', name))));
  return {
    width: masks[0].width,
    height: masks[0].height,
    numFrames: masks.length,
    times: report.times ?? null,
    lastDuration: report.durations?.at(-1),
    isTruncated: report.truncated !== undefined,
    masks: masks.map(({ pixels }) => pixels),
  };
}
