// A page that runs for long: it opens one clip of files after the other, segments it and shows it.

import { readFileSync } from 'node:fs';
import { setTimeout as pause } from 'node:timers/promises';
import { launchBrowser } from '../../scripts/browser.mjs';
import { serve } from '../../scripts/serve.mjs';
import { pngBytes } from '../../tests/png.mjs';
import { madeFrame, soak } from './points.mjs';

const FRAMES = 4;
const server = await serve();
const browser = await launchBrowser();
const context = await browser.newContext({ serviceWorkers: 'block' });
const page = await context.newPage();
page.setDefaultTimeout(300_000);
const session = await context.newCDPSession(page);
await page.goto(server.url);
const done = () => page.waitForFunction(() => ['done', 'error'].includes(document.body.dataset.state));
await done();

async function clip(k) {
  const files = Array.from({ length: FRAMES }, (_, t) => ({
    name: `clip${k}-${t}.png`,
    mimeType: 'image/png',
    buffer: pngBytes(madeFrame(4 * k + t), { channels: 4 }),
  }));
  await page.setInputFiles('#file', files);
  await page.waitForFunction((name) => document.querySelector('#clip-name').textContent.includes(name), `clip${k}`);
  await done();
}

/**
 * Measures the live objects of the main thread, of scripts and of the browser, and the memory of the page's process with its
 * workers, which collect garbage when the browser signals low memory.
 */
async function measure() {
  await session.send('Memory.simulatePressureNotification', { level: 'critical' });
  for (let k = 0; k < 3; k += 1) {
    await session.send('HeapProfiler.collectGarbage');
    await pause(100);
  }
  const usage = await session.send('Runtime.getHeapUsage');
  const { usedSize, backingStorageSize = 0, embedderHeapUsedSize = 0 } = usage;
  return { heap: usedSize + backingStorageSize + embedderHeapUsedSize, rss: await renderers() };
}

/**
 * Returns the resident bytes of all renderer processes, without files and memory shared with the GPU process, where tiles
 * come and go by megabytes.
 */
async function renderers() {
  const { processInfo } = await (await browser.newBrowserCDPSession()).send('SystemInfo.getProcessInfo');
  const ids = processInfo.filter(({ type }) => type === 'renderer').map(({ id }) => id);
  const kilobytes = ids.map((id) =>
    Number(/^RssAnon:\s+(\d+) kB$/m.exec(readFileSync(`/proc/${id}/status`, 'utf8'))[1]),
  );
  return 1024 * kilobytes.reduce((sum, size) => sum + size, 0);
}

const result = await soak('page', 'clip', Number(process.argv[2]), clip, measure);
await browser.close();
await server.close();
console.log(JSON.stringify({ ...result, cpuSeconds: null }));
