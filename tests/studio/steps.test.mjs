// Steps of corrections in the studio: which are possible, joins and what they show, status texts, proposals to join, places to check, and
// moving through the frames.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { synthClip } from 'tracecut';
import { applyStep, possibleSteps } from '../../build/model/correction-steps.js';
import { describeMotion } from '../../build/model/describe.js';
import {
  acceptDoubt,
  describeDoubts,
  describeObstacle,
  doubtAt,
  repairDoubt,
  showNextDoubt,
} from '../../build/model/doubts.js';
import { JoinProposals, findSimilarObjects } from '../../build/model/join-proposals.js';
import { jumpTo, Playback, stepFrames, togglePlaying } from '../../build/model/playback.js';
import { Presence, Times } from '../../build/model/presence.js';
import { showCorrected } from '../../build/model/show-result.js';
import { Store } from '../../build/model/store.js';
import { movingFrames } from '../moving.mjs';
import { maskAt, masksOf, openModel, openSampleWork, pixelsOf, SAMPLE, show, strokeOn } from './studio.mjs';

test('a step says how long it took, that it was undone, or why it is not possible', async () => {
  const { store, selection, corrections } = await openSampleWork();
  const before = masksOf(store);
  const background = pixelsOf(store, 12, 0).length;
  const joinedArea = pixelsOf(store, 12, 1).length + pixelsOf(store, 12, 2).length;
  store.set({ frame: 12 });
  const step = await applyStep(store, () => selection.join(1, [2]));
  assert.match(step.text, /^Corrected in \d+\.\d\ss\. 2 moving objects\.$/);
  assert.equal(step.isError, false);
  assert.deepEqual([pixelsOf(store, 12, 0).length, pixelsOf(store, 12, 1).length], [background, joinedArea]);
  assert.deepEqual([store.state.frame, store.state.headline], [12, '2 moving objects']);
  const undo = await applyStep(store, () => selection.undo(), 'Undone');
  assert.equal(undo.text, 'Undone. 3 moving objects.');
  assert.equal(masksOf(store), before);

  // A saved project splits at a place only.
  const refused = await applyStep(store, () => corrections.split(2));
  assert.deepEqual(refused, { text: 'Not possible here: No part selected.', isError: true });
  assert.equal(masksOf(store), before);
  assert.equal(corrections.undoCount(), 0);

  const otherClip = await applyStep(store, async () => {
    store.set({ visit: store.state.visit + 1 });
    return null;
  });
  assert.equal(otherClip, null);
});

test('steps are possible where they change something', () => {
  const corrector = { splitsAtPlace: true, undoCount: () => 0, redoCount: () => 1 };
  const choice = { object: 2, target: 1, hasPlace: false, tool: 'pick', numStrokes: 0 };
  const possible = (changes, { hasPrevious = false, ...others } = {}) => {
    const steps = possibleSteps({ ...corrector, ...others }, { ...choice, ...changes }, hasPrevious);
    return Object.keys(steps).filter((name) => steps[name]);
  };
  assert.deepEqual(possible({}), ['join', 'makeBackground', 'redo']);
  assert.deepEqual(possible({ target: 0 }), ['makeBackground', 'redo']);
  assert.deepEqual(possible({ hasPlace: true }), ['join', 'makeBackground', 'split', 'redo']);
  // With a session an object is split anywhere, and the background at a place.
  const session = { splitsAtPlace: false };
  assert.deepEqual(possible({}, session), ['join', 'makeBackground', 'split', 'redo']);
  assert.deepEqual(possible({ object: 0 }, session), ['redo']);
  assert.deepEqual(possible({ object: 0, hasPlace: true }, session), ['split', 'redo']);
  assert.deepEqual(possible({ object: 0, hasPlace: true }), ['redo']);
  assert.deepEqual(possible({ object: 0, tool: 'together', numStrokes: 1 }), ['applyStrokes', 'clearStrokes', 'redo']);
  assert.deepEqual(possible({ object: 0, tool: 'apart', numStrokes: 1 }), ['clearStrokes', 'redo']);
  assert.deepEqual(possible({ object: 0, tool: 'apart', numStrokes: 2 }), ['applyStrokes', 'clearStrokes', 'redo']);
  assert.deepEqual(possible({ object: 0 }, { undoCount: () => 2 }), ['undo', 'redo']);
  assert.deepEqual(possible({ object: 0 }, { hasPrevious: true, redoCount: () => 0 }), ['undo']);
});

