// The documentation in Chromium: an accessibility checker, phones, the search, and what is left without a network.

import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, describe, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { writeDocuments } from '../../scripts/documents.mjs';
import { useServerAndBrowser } from '../site.mjs';
import { accessibilityFaults, onlyLong } from './support.mjs';

const LOOKS = {
  'in the light': { colorScheme: 'light' },
  'in the dark': { colorScheme: 'dark' },
  'on a phone': { viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true },
};

describe('the documentation', () => {
  const site = useServerAndBrowser();

  /** A page of the documentation, and what it asked for. */
  async function open(name, options = {}, base = `${site.url}docs/`) {
    const context = await site.browser.newContext(options);
    const page = await context.newPage();
    const [asked, faults] = [[], []];
    page.on('request', (request) => asked.push(request.url()));
    page.on('pageerror', ({ message }) => faults.push(message));
    page.on('console', (message) => message.type() === 'error' && faults.push(message.text()));
    await page.goto(`${base}${name}`);
    return { page, asked, faults };
  }

  for (const [look, options] of Object.entries(LOOKS)) {
    test(
      `has no fault that an accessibility checker finds, ${look}`,
      look === 'in the light' ? {} : onlyLong,
      async () => {
        for (const name of ['index.html', 'reference.html', 'method.html']) {
          const { page, faults } = await open(name, { ...options, bypassCSP: true });
          assert.deepEqual(await accessibilityFaults(page), [], name);
          await page.fill('input[type="search"]', 'segmentVideo');
          await page.waitForSelector('.results li');
          assert.deepEqual(await accessibilityFaults(page), [], `${name}, searching`);
          assert.ok(
            await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth),
            `${name} is too wide`,
          );
          assert.deepEqual(faults, []);
          await page.context().close();
        }
      },
    );
  }

  test('the search box leads to the place, and asks for the index when it is used', async () => {
    const { page, asked, faults } = await open('speed.html');
    assert.equal(asked.filter((url) => url.includes('search-index')).length, 0);
    await page.keyboard.press('/');
    await page.keyboard.type('segmentVideo');
    await page.waitForSelector('.results li');
    await page.keyboard.press('Enter');
    await page.waitForURL('**/docs/reference.html#segmentvideo');
    assert.equal(await page.isVisible('#segmentvideo'), true);
    assert.deepEqual(
      asked.filter((url) => !url.startsWith(site.url)),
      [],
    );
    assert.deepEqual(faults, []);
  });

  test('a search without a result says so, and Escape closes it', async () => {
    const { page } = await open('index.html');
    await page.fill('input[type="search"]', 'xyzzy');
    await page.waitForFunction(() => document.querySelector('.results p').textContent === 'Nothing has “xyzzy” in it.');
    await page.keyboard.press('Escape');
    assert.equal(await page.isVisible('.results'), false);
  });

  test('on paper there is the text alone', async () => {
    const { page } = await open('index.html');
    await page.emulateMedia({ media: 'print' });
    for (const selector of ['.top', '#pages']) assert.equal(await page.isVisible(selector), false, selector);
    assert.equal(await page.isVisible('h1'), true);
  });

  describe('as a folder', () => {
    const folder = mkdtempSync(join(tmpdir(), 'tracecut-docs-'));
    before(() => writeDocuments(folder));
    after(() => rmSync(folder, { recursive: true }));

    test('it is whole and searched without a server', async () => {
      const { page, asked } = await open('choices.html', {}, `${pathToFileURL(join(folder, 'docs')).href}/`);
      await page.fill('input[type="search"]', 'segmentVideo');
      await page.locator('.results a').first().click();
      await page.waitForURL('**/reference.html#segmentvideo');
      assert.deepEqual(
        asked.filter((url) => !url.startsWith('file:')),
        [],
      );
    });
  });

  test('pages that were read are kept by the service worker, and open without a network', async () => {
    const { page } = await open('', {}, site.url);
    await page.evaluate(() => navigator.serviceWorker.register('./service-worker.js'));
    await page.evaluate(() => navigator.serviceWorker.ready.then(() => true));
    await page.waitForFunction(() => navigator.serviceWorker.controller);
    await page.goto(`${site.url}docs/index.html`);
    await page.fill('input[type="search"]', 'flow');
    await page.waitForSelector('.results li');
    await page.waitForFunction(async () => (await caches.match('search-index.js')) !== undefined);
    await page.context().setOffline(true);
    await page.reload();
    await page.fill('input[type="search"]', 'flow');
    await page.waitForSelector('.results li');
    assert.equal(await page.textContent('h1'), 'TraceCut');
  });
});
