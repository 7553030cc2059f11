// What a phone films, whole: 75 frames of 1920 × 1080 with AAC, dropped on the page and saved as a transparent video with
// its sound, in two clicks. Looked at by ffprobe and ffmpeg. How long it took is printed.

import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { bytesOf, ended, exportAs, sharedClips, useSite } from '../browser/support.mjs';

const FRAMES = 75;
const RATE = 25;
/** Seconds from click to click, and how long one is. */
const BEAT = 0.5;
const CLICK = 0.01;
/** How far picture and sound may be apart, in seconds. */
const MOST_APART = 0.04;
const PCM_RATE = 48000;

const pictures = join(sharedClips, '..', 'davis', 'camel', 'JPEGImages');
const folder = mkdtempSync(join(tmpdir(), 'tracecut-'));
const site = useSite({ sample: 'tiny' });
after(() => rmSync(folder, { recursive: true, force: true }));

const missing = [
  existsSync(pictures) ? [] : pictures,
  ['ffmpeg', 'ffprobe'].filter((name) => spawnSync(name, ['-version']).error),
].flat();
const skip = missing.length > 0 && `${missing.join(', ')}: not here`;

const ffmpeg = (...args) => execFileSync('ffmpeg', ['-v', 'error', ...args], { maxBuffer: 2 ** 30 });

test('a clip of a phone becomes a transparent video with its sound', { skip }, async () => {
  const source = join(folder, 'phone.mp4');
  const clicks = `aevalsrc='if(lt(mod(t,${BEAT}),${CLICK}),sin(6283*t),0)':s=44100:d=${FRAMES / RATE}`;
  ffmpeg(
    ...['-framerate', String(RATE), '-i', join(pictures, '%05d.jpg'), '-f', 'lavfi', '-i', clicks],
    ...['-frames:v', String(FRAMES), '-vf', 'scale=1920:1080:flags=lanczos,setsar=1', '-pix_fmt', 'yuv420p'],
    ...['-c:v', 'libx264', '-preset', 'veryfast', '-crf', '18', '-c:a', 'aac', '-shortest', '-y', source],
  );
  const { page, faults } = await site.open();
  assert.equal(await ended(page), 'done');
  const begun = performance.now();
  await page.setInputFiles('#file', source);
  await page.waitForFunction(() => globalThis.tracecutStudio.source?.name === 'phone.mp4');
  assert.equal(await ended(page), 'done', await page.evaluate(() => document.querySelector('#error').innerText));
  const segmented = performance.now();
  await page.click('#export-open');
  const [video] = await Promise.all([page.waitForEvent('download'), exportAs(page, 'transparent')]);
  const made = join(folder, 'phone.webm');
  writeFileSync(made, await bytesOf(video));
  const seconds = (from, to) => ((to - from) / 1000).toFixed(1);
  const saved = performance.now();
  console.log(`segmented in ${seconds(begun, segmented)} s, saved in ${seconds(segmented, saved)} s`);
  assert.equal(video.suggestedFilename(), 'phone-cutout.webm');
  assert.deepEqual(faults, []);

  const streams = probed(made);
  const picture = streams.find(({ codec_type: type }) => type === 'video');
  const sound = streams.find(({ codec_type: type }) => type === 'audio');
  assert.deepEqual([picture.width, picture.height, Number(picture.nb_read_packets)], [1920, 1080, FRAMES]);
  assert.equal(picture.tags.alpha_mode ?? picture.tags.ALPHA_MODE, '1');
  assert.equal(sound.codec_name, 'opus');
  assert.ok(Math.abs(Number(picture.start_time)) < MOST_APART, `the picture begins at ${picture.start_time} s`);
  const heard = clicksOf(made);
  assert.deepEqual(clicksOf(source).length, heard.length);
  heard.forEach((at, k) => assert.ok(Math.abs(at - BEAT * k) < MOST_APART, `click ${k} at ${at} s`));
  const opaque = shareOpaque(made, picture.codec_name);
  assert.equal(opaque.length, FRAMES);
  // The camel fills some tenth of the picture.
  assert.ok(
    Math.min(...opaque) > 0.03 && Math.max(...opaque) < 0.5,
    `opaque: ${opaque.map((share) => share.toFixed(2))}`,
  );
});

function probed(file) {
  const args = ['-v', 'error', '-count_packets', '-show_streams', '-of', 'json', file];
  return JSON.parse(execFileSync('ffprobe', args)).streams;
}

/** When clicks begin, in seconds of the file's clock. */
function clicksOf(file) {
  const clock = ['-af', 'aresample=async=1:first_pts=0', '-ar', String(PCM_RATE)];
  const bytes = ffmpeg('-i', file, '-vn', '-ac', '1', ...clock, '-f', 'f32le', '-');
  const samples = new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  const times = [];
  samples.forEach((sample, k) => {
    const at = k / PCM_RATE;
    if (Math.abs(sample) > 0.3 && at - (times.at(-1) ?? -1) > BEAT / 2) times.push(at);
  });
  return times;
}

/** The share of each frame that is more opaque than not. */
function shareOpaque(file, codec) {
  const decoder = codec === 'vp8' ? 'libvpx' : 'libvpx-vp9';
  const alpha = ['-vf', 'alphaextract,scale=192:108', '-pix_fmt', 'gray', '-f', 'rawvideo', '-'];
  const bytes = ffmpeg('-c:v', decoder, '-i', file, ...alpha);
  const [size, count] = [192 * 108, bytes.length / (192 * 108)];
  const share = (frame) => frame.reduce((sum, value) => sum + (value > 127 ? 1 : 0), 0) / size;
  return Array.from({ length: count }, (_, t) => share(bytes.subarray(t * size, (t + 1) * size)));
}
