// Settings, views and words of the page; how much longer a run takes.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { parameters } from '../../dist/node.js';
import {
  ended,
  inPhase,
  openSample,
  picture,
  plainFrame,
  pngFile,
  run,
  SMALL,
  text,
  useSample,
  useSite,
} from './support.mjs';

const { Countdown, StageClock, timeLeft } = await import('../../studio/model/stage-clock.js');
const { ESSENTIALS } = await import('../../studio/model/settings.js');

describe('settings', () => {
  const site = useSite();
  const sample = useSample(site);

  test('name only parameters that there are', () => {
    const names = parameters().map(({ name }) => name);
    assert.deepEqual(
      ESSENTIALS.map(({ name }) => name).filter((name) => !names.includes(name)),
      [],
    );
  });

  test('are marked, applied by “Run again”, and reset', async () => {
    const { page, faults } = sample;
    const row = '#settings-few [data-parameter="trajectory.gridStep"]';
    const count = () => page.evaluate(() => globalThis.tracecutDemo.result.trajectories.count);
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

  test('of a link are told where the page has no slider for them; masks cannot be left out', async () => {
    const { page } = await openSample(site, { query: '#flow.smoothness=40&cut.spatialWeight=2&clip.dense=false' });
    assert.equal(await text(page, '#settings-others'), 'Also changed: flow.smoothness = 40.');
    assert.deepEqual(await page.evaluate(() => globalThis.tracecutDemo.app.job.options), {
      cut: { spatialWeight: 2 },
      flow: { smoothness: 40 },
    });
    await page.click('#settings-reset');
    assert.equal(await page.locator('#settings-others').isVisible(), false);
    assert.equal(await page.locator('#pending').isVisible(), true);
    await page.context().close();
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
    const before = await page.evaluate(() => globalThis.tracecutDemo.app.job.found.superpixels.count);
    await page.locator('#settings-few [data-parameter="superpixel.joinBelow"] input').fill('5');
    await page.click('#again');
    assert.equal(await ended(page), 'done');
    const after = await page.evaluate(() => globalThis.tracecutDemo.app.job.found.superpixels.count);
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

  test('the clip, each object and the frame on screen are described', async () => {
    const { page } = sample;
    assert.match(
      await text(page, '#summary'),
      /^Object \d \((orange|light blue|pink)\) (at|on|in) the [a-z ]+ (moves|stays|grows|shrinks)/,
    );
    for (const facts of await page.locator('.object:not(:first-child) .object-facts').allInnerTexts()) {
      assert.match(facts, /^[a-z ]+, (moves|stays|grows|shrinks)/);
    }
    for (const span of await page.locator('.lane-name').allInnerTexts()) assert.match(span, /^\d\.\d–\d\.\d\ss$/);
    await page.evaluate(() => globalThis.tracecutDemo.app.timeline.seek(11));
    await page.waitForFunction(
      (frames) =>
        new RegExp(`^Frame 12 of ${frames}, 0\\.7\\ss: Object 1 \\(orange\\)`).test(
          document.querySelector('#frame-text').textContent,
        ),
      SMALL.frames,
    );
    assert.equal(await page.getAttribute('#canvas', 'aria-describedby'), 'frame-text');
  });

  test('each object has a lane, and a click in it seeks', async () => {
    const { page } = sample;
    const lanes = await page.locator('.lane').count();
    assert.equal(lanes, await page.evaluate(() => globalThis.tracecutDemo.result.objects.length));
    const box = await page.locator('[data-lane="1"] .lane-canvas').boundingBox();
    await page.mouse.click(box.x + (box.width * 12.5) / SMALL.frames, box.y + box.height / 2);
    assert.equal(await text(page, '#counter'), `13 / ${SMALL.frames}`);
    await page.click('[data-lane="1"] .lane-name');
    const peak = await page.evaluate(() => globalThis.tracecutDemo.app.points.presence.facts(1).peak);
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

describe('the estimate of the time left', () => {
  const plan = [
    { id: 'a', name: 'A', share: 0.5 },
    { id: 'b', name: 'B', share: 0.25 },
    { id: 'c', name: 'C', share: 0.25 },
  ];
  const clock = (/** @type {object[]} */ ...states) => {
    const made = new StageClock(plan);
    states.forEach((state, k) => Object.assign(made.stages[k], state));
    return made;
  };

  test('says nothing before anything is through', () => {
    assert.equal(timeLeft(clock(), 0), null);
    assert.equal(timeLeft(clock({ done: 1, total: 100, ms: 50 }), 0), null);
  });

  test('takes a stage by its own pace, later ones by their shares', () => {
    const guess = timeLeft(clock({ done: 10, total: 20, ms: 1000 }), 0);
    assert.equal(guess, 1000 + 1000 + 1000);
    assert.equal(
      timeLeft(clock({ done: 20, total: 20, ms: 2000 }, { done: 1, total: 1, ms: 500 }), 0),
      (2500 / 0.75) * 0.25,
    );
  });

  test('is over when all is through', () => {
    const all = clock(...plan.map(() => ({ done: 1, total: 1, ms: 10 })));
    assert.equal(timeLeft(all, 0), 0);
  });

  test('what is shown goes down with the clock and follows new guesses slowly', () => {
    const shown = new Countdown();
    assert.equal(shown.follow(10_000, 0), 10_000);
    assert.equal(shown.follow(9_900, 100), 9_900);
    const jumped = shown.follow(20_000, 200);
    assert.ok(jumped > 9_800 && jumped < 11_000, jumped);
    assert.equal(shown.follow(null, 300), null);
  });
});
