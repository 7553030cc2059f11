// Wrong arguments of public functions: unknown options, of which the error suggests one and lists all, and what drawing
// functions refuse. Pixels are tested in a browser (tests/browser/draw.spec.mjs).

import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import * as draw from 'tracecut/draw';
import * as edit from 'tracecut/edit';
import * as files from 'tracecut/export';
import * as node from 'tracecut/node';
import { selftest } from 'tracecut/selftest';
import * as stages from 'tracecut/stages';

const clip = await node.synthClip({ width: 64, height: 48, frames: 2 });
const frame = clip.frame(0);
const frames = [frame, clip.frame(1)];
const masks = { width: 64, height: 48, numFrames: 2, labels: (t) => clip.mask(t) };
const session = await node.createSession();
const engine = await stages.createImageEngine();
const editor = edit.editMasks(masks, { picture: (t) => clip.frame(t) });
const stroke = { t: 0, points: [1, 2], radius: 3 };
const region = edit.encodeRuns(clip.mask(0));
after(() => [session, engine, clip].forEach((open) => open.close()));

const context = new Proxy({}, { get: () => () => ({}) });
const grid = { width: 64, height: 48, scaleX: 1, scaleY: 1 };
const map = new Float32Array(64 * 48);

/** Takes the first item of a generator, which checks its options when it starts. */
const first = (generator) => generator.next();

/** A call of every public function that takes options, with these. */
const CALLS = {
  adjustMask: (o) => edit.adjustMask({ ...masks, labels: clip.mask(0) }, o),
  boundaries: (o) => stages.boundaries(frame, o),
  clipsZip: (o) => files.clipsZip([{ name: 'a', masks }], o),
  cocoRle: (o) => files.cocoRle(masks, o),
  configure: (o) => node.configure(o),
  createImageEngine: (o) => stages.createImageEngine(o),
  createSession: (o) => node.createSession(o),
  drawBoundaries: (o) => draw.drawBoundaries(context, { ...grid, pb: map, thin: map }, o),
  drawCells: (o) => draw.drawCells(context, trajectories, 0, { color: () => null, ...o }),
  drawCutout: (o) => draw.drawCutout(context, frame, { ...masks, alpha: clip.mask(0) }, o),
  drawDiscontinuities: (o) => draw.drawDiscontinuities(context, edges, 0, o),
  drawFlow: (o) => draw.drawFlow(context, clip.flow(0), o),
  drawLabels: (o) => node.drawLabels(context, masks, 0, o),
  drawSuperpixels: (o) => draw.drawSuperpixels(context, regions, o),
  drawTrajectories: (o) => draw.drawTrajectories(context, trajectories, 0, o),
  editMasks: (o) => edit.editMasks(masks, o),
  encodeImages: (o) => files.encodeImages(masks, frames, o),
  'encodeImages: sound': (o) => files.encodeImages(masks, frames, { sound: { source: new Blob(), ...o } }),
  encodeVideo: (o) => node.encodeVideo(masks, frames, o),
  enlargeMask: (o) => edit.enlargeMask({ ...masks, labels: clip.mask(0) }, frame, o),
  estimateVideoSize: (o) => files.estimateVideoSize({ width: 64, height: 48, numFrames: 2, ...o }),
  flow: (o) => stages.flow(frame, frame, o),
  framesOfRaw: (o) => first(node.framesOfRaw([], { width: 8, height: 8, format: 'gray', ...o })),
  framesOfVideo: (o) => first(node.framesOfVideo('none.mp4', o)),
  fromCocoRle: (o) => files.fromCocoRle({ size: [1, 1], counts: '1' }, o),
  imageDiscontinuities: (o) => stages.imageDiscontinuities(frame, o),
  'ImageEngine.superpixels': (o) => engine.superpixels(frame, o),
  labelMaps: (o) => files.labelMaps(masks, o),
  'MaskEditor.carry': (o) => editor.carry(editor.edits[0], o),
  'MaskEditor.interpolate': (o) => editor.interpolate({ from: 1, to: 2 }, o),
  'MaskEditor.paint': (o) => editor.paint({ label: 1, t: 0, region, ...o }),
  maskPng: (o) => node.maskPng(masks, 0, o),
  masksAtSize: (o) => edit.masksAtSize(masks, frames, o),
  masksZip: (o) => node.masksZip(masks, o),
  objectTable: (o) => files.objectTable(masks, o),
  objectTableCsv: (o) => files.objectTableCsv([], o),
  previewMasks: (o) => node.previewMasks(frames, o),
  prompts: (o) => files.prompts(masks, o),
  saveProject: (o) => edit.saveProject(masks, o),
  segmentEach: (o) => first(node.segmentEach([{ name: 'a', source: frames }], o)),
  segmentVideo: (o) => node.segmentVideo(frames, o),
  selftest: (o) => selftest(o),
  'Session.apart': (o) => session.apart([stroke, stroke], o),
  'Session.merge': (o) => session.merge(1, 2, o),
  'Session.run': (o) => session.run(o),
  'Session.split': (o) => session.split(1, undefined, o),
  'Session.together': (o) => session.together([stroke], o),
  'Session.undo': (o) => session.undo(o),
  smoothMasks: (o) => edit.smoothMasks(masks, { picture: () => frame, ...o }),
  superpixels: (o) => stages.superpixels(frame, o),
  synthClip: (o) => node.synthClip(o),
  trajectories: (o) => stages.trajectories(frames, o),
  videoFrames: (o) => node.videoFrames(frames, o),
  videoInfo: (o) => node.videoInfo(frames, o),
  videoStrip: (o) => first(node.videoStrip(frames, o)),
};

