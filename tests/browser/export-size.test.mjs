// What the page saves of a video has the size of the video, its frames, its times and its sound: opened again.

import assert from 'node:assert/strict';
import { before, describe, test } from 'node:test';
import { unzipSync } from 'fflate';
import {
  bytesOf,
  exportAs,
  gifFile,
  onlyLong,
  openLook,
  openSample,
  openSave,
  plainFrame,
  run,
  screenshot,
  text,
  useSite,
} from './support.mjs';

const MASKS_AT = 480;

/** Clips above the size that masks are made at, and their frames; one of 4K takes long. */
const SIZES = onlyLong.skip
  ? [[512, 288, 6]]
  : [
      [854, 480, 12],
      [3840, 2160, 6],
    ];
const [WIDTH, HEIGHT] = SIZES.at(-1);

const site = useSite({ sample: 'tiny' });
const sample = { page: null, faults: null };
before(async () => {
  Object.assign(sample, await openSample(site));
  await sample.page.evaluate(prepare);
});

async function save(page, id) {
  const coming = page.waitForEvent('download');
  await exportAs(page, id);
  await page.waitForFunction(() => !/^Saving/.test(document.querySelector('#export-status').textContent));
  const said = await text(page, '#export-status');
  assert.match(said, /^Saved/, `${id}: ${said}`);
  return bytesOf(await coming);
}

describe('exports of a clip whose sound WebM cannot hold', () => {
  test('have it as Opus in WebM, as the page says', async () => {
    const { page, faults } = sample;
    const times = Array.from({ length: 6 }, (_, k) => 0.04 * k);
    const made = await page.evaluate(makeClip, { width: 320, height: 180, times, isPlain: true });
    const file = { name: 'clip.mp4', mimeType: 'video/mp4', buffer: Buffer.from(made, 'base64') };
    assert.equal(await run(page, [file]), 'done', await text(page, 'main'));
    await openSave(page);
    await page.waitForFunction(() => !document.querySelector('#export-with-sound').hidden);
    assert.match(await text(page, '#export-sound-facts'), /^pcm-s16, unchanged; Opus in WebM\.$/);
    for (const [id, codec] of [
      ['transparent', 'opus'],
      ['overlay-webm', 'opus'],
      ['overlay-mp4', 'pcm-s16'],
    ]) {
      const clip = await page.evaluate(readClip, (await save(page, id)).toString('base64'));
      assert.equal(clip.codec, codec, id);
      assert.ok(Math.abs(clip.sound - 0.24) < 0.05, `${id}: sound of ${clip.sound} s`);
    }
    await page.click('#export-close');
    assert.deepEqual(faults, []);
  });
});

