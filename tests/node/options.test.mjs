// Options of every public function: an unknown name is an error that suggests one of the same call and lists all of them.

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

/** Calls with options, a misspelt option, and the option that is meant; null if the options resemble nothing. */
const CALLS = {
  adjustMask: [(o) => edit.adjustMask({ ...masks, labels: clip.mask(0) }, o), 'fether', 'feather'],
  boundaries: [(o) => stages.boundaries(frame, o), 'countour', 'contour'],
  clipsZip: [(o) => files.clipsZip([{ name: 'a', masks }], o), 'onprogress', 'onProgress'],
  cocoRle: [(o) => files.cocoRle(masks, o), 'Objects', 'objects'],
  configure: [(o) => node.configure(o), 'wams', 'wasm'],
  createImageEngine: [(o) => stages.createImageEngine(o), 'wroker', 'worker'],
  createSession: [(o) => node.createSession(o), 'wroker', 'worker'],
  drawBoundaries: [(o) => draw.drawBoundaries(context, { ...grid, pb: map, thin: map }, o), 'whit', 'white'],
  drawCells: [(o) => draw.drawCells(context, trajectories, 0, { color: () => null, ...o }), 'raech', 'reach'],
  drawCutout: [(o) => draw.drawCutout(context, frame, { ...masks, alpha: clip.mask(0) }, o), 'backgroud', 'background'],
  drawDiscontinuities: [(o) => draw.drawDiscontinuities(context, edges, 0, o), 'treshold', 'threshold'],
  drawFlow: [(o) => draw.drawFlow(context, clip.flow(0), o), 'scal', 'scale'],
  drawLabels: [
    (o) => draw.drawLabels?.(context, masks, 0, o) ?? node.drawLabels(context, masks, 0, o),
    'opactiy',
    'opacity',
  ],
  drawSuperpixels: [(o) => draw.drawSuperpixels(context, regions, o), 'imgae', 'image'],
  drawTrajectories: [(o) => draw.drawTrajectories(context, trajectories, 0, o), 'tial', 'tail'],
  editMasks: [(o) => edit.editMasks(masks, o), 'sesion', 'session'],
  encodeImages: [(o) => files.encodeImages(masks, frames, o), 'Format', 'format'],
  'encodeImages: sound': [
    (o) => files.encodeImages(masks, frames, { sound: { source: new Blob(), ...o } }),
    'strat',
    'sound.start',
  ],
  encodeVideo: [(o) => node.encodeVideo(masks, frames, o), 'qualty', 'quality'],
  enlargeMask: [(o) => edit.enlargeMask({ ...masks, labels: clip.mask(0) }, frame, o), 'decodr', 'decoder'],
  estimateVideoSize: [
    (o) => files.estimateVideoSize({ width: 64, height: 48, numFrames: 2, ...o }),
    'qualty',
    'quality',
  ],
  flow: [(o) => stages.flow(frame, frame, o), 'flwo', 'flow'],
  framesOfRaw: [
    (o) => first(node.framesOfRaw([], { width: 8, height: 8, format: 'gray', ...o })),
    'framerate',
    'frameRate',
  ],
  framesOfVideo: [(o) => first(node.framesOfVideo('none.mp4', o)), 'ffmpge', 'ffmpeg'],
  fromCocoRle: [(o) => files.fromCocoRle({ size: [1, 1], counts: '1' }, o), 'decodr', 'decoder'],
  imageDiscontinuities: [(o) => stages.imageDiscontinuities(frame, o), 'stil', 'still'],
  'ImageEngine.superpixels': [(o) => engine.superpixels(frame, o), 'cuont', 'count'],
  labelMaps: [(o) => files.labelMaps(masks, o), 'framerate', 'frameRate'],
  'MaskEditor.carry': [(o) => editor.carry(editor.edits[0], o), 'lsat', 'last'],
  'MaskEditor.interpolate': [(o) => editor.interpolate({ from: 1, to: 2 }, o), 'side', 'sides'],
  'MaskEditor.paint': [(o) => editor.paint({ label: 1, t: 0, region, ...o }), 'labl', 'label'],
  maskPng: [(o) => node.maskPng(masks, 0, o), 'objects', 'object'],
  masksAtSize: [(o) => edit.masksAtSize(masks, frames, o), 'edge', 'edges'],
  masksZip: [(o) => node.masksZip(masks, o), 'perobject', 'perObject'],
  objectTable: [(o) => files.objectTable(masks, o), 'trajectory', 'trajectories'],
  objectTableCsv: [(o) => files.objectTableCsv([], o), 'decodr', 'decoder'],
  previewMasks: [(o) => node.previewMasks(frames, o), 'sise', 'size'],
  prompts: [(o) => files.prompts(masks, o), 'object', 'objects'],
  saveProject: [(o) => edit.saveProject(masks, o), 'file', 'files'],
  segmentEach: [(o) => first(node.segmentEach([{ name: 'a', source: frames }], o)), 'windw', 'window'],
  segmentVideo: [(o) => node.segmentVideo(frames, o), 'Size', 'size'],
  selftest: [(o) => selftest(o), 'oncheck', 'onCheck'],
  'Session.apart': [(o) => session.apart([stroke, stroke], o), 'sginal', 'signal'],
  'Session.merge': [(o) => session.merge(1, 2, o), 'sginal', 'signal'],
  'Session.run': [(o) => session.run(o), 'onprogress', 'onProgress'],
  'Session.split': [(o) => session.split(1, undefined, o), 'sginal', 'signal'],
  'Session.together': [(o) => session.together([stroke], o), 'sginal', 'signal'],
  'Session.undo': [(o) => session.undo(o), 'sginal', 'signal'],
  smoothMasks: [(o) => edit.smoothMasks(masks, { picture: () => frame, ...o }), 'raech', 'reach'],
  superpixels: [(o) => stages.superpixels(frame, o), 'cuont', 'count'],
  synthClip: [(o) => node.synthClip(o), 'widht', 'width'],
  trajectories: [(o) => stages.trajectories(frames, o), 'maxframes', 'maxFrames'],
  videoFrames: [(o) => node.videoFrames(frames, o), 'sise', 'size'],
  videoInfo: [(o) => node.videoInfo(frames, o), 'ondamage', 'onDamage'],
  videoStrip: [(o) => first(node.videoStrip(frames, o)), 'cuont', 'count'],
};

