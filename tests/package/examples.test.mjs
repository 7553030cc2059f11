// The examples for browsers, in folders of their own with the packed tarball.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import * as vite from 'vite';
import { synthClip } from '../../dist/node.js';
import { pngBytes } from '../png.mjs';
import { bytesOf, useServerAndBrowser } from '../site.mjs';
import { installed, served } from './installed.mjs';

const site = useServerAndBrowser();

/** Opens a page; whatever goes wrong on it fails the test at its end. */
async function open(t, url) {
  const page = await site.browser.newPage();
  const wrong = [];
  page.on('pageerror', (error) => wrong.push(error.message));
  page.on('console', (message) => message.type() === 'error' && wrong.push(message.text()));
  t.after(async () => {
    await page.close();
    assert.deepEqual(wrong, []);
  });
  await page.goto(url);
  return page;
}

const status = (page, text) => page.getByRole('status').filter({ hasText: text }).waitFor();

test('the plain page segments the images that are chosen and plays them with their objects coloured', async (t) => {
  const page = await open(t, await served(t, installed(t, 'examples/page')));
  const clip = await synthClip({ width: 256, height: 144, frames: 8, seed: 1 });
  const images = Array.from({ length: clip.numFrames }, (_, k) => ({
    name: `${k}.png`,
    mimeType: 'image/png',
    buffer: Buffer.from(pngBytes(clip.frame(k))),
  }));
  await page.locator('input').setInputFiles(images);
  await status(page, '3 objects in 8 frames');
  await page.waitForFunction(() => !document.querySelector('input').disabled);
  const shown = await page.evaluate(() => [
    ...document.querySelector('canvas').getContext('2d').getImageData(0, 0, 256, 144).data,
  ]);
  const [last, mask] = [clip.frame(7).data, clip.mask(7)];
  const changed = (p) =>
    Math.abs(shown[4 * p] - last[4 * p]) +
      Math.abs(shown[4 * p + 1] - last[4 * p + 1]) +
      Math.abs(shown[4 * p + 2] - last[4 * p + 2]) >
    3;
  const share = (wanted) => {
    const pixels = [...mask.keys()].filter((p) => mask[p] > 0 === wanted);
    return pixels.filter(changed).length / pixels.length;
  };
  assert.ok(share(true) > 0.9, `${share(true)} of the objects is coloured`);
  assert.ok(share(false) < 0.1, `${share(false)} of the background is`);
});

test('the plain page explains that a file is not a video', async (t) => {
  const page = await open(t, await served(t, installed(t, 'examples/page')));
  await page
    .locator('input')
    .setInputFiles({ name: 'notes.mp4', mimeType: 'video/mp4', buffer: Buffer.from('no video at all') });
  await page.waitForFunction(
    () =>
      !document.querySelector('input').disabled &&
      !document.querySelector('[role=status]').textContent.startsWith('Nothing'),
  );
  assert.match(await page.getByRole('status').textContent(), /is not a video/);
});

test('the Vite example makes an object background by a click, takes it back, and saves an archive', async (t) => {
  const root = installed(t, 'examples/vite');
  await vite.build({ root, logLevel: 'warn', build: { outDir: 'out' } });
  const page = await open(t, await served(t, join(root, 'out')));
  await status(page, /^3 objects/);
  const clip = await synthClip({ width: 480, height: 270, frames: 10, seed: 1 });
  await page.locator('canvas').click({ position: middleOf(clip.mask(0), 1, clip.width) });
  await status(page, /^2 objects/);
  await page.getByRole('button', { name: 'Undo' }).click();
  await status(page, /^3 objects/);
  const [download] = await Promise.all([
    page.waitForEvent('download'),
    page.getByRole('button', { name: 'Save' }).click(),
  ]);
  const archive = await bytesOf(download);
  assert.equal(download.suggestedFilename(), 'masks.zip');
  assert.equal(archive.toString('latin1', 0, 2), 'PK');
  assert.ok(archive.includes('00009.png'));
});

/** A place inside an object: the middle of its middle row. */
function middleOf(mask, object, width) {
  const pixels = [...mask.keys()].filter((p) => mask[p] === object);
  const y = Math.floor(pixels[pixels.length >> 1] / width);
  const row = pixels.filter((p) => Math.floor(p / width) === y).map((p) => p % width);
  return { x: row[row.length >> 1], y };
}
