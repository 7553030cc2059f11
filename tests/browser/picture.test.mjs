// The picture has the room, in every state and window; nothing moves it.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { UPRIGHT, WIDE, fiveObjects, pictureBox } from './five.mjs';
import { accessibilityFaults, bytesOf, ended, openFix, openSample, screenshot, text, useSite } from './support.mjs';

/** The least share of the window's height, and of its width where that is the limit. */
const WINDOWS = [
  { width: 1440, height: 900, shape: WIDE, down: 0.69 },
  { width: 1440, height: 900, shape: UPRIGHT, down: 0.7 },
  { width: 1366, height: 768, shape: WIDE, down: 0.7 },
  { width: 1366, height: 768, shape: UPRIGHT, down: 0.6 },
  { width: 390, height: 844, shape: WIDE, across: 0.999 },
  { width: 390, height: 844, shape: UPRIGHT, down: 0.5 },
  { width: 844, height: 390, shape: WIDE, down: 0.65 },
  { width: 844, height: 390, shape: UPRIGHT, down: 0.65 },
];

/** Runs in the page: whether a video has an alpha channel, and the colour of its first frame's lower left corner. */
async function cornerOf(bytes) {
  const media = await import('/dist/vendor/media.js');
  const { videoFrames } = await import('/dist/index.js');
  const blob = new Blob([new Uint8Array(bytes)]);
  const input = new media.Input({ source: new media.BlobSource(blob), formats: media.ALL_FORMATS });
  const packets = new media.EncodedPacketSink(await input.getPrimaryVideoTrack());
  const { sideData } = await packets.getFirstPacket();
  for await (const { pixels } of videoFrames(blob)) {
    const frame = await pixels();
    const at = 4 * ((frame.height - 5) * frame.width + 4);
    return { alpha: Boolean(sideData.alpha), colour: [...frame.data.slice(at, at + 3)] };
  }
  return null;
}

/** Opens the project and waits until it is on screen. */
async function openFive(page, project) {
  await page.setInputFiles('#file', [project]);
  await page.waitForFunction(
    () => globalThis.tracecutStudio.source?.name === 'five.webm' && document.body.dataset.state === 'done',
  );
  assert.equal(await page.locator('.object').count(), 6);
}

describe('the picture', () => {
  const site = useSite({ sample: 'tiny' });

  for (const { width, height, shape, down = 0, across = 0 } of WINDOWS) {
    const name = `${width}x${height}, ${shape === WIDE ? 'wide' : 'upright'}`;
    test(`is the largest thing in every state, ${name}`, async () => {
      const isPhone = Math.min(width, height) < 500;
      const { page, faults } = await openSample(site, {
        viewport: { width, height },
        isMobile: isPhone,
        hasTouch: isPhone,
        bypassCSP: true,
      });
      const { video, project } = await fiveObjects(page, shape);
      const boxes = [];
      const measure = async (state) => {
        await page.evaluate(() => scrollTo(0, 0));
        const box = await page.evaluate(pictureBox);
        const told = `${state}: ${JSON.stringify(box)}`;
        assert.ok(box.down >= down && box.across >= across, told);
        assert.ok(box.top >= 0 && box.top + box.height <= height, `all of it is in view, ${told}`);
        await screenshot(page, `${name}, ${state}`, { whole: false });
        boxes.push([box.width, box.height, box.left, box.top].map(Math.round).join());
      };
      await page.setInputFiles('#file', [video]);
      await page.waitForFunction((aspect) => {
        const { clientWidth, clientHeight } = document.querySelector('#canvas');
        return document.body.dataset.phase === 'running' && Math.abs(clientWidth / clientHeight - aspect) < 0.05;
      }, shape.width / shape.height);
      await measure('running');
      await openFive(page, project);
      await measure('done');
      await openFix(page);
      await measure('fix');
      for (const tool of ['paint', 'add', 'apart', 'pick']) {
        await page.check(`#correct-tools [value="${tool}"]`, { force: true });
        await measure(tool);
      }
      await page.click('#correct-done');
      await page.check('[name="view"][value="cutout"]', { force: true });
      await measure('cut-out');
      await page.check('[name="view"][value="overlay"]', { force: true });
      await page.click('#export-open');
      await page.waitForSelector('#export[open]');
      await page.waitForSelector('#export-preview > *');
      await measure('save');
      await page.click('#export-close');
      assert.equal(new Set(boxes).size, 1, `it stays where it is: ${boxes.join(' ')}`);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(wide <= 0, `the page is ${wide} px too wide`);
      await page.locator('[data-lane="5"]').scrollIntoViewIfNeeded();
      assert.deepEqual(await accessibilityFaults(page), []);
      assert.deepEqual(faults, []);
    });
  }

  test('stays where it is while a stroke is painted and carried', async () => {
    const { page } = await openSample(site, { viewport: { width: 1366, height: 768 } });
    await openFive(page, (await fiveObjects(page, WIDE)).project);
    await openFix(page);
    await page.check('#correct-tools [value="paint"]', { force: true });
    await page.selectOption('#correct-object', '1');
    await page.evaluate(() => {
      globalThis.shifts = [];
      const watch = new PerformanceObserver((list) => {
        for (const { value, sources } of list.getEntries())
          globalThis.shifts.push(
            `${value}: ${sources.map(({ node }) => node?.id || node?.className || node?.nodeName)}`,
          );
      });
      watch.observe({ type: 'layout-shift' });
      globalThis.places = new Set();
      const look = () => {
        const { top, left, width } = document.querySelector('#canvas').getBoundingClientRect();
        globalThis.places.add([top, left, width].join());
        requestAnimationFrame(look);
      };
      look();
    });
    const box = await page.locator('#canvas').boundingBox();
    await page.mouse.move(box.x + 200, box.y + 200);
    await page.mouse.down();
    await page.mouse.move(box.x + 320, box.y + 260, { steps: 6 });
    await page.mouse.up();
    await page.waitForFunction(() => /^In .*[.]$/.test(document.querySelector('#correct-status').textContent));
    await page.waitForTimeout(200);
    assert.deepEqual(await page.evaluate(() => globalThis.shifts), []);
    assert.equal(await page.evaluate(() => globalThis.places.size), 1);
  });
});

