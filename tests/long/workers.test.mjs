// Service workers and shared workers, where workers or later modules are missing.

import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { before, test } from 'node:test';
import { outcome } from '../package/app/segment.js';
import { served } from '../package/installed.mjs';
import { project } from '../package/project.mjs';
import { useServerAndBrowser } from '../site.mjs';

const site = useServerAndBrowser();
const INLINE = "from './node_modules/tracecut/dist/inline.js'";
const ORDINARY = "from './node_modules/tracecut/dist/index.js'";
let expected;
before(async () => {
  expected = await outcome();
});

/** The application's module with the package from a place of its own. */
function segment(folder, from) {
  const text = readFileSync(join(folder, 'segment.js'), 'utf8');
  writeFileSync(join(folder, 'segment.js'), text.replace("from 'tracecut'", from));
}

test('a service worker that loads the package as many modules is told to use the inline one', async (t) => {
  const folder = await project(t, {});
  segment(folder, ORDINARY);
  writeFileSync(
    join(folder, 'worker.js'),
    `import { outcome } from './segment.js';
    self.addEventListener('message', ({ source }) => {
      outcome().then((found) => source.postMessage(found), ({ code, message }) => source.postMessage({ code, message }));
    });`,
  );
  const found = await inServiceWorker(t, folder);
  assert.equal(found.code, 'wasm-load');
  assert.match(found.message, /import\(\) is disallowed.*tracecut\/inline/);
  const inside = await project(t, {});
  segment(inside, INLINE);
  writeFileSync(
    join(inside, 'worker.js'),
    `import { outcome } from './segment.js';
    self.addEventListener('message', (event) => event.waitUntil(outcome().then((found) => event.source.postMessage(found))));`,
  );
  assert.deepEqual(await inServiceWorker(t, inside), expected);
});

async function inServiceWorker(t, folder) {
  const page = await emptyPage(t, folder);
  return page.evaluate(async () => {
    await navigator.serviceWorker.register('./worker.js', { type: 'module' });
    const { active } = await navigator.serviceWorker.ready;
    const answer = new Promise((done) => {
      navigator.serviceWorker.onmessage = ({ data }) => done(data);
    });
    active.postMessage('go');
    return answer;
  });
}

for (const [how, from] of [
  ['in many modules', ORDINARY],
  ['with everything inside', INLINE],
]) {
  test(`a shared worker with the package ${how}`, async (t) => {
    const folder = await project(t, {});
    segment(folder, from);
    writeFileSync(
      join(folder, 'shared.js'),
      `import { outcome } from './segment.js';
      self.onconnect = ({ ports: [port] }) =>
        outcome().then((found) => port.postMessage(found), ({ code, message }) => port.postMessage({ code, message }));`,
    );
    const page = await emptyPage(t, folder);
    const found = await page.evaluate(
      () =>
        new Promise((done, fail) => {
          const worker = new SharedWorker('./shared.js', { type: 'module' });
          worker.onerror = () => fail(new Error('no shared worker'));
          worker.port.onmessage = ({ data }) => done(data);
          worker.port.start();
        }),
    );
    assert.deepEqual(found, expected);
  });
}

async function emptyPage(t, folder) {
  writeFileSync(join(folder, 'index.html'), '<!doctype html><link rel="icon" href="data:,">');
  const context = await site.browser.newContext();
  t.after(() => context.close());
  const page = await context.newPage();
  await page.goto(await served(t, folder));
  return page;
}
