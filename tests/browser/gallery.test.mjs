// The gallery: clips with their masks ready, opened by a click and by keys, without a run.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { describe, test } from 'node:test';
import { root } from '../../scripts/tools.mjs';
import { accessibilityFaults, ended, openFix, openSample, openSave, screenshot, text, useSite } from './support.mjs';

const { clips } = JSON.parse(readFileSync(join(root, 'www', 'demo', 'gallery', 'index.json'), 'utf8'));
const [first, second] = clips;

/** Opens the list and waits for its posters. */
async function openList(page) {
  await page.click('#gallery summary');
  await page.waitForSelector('.gallery-card');
  const posters = page.locator('.gallery-card img');
  await posters.first().scrollIntoViewIfNeeded();
  await page.waitForFunction(() =>
    [...document.querySelectorAll('.gallery-card img')].every((image) => image.complete && image.naturalWidth > 0),
  );
  return posters.count();
}

/** Waits until a clip of the gallery is on screen, done. */
async function shown(page, id) {
  await page.waitForFunction((wanted) => globalThis.tracecutDemo.source?.gallery === wanted, id);
  assert.equal(await ended(page), 'done');
}

/** Runs in the page: what is on screen. */
const seen = () => {
  const { app, result } = globalThis.tracecutDemo;
  app.viewer.draw();
  const masked = (t) => result.labels(t).reduce((sum, label) => sum + (label > 0 ? 1 : 0), 0);
  const frames = Array.from({ length: result.numFrames }, (_, t) => masked(t));
  return { frames, stages: app.job.stages.map(({ id }) => id) };
};

describe('the gallery', () => {
  const site = useSite({ sample: 'tiny' });

  test('opens a clip with its masks at once, by a click; it plays, is saved and corrected like any other', async () => {
    const { page, faults } = await openSample(site, { bypassCSP: true, acceptDownloads: true });
    const asked = [];
    page.on('request', (request) => asked.push(new URL(request.url()).pathname));
    assert.equal(await openList(page), clips.length);
    assert.deepEqual(await accessibilityFaults(page), []);
    assert.ok(!asked.some((name) => name.endsWith('.tracecut')), 'clips are fetched when they are chosen');
    await page.click(`[data-clip="${first.id}"]`);
    await shown(page, first.id);
    const { frames, stages } = await page.evaluate(seen);
    assert.deepEqual(stages, ['frames'], 'frames are read, nothing is computed');
    assert.equal(frames.length, first.frames);
    assert.ok(frames.every((pixels) => pixels > 1000));
    assert.match(await text(page, '#headline'), new RegExp(`^${first.objects} moving objects`));
    assert.equal(await page.locator('#object-list .object').count(), first.objects + 1);
    assert.equal(await page.locator('.gallery-card[aria-current]').getAttribute('data-clip'), first.id);
    await screenshot(page, 'gallery');
    await page.click('#play');
    await page.waitForFunction(() => globalThis.tracecutDemo.app.timeline.frame > 2);
    await page.click('#play');
    await openSave(page);
    const coming = page.waitForEvent('download');
    await page.click('[data-export="project"]');
    assert.match((await coming).suggestedFilename(), /\.tracecut$/);
    await page.click('#export-close');
    assert.deepEqual(faults, []);
    await page.context().close();
  });

  test('works from the keyboard, and is kept in the browser only when it was corrected', async () => {
    const { page, faults } = await openSample(site);
    await page.focus('#gallery summary');
    await page.keyboard.press('Enter');
    await page.waitForSelector('.gallery-card');
    await page.keyboard.press('Tab');
    await page.keyboard.press('Tab');
    const focused = () => page.evaluate(() => document.activeElement.getAttribute('aria-label'));
    assert.match(await focused(), new RegExp(`^\\p{Lu}.*\\. .+\\. ${second.objects} objects?, \\d\\.\\d`, 'u'));
    await page.keyboard.press('Enter');
    await shown(page, second.id);
    // Longer than changes wait to be kept.
    await page.waitForTimeout(1500);
    assert.equal(await page.evaluate(() => document.body.dataset.kept), undefined);
    await openFix(page);
    await page.selectOption('#correct-object', '1');
    await page.click('#correct-background');
    await page.waitForFunction(() => document.body.dataset.kept !== undefined);
    assert.deepEqual(faults, []);
    await page.context().close();
  });

  test('on a phone, brings the picture back into sight', async () => {
    const { page, faults } = await openSample(site, {
      viewport: { width: 390, height: 844 },
      hasTouch: true,
      bypassCSP: true,
    });
    await openList(page);
    const { innerWidth, wide } = await page.evaluate(() => ({
      innerWidth,
      wide: document.documentElement.scrollWidth,
    }));
    assert.ok(wide <= innerWidth, `${wide} px`);
    assert.match(await text(page, '#gallery summary'), /^Gallery/);
    assert.equal(await text(page, `[data-clip="coast"]`), 'On the coast');
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'gallery-phone');
    await page.locator(`[data-clip="coast"]`).tap();
    await shown(page, 'coast');
    assert.equal(await text(page, '#clip-name'), 'On the coast');
    const top = await page.evaluate(() => document.querySelector('#stage').getBoundingClientRect().top);
    assert.ok(Math.abs(top) < 60, `${top} px`);
    assert.deepEqual(faults, []);
    await page.context().close();
  });

  test('without a network says so calmly, and leaves what is on screen; what was opened before opens again', async () => {
    const { page } = await openSample(site, { serviceWorkers: 'allow' });
    await page.evaluate(() => navigator.serviceWorker.ready.then(() => true));
    await page.reload();
    assert.equal(await ended(page), 'done');
    await openList(page);
    await page.click(`[data-clip="${first.id}"]`);
    await shown(page, first.id);
    await page.context().setOffline(true);
    await page.click(`[data-clip="${second.id}"]`);
    await page.waitForFunction(() => /network/.test(document.querySelector('#gallery-status').textContent));
    await shown(page, first.id);
    await page.reload();
    assert.equal(await ended(page), 'done');
    await openList(page);
    await page.click(`[data-clip="${first.id}"]`);
    await shown(page, first.id);
    await page.context().close();
  });
});
