// Compares the results of a page with the application of this folder with the results in Node.

import assert from 'node:assert/strict';

/**
 * Checks that the page at `url` finds what Node finds, and that nothing goes wrong on the way.
 * @param {import('node:test').TestContext} t
 * @param {import('playwright-core').Browser} browser
 * @param {string} url
 * @param {object} expected
 * @param {{files?: number}} [options] of how many files workers are started
 */
export async function gives(t, browser, url, expected, { files = 2 } = {}) {
  const page = await browser.newPage();
  t.after(() => page.close());
  const [wrong, workers] = [[], []];
  page.on('worker', (worker) => workers.push(worker.url()));
  page.on('pageerror', (error) => wrong.push(error.message));
  page.on('console', (message) => message.type() === 'error' && wrong.push(message.text()));
  page.on('response', (response) => response.ok() || wrong.push(`${response.status()} ${response.url()}`));
  await page.goto(url);
  await page.waitForFunction(() => globalThis.outcome ?? false, undefined, { timeout: 60_000 });
  const [found, video] = await page.evaluate(() => globalThis.outcome);
  assert.deepEqual(found, expected);
  assertVideo(video);
  assert.deepEqual(wrong, []);
  // One more makes archives; sessions have further ones where the machine has more cores.
  assert.ok(workers.length >= 4, `each session has a worker: ${workers}`);
  assert.equal(new Set(workers).size, files, String(workers));
}

/** Checks what became of a video that was written and read. */
export function assertVideo(video) {
  assert.equal(video.type, 'video/webm');
  assert.deepEqual(video.times, [0, 100, 200, 300, 400, 500, 600, 700]);
  assert.ok(video.overlap > 0.8, `objects of the decoded video overlap the true ones by ${video.overlap}`);
}