/** Public functions without an object of options. */
const WITHOUT = [
  'decodeRuns drawSaliency encodeRuns fitFrame fitSize flowColor fromTracksDat growRegions heatColor labelsNpy',
  'objectColor objectShape openProject parameters readFrames sceneMotion searchReport sortFiles soundInfo',
  'tracksDat',
]
  .join(' ')
  .split(' ');

const trajectories = {
  ...{ width: 64, height: 48, numFrames: 2 },
  trajectories: {
    count: 0,
    startFrame: new Uint32Array(0),
    offset: new Uint32Array(1),
    x: new Float32Array(0),
    y: new Float32Array(0),
    label: new Uint8Array(0),
  },
  clusters: { label: new Uint32Array(0) },
};
const edges = {
  ...trajectories,
  edges: () => ({ i: new Uint32Array(0), j: new Uint32Array(0), d: new Float32Array(0) }),
};
const regions = await engine.superpixels(frame);
await editor.paint({ label: 1, t: 0, region });

const isClass = (value) => /^class\b/.test(Function.prototype.toString.call(value));

test('every public function has a line in the table', () => {
  const exported = [node, draw, edit, files, stages].flatMap((entry) => Object.entries(entry));
  const names = new Set(exported.filter(([, v]) => typeof v === 'function' && !isClass(v)).map(([name]) => name));
  const listed = new Set([...Object.keys(CALLS).map((call) => call.split(':')[0]), ...WITHOUT]);
  const missing = [...names].filter((name) => !listed.has(name));
  assert.deepEqual(missing, []);
});

test('every public function refuses an unknown option, lists its own and suggests the one that is meant', async () => {
  for (const [name, call] of Object.entries(CALLS)) {
    const message = await messageOf(() => call({ qqqqqq: 1 }));
    const [, group = '', list] =
      /^(sound\.)?qqqqqq = 1 \(expected a known option; the options are (.*)\)$/.exec(message) ?? [];
    assert.ok(list, `${name}: ${message}`);
    const option = list
      .split(', ')
      .find((parameter) => /^\w{4,}$/.test(parameter.replace(group, '')))
      .replace(group, '');
    const misspelt = `${option}${option.at(-1)}`;
    assert.match(
      await messageOf(() => call({ [misspelt]: 5 })),
      new RegExp(`${misspelt} = 5 \\(expected a known option, such as ${group}${option};`),
      name,
    );
  }
});

