// Faults around the page: storage that is full, a network that goes while the page loads, files that are missing. Each with
// what is kept (docs/reliability.md).

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { bytesOf, ended, exportAs, openSample, openSave, plainFrame, pngFile, run, text, useSite } from './support.mjs';

const clip = (name) =>
  [0, 1, 2].map((k) =>
    pngFile(
      `${name}${k}.png`,
      plainFrame(48, 32, (x, y) => [(x * 5 + k * 9) % 256, y * 7, 0]),
    ),
  );
/** The works that the browser keeps, by the names of their clips. */
const works = (page) =>
  page.evaluate(
    () =>
      new Promise((done) => {
        const opening = indexedDB.open('tracecut');
        opening.onsuccess = () => {
          const all = opening.result.transaction('work').objectStore('work').getAll();
          all.onsuccess = () => done(all.result.map(({ name, project }) => [name, project.length > 0]));
        };
      }),
  );
const isKept = (page, name) =>
  page.waitForFunction(
    (wanted) => document.body.dataset.saved && document.querySelector('#clip-name').textContent.includes(wanted),
    name,
  );

describe('faults around the page', { timeout: 300_000 }, () => {
  const site = useSite({ sample: 'tiny', isOwn: true });

  test('where storage is full the result is shown and saved, and work that was kept stays whole', async () => {
    const { page, faults } = await openSample(site);
    assert.equal(await run(page, clip('first')), 'done');
    await isKept(page, 'first');
    const before = await works(page);
    assert.equal(before.length, 1);
    // What a browser does where there is no room: the whole transaction is taken back. Its quota itself is looked at too
    // rarely for a test.
    await page.evaluate(() => {
      const { put } = IDBObjectStore.prototype;
      IDBObjectStore.prototype.put = function (...args) {
        const request = put.apply(this, args);
        this.transaction.abort();
        return request;
      };
    });
    await page.evaluate(() => delete document.body.dataset.saved);
    assert.equal(await run(page, clip('second')), 'done');
    assert.match(await text(page, '#headline'), /./);
    await page.keyboard.press('e');
    const coming = page.waitForEvent('download');
    await exportAs(page, 'zip');
    assert.ok((await bytesOf(await coming)).length > 0, 'saving works');
    // What could not be kept is not left without a question.
    const asked = page.waitForEvent('dialog').then((dialog) => (dialog.accept(), dialog.type()));
    const other = await page.context().newPage();
    await other.goto(page.url());
    await page.close({ runBeforeUnload: true });
    assert.equal(await asked, 'beforeunload');
    assert.deepEqual(await works(other), before);
    assert.deepEqual(faults, []);
  });

  test('a network failure while the wasm file loads is reported, and the next attempt works', async () => {
    const { page } = await openSample(site);
    await page.context().route('**/tracecut_bg.wasm', (route) => route.abort('connectionreset'));
    await page.reload();
    assert.equal(await ended(page), 'error');
    assert.match(await text(page, '#error'), /tracecut_bg\.wasm/);
    await page.context().unroute('**/tracecut_bg.wasm');
    assert.equal(await run(page, clip('again')), 'done');
  });

  test('a part that fails to load on first use is reported, and the result stays', async () => {
    for (const isOffline of [true, false]) {
      const { page } = await openSample(site);
      // The parts that the result needs by itself are there.
      await page.waitForSelector('#certainty', { state: 'visible' });
      const context = page.context();
      if (isOffline) await context.setOffline(true);
      else await context.route('**/view/*.js', (route) => route.abort());
      const labels = () => page.evaluate(() => [...globalThis.tracecutStudio.result.labels(3)].join(''));
      const before = await labels();
      await page.keyboard.press('e');
      const notice = isOffline ? /^You’re offline/ : /^A part of the page didn’t load[.] Reload/;
      await page.waitForFunction(
        (text) => new RegExp(text).test(document.querySelector('#notice').textContent),
        notice.source,
      );
      if (isOffline) await context.setOffline(false);
      else await context.unroute('**/view/*.js');
      assert.equal(await page.evaluate(() => document.body.dataset.state), 'done');
      assert.equal(await labels(), before);
      // Chromium never repeats a failed import; after a failed probe there was none.
      if (!isOffline) {
        await page.reload();
        assert.equal(await ended(page), 'done');
      }
      await openSave(page);
      await context.close();
    }
  });
});
