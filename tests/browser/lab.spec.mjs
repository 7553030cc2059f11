// The lab: draws the stages of its sample, explains pixels, runs again with other parameters, opens clips.

import { movingFrames, plainFrame } from '../moving.mjs';
import { expect, openSample, runEnd, test } from './fixtures.mjs';
import { CONTRAST, NO_CONTRAST, accessibilityFaults, dropFiles, openFive, pngFile, pngFiles } from './studio-page.mjs';

/** Opens the card of a stage. */
const openStage = (page, id) => page.click(`[aria-controls="stage-${id}"]`);

/** Waits until frame `t` is drawn with a stage in a mode, and returns the hash of the picture. */
async function drawn(page, stage, mode, t) {
  await expect(page.locator('#canvas')).toHaveAttribute('data-drawn', `${stage} ${mode} ${t}`);
  return pictureHash(page);
}

/** Returns the hash of the picture on the canvas. */
function pictureHash(page) {
  return page.evaluate(async () => {
    const canvas = document.querySelector('#canvas');
    const context = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
    context.drawImage(canvas, 0, 0);
    const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
    return new Uint8Array(await crypto.subtle.digest('SHA-1', data)).join();
  });
}

/** Does something that starts a run, and waits until a run is done after that. */
async function runAgain(page, act) {
  const before = await page.evaluate(() => globalThis.finishedRuns);
  await act();
  await page.waitForFunction((count) => globalThis.finishedRuns > count, before);
}