describe('exports at the size of the source', () => {
  for (const [width, height, count] of SIZES) {
    test(`a clip of ${width} × ${height}, computed at ${MASKS_AT}`, async () => {
      const { page, faults } = sample;
      const times = Array.from({ length: count }, (_, k) => 0.04 * k + (k > 3 ? 0.017 : 0));
      await page.evaluate(`globalThis.playedPixels = ${playedPixels}`);
      const made = await page.evaluate(makeClip, { width, height, times });
      const file = { name: `clip-${height}.mp4`, mimeType: 'video/mp4', buffer: Buffer.from(made, 'base64') };
      assert.equal(await run(page, [file]), 'done', await text(page, 'main'));
      assert.match(await text(page, '#subline'), new RegExp(`${count} frames of ${MASKS_AT} × 270`));
      await page.evaluate(() => globalThis.tracecutStudio.app.timeline.seek(2));
      await openSave(page);
      await page.waitForFunction(() => !document.querySelector('#export-with-sound').hidden);
      assert.match(
        await text(page, '.card:has(:checked) .value'),
        new RegExp(`^${width} × ${height}, 0\\.\\d\\ss, about [\\d.]+\\s[KM]B$`),
      );
      assert.match(await text(page, '#export-sound-facts'), /^Opus, unchanged\.$/);
      await screenshot(page, `export-${height}`);
      const clear = await page.evaluate(readClip, (await save(page, 'cutout-webm')).toString('base64'));
      assert.deepEqual(clear.size, [width, height]);
      assert.equal(clear.times.length, count);
      times.forEach((time, k) => assert.ok(Math.abs(clear.times[k] - time) < 0.001, `frame ${k} at ${clear.times[k]}`));
      assert.ok(Math.abs(clear.sound - (2 * times.at(-1) - times.at(-2))) < 0.025, `sound of ${clear.sound} s`);
      const { wrong, objects } = await page.evaluate(compareAlpha, 2);
      assert.ok(objects > 0.01, `${objects} of the frame is objects`);
      assert.ok(wrong < 0.002, `${wrong} of the alpha differs from the mask`);
      const mp4 = await page.evaluate(readClip, (await save(page, 'overlay-mp4')).toString('base64'));
      assert.deepEqual([mp4.size, mp4.times.length], [[width, height], count]);
      times.forEach((time, k) => assert.ok(Math.abs(mp4.times[k] - time) < 0.001, `frame ${k} at ${mp4.times[k]}`));
      assert.ok(mp4.sound > 0.1);
      const mask = await save(page, 'png');
      assert.deepEqual([mask.readUInt32BE(16), mask.readUInt32BE(20)], [width, height]);
      const behind = await save(page, 'background-png');
      assert.deepEqual([behind.readUInt32BE(16), behind.readUInt32BE(20)], [width, height]);
      const coco = JSON.parse(await save(page, 'coco'));
      assert.deepEqual([coco.images[0].width, coco.images[0].height, coco.images.length], [width, height, count]);
      await page.click('#export-close');
      assert.deepEqual(faults, []);
    });
  }

  test('the sound of a clip plays with the result, unless it is muted', async () => {
    const { page, faults } = sample;
    assert.equal(await page.locator('#mute').getAttribute('aria-label'), 'Mute');
    await page.evaluate(() => {
      const { play } = HTMLMediaElement.prototype;
      HTMLMediaElement.prototype.play = function () {
        globalThis.player = this;
        return play.call(this);
      };
    });
    await page.click('#play');
    await page.waitForFunction(
      () => globalThis.player && !globalThis.player.paused && globalThis.player.currentTime > 0,
    );
    const isPaused = () => page.evaluate(() => globalThis.player.paused);
    await page.click('#mute');
    assert.equal(await isPaused(), true);
    assert.equal(await page.evaluate(() => Object.keys(localStorage).length), 1, 'it is remembered');
    await page.click('#mute');
    await page.waitForFunction(() => !globalThis.player.paused);
    assert.equal(await page.evaluate(() => Object.keys(localStorage).length), 0);
    await page.click('#play');
    assert.equal(await isPaused(), true);
    assert.deepEqual(faults, []);
  });

  test('or half of it, or as computed, or any other; without sound where none is wanted', async () => {
    const { page, faults } = sample;
    await openSave(page);
    assert.deepEqual(await page.locator('#export-size option').allTextContents(), [
      `Same as source, ${WIDTH} × ${HEIGHT}`,
      `Half, ${WIDTH / 2} × ${HEIGHT / 2}`,
      'Working size, 480 × 270',
      'Other…',
    ]);
    const sizeOf = async (id) => {
      const files = unzipSync(await save(page, id));
      const png = Buffer.from(files[Object.keys(files).find((name) => name.endsWith('.png'))]);
      return [png.readUInt32BE(16), png.readUInt32BE(20)];
    };
    await page.selectOption('#export-size', 'half');
    assert.deepEqual(await sizeOf('zip'), [WIDTH / 2, HEIGHT / 2]);
    await page.selectOption('#export-size', 'working');
    assert.deepEqual(await sizeOf('zip-objects'), [480, 270]);
    assert.deepEqual(await sizeOf('background-zip'), [480, 270]);
    await page.selectOption('#export-size', 'own');
    await page.fill('#export-side', '500');
    assert.match(await text(page, '.card:last-child .value'), /^500 × 281, 6 frames/);
    await screenshot(page, 'export-custom');
    await page.uncheck('#export-sound');
    const mute = await page.evaluate(readClip, (await save(page, 'overlay-webm')).toString('base64'));
    assert.deepEqual([mute.size, mute.sound], [[500, 281], 0]);
    await page.selectOption('#export-quality', 'low');
    assert.ok((await save(page, 'overlay-webm')).length > 1000);
    await page.click('#export-close');
    assert.deepEqual(faults, []);
  });

  test('overlays look as the masks on screen do', async () => {
    const { page } = sample;
    await openLook(page);
    const set = (name, value) => page.locator(`[data-setting="masks.${name}"]`).fill(value);
    const inside = async () => {
      await openSave(page);
      await page.selectOption('#export-size', 'working');
      await page.evaluate(readClip, (await save(page, 'overlay-webm')).toString('base64'));
      await page.click('#export-close');
      return page.evaluate(insideColor, 2);
    };
    await set('fill', '1');
    const full = await inside();
    assert.ok(full.distance < 14, `${full.shown} is not the object's colour ${full.color}`);
    await set('opacity', '0');
    const none = await inside();
    assert.ok(none.distance > 30, `${none.shown} is still the object's colour`);
    await set('opacity', '1');
    await set('fill', '0');
  });
});

