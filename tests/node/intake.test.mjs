// The intake table: frames of files by ffmpeg, masks of folders by readFrames, and the same masks on the command line.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readdirSync, readFileSync, rmSync, statSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { readFrames, segmentVideo } from 'tracecut';
import { framesOfVideo } from 'tracecut/node';
import { CASES, checkOutcome, maskOfRed } from '../intake/cases.mjs';
import { ensureClips, hasFfmpeg } from '../intake/clips.mjs';
import { commandLine } from '../programs.mjs';
import { readPng } from '../png.mjs';

const withoutFfmpeg = hasFfmpeg() ? false : 'needs ffmpeg';

for (const row of CASES) {
  test(row.name, { withoutFfmpeg }, async () => {
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

/** Exit code for data that cannot be read, or only in part. */
const BAD_INPUT = 3;

const skip = hasFfmpeg() ? (commandLine() ? false : 'needs the command line that Cargo built') : 'needs ffmpeg';

for (const row of CASES) {
  test(row.name, { skip }, (t) => {
    const { status, stderr, out } = segment(t, row.file);
    if (row.error) {
      assert.equal(status, BAD_INPUT, stderr);
      assert.match(stderr, row.words);
    } else {
      assert.equal(status, row.isTruncated ? BAD_INPUT : 0, stderr);
      checkOutcome(row, outcomeIn(out));
    }
  });
}

for (const file of ['bt709.mp4', 'sar.mp4', 'vfr.mp4']) {
  test(`the masks of ${file} are the same in Node`, { skip }, async (t) => {
    const { masks } = outcomeIn(segment(t, file).out);
    const result = await segmentVideo(framesOfVideo(join(ensureClips(), file))).collect();
    assert.equal(result.numFrames, masks.length);
    masks.forEach((mask, k) => assert.deepEqual(result.labels(k), mask, `picture ${k}`));
  });
}

function segment(t, file) {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-intake-'));
  t.after(() => rmSync(folder, { recursive: true }));
  const out = join(folder, 'out');
  const args = ['segment', join(ensureClips(), file), '--out', out, '--format', 'png', '--quiet'];
  return { ...spawnSync(commandLine(), args, { encoding: 'utf8' }), out };
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
