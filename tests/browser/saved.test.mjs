// Work is not lost: kept by itself, offered after a reload or a killed tab, saved and opened as a project file; a run that
// was cut off is offered again, one that ended or was cancelled is not.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import {
  accessibilityFaults,
  bytesOf,
  ended,
  inPhase,
  movingClip,
  openFix,
  openLook,
  openSave,
  plainFrame,
  pngFile,
  redo,
  screenshot,
  setControl,
  text,
  useSite,
} from './support.mjs';

/** A textured square that moves over a textured ground. */
function clip(count, width, height) {
  const noise = (x, y, salt) => {
    const h = Math.imul((x >> 1) + 7, 374761393) ^ Math.imul((y >> 1) + 3, 668265263) ^ Math.imul(salt, 2246822519);
    const mixed = Math.imul(h ^ (h >>> 13), 1274126177);
    return 60 + (((mixed ^ (mixed >>> 16)) >>> 0) % 160);
  };
  return Array.from({ length: count }, (_, t) => {
    const inside = (x, y) => x >= 10 + 2 * t && x < 38 + 2 * t && y >= 16 && y < 48;
    const frame = plainFrame(width, height, (x, y) => {
      const value = inside(x, y) ? noise(x - 2 * t, y, 2) : noise(x, y, 1);
      return [value, value, inside(x, y) ? 255 - value : value];
    });
    return pngFile(`frame${String(t).padStart(3, '0')}.png`, frame);
  });
}