test.describe.serial('the lab', () => {
  let page;
  const status = () => page.locator('#status');

  test.beforeAll(async ({ openStudio }) => {
    page = await openSample(openStudio, { sample: 'brief', query: 'lab/', bypassCSP: true });
    await page.evaluate(() => {
      globalThis.finishedRuns = 0;
      const count = () => (globalThis.finishedRuns += document.body.dataset.state === 'done' ? 1 : 0);
      new MutationObserver(count).observe(document.body, { attributeFilter: ['data-state'] });
    });
  });
  test.afterAll(() => page.context().close());

  test('segments the sample and draws every stage, each mode another picture', async () => {
    await expect(status()).toHaveText(/^\d moving objects? in 8 frames\.$/);
    const pictures = new Map();
    const stages = await page.$$eval('.stage-body', (bodies) => bodies.map(({ id }) => id.replace('stage-', '')));
    expect(stages).toHaveLength(10);
    for (const stage of stages) {
      await openStage(page, stage);
      const modes = await page.$$eval(`#mode-${stage} option`, (options) => options.map(({ value }) => value));
      for (const mode of modes.length > 0 ? modes : ['']) {
        if (mode) await page.selectOption(`#mode-${stage}`, mode);
        const picture = await drawn(page, stage, mode, 4);
        expect(pictures.get(picture), `looks like ${stage} ${mode}`).toBeUndefined();
        pictures.set(picture, `${stage} ${mode}`);
        await expect(page.locator(`#stage-${stage} .facts`)).toHaveText(/\d/);
      }
    }
    expect(pictures.size).toBeGreaterThanOrEqual(29);
  });

  test('goes frame by frame with buttons, keys and the slider, and plays', async () => {
    await openStage(page, 'discontinuities');
    await page.selectOption('#mode-discontinuities', 'threshold');
    const show = (t) => drawn(page, 'discontinuities', 'threshold', t);
    const first = await show(4);
    await page.keyboard.press('ArrowRight');
    expect(await show(5)).not.toBe(first);
    await page.keyboard.press('ArrowLeft');
    expect(await show(4)).toBe(first);
    await page.click('#back');
    await show(3);
    await page.locator('#scrub').fill('1');
    await show(1);
    await page.click('#play');
    await page.waitForFunction(() => Number(document.querySelector('#scrub').value) > 3);
    await page.click('#play');
    await expect(page.locator('#play')).toHaveText('Play');
  });

  test('explains a pixel that is clicked or entered', async () => {
    await page.locator('#scrub').fill('4');
    await openStage(page, 'clusters');
    await page.selectOption('#mode-clusters', 'cluster');
    const before = await drawn(page, 'clusters', 'cluster', 4);
    const { width, height } = await page.locator('#canvas').boundingBox();
    await page.locator('#canvas').click({ position: { x: width / 2, y: height / 2 } });
    const title = page.locator('.why-title');
    await expect(title).toHaveText(/^(Background|Object \d+) at \(64, 36\) in frame 5$/);
    await expect.poll(() => pictureHash(page)).not.toBe(before);
    await page.fill('#why-form [name=x]', '3');
    await page.fill('#why-form [name=y]', '4');
    await page.click('#why-form button');
    await expect(title).toHaveText(/\(3, 4\) in frame 5/);
    await page.click('#forward');
    await expect(title).toHaveText(/\(3, 4\) in frame 6/);
    expect(await page.locator('#why-answer li').count()).toBeGreaterThanOrEqual(2);
    await page.keyboard.press('Escape');
    await expect(page.locator('#why-answer')).toBeEmpty();
  });

  test('runs again with a changed parameter or preset, and resets them', async () => {
    await openStage(page, 'trajectories');
    const facts = page.locator('#stage-trajectories .facts');
    const t = await page.inputValue('#scrub');
    await drawn(page, 'trajectories', '', t);
    const defaultFacts = await facts.innerText();
    await page.click('#stage-trajectories summary');
    const field = page.locator('[id="trajectory.gridStep"]');
    await expect(field).toHaveValue('8');
    await field.fill('99');
    await field.blur();
    const invalid = page.locator('.parameter:has([id="trajectory.gridStep"]) .invalid');
    await expect(invalid).toHaveText('Enter a number, 3 to 64.');
    await runAgain(page, async () => {
      await field.fill('16');
      await field.blur();
    });
    await drawn(page, 'trajectories', '', t);
    await expect(page.locator('#changes')).toHaveText('1 changed');
    await expect(facts).not.toHaveText(defaultFacts);
    await runAgain(page, () => page.click('#reset'));
    await expect(facts).toHaveText(defaultFacts, { useInnerText: true });
    await expect(field).toHaveValue('8');
    await runAgain(page, () => page.selectOption('#preset', 'paper'));
    await expect(field).toHaveValue('');
    await runAgain(page, () => page.click('#reset'));
  });

  test('passes an accessibility checker, and fits a phone', async () => {
    await page.click('#why-form button');
    await page.waitForSelector('#why-answer table');
    for (const stage of ['frames', 'cut']) {
      await openStage(page, stage);
      await page.click(`#stage-${stage} summary`);
      expect(await accessibilityFaults(page, NO_CONTRAST), stage).toEqual([]);
    }
    for (const colorScheme of ['light', 'dark']) {
      await page.emulateMedia({ colorScheme });
      expect(await accessibilityFaults(page, CONTRAST), colorScheme).toEqual([]);
    }
    await page.emulateMedia({ colorScheme: 'light' });
    await page.setViewportSize({ width: 390, height: 844 });
    expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
    expect(await accessibilityFaults(page, NO_CONTRAST)).toEqual([]);
    await page.setViewportSize({ width: 1280, height: 800 });
  });

  test('opens a dropped clip, and selects another part of it', async () => {
    await runAgain(page, () => dropFiles(page, pngFiles(movingFrames(12, [96, 64]))));
    await expect(page.locator('#clip-name')).toHaveText('frame0.png and 11 more');
    await expect(status()).toHaveText(/ in 12 frames\.$/);
    await openStage(page, 'frames');
    await runAgain(page, async () => {
      await page.fill('.selection [name=maxFrames]', '8');
      await page.locator('.selection [name=maxFrames]').blur();
    });
    await expect(status()).toHaveText(/ in 8 of 12 frames\.$/);
  });

  test('cancels a run, and starts it again', async () => {
    await page.evaluate(() => {
      const cancel = new MutationObserver(() => {
        if (document.body.dataset.state !== 'running') return;
        cancel.disconnect();
        document.body.dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape', bubbles: true }));
      });
      cancel.observe(document.body, { attributeFilter: ['data-state'] });
    });
    await page.setInputFiles('#file', pngFiles(movingFrames(6, [96, 64])));
    await expect(page.locator('body')).toHaveAttribute('data-state', 'stopped');
    await runAgain(page, () => page.click('#again'));
    await expect(status()).toHaveText(/ in 6 frames\.$/);
  });

  test('says what is wrong with a clip, and offers the sample', async () => {
    const open = async (files) => {
      await page.setInputFiles('#file', files);
      await expect(page.locator('body')).toHaveAttribute('data-state', 'error');
    };
    await open([pngFile('alone.png', plainFrame(60, 40))]);
    await expect(page.locator('#error')).toHaveText(/at least two frames/);
    expect(await accessibilityFaults(page)).toEqual([]);
    await open(pngFiles([60, 64].map((width) => plainFrame(width, 40))));
    await expect(page.locator('#error')).toHaveText(/64x40/);
    await runAgain(page, () => page.click('#error-sample'));
  });

  test('opens the clip of the studio with one click, and links back', async ({ openStudio }) => {
    const studio = await openSample(openStudio, { sample: 'tiny' });
    await openFive(studio, { width: 96, height: 64, frames: 4 });
    await studio.click('#redo-open');
    await studio.click('#lab-open');
    await studio.waitForURL(/\/lab\/#clip$/);
    expect(await runEnd(studio)).toBe('done');
    await expect(studio.locator('#clip-name')).toHaveText('five.webm');
    await expect(studio.locator('#status')).toHaveText(/ in 4 frames\.$/);
    await studio.click('#sample');
    await expect(studio.locator('#clip-name')).toHaveText('Sample');
    expect(await runEnd(studio)).toBe('done');
    await studio.click('nav a');
    await studio.waitForSelector('#lab-open', { state: 'attached' });
    expect(new URL(studio.url()).pathname).toBe('/');
  });
});