test('the delays of a GIF are kept on screen and in saved files', async () => {
  const { page, faults } = sample;
  const delays = [5, 30, 5, 5, 60, 5, 5, 25];
  const frames = delays.map((_, t) =>
    plainFrame(96, 64, (x, y) => {
      const inside = x >= 12 + 2 * t && x < 40 + 2 * t && y >= 16 && y < 48;
      const value =
        60 +
        ((Math.imul(((inside ? x - 2 * t : x) >> 1) + 131 * (y >> 1) + (inside ? 5 : 0), 2654435761) >>> 20) % 150);
      return [value, value, value];
    }),
  );
  assert.equal(await run(page, [gifFile('uneven.gif', frames, delays)]), 'done', await text(page, 'main'));
  const times = delays.map((_, t) => delays.slice(0, t).reduce((sum, delay) => sum + delay / 100, 0));
  const known = await page.evaluate(() => globalThis.tracecutStudio.app.job.times);
  times.forEach((time, t) => assert.ok(Math.abs(known[t] - time) < 1e-6, `frame ${t} at ${known[t]} s`));
  // On a busy machine a frame may come late: one round of several has to be on time.
  let lasted = [];
  const isOnTime = () => Math.abs(lasted[0] - 300) < 150 && Math.abs(lasted[1] - 600) < 150;
  for (let round = 0; round < 5 && !isOnTime(); round += 1) lasted = await page.evaluate(watchFrames, [1, 4]);
  assert.ok(isOnTime(), `frames 1 and 4 lasted ${lasted} ms`);
  await openSave(page);
  const saved = await page.evaluate(readClip, (await save(page, 'overlay-webm')).toString('base64'));
  times.forEach((time, t) => assert.ok(Math.abs(saved.times[t] - time) < 0.001, `frame ${t} at ${saved.times[t]} s`));
  // The last frame is on for five times as long as the one before.
  assert.ok(Math.abs(saved.end - 1.4) < 0.002, `ends at ${saved.end} s`);
  assert.match(await text(page, '.card:nth-of-type(1) .value'), /, 1\.4\ss,/);
  assert.deepEqual(faults, []);
});

/** Runs in the page: plays for a while; how long each of these frames was on screen, NaN where it was not. */
async function watchFrames(frames) {
  const seen = [];
  const scrub = document.querySelector('#scrub');
  document.querySelector('#play').click();
  for (const end = performance.now() + 3500; performance.now() < end; await new Promise(requestAnimationFrame))
    if (seen.at(-1)?.[0] !== scrub.value) seen.push([scrub.value, performance.now()]);
  document.querySelector('#play').click();
  return frames.map((frame) => {
    const at = seen.findIndex(([value], k) => value === String(frame) && k > 0 && k + 1 < seen.length);
    return at < 0 ? NaN : seen[at + 1][1] - seen[at][1];
  });
}

