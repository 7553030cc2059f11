// Command line and Node read the same pictures of a video file, and so they make the same masks.

import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { framesOfVideo, segmentVideo } from 'tracecut/node';
import { hasFfmpeg } from '../intake/clips.mjs';
import { commandLine } from '../native.mjs';
import { readPng } from '../png.mjs';

const NUM_FRAMES = 25;
/** Pixels of the object, which covers 9% of a picture. */
const OBJECT = '64x60';

/** Makes an MP4 in BT.709 and the limited range, as nearly all HD video is: a square that moves over a still ground. */
function makeClip(path) {
  const texture = (colour, size, seed) =>
    `-f lavfi -i color=${colour}:s=${size}:r=25,format=rgb24,noise=alls=90:all_seed=${seed},gblur=1,loop=-1:1`;
  const moving = '[0][1]overlay=x=21+3*n:y=39+n:format=gbrp,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p';
  const tags = '-color_range tv -colorspace bt709 -color_primaries bt709 -color_trc bt709';
  const line =
    `-v error ${texture('0x5a965a', '240x180', 1)} ${texture('0xe63c28', OBJECT, 2)} -filter_complex ${moving} ` +
    `-frames:v ${NUM_FRAMES} -c:v libx264 -crf 20 ${tags}`;
  execFileSync('ffmpeg', [...line.split(' '), path]);
}

const skip = hasFfmpeg() ? (commandLine() ? false : 'needs the command line that Cargo built') : 'needs ffmpeg';

test('an MP4 has the same masks on the command line and in Node', { skip }, async (t) => {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-same-'));
  t.after(() => rmSync(folder, { recursive: true }));
  const [clip, out] = [join(folder, 'clip.mp4'), join(folder, 'out')];
  makeClip(clip);
  const { status, stderr } = spawnSync(commandLine(), ['segment', clip, '--out', out, '--quiet'], { encoding: 'utf8' });
  assert.equal(status, 0, stderr);
  const result = await segmentVideo(framesOfVideo(clip)).collect();
  const names = readdirSync(join(out, 'masks')).sort();
  assert.deepEqual([names.length, result.numFrames], [NUM_FRAMES, NUM_FRAMES]);
  names.forEach((name, k) => {
    const { pixels } = readPng(readFileSync(join(out, 'masks', name)));
    assert.ok(Buffer.from(pixels).equals(Buffer.from(result.labels(k))), `mask ${k} differs`);
  });
  const share = result.objects[0].meanArea / (result.width * result.height);
  assert.ok(share > 0.08 && share < 0.1, `the object covers ${share} of a picture`);
});