test('a join keeps the object if a part was kept, also by strokes, and undo hides what was hidden before', async () => {
  const { store, selection } = await openSampleWork();
  const hidden = () => [...store.state.hidden].sort();
  const joinStrokes = () => selection.joinStrokes([1, 2].map((object) => strokeOn(store, 6, object)));
  for (const join of [() => selection.join(1, [2]), joinStrokes]) {
    store.set({ hidden: new Set([2, 3]) });
    await show(store, join());
    assert.deepEqual(hidden(), [3]);
    // What the user hides meanwhile stays.
    store.set({ hidden: new Set() });
    await show(store, selection.undo());
    assert.deepEqual(hidden(), [2]);
    await show(store, selection.redo());
    assert.deepEqual(hidden(), []);
    await show(store, selection.undo());
    store.set({ hidden: new Set([1, 2]) });
    await show(store, join());
    assert.deepEqual(hidden(), [1, 2].slice(0, hidden().length));
    assert.ok(hidden().includes(1));
    await show(store, selection.undo());
    assert.deepEqual(hidden(), [1, 2]);
  }
  store.set({ hidden: new Set([3]) });
  await show(store, selection.join(0, [3]));
  assert.equal(maskAt(store, 6).includes(3), false);
  await show(store, selection.undo());
  assert.deepEqual(hidden(), [3], 'also the highest label, which was gone');
  await show(store, selection.undo());
  assert.deepEqual(hidden(), [3], 'nothing is left to undo');
});

test('objects are selected to be joined, the one shown alone first', async () => {
  const { store, selection } = await openSampleWork();
  const selected = () => [...store.state.selected];
  selection.toggleSelected(0);
  assert.deepEqual(selected(), []);
  selection.isolate(3);
  assert.deepEqual([...store.state.hidden], [0, 1, 2]);
  selection.toggleSelected(2);
  assert.deepEqual(selected(), [3, 2]);
  selection.toggleSelected(3);
  assert.deepEqual(selected(), [2]);
  selection.isolate(3);
  assert.equal(store.state.hidden.size, 0);
  await show(store, selection.join(1, [2]));
  assert.deepEqual(selected(), [], 'a correction ends the selection');
});

/** A clip of 8 × 8 pixels with square objects, each in a span of frames and at a column. */
function clipOf(objects, cuts = []) {
  const numFrames = 6;
  const labels = (t) => {
    const mask = new Uint8Array(64);
    for (const { object, first, last, x } of objects)
      if (first <= t && t <= last) for (let p = 0; p < 16; p += 1) mask[8 * (2 + (p >> 2)) + x + (p & 3)] = object;
    return mask;
  };
  const trajectories = { count: 0, startFrame: [], offset: [0], x: [], y: [] };
  const scene = { x: new Float32Array(numFrames + 1), y: new Float32Array(numFrames + 1) };
  return { width: 8, height: 8, numFrames, labels, trajectories, scene, spans: objects, cuts };
}

const PIECES = [
  { object: 1, first: 0, last: 1, x: 0 },
  { object: 2, first: 2, last: 3, x: 1 },
  { object: 3, first: 4, last: 5, x: 1 },
];

test('objects look like one if each begins where and when another ends', () => {
  const similar = (...clip) => findSimilarObjects(clipOf(...clip)).map((group) => group.sort());
  assert.deepEqual(similar(PIECES), [[1, 2, 3]]);
  assert.deepEqual(similar(PIECES, [2]), [[2, 3]], 'not across a cut');
  assert.deepEqual(similar(PIECES.map((piece) => ({ ...piece, x: 2 * piece.object - 2 }))), [], 'not elsewhere');
  assert.deepEqual(similar([PIECES[0], { ...PIECES[1], first: 3 }]), [], 'not after a gap');
});

test('a dismissed proposal does not come back until another clip is open', (t) => {
  t.mock.timers.enable({ apis: ['setTimeout'] });
  const { scene, spans, ...result } = clipOf(PIECES);
  const store = new Store();
  let searches = 0;
  const proposals = new JoinProposals(store, () => (searches += 1));
  const showClip = (patch) => {
    const segmentation = { result, scene, mask: result.labels };
    const analysis = { segmentation, facts: spans, frameData: {} };
    store.set({ phase: 'done', analysis, job: { corrector: {} }, ...patch });
    t.mock.timers.tick(1000);
  };
  showClip({});
  assert.deepEqual(proposals.current, [1, 2, 3]);
  proposals.dismiss();
  assert.equal(proposals.current, undefined);
  showClip({});
  assert.deepEqual([proposals.current, searches], [undefined, 2]);
  showClip({ visit: 1 });
  assert.deepEqual(proposals.current, [1, 2, 3]);
  showClip({ phase: 'running' });
  showClip({ job: { corrector: null } });
  assert.deepEqual([proposals.current, searches], [undefined, 3]);
});

