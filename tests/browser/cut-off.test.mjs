// A run that a reload or a killed tab cut off is offered again; one that ended or was cancelled is not.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { accessibilityFaults, ended, inPhase, movingClip, screenshot, text, useSite } from './support.mjs';

describe('a run that was cut off', () => {
  const site = useSite({ sample: 'tiny' });
  const clip = movingClip(170, [160, 120]);
  /** The runs that are remembered. */
  const runs = (page) =>
    page.evaluate(async () => {
      const { stored } = await import('/view/storage.js');
      return (await stored()).filter(({ id }) => id.startsWith('run-')).map(({ about }) => about.take.step);
    });
  /** Until those are remembered, by the steps that they take. */
  async function remembered(page, steps) {
    for (let tries = 0; tries < 300; tries += 1) {
      if (String(await runs(page)) === String(steps)) return;
      await page.waitForTimeout(100);
    }
    assert.fail(`remembered are ${await runs(page)}`);
  }

  async function begun(page) {
    assert.equal(await ended(page), 'done');
    await page.setInputFiles('#file', clip);
    await inPhase(page, 'running');
    await remembered(page, [1]);
  }

  /** Another page of the same browser, as after a killed tab. */
  async function anew(page) {
    const [context, address] = [page.context(), page.url()];
    await page.close({ runBeforeUnload: false });
    const again = await context.newPage();
    again.setDefaultTimeout(180_000);
    await again.goto(address);
    return again;
  }

  test('is offered with its settings; when it has ended it is forgotten', async () => {
    const { page, faults } = await site.open({ bypassCSP: true });
    await begun(page);
    await page.selectOption('#take-step', '3');
    // The run begins anew with that, and is remembered so.
    await remembered(page, [3]);
    const again = await anew(page);
    await again.waitForSelector('#saved', { state: 'visible' });
    assert.equal(await text(again, '#saved-open'), 'Run again: frame000.png … frame169.png');
    assert.equal(await text(again, '#saved-text'), 'The run of frame000.png … frame169.png was cut off.');
    await ended(again);
    await screenshot(again, 'cut-off');
    assert.deepEqual(await accessibilityFaults(again), []);
    await again.click('#saved-open');
    await again.waitForFunction(() => globalThis.tracecutStudio.take?.step === 3);
    await again.waitForFunction(() => globalThis.tracecutStudio.app.points?.result.numFrames === 57);
    assert.equal(await ended(again), 'done');
    await remembered(again, []);
    await again.waitForFunction(() => document.body.dataset.kept && !('unkept' in document.body.dataset));

    const third = await anew(again);
    await third.waitForSelector('#saved', { state: 'visible' });
    assert.match(await text(third, '#saved-text'), /^Your work on .* was kept\.$/);
    assert.deepEqual(faults, []);
    await third.context().close();
  });

  test('is not offered while it goes on in another tab', async () => {
    const { page } = await site.open();
    await begun(page);
    const other = await page.context().newPage();
    await other.goto(page.url());
    await ended(other);
    await other.waitForTimeout(2500);
    assert.equal(await page.evaluate(() => document.body.dataset.phase), 'running');
    assert.equal(await other.locator('#saved').isVisible(), false);
    await page.context().close();
  });
});
