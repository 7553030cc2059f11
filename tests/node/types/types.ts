// Never run: it has to compile against the package's declarations, which is what the test `types.test` checks.

import {
  createSession,
  drawLabels,
  encodeVideo,
  maskPng,
  masksZip,
  parameters,
  searchReport,
  segmentEach,
  segmentVideo,
  synthClip,
  TraceCutError,
  version,
  videoFrames,
  videoInfo,
  videoStrip,
} from 'tracecut';
import { editMasks } from 'tracecut/edit';
import {
  drawBoundaries,
  drawCells,
  drawDiscontinuities,
  drawFlow,
  drawSaliency,
  drawSuperpixels,
  drawTrajectories,
  fitFrame,
  objectColor,
  objectShape,
} from 'tracecut/draw';
import { clipsZip, cocoRle, fromCocoRle, labelMaps, labelsNpy } from 'tracecut/export';
import { boundaries, EdgeKind, imageDiscontinuities, superpixels } from 'tracecut/stages';
import type {
  Background,
  BoundaryMap,
  ComponentTable,
  Damage,
  ErrorCode,
  FlowField,
  MaskSource,
  ObjectList,
  Progress,
  Result,
  SaliencyMap,
  SaliencyTable,
  SearchReport,
  Session,
  SessionOptions,
  Stage,
  Stroke,
  Superpixels,
  VideoInfo,
  VideoProgress,
  VideoResult,
  VideoSegmentation,
  WindowResult,
} from 'tracecut';
import type { CocoMasks } from 'tracecut/export';
import type { DiscontinuityOptions, ImageDiscontinuities, ImageOptions } from 'tracecut/stages';

const options: SessionOptions = {
  clip: { maxSide: 320, seed: 1 },
  trajectory: { gridStep: 6 },
  connectedness: { mode: 'paper' },
  worker: false,
};
const session: Session = await createSession(options);
const clip = await synthClip({ width: 320, height: 180, frames: 10, seed: 2 });
await session.push(clip.frame(0));
await session.push(new Uint8Array());
await session.push(new Blob());
await session.push({ data: new Uint8ClampedArray(4), width: 1, height: 1 });
await session.push(new ImageData(1, 1));
await session.push(new OffscreenCanvas(1, 1));

const controller = new AbortController();
const report = ({ stage, done, total }: Progress): void => console.log(stage, done / total);
const result: Result = await session.run({ onProgress: report, signal: controller.signal });
const stroke: Stroke = { t: 0, points: [1, 2, 3, 4], radius: 3 };
const corrected: Result[] = [
  await session.merge(1, 2),
  await session.split(1, { t: 0, x: 1, y: 2 }, { onProgress: report, signal: controller.signal }),
  await session.together([stroke]),
  await session.apart([stroke, { ...stroke, points: new Float32Array(4) }]),
  await session.undo(),
];
console.log(session.corrections, corrected.length);
const labels: Uint32Array = result.clusters.label;
const x: Float32Array = result.trajectories.x;
const values: Float64Array = result.embedding.eigenvalues;
const edges: Float32Array = result.edges(0).d;
const seconds: number | undefined = result.seconds.flow;
const text: string = result.toTracksDat();
const flow: FlowField = await session.flow(0);
const masks: Uint8Array = result.labels(0);
const objects: ObjectList = result.objects;
const regions: Superpixels = await result.superpixels(0);
const map: BoundaryMap = await session.boundaries(0);
const salient: SaliencyTable = result.saliency;
const pieces: ComponentTable = result.components;
const pieceOfPoint: Int32Array = pieces.ofPoint;
const heat: SaliencyMap = await result.saliencyMap(0);
const plate: Background = await result.background(0);
const picture: Uint8ClampedArray = (await session.background(0)).data;
const stages: Stage[] = ['saliency', 'connectedness'];
console.log(
  salient.foreground,
  salient.inContext,
  pieceOfPoint,
  heat.saliency,
  heat.scaleX,
  new ImageData(plate.data, plate.width),
  picture,
  await session.saliencyMap(0),
  stages,
);
const still: ImageOptions = { contour: { lowThreshold: 0.05 }, superpixel: {}, worker: false };
const gabriel = (await superpixels(new Uint8Array(), { ...still, count: 400 })).edges.kind.filter(
  (kind) => kind === EdgeKind.Gabriel,
).length;
const thin: Float32Array = (await boundaries(clip.frame(0))).thin;
const embedded: DiscontinuityOptions = { still: { dimensions: 8, grouping: 'joint' } };
const found: ImageDiscontinuities = await imageDiscontinuities(clip.frame(0), embedded);
console.log(found.pb, found.discontinuity, found.spectral, found.combined, found.scaleX);
console.log(masks, objects.length, result.clusters.object, regions.borders.pb, map.scaleX, gabriel, thin);
const names: string[] = parameters().map((parameter) => parameter.name);
console.log(version.length, labels, x, values, edges, seconds, text, flow.u, names);