test('parameters are suggested with their group, and only those of the call', async () => {
  for (const [options, words] of [
    [{ maxSide: 320 }, /^maxSide = 320 \(expected a known option, such as clip\.maxSide; the options are preset, /],
    [{ clp: {} }, /^clp = an Object \(expected a known option, such as clip;/],
    [
      { clip: { maxSid: 3 } },
      /^clip\.maxSid = 3 \(expected a known option, such as clip\.maxSide; the options are clip\./,
    ],
    [{ clip: 7 }, /^clip = 7 \(expected an object with maxSide, /],
  ])
    assert.match(await messageOf(() => node.createSession(options)), words);
  assert.equal(
    await messageOf(() => stages.superpixels(frame, { Size: 4 })),
    'Size = 4 (expected a known option; the options are count, wasm, decoder, worker, contour, superpixel)',
  );
});

test('a queue refuses the options that only a single video has', async () => {
  for (const name of ['onDamage', 'keep'])
    assert.match(await messageOf(() => CALLS.segmentEach({ [name]: true })), /it is an option of segmentVideo alone/);
});

/** Returns the message of the TraceCutError that a call throws or rejects with. */
async function messageOf(call) {
  try {
    await call();
  } catch (error) {
    assert.ok(error instanceof node.TraceCutError, String(error.stack));
    assert.equal(error.code, 'param');
    return error.message;
  }
  return assert.fail('nothing was refused');
}

const RESULT = {
  width: 40,
  height: 30,
  numFrames: 3,
  labels: () => new Uint8Array(40 * 30),
  trajectories: {
    count: 1,
    startFrame: Uint32Array.of(0),
    offset: Uint32Array.of(0, 3),
    x: Float32Array.of(5, 10, 15),
    y: Float32Array.of(12, 12, 12),
  },
  clusters: { count: 1, label: Uint32Array.of(1), object: Uint8Array.of(1) },
  edges: () => ({ i: new Uint32Array(), j: new Uint32Array(), d: new Float32Array() }),
};

const LABELLED = { ...RESULT, labels: () => new Uint8Array(1200).fill(1) };

/** A context that counts saved states; whatever is painted would be an error. */
function createContext() {
  const context = { numSaved: 0, canvas: { width: 40, height: 30 } };
  context.save = () => (context.numSaved += 1);
  context.restore = () => (context.numSaved -= 1);
  context.translate = () => {};
  context.drawImage = () => assert.fail('painted');
  return context;
}

/** Calls of drawing functions, by what follows the context, and the code and message of their errors. */
const DRAWING_CALLS = [
  [node.drawLabels, [RESULT, 3], /^param: t = 3 \(expected a whole number, 0\.\.=2\)/],
  [node.drawLabels, [RESULT, 0, { opacity: 2 }], /^param: opacity = 2 \(expected a number, 0\.\.=1\)/],
  [node.drawLabels, [LABELLED, 0, { colors: () => 'orange' }], /^param: colour = "orange" \(expected #rrggbb\)/],
  [node.drawLabels, [RESULT, 0, { fill: 1 }], /^param: fill = 1 \(expected a known option; the options are opacity/],
  [draw.drawTrajectories, [{}, 0], /^data: result = an Object/],
  [draw.drawTrajectories, [RESULT, 0, { tail: -1 }], /^param: tail = -1/],
  [draw.drawTrajectories, [RESULT, 0, { color: 3 }], /^param: color = 3/],
  [draw.drawDiscontinuities, [RESULT, 0, { threshold: 'high' }], /^param: threshold = "high"/],
  [draw.drawSuperpixels, [{}], /^data: superpixels = an Object/],
  [
    draw.drawSuperpixels,
    [{ label: [0], count: 1, width: 1, height: 1 }, { fill: 'mean' }],
    /^param: image = undefined/,
  ],
  [draw.drawBoundaries, [{ width: 1, height: 1, pb: new Float32Array(2) }], /^data: map = an Object/],
  [draw.drawCells, [RESULT, 0, {}], /^param: color = undefined/],
  [draw.fitFrame, [{ width: 0, height: 1 }], /^param: frame = an Object/],
];

test('wrong input is refused with its name, and the context keeps its state', () => {
  const context = createContext();
  const isRefused = (message) => (error) =>
    error.name === 'TraceCutError' && message.test(`${error.code}: ${error.message}`);
  for (const [call, input, message] of DRAWING_CALLS) {
    assert.throws(() => call(context, ...input), isRefused(message), String(message));
    assert.equal(context.numSaved, 0, String(message));
  }
  assert.throws(() => node.drawLabels(null, RESULT, 0), isRefused(/^param: context = null/));
});
