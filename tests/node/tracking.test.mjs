// Trajectories alone, trajectories from outside beside frames, and their file.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { synthClip } from 'tracecut';
import { fromTracksDat, tracksDat, trajectories } from 'tracecut/stages';
import { createRemoteEngine } from '../../dist/worker/remote.js';
import { SMALL, framesOf, open, ready, rejects, segment, standIn } from './support.mjs';

const SIZE = { width: SMALL.width, height: SMALL.height };

test("trajectories equal a session's, and no stage comes after them", async () => {
  const frames = await framesOf();
  const stages = new Map();
  const onProgress = ({ stage, done, total }) => stages.set(stage, done / total);
  const tracks = await trajectories(frames, { onProgress, frameRate: 10 });
  assert.deepEqual(
    [...stages],
    [
      ['flow', 1],
      ['trajectories', 1],
    ],
  );
  const { count, startFrame, offset, x, y, id } = (await segment(frames)).trajectories;
  assert.ok(count > 50);
  const { times, ...list } = tracks;
  assert.deepEqual(list, { count, startFrame, offset, x, y, id, numFrames: SMALL.frames, ...SIZE });
  assert.deepEqual(
    [...times],
    frames.map((_, t) => t / 10),
  );
});

test('they take the same input as videos, and report errors', async () => {
  const frames = await framesOf();
  const half = await trajectories(frames, { step: 2, size: 64, trajectory: { gridStep: 3 }, threads: 1 });
  assert.deepEqual([half.numFrames, half.width, half.height], [4, 64, 36]);
  await rejects(trajectories(frames.slice(0, 1)), 'too-few-frames');
  await rejects(trajectories([]), 'no-frames');
  await rejects(trajectories(frames, { gridStep: 3 }), 'param', /gridStep/);
  await rejects(trajectories(frames, { onProgress: 5 }), 'param', /onProgress/);
  const stop = new AbortController();
  const stopped = trajectories(frames, { signal: stop.signal, onProgress: () => stop.abort(new Error('enough')) });
  await assert.rejects(stopped, /enough/);
});

test('an engine in a worker tracks as one in this thread', async (t) => {
  const { readFile } = await import('node:fs/promises');
  const wasm = await WebAssembly.compile(await readFile(new URL('../../dist/tracecut_bg.wasm', import.meta.url)));
  const engine = await createRemoteEngine(() => standIn(), wasm, {});
  t.after(() => engine.close());
  const frames = await framesOf();
  for (const { data, width, height } of frames)
    await engine.request('push', { kind: 'pixels', data: new Uint8Array(data), width, height });
  const stages = new Set();
  const list = await engine.track(({ stage }) => stages.add(stage), new AbortController().signal);
  assert.deepEqual([...stages], ['flow', 'trajectories']);
  assert.deepEqual(list.x, (await trajectories(frames)).x);
});

test('trajectories from outside and frames give masks, in either order', async (t) => {
  const frames = await framesOf();
  const ours = await segment(frames);
  const input = { ...ours.trajectories, numFrames: SMALL.frames, ...SIZE };
  const after = await ready(t);
  await after.setTrajectories(input);
  const before = await open(t);
  await before.setTrajectories(input);
  for (const frame of frames) await before.push(frame);
  const [first, second] = [await after.run(), await before.run()];
  assert.deepEqual(first.trajectories.x, ours.trajectories.x);
  assert.ok(first.objects.length > 0 && first.saliency && first.components);
  let matching = 0;
  for (let k = 0; k < SMALL.frames; k += 1) {
    assert.deepEqual(first.labels(k), second.labels(k));
    const mask = ours.labels(k);
    matching += first.labels(k).filter((label, p) => label === mask[p]).length;
  }
  const share = matching / (SMALL.frames * SMALL.width * SMALL.height);
  assert.ok(share > 0.97, `${share} of the pixels are as with our own tracker`);
  assert.equal((await first.superpixels(0)).width, SMALL.width);
});

