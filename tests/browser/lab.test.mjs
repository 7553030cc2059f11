// The lab, one story: the sample is segmented, each layer paints, a parameter changes the run, a pixel is explained, clips
// are opened, errors and cancelling have a way on.

import assert from 'node:assert/strict';
import { afterEach, before, describe, test } from 'node:test';
import {
  CONTRAST,
  NO_CONTRAST,
  accessibilityFaults,
  ended,
  movingClip,
  plainFrame,
  pngFile,
  run,
  screenshot,
  text,
  useSite,
} from './support.mjs';

const PHONE = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };

/** Opens the lab and waits for its sample. */
async function openLab(site, options) {
  const { page, faults } = await site.open({ query: 'lab/', ...options });
  assert.equal(await ended(page), 'done');
  await page.evaluate(() => {
    globalThis.runs = 0;
    const count = () => (globalThis.runs += document.body.dataset.state === 'done' ? 1 : 0);
    new MutationObserver(count).observe(document.body, { attributeFilter: ['data-state'] });
  });
  return { page, faults };
}

/** Opens the card of a stage. */
const openStage = (page, id) => page.click(`[aria-controls="stage-${id}"]`);

/** Waits until frame `t` is drawn with a stage in a mode, and gives the picture. */
async function drawn(page, stage, mode, t) {
  await page.waitForFunction(
    (wanted) => document.querySelector('#canvas').dataset.drawn === wanted,
    `${stage} ${mode} ${t}`,
  );
  return page.evaluate(() => document.querySelector('#canvas').toDataURL());
}

/** Does something, and waits until a run that it began has ended. */
async function runsAgain(page, act) {
  const before = await page.evaluate(() => globalThis.runs);
  await act();
  await page.waitForFunction((count) => globalThis.runs > count, before);
}

