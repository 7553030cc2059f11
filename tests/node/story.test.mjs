// Random stories of calls (tests/story.mjs), in all the ways that a session may run in Node: a few, and hundreds in
// `npm run test:long`. `STORY=1234 node --test tests/node/story.test.mjs` tells the one of that number.

import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import * as api from '../entries.mjs';
import { play, prepare } from '../story.mjs';

const WAYS = [{}, { worker: true }, { threads: 2 }, { worker: true, threads: 2 }];
const STEPS = 40;
const { STORY, TRACECUT_LONG } = process.env;
const usual = TRACECUT_LONG ? { first: 1000, count: 500 } : { first: 0, count: 7 };
const { first, count } = STORY ? { first: Number(STORY), count: 1 } : usual;

/** Rejections that nobody heard of. */
const unheard = [];
process.on('unhandledRejection', (reason) => unheard.push(reason));
after(() => assert.deepEqual(unheard, []));

const counts = {};
for (const options of WAYS)
  test(`${count} stories with ${JSON.stringify(options)}: legal answers, known codes, the same result after`, async () => {
    const world = await prepare(api, options);
    for (let seed = first; seed < first + count; seed += 1)
      for (const [answer, times] of Object.entries(await play(world, seed, STEPS)))
        counts[answer] = (counts[answer] ?? 0) + times;
  });

test('the random stories cover every kind of call', { skip: STORY && 'one story does not' }, () => {
  // Those that no time decides on.
  const wanted = ['run ok', 'run own', 'run closed', 'run too-few-frames', 'clear busy', 'push ok', 'push closed'];
  wanted.push('segmentVideo ok', 'second collect state', 'createSession param', 'engine.flow ok');
  const missing = wanted.filter((answer) => !counts[answer]);
  assert.deepEqual(missing, [], JSON.stringify(counts));
});
