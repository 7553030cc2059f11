// Why a pixel has its label, on the page: asked with the mouse and by keys, in words, numbers and in the picture.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { accessibilityFaults, openSample, screenshot, text, useSite } from './support.mjs';

const FRAME = 12;

describe('a pixel is explained', () => {
  const site = useSite();
  let page;
  let faults;

  /** Clicks well inside of an object, and gives the pixel of the clip that is told of. */
  async function click(label) {
    const position = await page.evaluate((wanted) => {
      const { points, viewer, timeline } = globalThis.tracecutDemo.app;
      const { width, unit } = viewer.view;
      const mask = points.mask(timeline.frame);
      const near = [0, 6, 12].flatMap((dx) => [0, 6, 12].map((dy) => dx + dy * width));
      const inside = mask.findIndex((_, p) => near.every((d) => mask[p + d] === wanted));
      return { x: ((inside % width) + 6) / unit, y: (Math.floor(inside / width) + 6) / unit };
    }, label);
    await clear();
    await page.locator('#canvas').click({ position });
    return [...(await told()), position];
  }
  const clear = () => page.evaluate(() => (document.querySelector('.why-title').textContent = ''));
  /** The pixel that the panel speaks of. */
  async function told(expected = '') {
    await page.waitForFunction((part) => {
      const { textContent } = document.querySelector('.why-title');
      return textContent !== '' && textContent.includes(part);
    }, expected);
    const [, x, y] = (await text(page, '.why-title')).match(/ at (\d+), (\d+) in frame 13$/);
    return [Number(x), Number(y)];
  }

  test('by a click: its label, what each would cost, who votes, what would change it', async () => {
    ({ page, faults } = await openSample(site, { bypassCSP: true }));
    page.setDefaultTimeout(60_000);
    await page.evaluate((frame) => globalThis.tracecutDemo.app.timeline.seek(frame), FRAME);
    assert.equal(await page.locator('#why').count(), 0, 'fetched when it is opened');
    const before = await page.evaluate(() => document.querySelector('#canvas').toDataURL());
    await page.click('#why-open');
    await page.waitForSelector('#why tbody tr');
    const [x, y] = await click(1);
    assert.match(await text(page, '.why-title'), /^Object 1 at /);
    const { costs, flip, voters } = await page.evaluate(
      (at) => globalThis.tracecutDemo.result.explain(...at),
      [FRAME, x, y],
    );
    const sums = await page.locator('#why .why-sum td').allTextContents();
    assert.deepEqual(
      sums,
      costs.map(({ total }) => total.toFixed(2)),
    );
    const words = await text(page, '.why-words ul');
    assert.ok(words.includes(`${flip.margin.toFixed(2)} more`), words);
    assert.ok(voters.length === 0 || words.includes(`vote here: ${voters.length},`), words);
    assert.notEqual(await page.evaluate(() => document.querySelector('#canvas').toDataURL()), before);
    assert.equal(await page.locator('.object.is-hidden').count(), 0, 'such a click chooses no object');
    const p = await page.evaluate(
      async ([t, px, py]) => {
        const { confidence, width } = await globalThis.tracecutDemo.result.confidence(t);
        return confidence[py * width + px];
      },
      [FRAME, x, y],
    );
    await page.waitForFunction(() => document.querySelector('.why-sure').textContent);
    assert.equal(await text(page, '.why-sure'), `This label is right with ${Math.round(100 * p)}\u00a0%.`);
    const unmarked = await page.evaluate(() => document.querySelector('#canvas').toDataURL());
    await page.check('#why-sure');
    await page.waitForFunction((old) => document.querySelector('#canvas').toDataURL() !== old, unmarked);
    await screenshot(page, 'why');
    assert.deepEqual(await accessibilityFaults(page), []);
  });

  test('by a cursor that arrow keys move, and not beyond the picture', async () => {
    const [x, y] = await click(1);
    await page.focus('#canvas');
    for (const key of ['ArrowRight', 'ArrowDown', 'Shift+ArrowRight']) await page.keyboard.press(key);
    await told(` ${x + 11}, ${y + 1} `);
    assert.equal(await page.evaluate(() => globalThis.tracecutDemo.app.timeline.frame), FRAME, 'the clip stays');
    for (let k = 0; k < 60; k += 1) await page.keyboard.press('Shift+ArrowUp');
    await told(` ${x + 11}, 0 `);
  });

  test('again after a correction, and no more once it is closed', async () => {
    const [, , position] = await click(1);
    await page.evaluate(() => document.querySelector('#correct-open').click());
    await page.waitForFunction(() => document.querySelector('#why').hidden);
    await page.selectOption('#correct-object', '1');
    await page.click('#correct-background');
    await page.waitForFunction(() => /^Corrected/.test(document.querySelector('#correct-status').textContent));
    await page.click('#why-open');
    await page.waitForFunction(() => !document.body.hasAttribute('data-correcting'));
    await page.waitForFunction(() => document.querySelector('.why-title').textContent);
    await clear();
    await page.locator('#canvas').click({ position });
    await told();
    assert.match(await text(page, '.why-title'), /^Background at /);
    await page.click('#why button');
    assert.equal(await page.locator('#why').isVisible(), false);
    assert.equal(await page.getAttribute('#why-open', 'aria-pressed'), 'false');
    assert.equal(await page.getAttribute('#canvas', 'tabindex'), null);
    assert.deepEqual(faults, []);
  });
});
