// The first steps and what is known of the result: in the help.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { accessibilityFaults, openSample, screenshot, text, useSite } from './support.mjs';

describe('first steps', () => {
  const site = useSite();

  test('are three sentences behind the button of the help, whose words are those of the page', async () => {
    const { page, faults } = await openSample(site, { bypassCSP: true });
    assert.equal(await page.locator('#guide').isVisible(), false);
    await page.focus('#help-open');
    await page.keyboard.press('Enter');
    await page.waitForSelector('#guide', { state: 'visible' });
    const words = await page.locator('#guide strong').allInnerTexts();
    assert.deepEqual(words, ['Objects', 'Fix', 'Save']);
    assert.match(await text(page, '#summary'), /^Object \d/);
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'guide');
    await page.click('#help-close');
    assert.equal(await text(page, '#objects-title'), 'Objects');
    assert.equal(await text(page, '#correct-open'), 'Fix');
    assert.match(await text(page, '#export-open'), /^Save/);
    assert.deepEqual(faults, []);
  });
});
