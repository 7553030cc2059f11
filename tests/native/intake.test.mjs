// The intake table: frames of files by ffmpeg, masks of folders by readFrames, containers as the package reads them in
// browsers, and masks on the command line. What browsers decode is tested in tests/browser/video-files.spec.mjs.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { existsSync, mkdtempSync, openAsBlob, readdirSync, readFileSync, rmSync, statSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, describe, test } from 'node:test';
import { readFrames, segmentVideo } from 'tracecut';
import { framesOfVideo } from 'tracecut/node';
import { videoInfo } from '../../dist/index.js';
import { root } from '../../scripts/tools.mjs';
import { CASES, CLIP, checkOutcome, ensureClips, hasFfmpeg, maskOfRed } from '../intake.mjs';
import { readPng } from '../png.mjs';

const withoutFfmpeg = hasFfmpeg() ? false : 'needs ffmpeg';

describe('in Node', { skip: withoutFfmpeg }, () => {
  for (const row of CASES)
    test(row.name, async () => {
      const path = join(ensureClips(), row.file);
      const code = row.error ?? row.except?.node;
      if (!code) return checkOutcome(row, await outcomeOf(path));
      await assert.rejects(outcomeOf(path), (error) => error.code === code && row.words.test(error.message));
    });
});

describe('the container, as read in browsers', { skip: withoutFfmpeg }, () => {
  // Nothing is decoded.
  before(() => (globalThis.VideoDecoder = { isConfigSupported: async () => ({ supported: false }) }));
  after(() => delete globalThis.VideoDecoder);

  for (const row of CASES.filter(({ times }) => times))
    test(row.name, async () => {
      const file = await openAsBlob(join(ensureClips(), row.file));
      const animated = /\.(png|gif|webp)$/.test(row.file) && { error: 'unsupported', words: /cannot decode animated/ };
      const { error: code, words: message } = animated || row;
      const reading = videoInfo(file, { onDamage() {} });
      if (code) return assert.rejects(reading, (error) => error.code === code && message.test(error.message));
      const { width, height, numFrames, times, duration, frameRate, decodable } = await reading;
      assert.deepEqual({ width, height, decodable }, { width: CLIP.width, height: CLIP.height, decodable: false });
      // Damage is known only after decoding.
      if (row.isTruncated) return assert.ok(numFrames >= row.numFrames, `${numFrames} frames`);
      const lastDuration = row.lastDuration ?? times.at(-1) - times.at(-2);
      checkOutcome(
        { ...row, lastDuration, masks: false },
        { width, height, numFrames, times, lastDuration, isTruncated: false },
      );
      if (row.lastDuration)
        assert.ok(Math.abs(duration - (times.at(-1) + lastDuration - times[0])) < 1e-3, `${duration} s`);
      assert.ok(Math.abs(frameRate - numFrames / duration) < 1e-5, `${frameRate} frames per second`);
    });
});

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

/** The command line: the one of the environment, or what Cargo built last. */
const PROGRAM =
  process.env.TRACECUT_CLI ?? join(root, 'target', 'debug', process.platform === 'win32' ? 'tracecut.exe' : 'tracecut');
const withoutProgram = existsSync(PROGRAM) ? false : 'needs the command line that Cargo built';

describe('on the command line', { skip: withoutFfmpeg || withoutProgram }, () => {
  // At half of the clips' size the square is found too, in half the time.
  for (const row of CASES)
    test(row.name, () => {
      const { status, stderr, out } = segment(row.file, '--set', `clip.maxSide=${CLIP.width / 2}`);
      if (row.error) {
        assert.equal(status, BAD_INPUT, stderr);
        assert.match(stderr, row.words);
      } else {
        assert.equal(status, row.isTruncated ? BAD_INPUT : 0, stderr);
        checkOutcome(row, outcomeIn(out));
      }
    });

  for (const file of ['bt709.mp4', 'sar.mp4', 'vfr.mp4'])
    test(`the masks of ${file} are the same as in Node`, async () => {
      const { masks } = outcomeIn(segment(file).out);
      const result = await segmentVideo(framesOfVideo(join(ensureClips(), file))).collect();
      assert.equal(result.numFrames, masks.length);
      masks.forEach((mask, k) => assert.deepEqual(result.labels(k), mask, `picture ${k}`));
    });
});

const folder = mkdtempSync(join(tmpdir(), 'tracecut-intake-'));
after(() => rmSync(folder, { recursive: true }));

function segment(file, ...options) {
  const out = join(mkdtempSync(join(folder, 'run-')), 'out');
  const args = ['segment', join(ensureClips(), file), '--out', out, '--format', 'png', '--quiet', ...options];
  return { ...spawnSync(PROGRAM, args, { encoding: 'utf8' }), out };
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
