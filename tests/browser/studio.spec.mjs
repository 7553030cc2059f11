// The studio as a whole: its sample on load, and a clip from a dropped file to a saved, fixed cut-out; with long and large clips,
// how busy its main thread is, and a clip as phones record it, with sound.

import { execFileSync } from 'node:child_process';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { createSession, synthClip } from '../../dist/node.js';
import { root } from '../../scripts/tools.mjs';
import { SMALL, downloadBytes, expect, openSample, runEnd, test } from './fixtures.mjs';
import { correct, dropFiles, fiveObjects, giveBytes, openFix, paint, selectTool } from './studio-page.mjs';
import { needsFfmpeg, useFilms } from './video-clips.mjs';

test('segments the sample on load, with the same labels and masks as in Node', async ({ openStudio }) => {
  const page = await openSample(openStudio);
  await expect(page.locator('#headline')).toHaveText('3 moving objects');
  await expect(page.locator('#subline')).toHaveText(/^16 frames of 192 × 108 · computed in \d/);
  await expect(page.locator('#welcome')).toHaveCount(0);
  const inPage = await page.evaluate(() => {
    const { result } = globalThis.tracecutStudio;
    const masks = Array.from({ length: result.numFrames }, (_, t) => result.labels(t).join(''));
    return { labels: [...result.clusters.label], x: [...result.trajectories.x], masks };
  });
  const clip = await synthClip(SMALL);
  const session = await createSession();
  for (let t = 0; t < clip.numFrames; t += 1) await session.push(clip.frame(t));
  const result = await session.run();
  session.close();
  expect([...result.clusters.label]).toEqual(inPage.labels);
  expect([...result.trajectories.x]).toEqual(inPage.x);
  inPage.masks.forEach((mask, t) => expect(mask === result.labels(t).join(''), `masks of frame ${t}`).toBe(true));
});

/** Wider than the working size, so that the file is larger than the masks. */
const CLIP = { width: 640, height: 200, frames: 8 };

/** The moving square, in pixels: its side, and its upper left corner in frame `t`. */
const SIDE = 100;
const cornerOf = (t) => [130 + 12 * t, 50];

test('cuts out a dropped clip at full size: run, fix, and two clicks to save', async ({ openStudio }) => {
  const page = await openSample(openStudio, { sample: 'tiny', bypassCSP: true });
  const corners = Array.from({ length: CLIP.frames }, (_, t) => cornerOf(t));
  const video = await page.evaluate(encodeSquare, { ...CLIP, side: SIDE, corners });
  const file = { name: 'square.webm', mimeType: 'video/webm', buffer: Buffer.from(video, 'base64') };
  await dropFiles(page, [file]);
  await expect(page.locator('#clip-name')).toHaveText('square.webm');
  await expect(page.locator('body')).toHaveAttribute('data-state', 'done');
  await expect(page.locator('#headline')).toHaveText('1 moving object');

  // A stroke beside the square, in pixels of the masks.
  const scale = 480 / CLIP.width;
  const stroke = [
    [520, 60],
    [580, 60],
  ];
  await openFix(page);
  await selectTool(page, 'paint');
  expect(await paint(page, ...stroke.map(([x, y]) => [x * scale, y * scale]))).toMatch(/^Applied to frame/);
  await page.click('#correct-done');

  await page.evaluate(() => {
    globalThis.clicks = [];
    const record = ({ isTrusted, target }) => isTrusted && globalThis.clicks.push(target.closest('[id]').id);
    addEventListener('click', record, { capture: true });
  });
  await page.click('#export-open');
  await page.waitForSelector('#export[open]');
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#export-run')]);
  expect(await page.evaluate(() => globalThis.clicks)).toEqual(['export-open', 'export-run']);
  expect(download.suggestedFilename()).toBe('square-cutout.webm');
  const [left, top] = cornerOf(0);
  const places = [
    [left + SIDE / 2, top + SIDE / 2],
    [550, 60],
    [20, 20],
    [left - 40, top],
    [620, 180],
  ];
  await giveBytes(page, 'saved', await downloadBytes(download));
  const { width, height, opacities } = await page.evaluate(async (list) => {
    const { width, height, colorAt } = await playedFrame(saved);
    return { width, height, opacities: list.map((place) => colorAt(place)[3]) };
  }, places);
  expect([width, height]).toEqual([CLIP.width, CLIP.height]);
  const [square, paintedOpacity, ...background] = opacities;
  expect(Math.min(square, paintedOpacity)).toBeGreaterThan(200);
  expect(Math.max(...background)).toBeLessThan(20);
  await page.click('#export-close');

  // The fix is undone without another run.
  expect(await correct(page, () => page.keyboard.press('Control+z'))).toBe('Undone. 1 moving object.');
});