describe('work', () => {
  const site = useSite({ sample: 'tiny' });

  const masks = (page) =>
    page.evaluate(() => {
      const { segmentation } = globalThis.tracecutStudio.app;
      return Array.from({ length: segmentation.result.numFrames }, (_, t) => segmentation.mask(t).join('')).join('|');
    });
  /** Until all is kept, and something was since `then`. */
  const keptAfter = (page, then) =>
    page.waitForFunction(
      (before) => Number(document.body.dataset.saved ?? 0) > before && !('unsaved' in document.body.dataset),
      then,
    );

  async function opened(page) {
    assert.equal(await ended(page), 'done');
    await page.setInputFiles('#file', clip(12, 96, 64));
    await inPhase(page, 'running');
    assert.equal(await ended(page), 'done');
    await keptAfter(page, 0);
  }

  /** Adds the ground at a place of the clip to a new object. */
  async function addThing(page) {
    const then = Number(await page.evaluate(() => document.body.dataset.saved));
    await openFix(page);
    await page.check('#correct-tools [value="paint"]', { force: true });
    await page.selectOption('#correct-object', '-1');
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => setTimeout(done, 100))));
    const box = await page.locator('#canvas').boundingBox();
    await page.mouse.move(box.x + 0.8 * box.width, box.y + 0.1 * box.height);
    await page.mouse.down();
    await page.mouse.move(box.x + 0.9 * box.width, box.y + 0.1 * box.height, { steps: 4 });
    await page.mouse.up();
    await page.waitForFunction(() => /^Applied to .*[.]/.test(document.querySelector('#correct-status').textContent));
    await keptAfter(page, then);
  }

  /** Chooses edges, a ground, and that the first object is not kept. */
  async function chooseLook(page) {
    const then = Number(await page.evaluate(() => document.body.dataset.saved));
    await openLook(page);
    for (const [name, value] of Object.entries({ grow: 3, feather: 2, smallest: 0.5, smooth: 1 }))
      await page.fill(`#edge-${name}`, String(value));
    await page.check('[name="view"][value="cutout"]', { force: true });
    await page.selectOption('#backdrop', 'green');
    await page.uncheck('[data-object="1"] input');
    await keptAfter(page, then);
  }

  /** What is chosen, as the page shows it. */
  async function chosen(page) {
    const values = await page.$$eval('#edge-grow, #edge-feather, #edge-smallest, #edge-smooth, #backdrop', (all) =>
      all.map(({ id, value }) => `${id} ${value}`),
    );
    const kept = await page.$$eval('[data-object] input', (all) => all.map(({ checked }) => checked));
    return { values, kept };
  }

  test('is offered again after a killed tab, with corrections, and can be deleted, which is asked first', async () => {
    const { page, faults } = await site.open({ bypassCSP: true });
    await opened(page);
    await addThing(page);
    await chooseLook(page);
    const look = await chosen(page);
    const before = await masks(page);
    const address = page.url();
    const context = page.context();
    // No handler of the page runs: as if its process had been killed.
    await page.close({ runBeforeUnload: false });

    const again = await context.newPage();
    await again.goto(address);
    await again.waitForSelector('#recent:not([hidden])', { timeout: 180_000 });
    assert.match(await text(again, '#recent-text'), /^Recent project: ./);
    await ended(again);
    await screenshot(again, 'saved');
    assert.deepEqual(await accessibilityFaults(again), []);
    await again.click('#recent-open');
    await again.waitForFunction(() => globalThis.tracecutStudio.app.segmentation?.result.numFrames === 12);
    assert.equal(await ended(again), 'done');
    assert.equal(await masks(again), before);
    assert.deepEqual(await chosen(again), look);
    await openFix(again);
    await again.click('#correct-undo');
    await again.waitForFunction(() => document.querySelector('#correct-undo').disabled);
    assert.notEqual(await masks(again), before);
    await again.click('#correct-redo');
    await again.waitForFunction(() => document.querySelector('#correct-redo').disabled);
    assert.equal(await masks(again), before);
    await again.close({ runBeforeUnload: false });

    const third = await context.newPage();
    await third.goto(address);
    await third.click('#recent-discard', { timeout: 180_000 });
    assert.equal(await text(third, '#recent-discard'), 'Delete forever?');
    assert.equal((await works(third)).length, 1);
    await third.click('#recent-discard');
    // A reload would come before the storage has forgotten it.
    await third.waitForFunction(() => document.querySelector('#projects-open').hidden);
    await ended(third);
    await third.reload();
    assert.equal(await ended(third), 'done');
    assert.equal(await third.locator('#recent').isVisible(), false);
    assert.deepEqual(faults, []);
    await context.close();
  });

  test('is saved as a file that holds the clip too, and opened from it', async () => {
    const { page, faults } = await site.open({ bypassCSP: true });
    await opened(page);
    await addThing(page);
    await chooseLook(page);
    const look = await chosen(page);
    assert.deepEqual(look.values.sort(), [
      ...['backdrop green', 'edge-feather 2', 'edge-grow 3', 'edge-smallest 0.5', 'edge-smooth 1'],
    ]);
    assert.ok(look.kept.length > 1 && !look.kept[0]);
    const before = await masks(page);
    const alpha = (of) => of.evaluate(() => globalThis.tracecutStudio.app.viewer.edgedMask().alpha.join());
    const smooth = (of) => of.waitForFunction(() => document.querySelector('#edge-smooth-text').textContent === '±1');
    await page.evaluate(() => globalThis.tracecutStudio.app.timeline.seek(5));
    await smooth(page);
    const edged = await alpha(page);
    await openSave(page);
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('[data-export="project"]')]);
    assert.match(download.suggestedFilename(), /-project\.tracecut$/);
    const file = { name: 'work.tracecut', mimeType: 'application/zip', buffer: await bytesOf(download) };
    await page.click('#export-close');

    const { page: other } = await site.open({ bypassCSP: true });
    assert.equal(await ended(other), 'done');
    await other.setInputFiles('#file', file);
    await other.waitForFunction(() => globalThis.tracecutStudio.app.segmentation?.result.numFrames === 12);
    assert.equal(await ended(other), 'done');
    assert.equal(await masks(other), before);
    const again = await chosen(other);
    assert.deepEqual({ ...again, values: again.values.sort() }, look);
    await other.evaluate(() => globalThis.tracecutStudio.app.timeline.seek(5));
    await other.waitForFunction(() => !/%/.test(document.querySelector('#edge-smooth-text').textContent));
    await smooth(other);
    await other.waitForFunction(() => globalThis.tracecutStudio.app.viewer.store.state.smoothedMasks);
    assert.equal(await alpha(other), edged);
    await other.setInputFiles('#file', { ...file, buffer: file.buffer.subarray(0, 500) });
    // What is on screen stays.
    assert.equal(await ended(other), 'done');
    assert.equal(await text(other, '#notice'), 'Couldn’t open work.tracecut. Not a TraceCut project.');
    assert.equal(await masks(other), before);
    assert.deepEqual(faults, []);
    await other.context().close();
    await page.context().close();
  });

  const works = (page) =>
    page.evaluate(async () => {
      const [{ listProjects }, storage] = await Promise.all([
        import('/model/saved-projects.js'),
        import('/view/storage.js'),
      ]);
      return (await listProjects(storage)).map(({ name, corrected, picture, earlier }) => ({
        name,
        corrected,
        picture: picture?.size ?? 0,
        earlier: earlier.length,
      }));
    });
  const facts = async (page) => (await works(page)).map(({ corrected, earlier }) => `${corrected} ${earlier}`);

  test('takes one place a clip, with a small picture; a new run of it leaves what was corrected beside it', async () => {
    const { page, faults } = await site.open({ bypassCSP: true });
    const then = async (act) => {
      const before = Number(await page.evaluate(() => document.body.dataset.saved ?? 0));
      await act();
      await keptAfter(page, before);
    };
    const open = (files) =>
      then(async () => {
        await page.setInputFiles('#file', files);
        await inPhase(page, 'running');
      });
    await opened(page);
    await addThing(page);
    const corrected = await masks(page);
    // Run again: the same clip, and its corrections.
    await then(async () => {
      await redo(page);
      await page.click('#confirm-yes');
    });
    assert.deepEqual(await facts(page), ['true 0']);
    await page.waitForTimeout(5);
    await open([...clip(9, 96, 64)]);
    assert.deepEqual(await facts(page), ['false 0', 'true 0']);
    // The first clip once more, as new files: its work is there, and stays.
    await open(clip(12, 96, 64));
    await page.waitForSelector('#recent', { state: 'visible' });
    assert.match(await text(page, '#recent-text'), /^You have a corrected project of frame000/);
    assert.deepEqual(await facts(page), ['false 1', 'false 0']);
    assert.notEqual(await masks(page), corrected);
    await addThing(page);
    assert.deepEqual(await facts(page), ['true 1', 'false 0'], 'both that were corrected');
    await page.click('#correct-done');
    assert.ok((await works(page)).every(({ picture }) => picture > 500));

    await page.click('#projects-open');
    await page.waitForSelector('#projects[open]');
    assert.equal(await page.locator('.projects > .project').count(), 2);
    // Each has its picture, with colours of objects in it.
    await page.waitForFunction(() =>
      [...document.querySelectorAll('.projects img')].every((image) => image.naturalWidth),
    );
    assert.equal(await page.locator('.projects img').count(), 3);
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'works');
    await page.setViewportSize({ width: 390, height: 844 });
    await screenshot(page, 'works-phone');
    assert.equal(await page.$eval('#projects', (dialog) => dialog.scrollWidth <= dialog.clientWidth), true);
    await page.setViewportSize({ width: 1280, height: 800 });
    // The earlier one, by keyboard.
    await page.focus('.versions [data-open]');
    await page.keyboard.press('Enter');
    await page.waitForFunction(() => /reopened/.test(document.querySelector('#facts, #subline').textContent));
    assert.equal(await ended(page), 'done');
    for (let tries = 0; tries < 50 && (await masks(page)) !== corrected; tries += 1) await page.waitForTimeout(200);
    assert.ok((await masks(page)) === corrected, 'the corrected masks are back');
    await page.waitForFunction(() => !('unsaved' in document.body.dataset));
    assert.deepEqual(await facts(page), ['true 1', 'false 0'], 'opened again, each has its place');
    await page.click('#projects-open');
    await page.waitForSelector('#projects[open]');
    const remove = page.locator('.projects > .project:nth-child(2) > button').last();
    await remove.focus();
    await page.keyboard.press('Enter');
    assert.equal(await remove.innerText(), 'Delete forever?');
    await page.keyboard.press('Enter');
    await page.waitForFunction(() => document.querySelectorAll('.projects > .project').length === 1);
    await page.keyboard.press('Escape');
    assert.deepEqual(faults, []);
    await page.context().close();
  });

  test('of a clip that was left at once is kept too', async () => {
    const { page, faults } = await site.open({ bypassCSP: true });
    await opened(page);
    await openFix(page);
    await page.selectOption('#correct-object', '1');
    // In one go: the next clip comes before the first is kept.
    await page.evaluate(() => {
      document.querySelector('#correct-background').click();
      document.querySelector('#correct-done').click();
    });
    await page.waitForFunction(() => document.querySelectorAll('.object').length === 1);
    await page.click('#sample');
    await page.waitForFunction(() => !('unsaved' in document.body.dataset));
    assert.deepEqual(await facts(page), ['true 0']);
    // Nothing was painted: the correction is in the masks.
    await page.click('#projects-open');
    await page.waitForSelector('#projects[open]');
    assert.match(await text(page, '.project-name'), /12 frames, corrected/);
    await page.click('[data-open]');
    await page.waitForFunction(() => globalThis.tracecutStudio.app.segmentation?.result.numFrames === 12);
    assert.equal(await ended(page), 'done');
    await redo(page);
    assert.equal(await page.locator('#confirm[open]').isVisible(), true, 'it is still corrected work');
    assert.deepEqual(faults, []);
    await page.context().close();
  });

  /** Works of so many clips in the storage, every one corrected or none. */
  const fill = (page, count, corrected) =>
    page.evaluate(
      async ([many, isCorrected]) => {
        const [{ listProjects, saveProject }, storage] = await Promise.all([
          import('/model/saved-projects.js'),
          import('/view/storage.js'),
        ]);
        const trim = { start: 0, frames: 2, step: 1, side: 480 };
        const kinds = [];
        for (let at = 1; at <= many; at += 1)
          kinds.push(
            await saveProject(storage, {
              ...{ id: `w${at}`, name: `n${at}`, at, files: [], project: new Uint8Array(3), edits: null },
              ...{ corrected: isCorrected && at <= 8, picture: null, earlier: [] },
              about: { name: `n${at}`, trim, changed: [], run: `r${at}` },
            }),
          );
        return { ids: (await listProjects(storage)).map(({ id }) => id), kinds };
      },
      [count, corrected],
    );

  test('that was corrected never goes by itself: where there is no room the page says so and asks', async () => {
    const { page, faults } = await site.open({ bypassCSP: true });
    await ended(page);
    const { ids, kinds } = await fill(page, 9, true);
    assert.deepEqual(ids, ['w8', 'w7', 'w6', 'w5', 'w4', 'w3', 'w2', 'w1']);
    assert.equal(kinds[8], false);
    await page.setInputFiles('#file', clip(12, 96, 64));
    await inPhase(page, 'running');
    assert.equal(await ended(page), 'done');
    await page.waitForSelector('#recent', { state: 'visible' });
    assert.match(await text(page, '#recent-text'), /^Storage is full/);
    assert.equal(await page.evaluate(() => 'unsaved' in document.body.dataset), true, 'leaving is asked about');
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'works-full');
    await page.focus('#recent-open');
    await page.keyboard.press('Enter');
    await page.waitForSelector('#projects[open]');
    const remove = page.locator('.projects > .project:nth-child(8) > button').last();
    await remove.focus();
    await page.keyboard.press('Enter');
    await page.keyboard.press('Enter');
    await page.waitForFunction(() => !('unsaved' in document.body.dataset));
    assert.equal((await works(page)).length, 8);
    assert.match((await works(page))[0].name, /frame000/);
    assert.equal(await page.locator('#recent').isVisible(), false);
    assert.deepEqual(faults, []);
    await page.context().close();
  });
});

