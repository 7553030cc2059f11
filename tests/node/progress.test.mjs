// What `onProgress` reports: the stage, the share of the whole run, which never falls and ends at 1, and the time left.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { createSession, segmentEach, segmentVideo } from 'tracecut';
import { trajectories } from 'tracecut/stages';
import { framesOf } from './support.mjs';

const SCENE = { width: 96, height: 54, frames: 16, seed: 4 };
const frames = await framesOf(SCENE);

/** Throws unless the shares never fall, end at 1 and the time left is a number or null. */
function checkReports(reports) {
  assert.ok(reports.length > 0);
  reports.forEach(({ stage, share, secondsLeft }, k) => {
    assert.equal(typeof stage, 'string');
    assert.ok(
      share >= (reports[k - 1]?.share ?? 0) && share <= 1,
      `${share} in ${stage} after ${reports[k - 1]?.share}`,
    );
    assert.ok(secondsLeft === null || (secondsLeft >= 0 && Number.isFinite(secondsLeft)));
  });
  assert.deepEqual([reports.at(-1).share, reports.at(-1).secondsLeft], [1, 0]);
}

/** Segments a source and returns the reports. */
async function reportsOf(source, options = {}) {
  const reports = [];
  await segmentVideo(source, { ...options, onProgress: (progress) => reports.push(progress) }).collect();
  return reports;
}

for (const worker of [false, true])
  test(`a session's run and corrections, ${worker ? 'in a thread' : 'here'}`, async () => {
    const session = await createSession({ worker });
    for (const frame of frames.slice(0, 10)) await session.push(frame);
    const reports = [];
    const options = { onProgress: (progress) => reports.push(progress) };
    const { objects } = await session.run(options);
    checkReports(reports);
    reports.length = 0;
    await session.split(objects[0].label, undefined, options);
    if (reports.length > 0) checkReports(reports);
    session.close();
  });

test('a run that was aborted continues with a share of what is left', async () => {
  const session = await createSession();
  for (const frame of frames.slice(0, 10)) await session.push(frame);
  const controller = new AbortController();
  const onProgress = ({ stage }) => stage === 'superpixels' && controller.abort();
  await assert.rejects(session.run({ onProgress, signal: controller.signal }), { name: 'AbortError' });
  const reports = [];
  await session.run({ onProgress: (progress) => reports.push(progress) });
  checkReports(reports);
  session.close();
});

test('runs without masks, and trajectories without frames', async () => {
  const session = await createSession({ clip: { dense: false } });
  for (const frame of frames.slice(0, 10)) await session.push(frame);
  const reports = [];
  const options = { onProgress: (progress) => reports.push(progress) };
  await session.run(options);
  checkReports(reports);
  session.close();
  reports.length = 0;
  const tracks = await trajectories(frames.slice(0, 10), options);
  checkReports(reports);
  reports.length = 0;
  const trackSession = await createSession();
  await trackSession.setTrajectories({ ...tracks });
  await trackSession.run(options);
  assert.equal(reports.at(-1).share, 1);
  trackSession.close();
});

test('a clip of many windows has one share over all of them', async () => {
  for (const options of [
    { window: 5, overlap: 3 },
    { step: 2, window: 6 },
  ])
    checkReports(await reportsOf(frames, options));
  const cut = await framesOf({ ...SCENE, frames: 5, seed: 7 });
  checkReports(await reportsOf([...frames.slice(0, 8), ...cut], { window: 6 }));
});

test('the share of a source of unknown length begins when that is known', async () => {
  async function* generated() {
    yield* frames;
  }
  const reports = await reportsOf(generated(), { window: 8 });
  assert.ok(reports.every(({ frames, share }) => frames.total !== null || share === 0));
  checkReports(reports.filter(({ frames }) => frames.total !== null));
});

test('a source that ends early ends at 1 too, and each clip of a queue has its own share', async () => {
  const damaged = [...frames.slice(0, 12), new Uint8Array(9), ...frames.slice(0, 9)];
  checkReports(await reportsOf(damaged, { window: 8, onDamage() {} }));
  const reports = [[], []];
  const clips = ['a', 'b'].map((name) => ({ name, source: frames.slice(0, 8) }));
  for await (const { error } of segmentEach(clips, { onProgress: (p) => reports[p.index].push(p) }))
    assert.equal(error, null);
  reports.forEach((ofClip) => checkReports(ofClip));
});