/** Runs in the page: encodes a video of a square that moves over a resting background, as base64. */
async function encodeSquare({ width, height, side, corners }) {
  const { base64Of, encodeClip, evenTimes } = await import('/tests/browser/page-helpers.mjs');
  const fill = (context, left, top, [across, down], [hue, salt]) => {
    for (let y = 0; y < down; y += 10)
      for (let x = 0; x < across; x += 10) {
        const grain = (Math.imul(x + salt, 374761393) ^ Math.imul(y + 3, 668265263)) >>> 26;
        context.fillStyle = `hsl(${hue} 50% ${20 + grain}%)`;
        context.fillRect(left + x, top + y, 10, 10);
      }
  };
  const draw = (context, t) => {
    fill(context, 0, 0, [width, height], [120, 7]);
    fill(context, ...corners[t], [side, side], [10, 9]);
  };
  return base64Of(
    await encodeClip({ times: evenTimes(corners.length, 10), draw, width, height, bitrate: 1e7, keyEvery: 5 }),
  );
}

/** No task of the main thread takes more time of the processor. Elapsed time would depend on what else the machine does. */
const MAX_TASK_MS = 100;

const FRAMES = 75;
const RATE = 25;
/** Time from click to click, and duration of a click. */
const BEAT_S = 0.5;
const CLICK_S = 0.01;
const MAX_OFFSET_S = 0.04;
const PCM_RATE = 48000;
const pictures = join(
  process.env.TRACECUT_SHARED ?? join(root, '..', 'shared'),
  'data',
  'davis',
  'camel',
  'JPEGImages',
);

const films = useFilms();

test(
  'no task of the main thread is long while the sample and a video run',
  { tag: '@long' },
  async ({ browser, sites }) => {
    const page = await browser.newPage({ viewport: { width: 1440, height: 900 }, serviceWorkers: 'block' });
    const expectShortTasks = async (name, start) => {
      await browser.startTracing(page, { categories: ['toplevel', 'devtools.timeline'] });
      await start();
      expect(await runEnd(page)).toBe('done');
      const times = longestTasks(await browser.stopTracing());
      console.log(`${name}: the longest tasks took ${times.join(', ')} ms of the processor`);
      expect(times[0], name).toBeLessThanOrEqual(MAX_TASK_MS);
    };
    const url = await sites('whole');
    await expectShortTasks('sample', () => page.goto(url));
    const { video } = await fiveObjects(page, { width: 480, height: 270, frames: 60 });
    await expectShortTasks('video', async () => {
      await page.setInputFiles('#file', [video]);
      await page.waitForFunction(() => globalThis.tracecutStudio.source?.name === 'five.webm');
    });
    await page.close();
  },
);

/** Returns the processor times of the longest tasks of a page's main thread, in milliseconds. */
function longestTasks(trace) {
  const { traceEvents } = JSON.parse(trace);
  const threadOf = ({ pid, tid }) => `${pid} ${tid}`;
  const isRenderer = ({ name, args }) => name === 'thread_name' && args.name === 'CrRendererMain';
  const mainThreads = new Set(traceEvents.filter(isRenderer).map(threadOf));
  const tasks = traceEvents.filter(
    (event) => /RunTask$/.test(event.name) && event.tdur && mainThreads.has(threadOf(event)),
  );
  expect(tasks.length).toBeGreaterThan(200);
  return tasks
    .map(({ tdur }) => Math.round(tdur / 1000))
    .sort((a, b) => b - a)
    .slice(0, 5);
}