/** Public functions without an object of options. */
const WITHOUT = [
  'decodeRuns',
  'drawSaliency',
  'encodeRuns',
  'fitFrame',
  'fitSize',
  'flowColor',
  'fromTracksDat',
  'growRegions',
  'heatColor',
  'labelsNpy',
  'objectColor',
  'objectShape',
  'openProject',
  'parameters',
  'readFrames',
  'sceneMotion',
  'searchReport',
  'sortFiles',
  'soundInfo',
  'tracksDat',
];

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
  assert.deepEqual(
    [...names].filter((name) => !listed.has(name)),
    [],
  );
});

for (const [name, [call, typo, meant]] of Object.entries(CALLS))
  test(`${name} refuses ${typo} and suggests ${meant}`, async () => {
    const words = await messageOf(() => call({ [typo]: 5 }));
    assert.match(words, new RegExp(`${typo} = 5 \\(expected a known option, such as ${meant.replace('.', '\\.')};`));
    const last = meant.split('.').at(-1);
    assert.match(words, new RegExp(`the options are .*\\b${last}\\b`));
    assert.match(await messageOf(() => call({ qqqqqq: 1 })), /^(sound\.)?qqqqqq = 1 \(expected a known option; /);
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
  const ofSuperpixels = await messageOf(() => stages.superpixels(frame, { Size: 4 }));
  assert.equal(
    ofSuperpixels,
    'Size = 4 (expected a known option; the options are count, wasm, decoder, worker, contour, superpixel)',
  );
});

test('a queue refuses the options that only a single video has', async () => {
  for (const name of ['onDamage', 'keep'])
    assert.match(
      await messageOf(() => CALLS.segmentEach[0]({ [name]: true })),
      /it is an option of segmentVideo alone/,
    );
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