describe('a run that was cut off', () => {
  const site = useSite({ sample: 'tiny' });
  const clip = movingClip(170, [160, 120]);
  /** The runs that are remembered. */
  const runs = (page) =>
    page.evaluate(async () => {
      const { list } = await import('/view/storage.js');
      return (await list()).filter(({ id }) => id.startsWith('run-')).map(({ about }) => about.trim.step);
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
    await setControl(page, '#clip-step', '3');
    // The run begins anew with that, and is remembered so.
    await remembered(page, [3]);
    const again = await anew(page);
    await again.waitForSelector('#recent', { state: 'visible' });
    assert.equal(await text(again, '#recent-open'), 'Run again: frame000.png … frame169.png');
    assert.equal(await text(again, '#recent-text'), 'The run of frame000.png … frame169.png was interrupted.');
    await ended(again);
    await screenshot(again, 'cut-off');
    assert.deepEqual(await accessibilityFaults(again), []);
    await again.click('#recent-open');
    await again.waitForFunction(() => globalThis.tracecutStudio.trim?.step === 3);
    await again.waitForFunction(() => globalThis.tracecutStudio.app.segmentation?.result.numFrames === 57);
    assert.equal(await ended(again), 'done');
    await remembered(again, []);
    await again.waitForFunction(() => document.body.dataset.saved && !('unsaved' in document.body.dataset));

    const third = await anew(again);
    await third.waitForSelector('#recent', { state: 'visible' });
    assert.match(await text(third, '#recent-text'), /^Recent project: ./);
    assert.deepEqual(faults, []);
    await third.context().close();
  });

  test('is not offered while another tab continues it', async () => {
    const { page } = await site.open();
    await begun(page);
    const other = await page.context().newPage();
    await other.goto(page.url());
    await ended(other);
    await other.waitForTimeout(2500);
    assert.equal(await page.evaluate(() => document.body.dataset.phase), 'running');
    assert.equal(await other.locator('#recent').isVisible(), false);
    await page.context().close();
  });
});
