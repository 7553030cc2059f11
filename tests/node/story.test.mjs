// Random stories of calls (tests/story.mjs), each by its number, in all the ways that a session may run in Node. More of
// them are told in tests/long.

import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import * as api from '../whole.mjs';
import { play, prepare } from '../story.mjs';

const WAYS = [{}, { worker: true }, { threads: 2 }, { worker: true, threads: 2 }];
const STORIES = 4;
const STEPS = 40;

/** Rejections that nobody heard of. */
const unheard = [];
process.on('unhandledRejection', (reason) => unheard.push(reason));
after(() => assert.deepEqual(unheard, []));

const counts = {};
for (const options of WAYS)
  test(`${STORIES} stories with ${JSON.stringify(options)}: legal answers, known codes, the same result after`, async () => {
    const world = await prepare(api, options);
    for (let seed = 0; seed < STORIES; seed += 1)
      for (const [answer, count] of Object.entries(await play(world, seed, STEPS)))
        counts[answer] = (counts[answer] ?? 0) + count;
  });

test('the stories tell of all that may happen', () => {
  // Those that no time decides on.
  const wanted = ['run ok', 'run own', 'run closed', 'run too-few-frames', 'clear busy', 'push ok', 'push closed'];
  wanted.push('segmentVideo ok', 'second collect state', 'createSession param', 'engine.flow ok');
  const missing = wanted.filter((answer) => !counts[answer]);
  assert.deepEqual(missing, [], JSON.stringify(counts));
});
