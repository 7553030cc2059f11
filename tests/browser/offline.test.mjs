// The page without a network: kept on the device after the first visit, complete, renewed when the site changes, and
// installable.

import assert from 'node:assert/strict';
import { readFileSync, rmSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { describe, test } from 'node:test';
import { siteList } from '../../scripts/site.mjs';
import { root } from '../../scripts/tools.mjs';
import { ended, movingClip, openSample, run, useSite } from './support.mjs';

/** Waits until the page is kept. */
const kept = (page) => page.evaluate(() => navigator.serviceWorker.ready.then(({ active }) => active.state));

const EXTRA = 'view/of-another-version.js';

/** Whether a file that is no more on the host is answered for by the version in force. */
const answered = (page) => page.evaluate(async (name) => (await fetch(name)).ok, `./${EXTRA}`);

describe('without a network', () => {
  const site = useSite({ sample: 'tiny', isOwn: true });

  test('the page opens again, by a link too, and does all that it did, of files that are kept', async () => {
    const { page, faults } = await openSample(site, { serviceWorkers: 'allow' });
    await kept(page);
    const before = await page.evaluate(() => [...globalThis.tracecutStudio.result.labels(3)].join(''));
    // What is fetched ahead would be cut off.
    await page.waitForLoadState('networkidle');
    await page.context().setOffline(true);
    const asked = [];
    page.on('request', (request) => request.url().startsWith('http') && asked.push(new URL(request.url()).pathname));
    await page.goto(`${page.url().replace(/[?#].*/, '')}?from=a-link`);
    assert.equal(await ended(page), 'done');
    assert.equal(await page.evaluate(() => [...globalThis.tracecutStudio.result.labels(3)].join('')), before);
    assert.equal(await run(page, movingClip(3, [48, 32])), 'done');
    const files = siteList(site.folder()).files.map(([file]) => file);
    assert.ok(asked.length > 40, `${asked.length} files`);
    assert.deepEqual(
      asked.filter((file) => !files.includes(`.${file}`)),
      [],
    );
    assert.deepEqual(faults, []);
  });

  test('a changed site is offered, and taken when the user wants it', async () => {
    const { page } = await openSample(site, { serviceWorkers: 'allow' });
    await kept(page);
    const first = await page.evaluate(() => caches.keys());
    await page.reload();
    assert.equal(await ended(page), 'done');
    assert.equal(await page.locator('#update').isVisible(), false);
    const extra = join(site.folder(), EXTRA);
    const version = '// Another version of the site.\n';
    writeFileSync(extra, version);
    await page.evaluate(async () => (await navigator.serviceWorker.getRegistration()).update());
    await page.locator('#update').waitFor();
    // The tabs that are open, and new ones, stay with the old version until there is only one.
    const other = await page.context().newPage();
    await other.goto(page.url());
    assert.equal(await ended(other), 'done');
    const answers = () => Promise.all([page, other].map(answered));
    rmSync(extra);
    assert.deepEqual(await answers(), [false, false]);
    await page.locator('#update').click();
    await page.getByText('Close other tabs first').waitFor();
    assert.equal(await page.evaluate(() => document.body.dataset.state), 'done', 'the result is still there');
    assert.deepEqual(await answers(), [false, false]);
    await other.close();
    writeFileSync(extra, version);
    await page.locator('#update').click();
    await page.waitForFunction(
      () => document.body.dataset.state === 'done' && document.querySelector('#update').hidden,
    );
    const second = await page.evaluate(() => caches.keys());
    assert.equal(second.length, 1);
    assert.notDeepEqual(second, first);
    rmSync(extra);
    assert.equal(await answered(page), true);
  });

  test('the manifest says how to install it, with icons of the sizes that it names', () => {
    const read = (name) => readFileSync(join(root, 'studio', name));
    assert.match(String(read('index.html')), /<link rel="manifest" href="\.\/manifest\.webmanifest">/);
    const { display, icons } = JSON.parse(read('manifest.webmanifest'));
    assert.equal(display, 'standalone');
    for (const { src, sizes, type } of icons) {
      const bytes = read(src);
      if (type === 'image/svg+xml') assert.ok(sizes === 'any' && bytes.includes('<svg'), src);
      else assert.equal(`${bytes.readUInt32BE(16)}x${bytes.readUInt32BE(20)}`, sizes, src);
    }
  });
});
