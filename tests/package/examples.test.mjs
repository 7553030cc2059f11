// The examples for browsers, in folders of their own with the packed tarball.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import * as vite from 'vite';
import { synthClip } from '../../dist/node.js';
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
