// What an accessibility checker says of the page in each of its states, in both colour schemes (between which nothing but
// colours differ) and at phone width; that every text fits where it stands; and what the help tells.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { describe, test } from 'node:test';
import { root } from '../../scripts/tools.mjs';
import { WIDE, fiveObjects } from './five-objects.mjs';
import {
  CONTRAST,
  NO_CONTRAST,
  accessibilityFaults,
  ended,
  openFix,
  openLook,
  openRedo,
  plainFrame,
  pngFile,
  run,
  screenshot,
  showOnly,
  text,
  useSample,
  useSite,
} from './support.mjs';

const { hashes, version } = JSON.parse(readFileSync(join(root, 'cli', 'src', 'selftest', 'expected.json'), 'utf8'));

const looks = {
  'on a desk': {},
  'on a phone': { viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true },
};

/** What it says of the page: on a desk of its colours too, in the light and, where there are new ones, in the dark. */
async function faultsOf(page, look, { isNew = true } = {}) {
  if (look !== 'on a desk') return accessibilityFaults(page, NO_CONTRAST);
  await page.emulateMedia({ colorScheme: 'light' });
  const light = await accessibilityFaults(page);
  if (!isNew) return light;
  await page.emulateMedia({ colorScheme: 'dark' });
  return [...light, ...(await accessibilityFaults(page, CONTRAST))];
}

/** Runs in the page: buttons, labels and headings whose text does not fit; some are meant to end in dots. */
function cutOff() {
  const kinds = 'button, h1, h2, h3, label > span, summary, .object-name, .layer-name, legend, .value';
  // Heard, not seen, while a result is fixed on a phone.
  const isShrunk = (heading) => heading !== null && heading.offsetWidth <= 1;
  return [...document.querySelectorAll(kinds)]
    .filter(
      (element) =>
        element.checkVisibility() && !element.closest('.visually-hidden') && !isShrunk(element.closest('.heading')),
    )
    .filter((element) => getComputedStyle(element).textOverflow !== 'ellipsis')
    .filter((element) => element.clientWidth > 0 && element.scrollWidth > element.clientWidth + 1)
    .map((element) => element.textContent.trim());
}

/** Asserts that no text is cut off and that the page is no wider than the window. */
async function assertFits(page, where) {
  assert.deepEqual(await page.evaluate(cutOff), [], where);
  const excess = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(excess <= 0, `${where}: ${excess} px too wide`);
}

/** Selects each radio button of a group in turn. */
async function forEachChoice(page, name, visit) {
  const values = await page.locator(`[name="${name}"]`).evaluateAll((all) => all.map(({ value }) => value));
  for (const [k, value] of values.entries()) {
    await page
      .locator(`[name="${name}"]`)
      .nth(k)
      .evaluate((button) => button.click());
    await visit(value);
  }
}

describe('an accessibility checker finds nothing', () => {
  const site = useSite();

  for (const [look, options] of Object.entries(looks)) {
    test(look, async () => {
      // The checker is no script of the site: the policy has to let it in.
      const { page } = await site.open({ ...options, bypassCSP: true });
      const visit = async (state, { isNew = true, fits = true } = {}) => {
        assert.deepEqual(await faultsOf(page, look, { isNew }), [], state);
        if (fits) await assertFits(page, state);
      };
      await visit('welcome', { isNew: false, fits: false });
      // The run may be over by now.
      await page.waitForFunction(() => ['running', 'done'].includes(document.body.dataset.phase));
      await visit('running', { fits: false });
      assert.equal(await ended(page), 'done');
      await screenshot(page, `axe-${look.replaceAll(' ', '-')}`);
      await forEachChoice(page, 'view', (view) => visit(`view ${view}`, { isNew: false }));
      await page
        .locator('[name="view"]')
        .first()
        .evaluate((button) => button.click());
      await openFix(page);
      await forEachChoice(page, 'tool', (tool) => visit(`fix, ${tool}`));
      await page.click('#correct-done');
      await showOnly(page);
      await visit('all layers');
      await openLook(page);
      await visit('edges and layers');
      await page.evaluate(() => (document.querySelector('#look').open = false));
      await openRedo(page);
      await visit('redo');
      await page.click('#redo-close');
      await page.keyboard.press('?');
      await page.waitForSelector('#help[open]');
      await visit('help');
      await page.click('#help-close');
      await page.click('#export-open');
      await page.waitForSelector('#export[open]');
      await forEachChoice(page, 'export-choice', (choice) => visit(`save, ${choice}`, { isNew: false }));
      await page.click('#export-more > summary');
      await page.click('#recipe-box > summary');
      await visit('save, more');
      assert.equal(
        await page.evaluate(
          () => document.querySelector('#export').scrollWidth <= document.querySelector('#export').clientWidth,
        ),
        true,
      );
      await page.click('#export-close');
      const { video, project } = await fiveObjects(page, WIDE);
      await page.setInputFiles('#file', project);
      await page.waitForFunction(() => globalThis.tracecutStudio.source?.name === 'five.webm');
      assert.equal(await ended(page), 'done');
      await page.focus('#trim-from');
      await page.keyboard.press('ArrowRight');
      await page.waitForSelector('#trim-run', { state: 'visible' });
      await visit('trim');
      await run(page, [pngFile('plain.png', plainFrame(60, 40))]);
      await visit('still image', { isNew: false, fits: false });
      await run(page, [{ name: 'notes.txt', mimeType: 'text/plain', buffer: Buffer.from('x') }]);
      await visit('error', { fits: false });
      assert.equal(await run(page, [video]), 'done');
      await page.waitForSelector('#projects-open', { state: 'visible' });
      await page.click('#projects-open');
      await page.waitForSelector('#projects[open]');
      await visit('projects');
      await page.click('#projects-close');
      await run(
        page,
        [0, 1, 2].map((k) => pngFile(`plain${k}.png`, plainFrame(96, 64))),
      );
      await page.waitForSelector('#suggestions', { state: 'visible' });
      await visit('nothing found');
    });
  }
});

describe('the help', () => {
  const sample = useSample(useSite(), { bypassCSP: true });

  test('has the first steps, three sentences behind the button of the help, whose words are those of the page', async () => {
    const { page, faults } = sample;
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

  test('the hashes of this browser are shown, and one that differs is told', async () => {
    const { page, faults } = sample;
    await page.keyboard.press('?');
    await page.click('#about-open');
    assert.match(await text(page, '#about'), new RegExp(`TraceCut ${version.replaceAll('.', '\\.')}, free software`));
    await page.click('#about-check');
    await page.waitForFunction(() => /^All/.test(document.querySelector('#about-status').textContent));
    assert.equal(await text(page, '#about-status'), 'All 19 parts match.');
    const names = await page.locator('#about dt').allInnerTexts();
    const lines = await page.locator('#about dd').allInnerTexts();
    assert.deepEqual(Object.fromEntries(names.map((name, k) => [name, lines[k].split(' ')[0]])), hashes);
    assert.ok(lines.every((line) => line.endsWith('· same')));
    await screenshot(page, 'about');
    assert.deepEqual(await accessibilityFaults(page), []);
    // As in an engine that rounds otherwise.
    await page.evaluate(() => (Math.round = Math.floor));
    await page.click('#about-check');
    await page.waitForFunction(() => /Please report/.test(document.querySelector('#about-status').textContent));
    assert.equal((await page.locator('#about .hash-differs').count()) > 0, true);
    assert.match(await text(page, '#about .hash-differs >> nth=0'), /differs from [0-9a-f]{16}/);
    assert.deepEqual(faults, []);
  });
});