describe('an upright clip', () => {
  const site = useSite({ sample: 'tiny' });

  test('has a filmstrip that shows it', async () => {
    const { page, faults } = await openSample(site);
    // The long side of its pictures is no whole number unless it is rounded.
    const { project } = await fiveObjects(page, { width: 270, height: 480, frames: 8 });
    await openFive(page, project);
    await page.waitForFunction(() => document.querySelector('#trim-strip').dataset.ready === 'five.webm');
    const bright = await page.evaluate(() =>
      [...document.querySelectorAll('#trim-strip canvas')].map((canvas) => {
        const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
        return data.reduce((sum, value, k) => sum + (k % 4 === 1 ? value : 0), 0) / (data.length / 4);
      }),
    );
    assert.equal(bright.length, 8);
    assert.ok(
      bright.every((green) => green > 50),
      bright.join(),
    );
    assert.deepEqual(faults, []);
  });
});

describe('corrections', () => {
  const site = useSite({ sample: 'tiny' });
  const count = (page) => page.locator('.object').count();

  async function corrected(options) {
    const { page, faults } = await openSample(site, options);
    await openFive(page, (await fiveObjects(page, WIDE)).project);
    await openFix(page);
    await page.selectOption('#correct-object', '2');
    await page.click('#correct-background');
    await page.waitForFunction(() => /^Corrected/.test(document.querySelector('#correct-status').textContent));
    assert.equal(await count(page), 5);
    return { page, faults };
  }

  test('are not lost by a key; another run asks, and is a step of undo', async () => {
    const { page, faults } = await corrected({ bypassCSP: true });
    const masks = () => page.evaluate(() => String(globalThis.tracecutStudio.app.points.mask(3)));
    const before = await masks();
    await page.click('#correct-done');
    await page.keyboard.press('r');
    assert.equal(await page.evaluate(() => document.body.dataset.phase), 'done');
    await page.click('#again');
    await page.waitForSelector('#ask[open]');
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'ask');
    await page.keyboard.press('Escape');
    assert.equal(await masks(), before, 'whoever says no keeps them');
    for (const undo of [() => page.click('#restore'), () => page.keyboard.press('Control+z')]) {
      await page.click('#again');
      await page.click('#ask-yes');
      await page.waitForSelector('#restore', { state: 'visible' });
      assert.equal(await ended(page), 'done');
      await undo();
      await page.waitForFunction(() => document.querySelector('#restore').hidden);
      assert.equal(await ended(page), 'done');
      assert.equal(await masks(), before);
    }
    await page.click('#again');
    await page.click('#ask-yes');
    await page.waitForSelector('#restore', { state: 'visible' });
    assert.equal(await ended(page), 'done');
    await openFix(page);
    await page.click('#correct-undo');
    await page.waitForFunction(() => document.querySelector('#restore').hidden);
    assert.equal(await ended(page), 'done');
    assert.equal(await masks(), before, 'undo in “Fix” is the same');
    await openFix(page);
    await page.click('#correct-undo');
    await page.waitForFunction(() => document.querySelectorAll('.object').length === 6);
    assert.deepEqual(faults, []);
  });

  test('are told as what they are; an object is merged with another one first', async () => {
    const { page } = await corrected();
    const into = () =>
      page.evaluate(() => [...document.querySelector('#correct-into').options].map(({ value }) => value));
    assert.ok(!(await into()).includes('0'), 'the background has a button of its own');
    assert.notEqual(await page.inputValue('#correct-into'), '0');
    await page.click('#correct-undo');
    await page.waitForFunction(() => document.querySelectorAll('.object').length === 6);
    assert.match(await text(page, '#correct-status'), /^Undone\. 5 moving objects/);
    await page.click('#correct-redo');
    await page.waitForFunction(() => document.querySelectorAll('.object').length === 5);
    assert.match(await text(page, '#correct-status'), /^Done again\. 4 moving objects/);
  });
});

