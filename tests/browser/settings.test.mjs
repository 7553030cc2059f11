// Settings, views and words of the page.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { ended, inPhase, picture, plainFrame, pngFile, run, SMALL, text, useSample, useSite } from './support.mjs';

describe('settings', () => {
  const sample = useSample(useSite());

  test('are marked, applied by “Run again”, and reset', async () => {
    const { page, faults } = sample;
    const row = '#settings-few [data-parameter="trajectory.gridStep"]';
    const count = () => page.evaluate(() => globalThis.tracecutStudio.result.trajectories.count);
    const before = await count();
    assert.equal(await page.locator('#pending').isVisible(), false);
    await page.locator(`${row} input`).fill('12');
    assert.equal(await page.locator('#pending').isVisible(), true);
    assert.match(await page.getAttribute(row, 'class'), /is-changed/);
    await page.click('#pending-run');
    assert.equal(await ended(page), 'done');
    assert.equal(await page.locator('#pending').isVisible(), false);
    const fewer = await count();
    assert.ok(fewer < 0.7 * before, `${fewer} trajectories at 12 px, ${before} at 8`);
    await page.click(`${row} .reset`);
    assert.equal(await page.locator('#pending').isVisible(), true, 'the result was made with another value');
    await page.click('#again');
    assert.equal(await ended(page), 'done');
    assert.equal(await count(), before);
    assert.equal(await page.locator('#settings-reset').isVisible(), false);
    assert.deepEqual(faults, []);
  });

  test('of still images count for still images', async () => {
    const { page } = sample;
    // Cells of a few pixels, some of which are hardly different from the next one.
    const cells = plainFrame(80, 60, (x, y) => {
      const value = 40 + (((x >> 3) * 37 + (y >> 3) * 71) % 64);
      return [value, value, 255 - value];
    });
    assert.equal(await run(page, [pngFile('cells.png', cells)]), 'done');
    assert.equal(await page.locator('[data-parameter="trajectory.gridStep"]:visible').count(), 0);
    const before = await page.evaluate(() => globalThis.tracecutStudio.app.job.found.superpixels.count);
    await page.locator('#settings-few [data-parameter="superpixel.joinBelow"] input').fill('5');
    await page.click('#again');
    assert.equal(await ended(page), 'done');
    const after = await page.evaluate(() => globalThis.tracecutStudio.app.job.found.superpixels.count);
    assert.notEqual(after, before);
    await page.click('#settings-reset');
    await page.click('#sample');
    assert.equal(await ended(page), 'done');
  });
});

describe('views and words', () => {
  const sample = useSample(useSite());

  test('the original stands beside the result, or under a slider that the keyboard moves', async () => {
    const { page } = sample;
    const boxes = () =>
      page.evaluate(() =>
        ['original', 'canvas'].map((id) => document.getElementById(id).getBoundingClientRect().toJSON()),
      );
    await page.keyboard.press('v');
    await page.waitForFunction(() => document.querySelector('#screen').dataset.view === 'beside');
    const [left, right] = await boxes();
    assert.ok(
      left.right <= right.left && Math.abs(left.width - right.width) < 1 && left.width > 200,
      JSON.stringify([left, right]),
    );
    const differ = await page.evaluate(() => {
      const [a, b] = ['original', 'canvas'].map((id) => document.getElementById(id).toDataURL());
      return a.length > 10000 && a !== b;
    });
    assert.ok(differ);
    await page.keyboard.press('v');
    const [under, over] = await boxes();
    assert.deepEqual(under, over);
    await page.focus('#split');
    await page.keyboard.press('Home');
    const clip = await page.evaluate(() => getComputedStyle(document.querySelector('#original')).clipPath);
    assert.match(clip, /^inset\(0px 100% 0px 0px\)$|^inset\(0px calc\(100%\) 0px 0px\)$/);
    await page.check('[name="view"][value="overlay"]', { force: true });
    assert.equal(await page.locator('#original').isVisible(), false);
  });

  test('each object has a lane, and a click in it seeks', async () => {
    const { page } = sample;
    const lanes = await page.locator('.lane').count();
    assert.equal(lanes, await page.evaluate(() => globalThis.tracecutStudio.result.objects.length));
    const box = await page.locator('[data-lane="1"] .lane-canvas').boundingBox();
    await page.mouse.click(box.x + (box.width * 12.5) / SMALL.frames, box.y + box.height / 2);
    assert.equal(await text(page, '#counter'), `13 / ${SMALL.frames}`);
    await page.click('[data-lane="1"] .lane-name');
    const peak = await page.evaluate(() => globalThis.tracecutStudio.app.points.presence.facts(1).peak);
    assert.equal(await text(page, '#counter'), `${peak + 1} / ${SMALL.frames}`);
  });

  test('a question mark lists the keys; while the list is open they do nothing else', async () => {
    const { page } = sample;
    const before = await picture(page);
    await page.keyboard.press('?');
    await page.waitForSelector('#help[open]');
    await page.keyboard.press('1');
    await page.keyboard.press('Escape');
    assert.equal(await page.locator('#help').isVisible(), false);
    assert.equal(await picture(page), before);
    assert.equal(await page.evaluate(() => document.body.dataset.phase), 'done');
  });

  test('while it runs, the time left is told', async () => {
    const { page } = sample;
    await page.evaluate(() => {
      globalThis.seen = new Set();
      const line = document.querySelector('#subline');
      new MutationObserver(() => globalThis.seen.add(line.textContent)).observe(line, { childList: true });
    });
    await page.click('#again');
    await inPhase(page, 'done');
    const seen = await page.evaluate(() => [...globalThis.seen].join('\n'));
    assert.match(seen, /so far · (about \d+\ss left|almost done)/);
  });
});
