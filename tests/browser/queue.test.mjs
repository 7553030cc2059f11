// Several videos opened together: each with its progress, one archive at the end; a clip that fails is a line.

import assert from 'node:assert/strict';
import { before, describe, test } from 'node:test';
import { unzipSync } from '../../dist/vendor/zip.js';
import { accessibilityFaults, bytesOf, ended, openFix, openSample, screenshot, text, useSite } from './support.mjs';

/** Runs in the page: the frames of the sample, there and back, as a video. */
async function makeVideo(count) {
  const { source } = globalThis.tracecutDemo;
  const media = await import('/dist/vendor/media.js');
  const output = new media.Output({ format: new media.WebMOutputFormat(), target: new media.BufferTarget() });
  const video = new media.VideoSampleSource({ codec: 'vp8', bitrate: 1e6 });
  output.addVideoTrack(video);
  await output.start();
  for (let t = 0; t < count; t += 1) {
    const canvas = new OffscreenCanvas(192, 108);
    const picture = await createImageBitmap(await source.preview(Math.min(t, 2 * source.count - 2 - t), source.width));
    canvas.getContext('2d').drawImage(picture, 0, 0, 192, 108);
    const sample = new media.VideoSample(canvas, { timestamp: t / 15, duration: 1 / 15 });
    await video.add(sample);
    sample.close();
  }
  await output.finalize();
  return [...new Uint8Array(output.target.buffer)];
}