describe('words', () => {
  const site = useSite({ sample: 'tiny' });

  test('say plainly what happens; numbers stand in the help; one button is the next step', async () => {
    const { page } = await openSample(site);
    const primary = () =>
      page.evaluate(() =>
        [...document.querySelectorAll('.primary')].filter((one) => one.checkVisibility()).map(({ id }) => id),
      );
    assert.deepEqual(await primary(), ['open'], 'drop');
    assert.equal(await page.locator('#subline').isVisible(), false);
    assert.equal(await page.locator('#facts').isVisible(), false);
    await page.click('#help-open');
    await page.waitForSelector('#help[open]');
    assert.match(await text(page, '#facts'), /trajector/);
    await page.click('#help-close');
    await page.evaluate(() => {
      globalThis.heads = new Set();
      const head = document.querySelector('#headline');
      new MutationObserver(() => globalThis.heads.add(head.textContent)).observe(head, { childList: true });
    });
    await page.click('#again');
    await page.waitForSelector('#cancel', { state: 'visible' });
    await ended(page);
    const heads = await page.evaluate(() => [...globalThis.heads]);
    assert.ok(heads.includes('Finding what moves together'), heads.join(' | '));
    for (const head of heads)
      assert.doesNotMatch(head, /window|flow|trajector|affinit|embedding|discontin|saliency|superpixel|cut/i);
    await openFive(page, (await fiveObjects(page, WIDE)).project);
    assert.deepEqual(await primary(), ['export-open'], 'check');
    await openFix(page);
    assert.deepEqual(await primary(), ['correct-done'], 'fix');
    await page.click('#correct-done');
    await page.click('#export-open');
    await page.waitForSelector('#export[open]');
    assert.equal(await page.locator('#export .primary:visible').count(), 1, 'save');
  });

  test('saving has four large choices; all others are behind “More”', async () => {
    const { page, faults } = await openSample(site, { bypassCSP: true });
    await openFive(page, (await fiveObjects(page, WIDE)).project);
    await page.click('#export-open');
    await page.waitForSelector('#export[open]');
    const seen = () => page.locator('[data-export]:visible').evaluateAll((all) => all.map((one) => one.dataset.export));
    assert.deepEqual(await seen(), ['transparent', 'green', 'blurred', 'zip']);
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'save');
    const corner = {};
    for (const id of ['transparent', 'green', 'blurred']) {
      const coming = page.waitForEvent('download');
      await page.click(`[data-export="${id}"]`);
      const file = await coming;
      assert.equal(file.suggestedFilename(), `five-cutout.${id === 'transparent' ? 'webm' : 'mp4'}`);
      corner[id] = await page.evaluate(cornerOf, [...(await bytesOf(file))]);
      await page.waitForFunction(() => /^Saved/.test(document.querySelector('#export-status').textContent));
    }
    assert.deepEqual(
      [corner.transparent.alpha, corner.green.alpha, corner.blurred.alpha],
      [true, false, false],
      'what is transparent',
    );
    const [red, green, blue] = corner.green.colour;
    assert.ok(red < 60 && green > 140 && blue < 110, `green is ${corner.green.colour}`);
    assert.ok(corner.blurred.colour[0] > 60, `blurred is ${corner.blurred.colour}`);
    await page.click('#export-more > summary');
    assert.ok((await seen()).length > 12);
    assert.deepEqual(faults, []);
  });
});