/** Runs in the page: what the other functions share. */
async function prepare() {
  const media = await import('/dist/vendor/media.js');
  const library = await import('/model/library.js');
  const bytesOf = (base64) => Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const base64Of = async (blob) => {
    const url = await new Promise((done) => {
      const reader = new FileReader();
      reader.onload = () => done(reader.result);
      reader.readAsDataURL(blob);
    });
    return url.slice(url.indexOf(',') + 1);
  };
  /** A second of a tone, as Opus in WebM. */
  const tone = async () => {
    const output = new media.Output({ format: new media.WebMOutputFormat(), target: new media.BufferTarget() });
    const track = new media.EncodedAudioPacketSource('opus');
    output.addAudioTrack(track);
    await output.start();
    const chunks = [];
    const encoder = new AudioEncoder({ output: (...one) => chunks.push(one), error: (error) => console.error(error) });
    const sampleRate = 48000;
    encoder.configure({ codec: 'opus', sampleRate, numberOfChannels: 1, bitrate: 64000 });
    const data = Float32Array.from({ length: sampleRate }, (_, k) => 0.3 * Math.sin(k / 20));
    const sound = { format: 'f32', sampleRate, numberOfFrames: data.length, numberOfChannels: 1, timestamp: 0, data };
    encoder.encode(new AudioData(sound));
    await encoder.flush();
    for (const [chunk, meta] of chunks) await track.add(media.EncodedPacket.fromEncodedChunk(chunk), meta);
    await output.finalize();
    return new Blob([output.target.buffer]);
  };
  /** The same as it is, in WAV. */
  const plainTone = () => {
    const [rate, count] = [44100, 44100];
    const view = new DataView(new ArrayBuffer(44 + 2 * count));
    const words = { 0: 'RIFF', 8: 'WAVEfmt ', 36: 'data' };
    for (const [at, word] of Object.entries(words)) new Uint8Array(view.buffer).set(new TextEncoder().encode(word), at);
    const longs = { 4: 36 + 2 * count, 16: 16, 24: rate, 28: 2 * rate, 40: 2 * count };
    for (const [at, value] of Object.entries(longs)) view.setUint32(at, value, true);
    for (const [at, value] of Object.entries({ 20: 1, 22: 1, 32: 2, 34: 16 })) view.setUint16(at, value, true);
    for (let k = 0; k < count; k += 1) view.setInt16(44 + 2 * k, 9000 * Math.sin(k / 20), true);
    return view.buffer;
  };
  /** How long a player says that a file is, in seconds. */
  const played = (blob) =>
    new Promise((done, failed) => {
      const video = document.createElement('video');
      Object.assign(video, { onloadedmetadata: () => done(video.duration), onerror: () => failed(video.error) });
      video.src = URL.createObjectURL(blob);
    });
  globalThis.sized = { media, library, bytesOf, base64Of, tone, plainTone, played };
}

/** Runs in the page: a textured square that moves over a textured ground, with a tone. */
async function makeClip({ width, height, times, isPlain = false }) {
  const { library, base64Of, tone, plainTone } = globalThis.sized;
  const texture = (salt, side) => {
    const small = new ImageData(side, side);
    for (let p = 0; p < side * side; p += 1) {
      let h = Math.imul(p + 7, 374761393) ^ Math.imul(salt, 668265263);
      h = Math.imul(h ^ (h >>> 13), 1274126177);
      const value = 50 + (((h ^ (h >>> 16)) >>> 0) % 150);
      small.data.set([value, value, salt > 1 ? 255 - value : value, 255], 4 * p);
    }
    const canvas = new OffscreenCanvas(side, side);
    canvas.getContext('2d').putImageData(small, 0, 0);
    return canvas;
  };
  const [ground, square] = [texture(1, 96), texture(2, 24)];
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext('2d');
  const frames = async function* () {
    for (const [t] of times.entries()) {
      context.drawImage(ground, 0, 0, width, width);
      context.drawImage(square, width * (0.2 + 0.009 * t), height * 0.25, height * 0.5, height * 0.5);
      yield canvas;
    }
  };
  const masks = { width: 16, height: 9, numFrames: times.length, labels: () => new Uint8Array(144), times };
  const options = {
    format: 'mp4',
    quality: 'very-high',
    sound: { source: isPlain ? plainTone() : await tone(), end: 2 },
  };
  return base64Of(await library.encodeVideo(masks, frames(), options));
}