describe('the lab', () => {
  const site = useSite();
  let page, faults;
  // The checker of accessibility is no script of the site.
  before(async () => ({ page, faults } = await openLab(site, { bypassCSP: true })));
  afterEach(() => assert.deepEqual(faults, []));

  test('segments the sample and draws every stage, each mode another picture', async () => {
    assert.match(await text(page, '#status'), /^\d moving objects? in 16 frames\.$/);
    const seen = new Map();
    const ids = await page.$$eval('.stage-body', (bodies) => bodies.map(({ id }) => id.replace('stage-', '')));
    assert.equal(ids.length, 10);
    for (const id of ids) {
      await openStage(page, id);
      const modes = await page.$$eval(`#mode-${id} option`, (options) => options.map(({ value }) => value));
      for (const mode of modes.length > 0 ? modes : ['']) {
        if (mode) await page.selectOption(`#mode-${id}`, mode);
        const picture = await drawn(page, id, mode, 8);
        assert.equal(seen.get(picture), undefined, `${id} ${mode} looks like ${seen.get(picture)}`);
        seen.set(picture, `${id} ${mode}`);
        assert.match(await text(page, `#stage-${id} .facts`), /\d/, `${id} ${mode}`);
      }
      await screenshot(page, `lab-${id}`, { whole: false });
    }
    assert.ok(seen.size >= 29, `${seen.size} pictures`);
  });

  test('goes frame by frame with buttons, keys and the slider, and plays', async () => {
    await openStage(page, 'discontinuities');
    await page.selectOption('#mode-discontinuities', 'threshold');
    const first = await drawn(page, 'discontinuities', 'threshold', 8);
    await page.keyboard.press('ArrowRight');
    assert.notEqual(await drawn(page, 'discontinuities', 'threshold', 9), first);
    await page.keyboard.press('ArrowLeft');
    assert.equal(await drawn(page, 'discontinuities', 'threshold', 8), first);
    await page.click('#back');
    await drawn(page, 'discontinuities', 'threshold', 7);
    await page.locator('#scrub').fill('3');
    await drawn(page, 'discontinuities', 'threshold', 3);
    await page.click('#play');
    await page.waitForFunction(() => Number(document.querySelector('#scrub').value) > 5);
    await page.click('#play');
    assert.equal(await text(page, '#play'), 'Play');
  });

  test('explains a pixel that is clicked or entered', async () => {
    await page.locator('#scrub').fill('8');
    await openStage(page, 'clusters');
    await page.selectOption('#mode-clusters', 'cluster');
    const before = await drawn(page, 'clusters', 'cluster', 8);
    const { width, height } = await page.locator('#canvas').boundingBox();
    await page.locator('#canvas').click({ position: { x: width / 2, y: height / 2 } });
    await page.waitForSelector('#why-answer table');
    assert.match(await text(page, '.why-title'), /^(Background|Object \d+) at \(96, 54\) in frame 9$/);
    await page.waitForFunction((picture) => document.querySelector('#canvas').toDataURL() !== picture, before);
    await page.fill('#why-form [name=x]', '3');
    await page.fill('#why-form [name=y]', '4');
    await page.click('#why-form button');
    await page.waitForFunction(() => document.querySelector('.why-title').innerText.includes('(3, 4) in frame 9'));
    await page.click('#forward');
    await page.waitForFunction(() => document.querySelector('.why-title').innerText.includes('(3, 4) in frame 10'));
    assert.ok((await page.locator('#why-answer li').count()) >= 2);
    await page.keyboard.press('Escape');
    assert.equal(await page.locator('#why-answer').innerText(), '');
  });

  test('opens a dropped clip, and selects another part of it', async () => {
    const files = movingClip(12, [96, 64]).map(({ name, buffer }) => [name, buffer.toString('base64')]);
    const drop = (list) => {
      const dataTransfer = new DataTransfer();
      for (const [name, base64] of list) {
        const bytes = Uint8Array.from(atob(base64), (char) => char.charCodeAt(0));
        dataTransfer.items.add(new File([bytes], name, { type: 'image/png' }));
      }
      document.body.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
    };
    await runsAgain(page, () => page.evaluate(drop, files));
    assert.equal(await text(page, '#clip-name'), 'frame000.png and 11 more');
    assert.match(await text(page, '#status'), / in 12 frames\.$/);
    await openStage(page, 'frames');
    await runsAgain(page, async () => {
      await page.fill('.selection [name=maxFrames]', '8');
      await page.locator('.selection [name=maxFrames]').blur();
    });
    assert.match(await text(page, '#status'), / in 8 of 12 frames\.$/);
  });

  test('runs again with a changed parameter or preset, and resets them', async () => {
    await openStage(page, 'trajectories');
    const facts = () => text(page, '#stage-trajectories .facts');
    const t = await page.inputValue('#scrub');
    await drawn(page, 'trajectories', '', t);
    const usual = await facts();
    await page.click('#stage-trajectories summary');
    const field = page.locator('[id="trajectory.gridStep"]');
    assert.equal(await field.inputValue(), '8');
    await field.fill('99');
    await field.blur();
    assert.equal(await text(page, '.parameter:has([id="trajectory.gridStep"]) .invalid'), 'Enter a number, 3 to 64.');
    await runsAgain(page, async () => {
      await field.fill('16');
      await field.blur();
    });
    await drawn(page, 'trajectories', '', t);
    assert.equal(await text(page, '#changes'), '1 changed');
    assert.notEqual(await facts(), usual);
    await runsAgain(page, () => page.click('#reset'));
    await page.waitForFunction(
      (wanted) => document.querySelector('#stage-trajectories .facts').innerText === wanted,
      usual,
    );
    assert.equal(await field.inputValue(), '8');
    await runsAgain(page, () => page.selectOption('#preset', 'paper'));
    assert.equal(await field.inputValue(), '', 'the preset decides');
    await runsAgain(page, () => page.click('#reset'));
  });

  test('cancels a run, and starts it again', async () => {
    await page.setInputFiles('#file', movingClip(6, [400, 226]));
    await page.waitForSelector('body[data-state="running"] #progress');
    await page.keyboard.press('Escape');
    await page.waitForSelector('body[data-state="stopped"]');
    await runsAgain(page, () => page.click('#again'));
    assert.match(await text(page, '#status'), / in 6 frames\.$/);
  });

  test('explains what is wrong with a clip, and offers ways to continue', async () => {
    assert.equal(await run(page, [pngFile('alone.png', plainFrame(60, 40))]), 'error');
    assert.match(await text(page, '#error'), /at least two frames/);
    const sizes = [60, 64].map((width, k) => pngFile(`${k}.png`, plainFrame(width, 40)));
    assert.equal(await run(page, sizes), 'error');
    assert.match(await text(page, '#error'), /64x40/);
    await runsAgain(page, () => page.click('#error-sample'));
  });

  test('opens the studio’s clip with one click, and links back', async () => {
    const studio = await site.open();
    await ended(studio.page);
    await run(studio.page, movingClip(6, [96, 60]));
    await studio.page.click('#redo-open');
    await studio.page.click('#lab-open');
    await studio.page.waitForURL(/\/lab\/#clip$/);
    assert.equal(await ended(studio.page), 'done');
    assert.equal(await text(studio.page, '#clip-name'), 'frame000.png and 5 more');
    assert.match(await text(studio.page, '#status'), / in 6 frames\.$/);
    await studio.page.click('#sample');
    await studio.page.waitForFunction(() => / in 16 frames\.$/.test(document.querySelector('#status').textContent));
    assert.equal(await text(studio.page, '#clip-name'), 'Sample');
    await studio.page.click('nav a');
    await studio.page.waitForSelector('#lab-open', { state: 'attached' });
    assert.equal(new URL(studio.page.url()).pathname, '/');
    assert.deepEqual(faults, []);
  });

  for (const look of ['desk', 'phone']) {
    test(`passes an accessibility checker, on a ${look}`, async () => {
      if (look === 'phone') ({ page, faults } = await openLab(site, { ...PHONE, bypassCSP: true }));
      await page.click('#why-form button');
      await page.waitForSelector('#why-answer table');
      for (const id of look === 'phone' ? ['cut'] : ['frames', 'saliency', 'cut']) {
        await openStage(page, id);
        await page.click(`#stage-${id} summary`);
        assert.deepEqual(await accessibilityFaults(page, NO_CONTRAST), [], id);
      }
      for (const colorScheme of look === 'phone' ? [] : ['light', 'dark']) {
        await page.emulateMedia({ colorScheme });
        assert.deepEqual(await accessibilityFaults(page, CONTRAST), [], colorScheme);
      }
      const excess = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(excess <= 0, `${excess} px too wide`);
      await screenshot(page, `lab-${look}`, { whole: false });
      if (look === 'phone') return;
      await run(page, [pngFile('alone.png', plainFrame(60, 40))]);
      assert.deepEqual(await accessibilityFaults(page), [], 'error');
    });
  }
});
