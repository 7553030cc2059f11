// A few stories of calls (tests/story.mjs) in a page: in workers, with helpers, and on the page's own thread.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { emptyPage } from '../browser/empty-page.mjs';
import { useServerAndBrowser } from '../site.mjs';

const STORIES = 2;
const STEPS = 30;
const site = useServerAndBrowser();

for (const options of [{ threads: 1 }, { threads: 2 }, { worker: false }])
  test(`${STORIES} stories in a page with ${JSON.stringify(options)}`, { timeout: 300_000 }, async (t) => {
    const page = await emptyPage(t, site, { modules: ['story.mjs', 'fingerprint.mjs'] });
    const { counts, unheard } = await page.evaluate(tell, [options, STORIES, STEPS]);
    assert.deepEqual(unheard, []);
    // Those that no time decides on; each story ends with a plain run besides.
    const missing = ['push ok', 'run own', 'run closed', 'clear busy', 'createSession param'].filter(
      (name) => !counts[name],
    );
    assert.deepEqual(missing, [], JSON.stringify(counts));
  });

/** Runs in the page. */
async function tell([options, stories, steps]) {
  const unheard = [];
  addEventListener('unhandledrejection', ({ reason }) => unheard.push(String(reason)));
  const [api, { play, prepare }] = await Promise.all([import('/model/library.js'), import('/story.mjs')]);
  const world = await prepare(api, options);
  const counts = {};
  for (let seed = 0; seed < stories; seed += 1)
    for (const [answer, count] of Object.entries(await play(world, seed, steps)))
      counts[answer] = (counts[answer] ?? 0) + count;
  return { counts, unheard };
}
