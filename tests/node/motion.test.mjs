// What a run finds of motion in a known scene: trajectories, also from outside, clusters, saliency and components.

import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import { createSession, parameters, synthClip } from 'tracecut';
import { fromTracksDat, tracksDat, trajectories } from 'tracecut/stages';
import { createRemoteEngine } from '../../dist/worker/remote.js';
import { abortAt, compileWasm, framesOf, open, ready, rejects, resultOf, segment, SMALL, standIn } from './support.mjs';

/** Large enough for components: the walker, the van and the balloon. */
const SCENE = { width: 256, height: 144, frames: 12, seed: 2 };
const clip = await synthClip(SCENE);
const session = await createSession();
for (let t = 0; t < SCENE.frames; t += 1) await session.push(clip.frame(t));
const result = await session.run();
const masks = Array.from({ length: SCENE.frames }, (_, t) => clip.mask(t));
after(() => session.close());

test('most trajectories of the scene carry the label of the object that they are on', () => {
  const { count, startFrame, offset, x, y } = result.trajectories;
  const votes = Array.from({ length: result.clusters.count }, () => new Map());
  for (let i = 0; i < count; i += 1) {
    const object = masks[startFrame[i]][Math.round(y[offset[i]]) * SCENE.width + Math.round(x[offset[i]])];
    const vote = votes[result.clusters.label[i]];
    vote.set(object, (vote.get(object) ?? 0) + 1);
  }
  const right = votes.reduce((sum, vote) => sum + Math.max(...vote.values()), 0);
  const objects = new Set(votes.map((vote) => [...vote].sort((a, b) => b[1] - a[1])[0][0]));
  assert.ok(right / count > 0.97, `${((100 * right) / count).toFixed(1)} % of ${count} trajectories`);
  assert.ok(objects.size === 4, `objects found: ${[...objects]}`);
});

test('masks cover the objects of the scene', () => {
  const both = Array.from({ length: clip.numObjects + 1 }, () => new Array(result.objects.length + 1).fill(0));
  for (let t = 0; t < SCENE.frames; t += 1) {
    const [truth, mask] = [masks[t], result.labels(t)];
    for (let p = 0; p < truth.length; p += 1) both[truth[p]][mask[p]] += 1;
  }
  const sum = (list) => list.reduce((a, b) => a + b, 0);
  const overlap = both.map((row, object) => {
    const unions = row.map((intersection, label) => sum(row) + sum(both.map((counts) => counts[label])) - intersection);
    return Math.max(
      ...row.map((intersection, label) => ((label === 0) === (object === 0) ? intersection / unions[label] : 0)),
    );
  });
  assert.ok(Math.min(...overlap) > 0.7, `intersection over union: ${overlap.map((v) => v.toFixed(3))}`);
});

test('saliency has an entry for each trajectory, and the foreground is above the threshold', async () => {
  const { trajectories, saliency } = await resultOf();
  const { ofPoints, inContext, foreground } = saliency;
  assert.deepEqual([ofPoints.length, inContext.length, foreground.length], new Array(3).fill(trajectories.count));
  assert.ok([ofPoints, inContext].every((table) => table.every((s) => s >= 0 && s <= 1)));
  const threshold = parameters().find(({ name }) => name === 'saliency.threshold').default;
  foreground.forEach((f, i) => assert.equal(f, Number(inContext[i] > threshold), `trajectory ${i} of ${inContext[i]}`));
});

