// In a separate process: on a busy machine, a process that has run clips before may never be notified of collected objects.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Session } from '../../dist/session/session.js';
import { untilCollected } from './support.mjs';

test('a session without references is closed', async () => {
  const counting = () => {
    const engine = { closed: 0, close: () => (engine.closed += 1) };
    return engine;
  };
  const forgotten = counting();
  const forget = () => void new Session(forgotten, async () => {});
  // The engine may still hold the last one somewhere when it is busy.
  for (let k = 0; k < 20; k += 1) forget();
  assert.ok(await untilCollected(() => forgotten.closed >= 10, 1000), `${forgotten.closed} of 20 were closed`);
  const closed = counting();
  const forgetClosed = () => void new Session(closed, async () => {}).close();
  for (let k = 0; k < 5; k += 1) forgetClosed();
  assert.equal(closed.closed, 5);
  assert.equal(await untilCollected(() => closed.closed !== 5), false, 'one that was closed is not closed again');
});
