// The page in German: what is chosen, that nothing English is left, that nothing is cut off.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import {
  accessibilityFaults,
  ended,
  inPhase,
  openFix,
  openSave,
  plainFrame,
  pngFile,
  run,
  screenshot,
  showOnly,
  text,
  useSite,
} from './support.mjs';

/** Words that English sentences hardly do without, and nouns of the page that German has other words for. */
const ENGLISH = new RegExp(
  String.raw`\b(the|and|of|with|is|are|to|from|for|by|on|off|or|not|all|each|every|this|that|it|what|where|when|you|your|` +
    String.raw`frames?|objects?|masks?|moves?|left|right|top|bottom|upper|lower|about|again|save|open|close|cancel|reset|run|` +
    String.raw`clear|apply|keep|kept|show|hide|settings?|colours?|background|foreground|done|made|computed|reading)\b`,
  'i',
);

/** Runs in the page: all that can be read, by eye or aloud; documentation of parameters and the recipe stay English. */
function readable() {
  const passed = '.group .setting, #recipe, #error-detail, .symbols, script, noscript, [lang="en"], kbd';
  const found = [];
  const take = (words) => words?.trim() && found.push(words.trim());
  take(document.title);
  for (const element of document.body.querySelectorAll('*')) {
    if (element.closest(passed)) continue;
    for (const name of ['aria-label', 'aria-valuetext', 'title', 'alt', 'placeholder'])
      take(element.getAttribute(name));
    for (const node of element.childNodes) if (node.nodeType === Node.TEXT_NODE) take(node.data);
  }
  return [...new Set(found)];
}

/** Runs in the page: buttons, labels and headings whose words do not fit; some are meant to end in dots. */
function cutOff() {
  const kinds = 'button, h1, h2, h3, label > span, summary, .object-name, .layer-name, .stage-name, legend, .value';
  // Heard, not seen, while a result is fixed on a phone.
  const isShrunk = (heading) => heading !== null && heading.offsetWidth <= 1;
  return [...document.querySelectorAll(kinds)]
    .filter(
      (element) =>
        element.offsetParent && !element.closest('.visually-hidden') && !isShrunk(element.closest('.heading')),
    )
    .filter((element) => getComputedStyle(element).textOverflow !== 'ellipsis')
    .filter((element) => element.clientWidth > 0 && element.scrollWidth > element.clientWidth + 1)
    .map((element) => element.textContent.trim());
}

/** Nothing English is left. */
async function inGerman(page, where) {
  const all = await page.evaluate(readable);
  assert.ok(all.length > 100, `${all.length} texts`);
  // Names of files that are made stay as they are.
  const left = all.filter((words) => ENGLISH.test(words.replace(/\S+\.(json|zip|webm|mp4|png|dat|txt|csv)\b/g, '')));
  assert.deepEqual(left, [], where);
}

const looks = {
  'on a desk': { viewport: { width: 1280, height: 800 } },
  'on a phone': { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true },
};

describe('the page in German', () => {
  const site = useSite();

  for (const [look, options] of Object.entries(looks)) {
    test(`nothing is left in English, and all of it fits, ${look}`, async () => {
      const name = `german-${look.replaceAll(' ', '-')}`;
      // The checker is no script of the site: the policy has to let it in.
      const { page, faults } = await site.open({ query: '?lang=de', bypassCSP: true, ...options });
      await inPhase(page, 'running');
      await inGerman(page, 'running');
      assert.equal(await ended(page), 'done');
      assert.equal(await page.evaluate(() => document.documentElement.lang), 'de');
      assert.match(await text(page, '#headline'), /^3 bewegte Objekte und der Hintergrund$/);
      await inGerman(page, 'done');
      const seen = async (where) => {
        assert.deepEqual(await page.evaluate(cutOff), [], where);
        const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
        assert.ok(wide <= 0, `${where}: ${wide} px too wide`);
        // On a phone the checker has had English, and these words on a desk.
        if (!options.isMobile) assert.deepEqual(await accessibilityFaults(page), [], where);
        await screenshot(page, `${name}-${where.replaceAll(' ', '-')}`);
      };
      await seen('done');
      await page.click('#help-open');
      await page.waitForSelector('#help[open]');
      await inGerman(page, 'help');
      await seen('help');
      await page.click('#help-close');
      await openFix(page);
      for (const tool of await page.locator('#correct-tools label:not(:has(:disabled))').all()) {
        await tool.click();
        await inGerman(page, 'fix');
      }
      await seen('fix');
      await page.click('#correct-done');
      await openSave(page);
      await page.click('#recipe-box > summary');
      await inGerman(page, 'save');
      await seen('save');
      await page.click('[data-export="png"]');
      await page.waitForFunction(() => document.querySelector('#export-status').textContent.includes('gespeichert'));
      await inGerman(page, 'saved');
      await page.click('#export-close');
      await showOnly(page);
      await page.click('#settings-all > summary');
      await page.click('#settings-expert > summary');
      for (const summary of await page.locator('.group:not([hidden]) > summary').all()) await summary.click();
      await inGerman(page, 'layers and settings');
      await seen('layers and settings');
      await run(page, [pngFile('flach.png', plainFrame(60, 40))]);
      await inGerman(page, 'still image');
      await run(page, [{ name: 'notiz.txt', mimeType: 'text/plain', buffer: Buffer.from('x') }]);
      assert.equal(await text(page, '#error-title'), 'Das ist weder ein Video noch ein Bild');
      await inGerman(page, 'error');
      assert.deepEqual(faults, []);
    });
  }
});

describe('the language of the page', () => {
  const site = useSite({ sample: 'tiny' });

  test('English is what a browser in English shows, without fetching another language', async () => {
    const { page } = await site.open();
    const asked = [];
    page.on('request', (request) => asked.push(request.url()));
    await page.reload();
    assert.equal(await ended(page), 'done');
    assert.equal(await page.evaluate(() => document.documentElement.lang), 'en');
    assert.match(await text(page, '#subline'), / 4 frames of 96 × 54/);
    assert.deepEqual(
      asked.filter((url) => url.includes('/words/')),
      [],
    );
  });

  test('a browser in German shows German; the choice in the help is kept, and the address counts more', async () => {
    const { page } = await site.open({ locale: 'de-DE' });
    const shown = (code) => page.waitForFunction((wanted) => document.documentElement.lang === wanted, code);
    const choose = async (code, present) => {
      await page.click('#help-open');
      await page.waitForSelector('#help[open]');
      assert.equal(await page.inputValue('#language'), present);
      await Promise.all([page.waitForNavigation(), page.selectOption('#language', code)]);
    };
    await shown('de');
    assert.equal(await ended(page), 'done');
    await choose('en', 'de');
    assert.equal(await ended(page), 'done');
    await shown('en');
    await page.goto(`${page.url()}?lang=de`);
    await shown('de');
    assert.equal(await ended(page), 'done');
    await choose('en', 'de');
    assert.equal(await ended(page), 'done');
    await shown('en');
    assert.match(page.url(), /\?lang=en$/);
  });
});