test('what moves in the scene is salient and foreground, what the camera pans over is not', async () => {
  const { trajectories, saliency } = result;
  const { count, startFrame, offset, x, y } = trajectories;
  // Where a trajectory is in the middle of its life tells whose it is.
  const objects = Array.from({ length: count }, (_, i) => {
    const p = Math.floor((offset[i] + offset[i + 1]) / 2);
    return masks[startFrame[i] + p - offset[i]][Math.round(y[p]) * SCENE.width + Math.round(x[p])];
  });
  for (let object = 0; object <= clip.numObjects; object += 1) {
    const members = [...objects.keys()].filter((i) => objects[i] === object);
    const mean = (table) => members.reduce((sum, i) => sum + table[i], 0) / members.length;
    const facts = `object ${object}: ${members.length}, s ${mean(saliency.ofPoints)}, in context ${mean(saliency.inContext)}, foreground ${mean(saliency.foreground)}`;
    assert.ok(members.length >= 10, facts);
    if (object === 0) assert.ok(mean(saliency.foreground) < 0.05 && mean(saliency.inContext) < 0.45, facts);
    else assert.ok(mean(saliency.foreground) > 0.9 && mean(saliency.inContext) > 0.7, facts);
  }
  const { saliency: map, width } = await result.saliencyMap(8);
  const sums = [0, 0, 0, 0];
  masks[8].forEach((object, p) => {
    sums[object > 0 ? 0 : 1] += map[Math.floor(p / SCENE.width) * width + (p % SCENE.width)];
    sums[object > 0 ? 2 : 3] += 1;
  });
  assert.ok(
    sums[0] / sums[2] > 0.8 && sums[1] / sums[3] < 0.5,
    `objects ${sums[0] / sums[2]}, background ${sums[1] / sums[3]}`,
  );
});

test('a clip in which nothing moves has no foreground and no components', async () => {
  const [frame] = await framesOf();
  const { saliency, components } = await segment(new Array(5).fill(frame));
  assert.ok(saliency.foreground.every((f) => f === 0));
  assert.ok(components.count.every((n) => n === 0) && components.ofPoint.every((c) => c === -1));
});

test('components lie in the foreground, numbered in each frame', () => {
  const { trajectories, saliency, components } = result;
  const { count, startFrame, offset, x } = trajectories;
  assert.deepEqual([components.count.length, components.ofPoint.length], [SCENE.frames, x.length]);
  assert.ok(Math.min(...components.count) >= 2, `components: ${components.count}`);
  const componentObjects = Array.from(components.count, () => new Set());
  for (let i = 0; i < count; i += 1) {
    for (let p = offset[i]; p < offset[i + 1]; p += 1) {
      const component = components.ofPoint[p];
      if (component < 0) {
        assert.equal(component, -1);
        continue;
      }
      assert.equal(saliency.foreground[i], 1, `component ${component} of a background trajectory`);
      componentObjects[startFrame[i] + p - offset[i]].add(component);
    }
  }
  componentObjects.forEach((numbers, t) => {
    const expected = new Set(Array.from({ length: components.count[t] }, (_, k) => k));
    assert.deepEqual(numbers, expected);
  });
});

test('saliency maps have a value for each pixel, for the last frame too', async (t) => {
  const session = await ready(t, { clip: { maxSide: 48 } });
  await rejects(session.saliencyMap(0), 'state', /saliency map of frame 0/);
  const result = await session.run();
  for (const frame of [0, SMALL.frames - 1]) {
    const map = await result.saliencyMap(frame);
    assert.deepEqual([map.width, map.height, map.scaleX, map.scaleY], [48, 27, 2, 2]);
    assert.equal(map.saliency.length, 48 * 27);
    assert.ok(map.saliency.every((s) => s >= 0 && s <= 1));
    assert.deepEqual(await session.saliencyMap(frame), map);
  }
  await rejects(result.saliencyMap(SMALL.frames), 'param', /t = 8/);
  session.close();
  await rejects(result.saliencyMap(0), 'closed', /saliency maps of a result come from its session/);
});

