// Stories of calls (tests/story.mjs) by the thousand; a number that fails is told, and told again by it alone:
// `STORY=1234 node --test tests/long/story.test.mjs`.

import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import * as api from '../whole.mjs';
import { play, prepare } from '../story.mjs';

const WAYS = [{}, { worker: true }, { threads: 2 }, { worker: true, threads: 2 }];
const STEPS = 40;
const chosen = process.env.STORY;
const seeds = chosen ? [Number(chosen)] : Array.from({ length: 500 }, (_, k) => 1000 + k);

const unheard = [];
process.on('unhandledRejection', (reason) => unheard.push(reason));
after(() => assert.deepEqual(unheard, []));

for (const options of WAYS)
  test(`${seeds.length} stories with ${JSON.stringify(options)}`, async (t) => {
    const world = await prepare(api, options);
    let answers = 0;
    for (const seed of seeds) for (const count of Object.values(await play(world, seed, STEPS))) answers += count;
    t.diagnostic(`${answers} answers, all of them legal`);
    assert.ok(answers > seeds.length);
  });
