// "About" in the help: which version this is, and whether this browser computes what every other does.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { describe, test } from 'node:test';
import { root } from '../../scripts/tools.mjs';
import { accessibilityFaults, openSample, screenshot, text, useSite } from './support.mjs';

const { hashes, version } = JSON.parse(readFileSync(join(root, 'cli', 'src', 'selftest', 'expected.json'), 'utf8'));

describe('about', () => {
  const site = useSite();

  test('the hashes of this browser are shown, and one that differs is told', async () => {
    const { page, faults } = await openSample(site, { bypassCSP: true });
    await page.keyboard.press('?');
    await page.click('#about-open');
    assert.match(await text(page, '#about'), new RegExp(`TraceCut ${version.replaceAll('.', '\\.')}, free software`));
    await page.click('#about-check');
    await page.waitForFunction(() => /^All/.test(document.querySelector('#about-status').textContent));
    assert.equal(await text(page, '#about-status'), 'All 19 parts came to what they come to everywhere.');
    const names = await page.locator('#about dt').allInnerTexts();
    const lines = await page.locator('#about dd').allInnerTexts();
    assert.deepEqual(Object.fromEntries(names.map((name, k) => [name, lines[k].split(' ')[0]])), hashes);
    assert.ok(lines.every((line) => line.endsWith('the same')));
    await screenshot(page, 'about');
    assert.deepEqual(await accessibilityFaults(page), []);
    // As in an engine that rounds otherwise.
    await page.evaluate(() => (Math.round = Math.floor));
    await page.click('#about-check');
    await page.waitForFunction(() => /please report/.test(document.querySelector('#about-status').textContent));
    assert.equal((await page.locator('#about .hash-differs').count()) > 0, true);
    assert.match(await text(page, '#about .hash-differs >> nth=0'), /differs from [0-9a-f]{16}/);
    assert.deepEqual(faults, []);
  });
});
