// The page's thread is never busy for long while a clip runs: no task takes more than a tenth of a second of the processor.
// Not by the clock, which says how busy the machine is; but caches that others use count too, so it runs alone.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { useServerAndBrowser } from '../site.mjs';
import { WIDE, fiveObjects } from './five-objects.mjs';
import { ended, onlyLong } from './support.mjs';

const MOST_MS = 100;
const site = useServerAndBrowser({ sample: 'whole' });

/** The processor's time of the longest tasks of the page's thread, in milliseconds. */
function longest(trace) {
  const { traceEvents } = JSON.parse(trace);
  const isMain = new Set(
    traceEvents.filter(({ name, args }) => name === 'thread_name' && args.name === 'CrRendererMain').map(threadOf),
  );
  const tasks = traceEvents.filter((event) => /RunTask$/.test(event.name) && event.tdur && isMain.has(threadOf(event)));
  assert.ok(tasks.length > 200, `only ${tasks.length} tasks were seen`);
  return tasks
    .map(({ tdur }) => Math.round(tdur / 1000))
    .sort((a, b) => b - a)
    .slice(0, 5);
}

const threadOf = ({ pid, tid }) => `${pid} ${tid}`;

test('the sample and a video leave the page’s thread free', onlyLong, async () => {
  const context = await site.browser.newContext({ viewport: { width: 1440, height: 900 }, serviceWorkers: 'block' });
  const page = await context.newPage();
  page.setDefaultTimeout(180_000);
  const traced = async (what, act) => {
    await site.browser.startTracing(page, { categories: ['toplevel', 'devtools.timeline'] });
    await act();
    assert.equal(await ended(page), 'done');
    const times = longest(await site.browser.stopTracing());
    console.log(`${what}: the longest tasks took ${times.join(', ')} ms of the processor`);
    assert.ok(times[0] <= MOST_MS, `${what}: ${times[0]} ms`);
  };
  await traced('sample', () => page.goto(site.url));
  const { video } = await fiveObjects(page, { ...WIDE, frames: 60 });
  await traced('video', async () => {
    await page.setInputFiles('#file', [video]);
    await page.waitForFunction(() => globalThis.tracecutStudio.source?.name === 'five.webm');
  });
  await context.close();
});