test('frames are stepped through, looping or up to the ends', () => {
  const store = new Store();
  store.set({ timeline: { ...store.state.timeline, numFrames: 4 } });
  const visit = (...acts) =>
    acts.map((act) => {
      act();
      return store.state.frame;
    });
  const [back, forward] = [() => stepFrames(store, -1), () => stepFrames(store, 1)];
  assert.deepEqual(
    visit(forward, back, back, forward, () => jumpTo(store, 9)),
    [1, 0, 3, 0, 3],
  );
  store.set({ loop: false });
  assert.deepEqual(
    visit(forward, () => jumpTo(store, -2), back),
    [3, 0, 0],
  );

  togglePlaying(store);
  assert.equal(store.state.isPlaying, true);
  forward();
  assert.deepEqual([store.state.isPlaying, store.state.frame], [false, 1]);
  jumpTo(store, 3);
  togglePlaying(store);
  assert.deepEqual([store.state.isPlaying, store.state.frame], [true, 0], 'from the start again');
  togglePlaying(store);
  assert.equal(store.state.isPlaying, false);
  store.set({ timeline: { ...store.state.timeline, numFrames: 1 } });
  togglePlaying(store);
  assert.equal(store.state.isPlaying, false, 'one frame is not played');
});

test('a clip plays at the times of its frames, and does not catch up after a pause of the page', () => {
  const store = new Store();
  const times = new Times([0, 0.1, 0.4, 0.5], 0.6);
  store.set({ timeline: { ...store.state.timeline, numFrames: 4, times }, isPlaying: true });
  const playback = new Playback(store);
  const pass = (seconds) => {
    playback.pass(seconds);
    return store.state.frame;
  };
  assert.deepEqual([0.06, 0.06, 0.2, 0.1, 0.1, 0.11].map(pass), [0, 1, 1, 2, 3, 0]);
  // One second is five thirds of the clip; ten are no more.
  const long = new Playback(store);
  store.set({ frame: 0 });
  long.pass(10);
  const { frame } = store.state;
  store.set({ frame: 0 });
  new Playback(store).pass(1);
  assert.equal(frame, store.state.frame);
  store.set({ frame: 2, loop: false });
  new Playback(store).pass(0.25);
  assert.deepEqual([store.state.frame, store.state.isPlaying], [3, false]);
});

test('motions of objects are relative to the scene, whose motion is estimated', async () => {
  const { store } = await openSampleWork();
  const { scene } = store.state.analysis.segmentation;
  const clip = await synthClip(SAMPLE);
  const motions = sceneMotions(clip);
  const presence = new Presence(clip);
  for (let t = 0; t < clip.numFrames; t += 1) presence.addMask(clip.mask(t));
  for (let object = 1; object <= clip.numObjects; object += 1) {
    const facts = presence.facts(object, scene);
    assert.ok(Math.abs(facts.motion.x - motions[object]) < 0.04, `object ${object}: ${facts.motion.x}`);
    if (Math.abs(motions[object]) > 0.08) assert.match(describeMotion(facts), motions[object] > 0 ? /right/ : /left/);
  }
  clip.close();
});

/** Returns how far each object of a synthetic clip moves to the right against the scene, as a share of the width. */
function sceneMotions(clip) {
  const { width, numFrames, numObjects } = clip;
  const centres = (t) => {
    const mask = clip.mask(t);
    return Array.from({ length: numObjects + 1 }, (_, object) => {
      const columns = [...mask.keys()].filter((p) => mask[p] === object).map((p) => p % width);
      return columns.reduce((sum, x) => sum + x, 0) / columns.length;
    });
  };
  let scene = 0;
  for (let t = 0; t + 1 < numFrames; t += 1) {
    const [{ u }, mask] = [clip.flow(t), clip.mask(t)];
    const steps = [...u].filter((_, p) => mask[p] === 0 && p % 11 === 0).sort((a, b) => a - b);
    scene += steps[steps.length >> 1];
  }
  const [from, to] = [centres(0), centres(numFrames - 1)];
  return from.map((x, object) => (to[object] - x - scene) / width);
}

const DOUBTS = [
  { from: 0, to: 3 },
  { from: 8, to: 12 },
];

