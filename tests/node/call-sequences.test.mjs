// Random call sequences (tests/call-sequences.mjs) for each place where a session can run in Node: a few, and 500 each in
// `npm run test:long`. `SEED=1234 node --test tests/node/call-sequences.test.mjs` runs one.

import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import { prepareSequences, runSequence } from '../call-sequences.mjs';
import * as api from '../entries.mjs';

const OPTIONS = [{}, { worker: true }, { threads: 2 }, { worker: true, threads: 2 }];
const NUM_STEPS = 40;
const { SEED, TRACECUT_LONG } = process.env;
const { first, count } = SEED
  ? { first: Number(SEED), count: 1 }
  : TRACECUT_LONG
    ? { first: 1000, count: 500 }
    : { first: 0, count: 4 };

const unhandled = [];
process.on('unhandledRejection', (reason) => unhandled.push(reason));
after(() => assert.deepEqual(unhandled, []));

const setup = prepareSequences(api);
const counts = {};
for (const [k, options] of OPTIONS.entries())
  test(`${count} sequences with ${JSON.stringify(options)} have valid outcomes, and leave later runs unchanged`, async () => {
    const optionSetup = { ...(await setup), options };
    // A few sequences are others in each place.
    const start = SEED || TRACECUT_LONG ? first : first + k * count;
    for (let seed = start; seed < start + count; seed += 1)
      for (const [outcome, times] of Object.entries(await runSequence(optionSetup, seed, NUM_STEPS)))
        counts[outcome] = (counts[outcome] ?? 0) + times;
  });

test('the sequences cover every kind of call', { skip: SEED && 'one sequence does not' }, () => {
  // Outcomes that do not depend on timing.
  const expected = ['run ok', 'run reason', 'run closed', 'run too-few-frames', 'clear busy', 'push ok', 'push closed'];
  expected.push('segmentVideo ok', 'second collect state', 'createSession param', 'engine.flow ok');
  assert.deepEqual(
    expected.filter((outcome) => !counts[outcome]),
    [],
    JSON.stringify(counts),
  );
});
