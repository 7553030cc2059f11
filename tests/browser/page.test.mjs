// The page itself: keys, narrow windows, colour schemes, names for screen readers, a policy that holds.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { inPhase, openSample, run, screenshot, showOnly, SMALL, text, useSample, useSite } from './support.mjs';

describe('the page', () => {
  const site = useSite();
  const sample = useSample(site);

  test('is driven by keys', async () => {
    const { page } = sample;
    const counter = () => text(page, '#counter');
    assert.equal(await counter(), `1 / ${SMALL.frames}`);
    await page.keyboard.press('ArrowRight');
    assert.equal(await counter(), `2 / ${SMALL.frames}`);
    await page.keyboard.press('End');
    assert.equal(await counter(), `${SMALL.frames} / ${SMALL.frames}`);
    await page.keyboard.press('ArrowRight');
    assert.equal(await counter(), `1 / ${SMALL.frames}`, 'looping');
    await page.keyboard.press('ArrowLeft');
    await page.keyboard.press('Home');
    assert.equal(await counter(), `1 / ${SMALL.frames}`);
    await page.keyboard.press(' ');
    await page.waitForFunction(() => globalThis.tracecutStudio.app.timeline.frame > 2);
    await page.keyboard.press(' ');
    assert.equal(await page.getAttribute('#play', 'aria-label'), 'Play');
    await page.keyboard.press('1');
    assert.equal(await page.locator('[data-layer="masks"]').isChecked(), false);
    await page.keyboard.press('1');
    assert.equal(await page.locator('[data-layer="masks"]').isChecked(), true);
  });

  test('leaves the space bar to a button that was reached by keyboard, and to no other', async () => {
    const { page } = sample;
    const playing = () => page.evaluate(() => globalThis.tracecutStudio.app.timeline.playing);
    await page.click('[data-object="1"] .keep');
    await page.keyboard.press('1');
    await page.keyboard.press('1');
    await page.keyboard.press(' ');
    assert.equal(await playing(), true, 'after a click the space bar plays');
    assert.equal(await page.locator('#show-all').isVisible(), true, 'and the object stays hidden');
    await page.keyboard.press(' ');
    await page.focus('[data-object="1"] .object-main');
    await page.keyboard.press('Tab');
    await page.keyboard.press(' ');
    assert.equal(await playing(), false);
    assert.equal(await page.locator('#show-all').isVisible(), false, 'the button under the focus was pressed');
  });

  for (const colorScheme of ['light', 'dark']) {
    test(`fits a phone, ${colorScheme}`, async () => {
      const phone = { viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true, colorScheme };
      const { page, faults } = await openSample(site, phone);
      const overflow = () =>
        page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert.equal(await overflow(), 0, 'with a result');
      await page.evaluate(() => globalThis.tracecutStudio.app.timeline.seek(12));
      await screenshot(page, `phone-${colorScheme}`);
      await showOnly(page);
      assert.equal(await overflow(), 0, 'with all layers');
      await run(page, [{ name: `${'long-name'.repeat(12)}.mp4`, mimeType: 'video/mp4', buffer: Buffer.from('x') }]);
      assert.equal(await overflow(), 0, 'with an error');
      await screenshot(page, `phone-error-${colorScheme}`);
      assert.deepEqual(
        faults.filter((fault) => !fault.includes('blob:')),
        [],
      );
    });
  }

  test('looks at home in the dark', async () => {
    const { page } = await openSample(site, { colorScheme: 'dark' });
    const [ground, ink] = await page.evaluate(() => {
      const { backgroundColor } = getComputedStyle(document.documentElement);
      return [backgroundColor, getComputedStyle(document.body).color].map((c) => Number(c.match(/\d+/)[0]));
    });
    assert.ok(ground < 60 && ink > 190, `ground ${ground}, ink ${ink}`);
    await page.evaluate(() => globalThis.tracecutStudio.app.timeline.seek(12));
    await screenshot(page, 'sample-dark');
  });

  test('gives every control a name', async () => {
    const { page } = sample;
    const nameless = await page.evaluate(() => {
      const controls = [...document.querySelectorAll('button, input, select, canvas[role], [role="progressbar"]')];
      const named = (e) => e.getAttribute('aria-label') || e.labels?.length || e.textContent.trim() || e.hidden;
      return controls.filter((e) => !named(e)).map((e) => e.outerHTML);
    });
    assert.deepEqual(nameless, []);
    assert.match(await page.getAttribute('#canvas', 'aria-label'), /moving object/);
    assert.equal(await page.getAttribute('#canvas', 'aria-describedby'), 'frame-text');
    assert.match(await page.textContent('#frame-text'), /^Frame \d+ of 16, .*: .*Object 1 \(orange\)/);
    assert.match(await page.locator('#live').textContent(), /moving object/);
  });

  test('tells the stages while it runs', async () => {
    const { page } = sample;
    await page.evaluate(() => {
      globalThis.heard = [];
      new MutationObserver(() => globalThis.heard.push(document.querySelector('#live').textContent)).observe(
        document.querySelector('#live'),
        { childList: true, characterData: true, subtree: true },
      );
    });
    await page.click('#again');
    await inPhase(page, 'done');
    const heard = await page.evaluate(() => globalThis.heard.join('\n'));
    assert.match(heard, /Reading frames/);
    assert.match(heard, /Following what moves/);
  });

  test('runs no foreign script and talks to no other place', async () => {
    const { page } = sample;
    const { injected, answer, directives } = await page.evaluate(async () => {
      const violations = [];
      document.addEventListener('securitypolicyviolation', (event) => violations.push(event.effectiveDirective));
      const script = document.createElement('script');
      script.textContent = 'globalThis.injected = true';
      document.body.append(script);
      const fetched = await fetch('http://127.0.0.1:9/').then(
        () => 'answered',
        () => 'refused',
      );
      await new Promise((resolve) => setTimeout(resolve, 300)); // Violations are reported later.
      return { injected: Boolean(globalThis.injected), answer: fetched, directives: violations };
    });
    assert.equal(injected, false);
    assert.equal(answer, 'refused');
    assert.deepEqual(directives.map((name) => name.slice(0, 11)).sort(), ['connect-src', 'script-src-']);
  });
});
