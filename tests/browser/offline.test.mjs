// The page without a network: kept on the device after the first visit, complete, renewed when the site changes, and
// installable.

import assert from 'node:assert/strict';
import { existsSync, rmSync, writeFileSync } from 'node:fs';
import { join, relative, sep } from 'node:path';
import { after, describe, test } from 'node:test';
import { precacheList } from '../../scripts/precache.mjs';
import { root } from '../../scripts/tools.mjs';
import { ended, openSample, plainFrame, pngFile, run, text, useSite } from './support.mjs';

/** Waits until the page is kept. */
const kept = (page) => page.evaluate(() => navigator.serviceWorker.ready.then(({ active }) => active.state));

/** Where a file lies that is served by this name. @param {string} name */
const placeOf = (name) =>
  name.startsWith('./dist/') ? name : name.replace(/^\.\/(lab\/)?/, (_, lab) => (lab ? 'www/' : 'studio/'));

/** Whether a file of `studio/` that is no more on the host is answered for by the version in force. */
const answered = (page, file) =>
  page.evaluate(
    async (name) => (await fetch(name)).ok,
    `./${relative(join(root, 'studio'), file).replaceAll(sep, '/')}`,
  );

describe('without a network', () => {
  const site = useSite({ sample: 'tiny' });
  const extra = join(root, 'studio', 'view', 'of-another-version.js');
  after(() => rmSync(extra, { force: true }));

  test('the page opens again and does all that it did', async () => {
    const { page, faults } = await openSample(site, { serviceWorkers: 'allow' });
    await kept(page);
    const before = await page.evaluate(() => [...globalThis.tracecutDemo.result.labels(3)].join(''));
    await page.context().setOffline(true);
    await page.reload();
    assert.equal(await ended(page), 'done');
    assert.equal(await page.evaluate(() => [...globalThis.tracecutDemo.result.labels(3)].join('')), before);
    assert.equal(
      await run(
        page,
        [0, 1, 2].map((k) =>
          pngFile(
            `${k}.png`,
            plainFrame(48, 32, (x, y) => [(x * 5 + k * 9) % 256, y * 7, 0]),
          ),
        ),
      ),
      'done',
    );
    // What is fetched ahead would be cut off.
    await page.waitForLoadState('networkidle');
    await page.goto(`${page.url().replace(/[?#].*/, '')}?from=a-link`);
    assert.equal(await ended(page), 'done');
    assert.deepEqual(faults, []);
  });

  test('every file that the page asks for is kept', async () => {
    const files = precacheList().files.map(([file]) => file);
    assert.deepEqual(
      files.filter((file) => !existsSync(join(root, placeOf(file)))),
      [],
    );
    const { page } = await site.open();
    const asked = [];
    page.on('request', (request) => request.url().startsWith('http') && asked.push(request.url()));
    await page.reload();
    assert.equal(await ended(page), 'done');
    const relative = asked.map((url) => `./${new URL(url).pathname.slice(1)}`);
    assert.ok(relative.length > 40, `${relative.length} files`);
    assert.deepEqual(
      relative.filter((file) => !files.includes(file)),
      [],
    );
  });

  test('a changed site is offered, and taken when the user wants it', async () => {
    const { page } = await openSample(site, { serviceWorkers: 'allow' });
    await kept(page);
    const first = await page.evaluate(() => caches.keys());
    await page.reload();
    assert.equal(await ended(page), 'done');
    assert.equal(await page.locator('#update').isVisible(), false);
    const version = '// Another version of the site.\n';
    writeFileSync(extra, version);
    await page.evaluate(async () => (await navigator.serviceWorker.getRegistration()).update());
    await page.locator('#update').waitFor();
    // The tabs that are open, and new ones, stay with the old version until there is only one.
    const other = await page.context().newPage();
    await other.goto(page.url());
    assert.equal(await ended(other), 'done');
    const answers = () => Promise.all([page, other].map((tab) => answered(tab, extra)));
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
    assert.equal(await answered(page, extra), true);
  });

  test('the manifest says how to install it, with icons of the sizes that it names', async () => {
    const { page } = await site.open();
    const found = await page.evaluate(async () => {
      const at = document.querySelector('link[rel="manifest"]').href;
      const manifest = await (await fetch(at)).json();
      const sizes = await Promise.all(
        manifest.icons.map(async ({ src }) => {
          const image = new Image();
          image.src = new URL(src, at);
          await image.decode();
          return `${image.naturalWidth}x${image.naturalHeight}`;
        }),
      );
      return { manifest, sizes };
    });
    assert.equal(found.manifest.display, 'standalone');
    found.manifest.icons.forEach(({ sizes }, k) =>
      assert.ok(sizes === 'any' || sizes === found.sizes[k], found.sizes[k]),
    );
  });

  test('a browser without service workers shows the page all the same', async () => {
    const context = { serviceWorkers: 'block' };
    const { page, faults } = await openSample(site, context);
    assert.match(await text(page, '#subline'), / 4 frames of 96 × 54/);
    assert.deepEqual(faults, []);
  });
});