describe('a queue of clips', () => {
  const site = useSite();
  const videos = {};
  const file = (name, buffer) => ({ name, mimeType: 'video/webm', buffer });

  before(async () => {
    const { page } = await openSample(site);
    for (const count of [8, 12, 24]) videos[count] = Buffer.from(await page.evaluate(makeVideo, count));
    await page.context().close();
  });
  const states = (page) =>
    page.evaluate(() => [...document.querySelectorAll('[data-queued]')].map((line) => line.dataset.queued));
  const through = (page) => page.waitForFunction(() => !document.querySelector('#queue-close').hidden);

  test('three clips and one that is none: lines, and one archive with a report', async () => {
    const { page, faults } = await openSample(site, { bypassCSP: true });
    const download = page.waitForEvent('download');
    await page.setInputFiles('#file', [
      file('one.webm', videos[8]),
      file('broken.webm', Buffer.from('nothing of the kind')),
      file('two.webm', videos[12]),
      file('three.webm', videos[24].subarray(0, Math.floor(0.7 * videos[24].length))),
    ]);
    await page.waitForSelector('[data-queued="running"]');
    assert.deepEqual(await accessibilityFaults(page), []);
    await through(page);
    assert.deepEqual(await states(page), ['done', 'failed', 'done', 'done']);
    assert.equal(await text(page, '#queue-count'), '4 of 4 clips done');
    assert.equal(await page.evaluate(() => document.body.dataset.source), 'sample', 'the clip on screen stays');
    const saved = await download;
    assert.equal(saved.suggestedFilename(), 'clips-masks.zip');
    const files = unzipSync(new Uint8Array(await bytesOf(saved)));
    const { clips } = JSON.parse(Buffer.from(files['report.json']).toString());
    assert.deepEqual(
      clips.map(({ name, folder, numFrames, width }) => [name, folder, numFrames > 8, width]),
      [
        ['one.webm', 'one', false, 192],
        ['broken.webm', undefined, false, undefined],
        ['two.webm', 'two', true, 192],
        ['three.webm', 'three', true, 192],
      ],
    );
    assert.match(clips[1].error, /./);
    assert.match(clips[3].damage, /cut off or damaged/);
    assert.equal(Object.keys(files).filter((name) => name.startsWith('two/')).length, 13);
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'queue');
    await page.click('#queue-close');
    assert.equal(await page.locator('#queue').isVisible(), false);
    assert.deepEqual(faults, []);
  });

  /** The size and frames of a video, and which part of its first frame is clear. */
  const looked = (page, bytes) =>
    page.evaluate(
      async (all) => {
        const { videoInfo } = await import('/dist/index.js');
        const file = new Blob([new Uint8Array(all)], { type: 'video/webm' });
        const { width, height, numFrames } = await videoInfo(file);
        const video = document.createElement('video');
        video.muted = true;
        video.src = URL.createObjectURL(file);
        await new Promise((done) => (video.onloadeddata = done));
        video.currentTime = 0.01;
        await new Promise((done) => (video.onseeked = done));
        const context = new OffscreenCanvas(width, height).getContext('2d');
        // On a busy machine a frame may be there to be drawn only a while after its time has come.
        let data = new Uint8ClampedArray();
        for (let tries = 0; tries < 40 && !data.some((value) => value > 0); tries += 1) {
          if (tries > 0) await new Promise((done) => setTimeout(done, 50));
          context.drawImage(video, 0, 0);
          ({ data } = context.getImageData(0, 0, width, height));
        }
        const alpha = Array.from({ length: width * height }, (_, p) => data[4 * p + 3]);
        return { numFrames, width, height, clear: alpha.filter((a) => a < 128).length / alpha.length };
      },
      [...bytes],
    );

  test('a clip that is through opens with a click while the others go on, is corrected, and all are saved as cut-outs', async () => {
    const { page, faults } = await openSample(site, { bypassCSP: true });
    await page.setInputFiles('#file', [
      file('one.webm', videos[8]),
      file('two.webm', videos[24]),
      file('three.webm', videos[12]),
    ]);
    await page.waitForSelector('[data-open]');
    await page.selectOption('#queue-kind', { label: 'Transparent cut-out' });
    // By keyboard alone.
    await page.focus('.queued [data-open]');
    await page.keyboard.press('Enter');
    await page.waitForFunction(() => globalThis.tracecutDemo.source?.name === 'one.webm');
    assert.equal(await ended(page), 'done');
    assert.notDeepEqual(await states(page), ['done', 'done', 'done'], 'the queue goes on');
    assert.equal(await page.locator('.queued[aria-current]').count(), 1);
    await page.setViewportSize({ width: 1440, height: 900 });
    await screenshot(page, 'queue-goes-on');
    await page.setViewportSize({ width: 1280, height: 800 });
    assert.equal(await page.evaluate(() => globalThis.tracecutDemo.app.points.result.numFrames), 8);
    // A bar over the whole width becomes an object.
    await openFix(page);
    await page.check('#correct-tools [value="paint"]', { force: true });
    await page.selectOption('#correct-object', '-1');
    await page.$eval('#brush-size', (range) => (range.value = 90));
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => setTimeout(done, 100))));
    const box = await page.locator('#canvas').boundingBox();
    await page.mouse.move(box.x + 1, box.y + 0.1 * box.height);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width - 1, box.y + 0.1 * box.height, { steps: 4 });
    await page.mouse.up();
    await page.waitForFunction(() => /^In .*[.]$/.test(document.querySelector('#correct-status').textContent));
    const part = await page.evaluate(() => {
      const mask = globalThis.tracecutDemo.app.points.mask(0);
      return mask.filter((label) => label === 0).length / mask.length;
    });
    assert.ok(part < 0.8, 'the bar covers a fifth at least');
    await page.click('#correct-done');
    await page.waitForFunction(() => /corrected/.test(document.querySelector('.queued-words').textContent));
    // The queue saves by itself when it is through; here the correction may come later than that.
    await through(page);
    const saved = [];
    page.on('download', (download) => saved.push(download));
    await page.click('#queue-save');
    await page.waitForSelector('#queue-close', { state: 'hidden' });
    await through(page);
    await page.waitForFunction(() => /^Saved/.test(document.querySelector('#queue-status').textContent));
    assert.deepEqual(await states(page), ['done', 'done', 'done']);
    assert.match(await text(page, '#queue-status'), /^Saved 3 files, \d/);
    const names = saved.map((download) => download.suggestedFilename());
    assert.deepEqual(names, ['one-cutout.webm', 'two-cutout.webm', 'three-cutout.webm']);
    const [one, two] = await Promise.all(saved.map(bytesOf));
    const first = await looked(page, one);
    assert.deepEqual([first.numFrames, first.width, first.height], [8, 192, 108]);
    assert.ok(Math.abs(first.clear - part) < 0.02, `${first.clear} is clear, ${part} is background`);
    assert.equal((await looked(page, two)).numFrames, 24);
    assert.deepEqual(await accessibilityFaults(page), []);
    assert.equal(await page.locator('.queued img').count(), 3);
    await page.setViewportSize({ width: 1440, height: 900 });
    await screenshot(page, 'queue-open');
    await page.setViewportSize({ width: 390, height: 844 });
    await screenshot(page, 'queue-open-phone');
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), true);
    // Each is kept as work; sessions of the queue are gone.
    await page.click('#works-open');
    await page.waitForSelector('#works[open]');
    assert.deepEqual(
      (await page.locator('.works .work-name').allInnerTexts()).map((name) => name.split('\n')[0]).sort(),
      [...['one.webm', 'three.webm', 'two.webm']],
    );
    assert.deepEqual(faults, []);
    await page.context().close();
  });

  test('one is cancelled, then all; what is dropped meanwhile is added', async () => {
    const phone = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };
    const { page } = await openSample(site, phone);
    await page.setInputFiles('#file', [file('a.webm', videos[24]), file('b.webm', videos[8])]);
    await page.waitForSelector('[data-queued="running"]');
    await page.setInputFiles('#file', [file('c.webm', videos[24]), file('d.webm', videos[8])]);
    await page.click('[aria-label="Cancel a.webm"]');
    await page.waitForFunction(() => document.querySelector('[data-queued="done"]'));
    await screenshot(page, 'queue-phone');
    assert.deepEqual((await states(page)).slice(0, 2), ['cancelled', 'done']);
    await page.click('#queue-cancel');
    await through(page);
    const [, , c, d] = await states(page);
    assert.deepEqual([c, d], ['cancelled', 'cancelled']);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), true);
    assert.equal(await page.isEnabled('#queue-save'), true);
  });
});