test('places to check are shown one after the other; accepted ones come back only with another run', async () => {
  const { app, store } = await openModel(movingFrames(16, [64, 48]));
  await app.openSample();
  const { job, timeline } = store.state;
  assert.equal(store.state.agreement.length, timeline.numFrames);
  assert.deepEqual(store.state.agreement, (await job.outputs.agreement()).frames);
  assert.deepEqual(store.state.doubts, job.result.doubts);
  Object.defineProperty(job.result, 'doubts', { value: DOUBTS });
  job.agreement = null;
  showCorrected(store);
  assert.equal(store.state.agreement, null);
  assert.deepEqual(store.state.doubts, DOUBTS);
  const visited = Array.from({ length: 3 }, () => {
    showNextDoubt(store);
    return store.state.frame;
  });
  assert.deepEqual(visited, [9, 1, 9]);
  assert.equal(doubtAt(store.state), 1);
  acceptDoubt(store);
  assert.deepEqual([store.state.doubts, store.state.frame], [[DOUBTS[0]], 1]);
  showCorrected(store);
  assert.deepEqual(store.state.doubts, [DOUBTS[0]]);
  // Nothing is accepted on a frame outside of the places.
  store.set({ frame: 7 });
  acceptDoubt(store);
  assert.deepEqual([store.state.doubts, store.state.frame], [[DOUBTS[0]], 7]);
  store.set({ frame: 2 });
  acceptDoubt(store);
  showNextDoubt(store);
  assert.deepEqual([store.state.doubts, doubtAt(store.state)], [[], -1]);

  await app.rerun();
  assert.deepEqual([store.state.fine, store.state.doubts], [new Set(), store.state.job.result.doubts]);
});

test('a place is repaired from its neighbours, or from there to the end of the shot, and is accepted', async () => {
  const { store } = await openSampleWork();
  const { job } = store.state;
  const { openEditor } = job.corrections;
  Object.defineProperty(job.result, 'doubts', { value: [DOUBTS[1], { from: 13, to: 14 }] });
  showCorrected(store);
  const requests = [];
  // Paints in the first frame instead of interpolating.
  openEditor.interpolate = async (range, { sides, onFrame }) => {
    requests.push({ ...range, sides });
    onFrame({ t: range.from });
    return openEditor.paint({ label: 7, stroke: { t: range.from, points: [20, 20], radius: 5 } });
  };
  store.set({ frame: 9, timeline: { ...store.state.timeline, cuts: [6, 14] } });
  let frames = 0;
  const options = { signal: new AbortController().signal, onFrame: () => (frames += 1) };
  const repaired = { from: 8, to: 9 };
  assert.deepEqual(await repairDoubt(store, DOUBTS[1], 'both', options), repaired, 'only the frames that changed');
  assert.deepEqual([store.state.doubts, store.state.fine], [[{ from: 13, to: 14 }], new Set([8])]);
  assert.equal(store.state.frame, 9, 'the repaired frames stay on screen');
  assert.ok(maskAt(store, 8).includes(7));
  assert.deepEqual(await repairDoubt(store, { from: 8, to: 12 }, 'before', options), repaired);
  assert.deepEqual(requests, [
    { from: 8, to: 12, sides: 'both' },
    { from: 8, to: 14, sides: 'before' },
  ]);
  assert.equal(frames, 2);
  assert.equal(job.corrections.undoCount(), 2);

  // Another clip is not touched.
  openEditor.interpolate = async () => {
    store.set({ visit: store.state.visit + 1 });
    return openEditor.paint({ label: 7, stroke: { t: 13, points: [20, 20], radius: 5 } });
  };
  assert.equal(await repairDoubt(store, { from: 13, to: 14 }, 'both', options), null);
  assert.equal(store.state.doubts.length, 1);
});

test('texts count the places, and say why one cannot be repaired', () => {
  assert.deepEqual([0, 1, 4].map(describeDoubts), ['', '1 place to check', '4 places to check']);
  const timeline = { numFrames: 16, cuts: [6] };
  const obstacles = (from, to) =>
    ['both', 'before'].map((repair) => describeObstacle({ timeline }, { from, to }, repair));
  assert.deepEqual(obstacles(2, 4), ['', '']);
  assert.deepEqual(obstacles(0, 4), Array(2).fill('There is no frame before these.'));
  assert.deepEqual(obstacles(6, 8), Array(2).fill('There is a cut before these frames.'));
  assert.deepEqual(obstacles(4, 6), ['There is a cut after these frames.', '']);
  assert.deepEqual(obstacles(12, 16), ['There is no frame after these.', '']);
});
