// A clip from the camera; Chromium has one made for tests.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { accessibilityFaults, ended, openSample, screenshot, text, useSite } from './support.mjs';

describe('the camera', () => {
  const site = useSite({
    sample: 'tiny',
    args: ['--use-fake-device-for-media-stream', '--use-fake-ui-for-media-stream'],
  });

  /** Keeps hold of every track that the page is given. */
  const watchTracks = (page) =>
    page.evaluate(() => {
      globalThis.tracks = [];
      const ask = navigator.mediaDevices.getUserMedia.bind(navigator.mediaDevices);
      navigator.mediaDevices.getUserMedia = async (wish) => {
        const stream = await ask(wish);
        globalThis.tracks.push(...stream.getTracks());
        return stream;
      };
    });
  const states = (page) => page.evaluate(() => globalThis.tracks.map(({ readyState }) => readyState));

  test('records a few seconds, which are segmented; then it is off', async () => {
    const { page, faults } = await openSample(site, { bypassCSP: true });
    await watchTracks(page);
    await page.click('#camera-open');
    await page.locator('#camera-record:enabled').waitFor();
    assert.deepEqual(await states(page), ['live']);
    assert.deepEqual(await accessibilityFaults(page), []);
    await page.selectOption('#camera-length', '2');
    await page.click('#camera-record');
    await page.waitForFunction(() => document.querySelector('#camera-count').textContent === '2');
    await screenshot(page, 'camera');
    await page.waitForFunction(
      () => globalThis.tracecutDemo.source?.name === 'camera.webm' || document.body.dataset.state === 'error',
    );
    assert.equal(await ended(page), 'done', await page.evaluate(() => document.querySelector('#error').innerText));
    assert.deepEqual(await states(page), ['ended']);
    assert.match(await text(page, '#clip-facts'), /\d+ × \d+, [12]\.\d s/);
    assert.deepEqual(faults, []);
  });

  test('is turned off when the dialog is closed, during the countdown too', async () => {
    const { page } = await openSample(site);
    await watchTracks(page);
    await page.click('#camera-open');
    await page.locator('#camera-record:enabled').click();
    await page.keyboard.press('Escape');
    assert.equal(await page.locator('#camera').isVisible(), false);
    // The dialog tells of its end a moment after it is gone.
    await page.waitForFunction(() => globalThis.tracks.every(({ readyState }) => readyState === 'ended'));
    assert.deepEqual(await states(page), ['ended']);
    await page.waitForTimeout(3500);
    assert.equal(await page.evaluate(() => globalThis.tracecutDemo.source.kind), 'sample', 'nothing was recorded');
  });

  const refusals = {
    NotAllowedError: /may not be used.*Allow it/,
    NotFoundError: /no camera.*Connect one/,
    NotReadableError: /no picture.*Close/,
  };
  for (const [name, words] of Object.entries(refusals)) {
    test(`that answers ${name} is explained in words`, async () => {
      const { page } = await site.open();
      await page.evaluate((what) => {
        navigator.mediaDevices.getUserMedia = () => Promise.reject(new DOMException('refused', what));
      }, name);
      await page.waitForFunction(() => globalThis.tracecutDemo);
      await page.click('#camera-open');
      await page.waitForFunction(() => document.querySelector('#camera-status').classList.contains('is-wrong'));
      assert.match(await text(page, '#camera-status'), words);
      assert.equal(await page.locator('#camera-record').isDisabled(), true);
      await page.click('#camera-close');
    });
  }
});
