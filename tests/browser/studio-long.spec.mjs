// The studio with long and large clips: how busy its main thread is, and a clip as phones record it, with sound.

import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { root } from '../../scripts/tools.mjs';
import { expect, runEnd, test } from './fixtures.mjs';
import { WIDE, fiveObjects } from './five-objects.mjs';

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
    const { video } = await fiveObjects(page, { ...WIDE, frames: 60 });
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

test(
  'a clip of a phone becomes a transparent video with its sound',
  { tag: '@long' },
  async ({ openStudio, cleanup }) => {
    test.slow();
  const programs = ['ffmpeg', 'ffprobe'].filter((name) => spawnSync(name, ['-version']).error);
    const missing = [...(existsSync(pictures) ? [] : [pictures]), ...programs];
    test.skip(missing.length > 0, `${missing.join(', ')}: missing`);
    const folder = mkdtempSync(join(tmpdir(), 'tracecut-'));
    cleanup.after(() => rmSync(folder, { recursive: true, force: true }));
    const source = join(folder, 'phone.mp4');
    const clicks = `aevalsrc='if(lt(mod(t,${BEAT_S}),${CLICK_S}),sin(6283*t),0)':s=44100:d=${FRAMES / RATE}`;
    ffmpeg(
      ...['-framerate', String(RATE), '-i', join(pictures, '%05d.jpg'), '-f', 'lavfi', '-i', clicks],
      ...['-frames:v', String(FRAMES), '-vf', 'scale=1920:1080:flags=lanczos,setsar=1', '-pix_fmt', 'yuv420p'],
      ...['-c:v', 'libx264', '-preset', 'veryfast', '-crf', '18', '-c:a', 'aac', '-shortest', '-y', source],
    );
    const page = await openStudio({ sample: 'tiny' });
    expect(await runEnd(page)).toBe('done');
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
  },
);

function ffmpeg(...args) {
  return execFileSync('ffmpeg', ['-v', 'error', ...args], { maxBuffer: 2 ** 30 });
}

/** Returns the times at which clicks begin, in seconds of the file. */
function clickTimes(file) {
  const clock = ['-af', 'aresample=async=1:first_pts=0', '-ar', String(PCM_RATE)];
  const bytes = ffmpeg('-i', file, '-vn', '-ac', '1', ...clock, '-f', 'f32le', '-');
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
  const bytes = ffmpeg('-c:v', decoder, '-i', file, ...alpha);
  const numPixels = 192 * 108;
  const shareOf = (frame) => frame.reduce((sum, value) => sum + (value > 127 ? 1 : 0), 0) / numPixels;
  return Array.from({ length: bytes.length / numPixels }, (_, t) =>
    shareOf(bytes.subarray(t * numPixels, (t + 1) * numPixels)),
  );
}
