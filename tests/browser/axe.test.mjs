// What an accessibility checker says of the page in each of its states, in both colour schemes (between which nothing but
// colours differ) and at phone width.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import {
  accessibilityFaults,
  ended,
  inPhase,
  openSave,
  plainFrame,
  pngFile,
  run,
  screenshot,
  showOnly,
  useSite,
} from './support.mjs';

const looks = {
  'on a desk': {},
  'on a phone': { viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true },
};

/** What it says of the page in the light and, on a desk, of its colours in the dark. */
async function faultsOf(page, look) {
  await page.emulateMedia({ colorScheme: 'light' });
  const light = await accessibilityFaults(page);
  if (look !== 'on a desk') return light;
  await page.emulateMedia({ colorScheme: 'dark' });
  return [...light, ...(await accessibilityFaults(page, ['color-contrast']))];
}

describe('an accessibility checker finds nothing', () => {
  const site = useSite();

  for (const [look, options] of Object.entries(looks)) {
    test(look, async () => {
      // The checker is no script of the site: the policy has to let it in.
      const { page } = await site.open({ ...options, bypassCSP: true });
      assert.deepEqual(await faultsOf(page, look), [], 'opening');
      await inPhase(page, 'running');
      assert.deepEqual(await faultsOf(page, look), [], 'running');
      assert.equal(await ended(page), 'done');
      assert.deepEqual(await faultsOf(page, look), [], 'done');
      await screenshot(page, `axe-${look.replaceAll(' ', '-')}`);
      await showOnly(page);
      await page.click('#settings-all > summary');
      await page.click('#settings-expert > summary');
      for (const summary of await page.locator('.group:not([hidden]) > summary').all()) await summary.click();
      await page.evaluate(() => globalThis.tracecutDemo.app.compare.choose('slider'));
      assert.deepEqual(await faultsOf(page, look), [], 'all layers and settings open');
      await page.keyboard.press('?');
      await page.waitForSelector('#help[open]');
      assert.deepEqual(await faultsOf(page, look), [], 'help');
      await page.click('#help-close');
      await openSave(page);
      await page.click('#recipe-box > summary');
      assert.deepEqual(await faultsOf(page, look), [], 'export');
      assert.equal(
        await page.evaluate(
          () => document.querySelector('#export').scrollWidth <= document.querySelector('#export').clientWidth,
        ),
        true,
      );
      await page.click('#export-close');
      await run(page, [pngFile('plain.png', plainFrame(60, 40))]);
      assert.deepEqual(await faultsOf(page, look), [], 'still image');
      await run(page, [{ name: 'notes.txt', mimeType: 'text/plain', buffer: Buffer.from('x') }]);
      assert.deepEqual(await faultsOf(page, look), [], 'error');
    });
  }
});
