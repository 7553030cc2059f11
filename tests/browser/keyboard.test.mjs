// The main path by keyboard alone, from opening a clip over a stroke of the brush to a saved video; what has the focus is
// always seen.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { accessibilityFaults, ended, openSample, plainFrame, pngFile, screenshot, useSite } from './support.mjs';

const site = useSite();

/** A bright square that moves over a textured ground. */
const frames = Array.from({ length: 9 }, (_, t) =>
  plainFrame(96, 64, (x, y) => {
    const inside = x >= 12 + 2 * t && x < 40 + 2 * t && y >= 16 && y < 48;
    const grain =
      (Math.imul(((inside ? x - 2 * t : x) >> 1) + 7, 374761393) ^ Math.imul((y >> 1) + 3, 668265263)) >>> 24;
    return [grain, grain, inside ? 255 - grain : grain];
  }),
);

/** Goes on with Tab until an element has the focus, and looks whether each on the way is marked as having it. */
async function tabIn(page, selector, key = 'Tab') {
  for (let presses = 0; presses < 60; presses += 1) {
    await page.keyboard.press(key);
    const { there, seen, what } = await page.evaluate((wanted) => {
      const focused = document.activeElement;
      const marked = focused.type === 'radio' ? (focused.closest('.card') ?? focused.nextElementSibling) : focused;
      const { outlineStyle, outlineWidth } = getComputedStyle(marked);
      const body = focused === document.body;
      return {
        there: focused.matches(wanted),
        seen: body || (outlineStyle !== 'none' && outlineWidth !== '0px'),
        what: focused.outerHTML.slice(0, 80),
      };
    }, selector);
    assert.ok(seen, `no mark on ${what}`);
    if (there) return;
  }
  assert.fail(`${selector} is out of reach`);
}

test('a clip is opened, segmented, corrected with the brush and saved as a video by keyboard alone', async () => {
  const { page, faults } = await openSample(site);

  const tabTo = (...way) => tabIn(page, ...way);

  await tabTo('#open');
  const chosen = page.waitForEvent('filechooser');
  // The browser must have heard that somebody waits before the key comes, or its own dialog opens, which no one sees.
  await page.evaluate(() => new Promise(requestAnimationFrame));
  await page.keyboard.press('Enter');
  await (await chosen).setFiles(frames.map((frame, k) => pngFile(`frame${k}.png`, frame)));
  assert.equal(await ended(page), 'done');
  await tabTo('#correct-open', 'Shift+Tab');
  await page.keyboard.press('Enter');
  await page.waitForSelector('body[data-correcting]');
  await tabTo('#correct-object');
  await tabTo('[name="tool"]:checked', 'Shift+Tab');
  while ((await page.evaluate(() => document.activeElement.value)) !== 'paint') await page.keyboard.press('ArrowRight');
  await tabTo('#canvas', 'Shift+Tab');
  for (const key of ['ArrowLeft', 'ArrowUp', ' ', 'ArrowLeft', 'ArrowLeft', ' ']) await page.keyboard.press(key);
  await page.waitForFunction(() => /^Applied to .*\.$/.test(document.querySelector('#correct-status').textContent));
  const countStrokes = () => page.evaluate(() => globalThis.tracecutStudio.app.job.corrections.edits.length);
  assert.equal(await countStrokes(), 1);
  await tabTo('#correct-done');
  await page.keyboard.press('Enter');
  await page.keyboard.press('e');
  await page.waitForSelector('#export[open]');
  await tabTo('[data-export="transparent"]');
  await tabTo('#export-run');
  const [video] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('Enter')]);
  assert.equal(video.suggestedFilename(), 'frame0-cutout.webm');
  assert.equal(await countStrokes(), 1, 'the video has the stroke');
  await page.waitForFunction(() => /^Saved/.test(document.querySelector('#export-status').textContent));
  assert.equal(await page.evaluate(() => document.activeElement.id), 'export-run', 'its place is kept');
  await tabTo('#export-more > summary', 'Shift+Tab');
  await page.keyboard.press('Enter');
  await tabTo('[data-export="coco"]');
  const [download] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('Enter')]);
  assert.match(download.suggestedFilename(), /^frame0-coco\.json$/);
  await page.keyboard.press('Escape');
  assert.equal(await page.locator('#export').isVisible(), false);
  await tabTo('#scrub');
  await page.keyboard.press('ArrowRight');
  assert.equal(await page.inputValue('#scrub'), '1');
  await tabTo('#play', 'Shift+Tab');
  await tabTo('.lane-name');
  await tabTo('.object-main');
  await page.keyboard.press('Enter');
  assert.equal(await page.getAttribute('.object-main', 'aria-pressed'), 'true');
  await tabTo('#look > summary', 'Shift+Tab');
  await page.keyboard.press('Enter');
  await tabTo('[data-layer="masks"]');
  await page.keyboard.press(' ');
  assert.equal(await page.locator('[data-layer="masks"]').isChecked(), false);
  assert.deepEqual(faults, []);
});

test('Fix is opened in view, used on the picture and left by keyboard alone', async () => {
  // The page is one column, which scrolls.
  const { page, faults } = await openSample(site, { bypassCSP: true, viewport: { width: 800, height: 900 } });
  await page.evaluate(() => scrollTo(0, document.body.scrollHeight));
  await page.keyboard.press('m');
  await page.waitForSelector('body[data-correcting]');
  const { top, bottom } = await page.evaluate(() => {
    const box = document.querySelector('#correct-tools').getBoundingClientRect();
    return { top: box.top, bottom: innerHeight - box.bottom };
  });
  assert.ok(top >= 0 && bottom >= 0, `the tools are ${top} px below the top, ${bottom} above the bottom`);

  const tool = () =>
    page.evaluate(() => document.activeElement.closest('#correct-tools') && document.activeElement.value);
  const frame = () => page.evaluate(() => globalThis.tracecutStudio.app.timeline.frame);
  assert.equal(await tool(), 'pick');
  await page.keyboard.press('ArrowRight');
  assert.equal(await tool(), 'paint');
  assert.equal(await frame(), 0, 'the arrow key chose the tool');

  await tabIn(page, '#canvas', 'Shift+Tab');
  assert.deepEqual(await accessibilityFaults(page), []);
  for (const key of ['ArrowLeft', 'ArrowUp', ' ', 'ArrowLeft', 'ArrowLeft', 'Shift+ArrowUp', ' '])
    await page.keyboard.press(key);
  await page.waitForFunction(() => /^Applied to .*\.$/.test(document.querySelector('#correct-status').textContent));
  await screenshot(page, 'crosshair');
  const edits = await page.evaluate(() =>
    globalThis.tracecutStudio.app.job.corrections.edits.map(({ paints: [{ label, parts }] }) => [
      label,
      [...parts.keys()][0],
    ]),
  );
  assert.deepEqual(edits, [[1, 0]], 'one stroke of the object, in the first frame');

  await page.keyboard.press('Escape');
  assert.equal(await page.locator('body[data-correcting]').count(), 0);
  assert.equal(await page.evaluate(() => document.activeElement.id), 'correct-open');
  assert.equal(await page.getAttribute('#canvas', 'tabindex'), null);
  assert.deepEqual(faults, []);
});