test('fewer of them, farther apart, give similar masks', async (t) => {
  const frames = await framesOf({ ...SMALL, seed: 3 });
  const result = await segment(frames);
  const ours = result.trajectories;
  const evenTracks = [...ours.startFrame.keys()].filter((i) => i % 2 === 0);
  const points = evenTracks.map((i) => [...ours.x.keys()].slice(ours.offset[i], ours.offset[i + 1]));
  const offset = [0];
  for (const trackPoints of points) offset.push(offset.at(-1) + trackPoints.length);
  const session = await ready(t, undefined, frames);
  await session.setTrajectories({
    numFrames: SMALL.frames,
    ...SIZE,
    startFrame: evenTracks.map((i) => ours.startFrame[i]),
    offset,
    x: points.flat().map((p) => ours.x[p]),
    y: points.flat().map((p) => ours.y[p]),
  });
  const fewer = await session.run();
  assert.equal(fewer.trajectories.count, evenTracks.length);
  assert.equal(fewer.objects.length, result.objects.length);
  const mask = result.labels(4);
  const matching = fewer.labels(4).filter((label, p) => label === mask[p]).length;
  assert.ok(matching > 0.95 * mask.length, `${matching} of ${mask.length} pixels`);
});

test('trajectories that do not fit the frames are refused, and others can be set', async (t) => {
  const session = await ready(t);
  const fitting = { numFrames: SMALL.frames, ...SIZE, startFrame: [0], offset: [0, 2], x: [4, 127.5], y: [4, 71.5] };
  await rejects(
    session.setTrajectories({ ...fitting, width: 64 }),
    'data',
    /64x72 pixels \(expected 128x72, as the frames\)/,
  );
  await session.setTrajectories({ ...fitting, x: [4, 128] });
  await rejects(session.run(), 'data', /x\[1\] = 128 \(expected a position in the frame, -0.5\.\.=127.5\)/);
  await session.setTrajectories({ ...fitting, numFrames: 5 });
  await rejects(session.run(), 'data', /trajectories of 5 frames \(expected 8/);
  await session.setTrajectories(fitting);
  assert.equal((await session.run()).trajectories.count, 1);
});

test('a track file is read as it was written', async () => {
  const clip = await synthClip(SMALL);
  const tracks = await trajectories(Array.from({ length: SMALL.frames }, (_, t) => clip.frame(t)));
  const label = Uint32Array.from({ length: tracks.count }, (_, i) => i % 3);
  const text = tracksDat({ ...tracks, label });
  const read = await fromTracksDat(text.replaceAll('\n', '\r\n'), SIZE);
  assert.deepEqual([read.numFrames, read.width, read.count], [SMALL.frames, SMALL.width, tracks.count]);
  assert.deepEqual([read.startFrame, read.offset, read.label], [tracks.startFrame, tracks.offset, label]);
  assert.ok(read.x.every((x, p) => Math.abs(x - tracks.x[p]) < 0.0006));
  assert.equal(tracksDat(read), text);
  const result = await segment(Array.from({ length: SMALL.frames }, (_, t) => clip.frame(t)));
  const parsed = await fromTracksDat(result.toTracksDat(), SIZE);
  assert.deepEqual(parsed.label, result.clusters.label);
});

test('a track file that is not one is an error that names the line', async () => {
  const broken = {
    '': /ends after line 0 \(expected the number of frames\)/,
    'x\n': /line 1 of the track file: "x"/,
    '3\n1\n0 1\n': /ends after line 3 \(expected x, y and frame of a point\)/,
    '3\n1\n0 1\n1 1 3\n': /line 4 of the track file: 3 \(expected a frame, 0\.\.=2\)/,
    '3\n1\n0 0\n': /line 3 of the track file: 0 \(expected a number of points, 1\.\.=3\)/,
    '3\n1\n0 2\n1 1 0\n1 1 2\n': /line 5 of the track file: 2 \(expected frame 1: tracks have no gaps\)/,
    '3\n1\n0 1\nNaN 1 0\n': /line 4 of the track file: "NaN"/,
    '3\n0\n0 1\n': /line 3 of the track file: "0 1" \(expected the end of the file\)/,
  };
  for (const [text, message] of Object.entries(broken))
    await assert.rejects(fromTracksDat(text, SIZE), { code: 'data', message }, JSON.stringify(text));
  await assert.rejects(fromTracksDat('3\n0\n', { width: 0, height: 4 }), { code: 'frame-size' });
  await assert.rejects(fromTracksDat('3\n0\n'), { code: 'param' });
});