test('choices are options by name; others are refused with the names that there are', async (t) => {
  const mode = parameters().find(({ name }) => name === 'connectedness.mode');
  assert.equal(mode.kind, 'choice');
  assert.ok(mode.choices.includes(mode.default));
  for (const choice of mode.choices) await open(t, { connectedness: { mode: choice } });
  const legal = new RegExp(`connectedness\\.mode = .* \\(expected one of ${mode.choices.join(', ')}\\)`);
  for (const wrong of ['sometimes', 'Paper', '', 1, true])
    await rejects(open(t, { connectedness: { mode: wrong } }), 'param', legal);
  const message = /connectedness\.mode = a list of 1 \(expected .* or a name\)/;
  await rejects(open(t, { connectedness: { mode: ['paper'] } }), 'param', message);
});

const SIZE = { width: SMALL.width, height: SMALL.height };

test("trajectories equal a session's, and no stage comes after them", async () => {
  const frames = await framesOf();
  const stages = new Map();
  const onProgress = ({ stage, done, total }) => stages.set(stage, done / total);
  const tracks = await trajectories(frames, { onProgress, frameRate: 10 });
  assert.deepEqual([...stages].flat(), ['flow', 1, 'trajectories', 1]);
  const { count, startFrame, offset, x, y, id } = (await resultOf()).trajectories;
  assert.ok(count > 50);
  const { times, ...list } = tracks;
  assert.deepEqual(list, { count, startFrame, offset, x, y, id, numFrames: SMALL.frames, ...SIZE });
  assert.deepEqual(
    times,
    Float64Array.from(frames, (_, t) => t / 10),
  );
});

test('they take the same input as videos, and report errors', async () => {
  const frames = await framesOf();
  const half = await trajectories(frames, { step: 2, size: 48, trajectory: { gridStep: 3 }, threads: 1 });
  assert.deepEqual([half.numFrames, half.width, half.height], [4, 48, 27]);
  await rejects(trajectories(frames.slice(0, 1)), 'too-few-frames');
  await rejects(trajectories([]), 'no-frames');
  await rejects(trajectories(frames, { gridStep: 3 }), 'param', /gridStep/);
  await rejects(trajectories(frames, { onProgress: 5 }), 'param', /onProgress/);
  await assert.rejects(trajectories(frames, abortAt({ reason: new Error('enough') })), /enough/);
});

test('an engine in a worker tracks as one in this thread', async (t) => {
  const engine = await createRemoteEngine(() => standIn(), await compileWasm(), {});
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
  const ours = await resultOf();
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
  const scene = { ...SMALL, seed: 3 };
  const [frames, result] = [await framesOf(scene), await resultOf(scene)];
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
  const fitting = { numFrames: SMALL.frames, ...SIZE, startFrame: [0], offset: [0, 2], x: [4, 95.5], y: [4, 53.5] };
  await rejects(
    session.setTrajectories({ ...fitting, width: 64 }),
    'data',
    /64x54 pixels \(expected 96x54, as the frames\)/,
  );
  await session.setTrajectories({ ...fitting, x: [4, 96] });
  await rejects(session.run(), 'data', /x\[1\] = 96 \(expected a position in the frame, -0.5\.\.=95.5\)/);
  await session.setTrajectories({ ...fitting, numFrames: 5 });
  await rejects(session.run(), 'data', /trajectories of 5 frames \(expected 8/);
  await session.setTrajectories(fitting);
  assert.equal((await session.run()).trajectories.count, 1);
});

test('a track file is read as it was written', async () => {
  const tracks = await trajectories(await framesOf());
  const label = Uint32Array.from({ length: tracks.count }, (_, i) => i % 3);
  const text = tracksDat({ ...tracks, label });
  const read = await fromTracksDat(text.replaceAll('\n', '\r\n'), SIZE);
  assert.deepEqual([read.numFrames, read.width, read.count], [SMALL.frames, SMALL.width, tracks.count]);
  assert.deepEqual([read.startFrame, read.offset, read.label], [tracks.startFrame, tracks.offset, label]);
  assert.ok(read.x.every((x, p) => Math.abs(x - tracks.x[p]) < 0.0006));
  assert.equal(tracksDat(read), text);
  const result = await resultOf();
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