try {
  await session.setTrajectories({
    numFrames: 2,
    width: 9,
    height: 9,
    startFrame: [0],
    offset: [0, 2],
    x: [1, 2],
    y: [1, 2],
  });
} catch (error) {
  if (error instanceof TraceCutError) {
    const code: ErrorCode = error.code;
    console.log(code, error.message);
  }
}

const watch = ({ stage, window, frames }: VideoProgress): void => console.log(stage, window, frames.total ?? '?');
const video: VideoSegmentation = segmentVideo(new Blob(), {
  start: 1,
  end: 2.5,
  step: 2,
  size: 480,
  window: 40,
  overlap: 8,
  clip: { seed: 1 },
  onProgress: watch,
});
for await (const window of video) {
  const seen: WindowResult = window;
  for (const { index, time, labels: settled } of seen.frames())
    console.log(index, time, settled.length, seen.trajectories.x);
}
async function* generated() {
  yield { frame: clip.frame(0), time: 0.1 };
}
const collected: VideoResult = await segmentVideo(generated(), { signal: controller.signal }).collect();
console.log(
  collected.objects[0]?.areas,
  (await editMasks(collected).toResult()).toTracksDat(),
  collected.shots[0]?.first,
  collected.trajectories.label,
);
for (const source of [
  'clip.mp4',
  new URL('https://example.org/clip.mp4'),
  [clip.frame(0)],
  new MediaStream(),
  document.createElement('video'),
]) {
  for await (const { frame, time, duration } of videoFrames(source, { size: 64 }))
    (await session.push(frame), console.log(time + duration));
}
const facts: VideoInfo = await videoInfo(new Blob());
console.log(facts.codec, facts.numFrames ?? 0);

const drawing = new OffscreenCanvas(1, 1).getContext('2d');
const onPage = document.createElement('canvas').getContext('2d');
const own: MaskSource = { width: 1, height: 1, numFrames: 1, labels: () => new Uint8Array(1), times: [0] };
const whole = await segmentVideo(new Blob()).collect();
if (drawing && onPage) {
  const unit: number = fitFrame(drawing, result);
  for (const masks of [result, whole, own])
    drawLabels(onPage, masks, 0, { objects: [1], outlineWidth: 2 * unit, colors: [objectColor(0)] });
  for (const source of [result, whole])
    drawTrajectories(drawing, source, 0, { color: 'cluster', which: (i) => i > 0, shape: objectShape(1) });
  drawDiscontinuities(drawing, result, 0, { calm: null });
  drawSuperpixels(drawing, regions, { image: drawing.canvas, edges: true });
  drawBoundaries(drawing, found, { of: 'combined' });
  drawSaliency(drawing, heat);
  drawFlow(drawing, flow, { scale: 2 });
  drawCells(drawing, whole, 0, { color: () => null });
}
const png: Uint8Array = await maskPng(whole, 0, { object: 1 });
const zip: Uint8Array = await masksZip(own, {
  perObject: true,
  onProgress: ({ done, total }) => console.log(done / total),
});
const coco: CocoMasks = await cocoRle(result, { category: 'car' });
const pixels: Uint8Array = await fromCocoRle(coco.annotations[0]!.segmentation);
const film: Blob = await encodeVideo(whole, videoFrames(new Blob()), {
  style: 'cutout',
  background: 'transparent',
  signal: controller.signal,
});
await encodeVideo(own, null, { style: 'masks', format: 'mp4' });
console.log(png, zip, pixels, film, labelMaps(own).data, labelsNpy(own));
const looked: SearchReport = searchReport(result);
const damages: Damage[] = [];
for await (const { width, time } of videoStrip(new Blob(), {
  count: 4,
  size: 96,
  onDamage: (one) => damages.push(one),
}))
  console.log(width, time, looked.cameraMoves);
for await (const { name, result: one, error, damage } of segmentEach([{ name: 'a', source: new Blob() }], {
  window: 20,
})) {
  const masks: VideoResult | null = one;
  const archive: Uint8Array = await clipsZip([
    { name, masks, error },
    { name: 'b', masks: null },
  ]);
  console.log(archive, damage?.frames);
}
{
  using scoped = await createSession();
  using scene = await synthClip();
  console.log(scoped.numFrames, scene.numObjects);
}