/** Runs in the page: size, times, duration and sound of a file, which stays for the tests that follow. */
async function readClip(base64) {
  const { media, bytesOf, played } = globalThis.sized;
  const blob = new Blob([bytesOf(base64)]);
  globalThis.sized.saved = blob;
  const input = new media.Input({ source: new media.BlobSource(blob), formats: media.ALL_FORMATS });
  const [video, audio] = [await input.getPrimaryVideoTrack(), await input.getPrimaryAudioTrack()];
  const times = [];
  for await (const { timestamp } of new media.EncodedPacketSink(video).packets()) times.push(timestamp);
  let sound = 0;
  if (audio)
    for await (const { timestamp, duration } of new media.EncodedPacketSink(audio).packets())
      sound = Math.max(sound, timestamp + duration);
  return {
    size: [await video.getDisplayWidth(), await video.getDisplayHeight()],
    times: times.sort((a, b) => a - b),
    end: await played(blob),
    sound,
    codec: (await audio?.getCodec()) ?? null,
  };
}

/** Runs in the page: the pixels that a player shows of the file read last, at a frame of the result. */
async function playedPixels(t) {
  const { times } = globalThis.tracecutStudio.app.job;
  const video = document.createElement('video');
  const event = (name) =>
    new Promise((done, failed) =>
      Object.assign(video, { [`on${name}`]: done, onerror: () => failed(new Error(video.error?.message)) }),
    );
  const loaded = event('loadeddata');
  Object.assign(video, { muted: true, src: URL.createObjectURL(globalThis.sized.saved) });
  await loaded;
  const sought = event('seeked');
  video.currentTime = (times[t] + times[t + 1]) / 2 - times[0];
  await sought;
  const context = new OffscreenCanvas(video.videoWidth, video.videoHeight).getContext('2d', {
    willReadFrequently: true,
  });
  const { width, height } = context.canvas;
  // The picture may come a little after the word that it has.
  for (let left = 100; left > 0; left -= 1) {
    context.drawImage(video, 0, 0);
    const image = context.getImageData(0, 0, width, height);
    if (image.data.some((value, k) => k % 4 === 3 && value > 0)) return image;
    await new Promise((done) => setTimeout(done, 20));
  }
  return context.getImageData(0, 0, width, height);
}

/** Runs in the page: the share of pixels whose alpha is not that of the mask on screen, brought to the frame's size. */
async function compareAlpha(t) {
  const { data, width, height } = await globalThis.playedPixels(t);
  const { app, source, trim } = globalThis.tracecutStudio;
  const picture = await source.preview(trim.start + t, Math.max(width, height), app.job.times[t]);
  const { labels } = await globalThis.sized.library.enlargeMask(app.viewer.view.mask(), picture);
  let [wrong, objects] = [0, 0];
  for (let p = 0; p < labels.length; p += 1) {
    const there = labels[p] > 0;
    objects += there;
    wrong += there !== data[4 * p + 3] > 127;
  }
  return { wrong: wrong / labels.length, objects: objects / labels.length };
}

/** Runs in the page: what is shown deep inside the first object, and that object's colour. */
async function insideColor(t) {
  const { data, width } = await globalThis.playedPixels(t);
  const { segmentation } = globalThis.tracecutStudio.app;
  const mask = segmentation.mask(t);
  const reach = 10;
  const at = mask.findIndex(
    (label, p) =>
      label > 0 && [-1, 0, 1].every((dy) => [-1, 0, 1].every((dx) => mask[p + reach * (dy * width + dx)] === label)),
  );
  const shown = [...data.subarray(4 * at, 4 * at + 3)];
  const rgb = Number.parseInt(globalThis.tracecutStudio.objectColor(mask[at]).slice(1), 16);
  const color = [rgb >> 16, (rgb >> 8) & 255, rgb & 255];
  return { shown, color, distance: Math.max(...color.map((value, c) => Math.abs(value - shown[c]))) };
}
