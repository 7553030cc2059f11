// Never run: it has to compile wherever `misuse.ts` does not, in projects with browser types, with a worker's, with
// Node's, and with none.

import {
  createSession,
  drawLabels,
  encodeVideo,
  maskPng,
  masksZip,
  readFrames,
  Result as ResultClass,
  segmentEach,
  segmentVideo,
  synthClip,
  TraceCutError,
  videoFrames,
} from 'tracecut';
import { fitFrame } from 'tracecut/draw';
import { adjustMask, openProject, saveProject } from 'tracecut/edit';
import { cocoRle, encodeImages } from 'tracecut/export';
import { createImageEngine } from 'tracecut/stages';
import type {
  ComponentTable,
  FrameRange,
  FrameSource,
  MaskSource,
  ObjectList,
  Result,
  SaliencyTable,
  VideoResult,
  WindowResult,
} from 'tracecut';

/** True of one type alone: `any` is equal to nothing else. */
type Is<A, B> = (<T>() => T extends A ? 1 : 2) extends <T>() => T extends B ? 1 : 2 ? true : false;
type IsAny<T> = 0 extends 1 & T ? true : false;
const yes = (_: true): void => {};
const no = (_: false): void => {};

no({} as never as IsAny<FrameSource>);
no({} as never as IsAny<Parameters<typeof segmentVideo>[0]>);
no({} as never as IsAny<Awaited<ReturnType<typeof encodeVideo>>>);
no({} as never as IsAny<Awaited<ReturnType<typeof encodeImages>>>);
no({} as never as IsAny<Parameters<typeof drawLabels>[0]>);
no({} as never as IsAny<Parameters<typeof drawLabels>[0]['fillRect']>);
no({} as never as IsAny<NonNullable<NonNullable<Parameters<typeof createSession>[0]>['wasm']>>);
no({} as never as IsAny<NonNullable<NonNullable<Parameters<typeof masksZip>[1]>['signal']>>);

const pixels = { data: new Uint8ClampedArray(4), width: 1, height: 1 };
const session = await createSession({ clip: { maxSide: 320, seed: 1 }, preset: 'fast', threads: 2 });
await session.push(pixels);
await session.push({ data: new Uint8Array(4), width: 1, height: 1 });
await session.push(new Uint8Array(4));
await session.push(new ArrayBuffer(4));
const clip = await synthClip({ width: 320, height: 180, frames: 10 });
await session.push(clip.frame(0));
const result: Result = await session.run({ onProgress: ({ stage, done, total }) => void [stage, done / total] });
yes({} as never as Is<typeof result.width, number>);
yes({} as never as Is<Result['objects'], ObjectList>);
yes({} as never as Is<Result['doubts'], readonly FrameRange[]>);
yes({} as never as Is<Result['saliency'], SaliencyTable>);
yes({} as never as Is<Result['components'], ComponentTable>);
yes({} as never as Is<Result['masks'], Uint8Array<ArrayBuffer>>);
yes({} as never as Is<Result['clusters']['object'], Uint8Array>);
yes({} as never as Is<ReturnType<Result['labels']>, Uint8Array<ArrayBuffer>>);
const file: Uint8Array = await maskPng(result, 0, { object: 1, transparent: true });
const zip: Uint8Array = await masksZip(result, { perObject: true, objects: [1, 2] });
const coco: string = JSON.stringify(await cocoRle(result, { category: (label) => `thing ${label}` }));
const own: MaskSource = { width: 1, height: 1, numFrames: 1, labels: () => new Uint8Array(1) };
const project = await openProject(await saveProject(own, { about: { any: ['thing'] } }));
const masks: VideoResult = project.masks;
for await (const window of segmentVideo([pixels, { frame: pixels, time: 1, duration: 0.1 }], { window: 20 })) {
  const seen: WindowResult = window;
  const times: Float64Array = seen.times;
  for (const { index, time, labels } of seen.frames()) void [index, time, times, labels.length];
}
async function* frames() {
  yield pixels;
  yield { frame: new Uint8Array(9), time: 0.04 };
}
const whole = await segmentVideo(frames(), { start: 0, step: 2 }).collect();
for await (const { width, time } of videoFrames(frames())) void [width, time];
for await (const { name, result: found, error } of segmentEach([{ name: 'a', source: frames() }])) {
  if (error instanceof TraceCutError) void error.code;
  void [name, found?.numFrames];
}
for await (const { name } of readFrames('frames')) void name.length;
await segmentVideo(readFrames('frames')).collect();
const again: Result = ResultClass.fromJSON(JSON.stringify(result));
const labels: number[] = again.objects.map(({ label }) => label);
const images = await createImageEngine({ contour: { lowThreshold: 0.05 } });
const { borders } = await images.superpixels(pixels, { count: 400 });
const soft = adjustMask({ labels: result.labels(0), width: 4, height: 4 }, { grow: 2, feather: 1 });
export { labels, borders, coco, file, fitFrame, masks, project, soft, whole, zip };