test('a clip of a phone becomes a transparent video with its sound', { tag: '@long' }, async ({ openStudio }) => {
  test.slow();
  needsFfmpeg();
  test.skip(!existsSync(pictures), `${pictures} is missing`);
  const source = films.path('phone.mp4');
  const clicks = `aevalsrc='if(lt(mod(t,${BEAT_S}),${CLICK_S}),sin(6283*t),0)':s=44100:d=${FRAMES / RATE}`;
  films.ffmpeg([
    ...['-framerate', String(RATE), '-i', join(pictures, '%05d.jpg'), '-f', 'lavfi', '-i', clicks],
    ...['-frames:v', String(FRAMES), '-vf', 'scale=1920:1080:flags=lanczos,setsar=1', '-pix_fmt', 'yuv420p'],
    ...['-c:v', 'libx264', '-preset', 'veryfast', '-crf', '18', '-c:a', 'aac', '-shortest', source],
  ]);
  const page = await openSample(openStudio, { sample: 'tiny' });
  const start = Date.now();
  await page.setInputFiles('#file', source);
  await page.waitForFunction(() => globalThis.tracecutStudio.source?.name === 'phone.mp4');
  expect(await runEnd(page), await page.locator('#error').innerText()).toBe('done');
  const segmented = Date.now();
  await page.click('#export-open');
  await page.click('[data-export="transparent"]');
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#export-run')]);
  const output = await download.path();
  const seconds = (from, to) => ((to - from) / 1000).toFixed(1);
  console.log(`segmented in ${seconds(start, segmented)} s, saved in ${seconds(segmented, Date.now())} s`);
  expect(download.suggestedFilename()).toBe('phone-cutout.webm');

  const streams = JSON.parse(
    execFileSync('ffprobe', ['-v', 'error', '-count_packets', '-show_streams', '-of', 'json', output]),
  ).streams;
  const video = streams.find(({ codec_type: type }) => type === 'video');
  const sound = streams.find(({ codec_type: type }) => type === 'audio');
  expect(video).toMatchObject({ width: 1920, height: 1080, nb_read_packets: String(FRAMES) });
  expect(video.tags.alpha_mode ?? video.tags.ALPHA_MODE).toBe('1');
  expect(sound.codec_name).toBe('opus');
  expect(Math.abs(Number(video.start_time))).toBeLessThan(MAX_OFFSET_S);
  const clickStarts = clickTimes(output);
  expect(clickStarts).toHaveLength(clickTimes(source).length);
  clickStarts.forEach((time, k) => expect(Math.abs(time - BEAT_S * k), `click ${k}`).toBeLessThan(MAX_OFFSET_S));
  const shares = opaqueShares(output, video.codec_name);
  expect(shares).toHaveLength(FRAMES);
  // The camel covers about a tenth of the picture.
  expect(Math.min(...shares)).toBeGreaterThan(0.03);
  expect(Math.max(...shares)).toBeLessThan(0.5);
});

/** Returns the times at which clicks begin, in seconds of the file. */
function clickTimes(file) {
  const clock = ['-af', 'aresample=async=1:first_pts=0', '-ar', String(PCM_RATE)];
  const bytes = films.ffmpeg(['-i', file, '-vn', '-ac', '1', ...clock, '-f', 'f32le', '-']);
  const samples = new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  const times = [];
  samples.forEach((sample, k) => {
    const time = k / PCM_RATE;
    if (Math.abs(sample) > 0.3 && time - (times.at(-1) ?? -1) > BEAT_S / 2) times.push(time);
  });
  return times;
}

/** Returns the share of each frame that is more opaque than transparent. */
function opaqueShares(file, codec) {
  const decoder = codec === 'vp8' ? 'libvpx' : 'libvpx-vp9';
  const alpha = ['-vf', 'alphaextract,scale=192:108', '-pix_fmt', 'gray', '-f', 'rawvideo', '-'];
  const bytes = films.ffmpeg(['-c:v', decoder, '-i', file, ...alpha]);
  const numPixels = 192 * 108;
  const shareOf = (frame) => frame.reduce((sum, value) => sum + (value > 127 ? 1 : 0), 0) / numPixels;
  return Array.from({ length: bytes.length / numPixels }, (_, t) =>
    shareOf(bytes.subarray(t * numPixels, (t + 1) * numPixels)),
  );
}
