// Never run: none of these may compile, in any of the projects beside this file. A line that does compile is an error
// of its own.

import {
  createSession,
  drawLabels,
  encodeVideo,
  maskPng,
  masksZip,
  segmentEach,
  segmentVideo,
  synthClip,
  videoInfo,
  videoStrip,
} from 'tracecut';
import { editMasks, openProject, saveProject } from 'tracecut/edit';
import { cocoRle, encodeImages, fromCocoRle } from 'tracecut/export';
import { boundaries, createImageEngine, flow, imageDiscontinuities, superpixels } from 'tracecut/stages';
import type { ErrorCode, MaskSource, Result, Session, Stroke, VideoResult, WindowResult } from 'tracecut';

declare const session: Session;
declare const result: Result;
declare const part: WindowResult;
declare const whole: VideoResult;
declare const masks: MaskSource;
declare const pixels: { data: Uint8ClampedArray; width: number; height: number };

// Frames
// @ts-expect-error: a frame is not a file's name
await session.push('frame.png');
// @ts-expect-error: nor a number
await session.push(7);
// @ts-expect-error: nor its pixels alone, as numbers
await session.push([0, 0, 0, 255]);
// @ts-expect-error: pixels have a size
await session.push({ data: new Uint8ClampedArray(4) });
// @ts-expect-error: by its own names
await session.push({ data: new Uint8ClampedArray(4), w: 1, h: 1 });
// @ts-expect-error: and are bytes
await session.push({ data: new Float32Array(4), width: 1, height: 1 });
// @ts-expect-error: one after the other
await session.push([pixels]);
// @ts-expect-error: nothing is no frame
await session.push();
// @ts-expect-error: two images have a flow
await flow(pixels);
// @ts-expect-error: an image is not an address
await boundaries('https://example.org/picture.png');

// Options of a session
// @ts-expect-error: parameters are known by name
await createSession({ clip: { maxSize: 320 } });
// @ts-expect-error: and by type
await createSession({ clip: { maxSide: '320' } });
// @ts-expect-error: groups too
await createSession({ clips: {} });
// @ts-expect-error: parameters stand in their groups
await createSession({ maxSide: 320 });
// @ts-expect-error: choices by the names that they have
await createSession({ connectedness: { mode: 'sometimes' } });
// @ts-expect-error: presets as well
await createSession({ preset: 'slow' });
// @ts-expect-error: threads are counted
await createSession({ threads: 'all' });
// @ts-expect-error: a file is no number
await createSession({ wasm: 7 });
// @ts-expect-error: a session has to be waited for
createSession().push(pixels);
// @ts-expect-error: a single image has no flow
await boundaries(pixels, { flow: {} });
// @ts-expect-error: nor superpixels, where none are made
await imageDiscontinuities(pixels, { superpixel: {} });
// @ts-expect-error: superpixels are counted
await superpixels(pixels, { count: 'many' });
// @ts-expect-error: an engine for images keeps no clip
(await createImageEngine()).run();
// @ts-expect-error: a made clip has its own options
await synthClip({ length: 10 });

// Running and correcting
// @ts-expect-error: progress is reported to a function
await session.run({ onProgress: 'yes' });
// @ts-expect-error: a controller is not its signal
await session.run({ signal: { abort() {} } });
// @ts-expect-error: there are no stages but these
await session.run({ onProgress: ({ stage }) => stage === 'segmentation' });
// @ts-expect-error: labels are numbers
await session.merge('1', 2);
// @ts-expect-error: a stroke is in a frame
const stroke: Stroke = { points: [1, 2], radius: 3 };
// @ts-expect-error: strokes come as a list
await session.together({ t: 0, points: [1, 2], radius: 3 });
// @ts-expect-error: no error is called so
const code: ErrorCode = 'oops';

// Results
// @ts-expect-error: they do not change
result.width = 9;
// @ts-expect-error: windows are read-only too
part.firstFrame = 9;
// @ts-expect-error: clips are read-only too
whole.numFrames = 9;
// @ts-expect-error: nor what is in them
result.trajectories.count = 0;
// @ts-expect-error: labels are asked for by frame
result.labels();
// @ts-expect-error: a frame has a number
result.labels('first');
// @ts-expect-error: masks are not there at once in a promise
(await result.superpixels(0)).labels(0);
// @ts-expect-error: a clip's result has one mask for each frame
whole.labels(0, 1);
// @ts-expect-error: labels get others, by numbers
await editMasks(whole).merge(1, 'two');
// @ts-expect-error: a window has settled frames to go through
for (const frame of part) void frame;

// @ts-expect-error: objects are a list
result.objects.ofCluster;
// @ts-expect-error: that does not change
whole.objects.push(whole.objects[0]!);

// Video
// @ts-expect-error: a number is no video
segmentVideo(7);
// @ts-expect-error: options are known by name
segmentVideo([], { windows: 50 });
// @ts-expect-error: windows are counted
segmentVideo([], { window: '50' });
// @ts-expect-error: frames of a list are frames
segmentVideo(['a.png', 'b.png']);
// @ts-expect-error: with times in numbers
segmentVideo([{ frame: pixels, time: '0.1' }]);
// @ts-expect-error: the result is collected
segmentVideo([]).toJSON();
// @ts-expect-error: a strip has no step
videoStrip([], { step: 2 });
// @ts-expect-error: facts are not there at once
videoInfo([]).width;
// @ts-expect-error: clips of a queue have names
segmentEach([{ source: [] }]);

// Files and drawing
// @ts-expect-error: a mask is of a frame
await maskPng(result);
// @ts-expect-error: of one object
await maskPng(result, 0, { object: [1, 2] });
// @ts-expect-error: options are known by name
await maskPng(result, 0, { objects: [1] });
// @ts-expect-error: objects are a list, or a function
await masksZip(masks, { objects: 1 });
// @ts-expect-error: that says yes or no
await masksZip(masks, { objects: (label) => `${label}` });
// @ts-expect-error: labels come from a function
const own: MaskSource = { width: 1, height: 1, numFrames: 1, labels: new Uint8Array(1) };
// @ts-expect-error: a size is two numbers and a count of frames
await cocoRle({ labels: () => new Uint8Array(1) });
// @ts-expect-error: COCO has a category for each object
await cocoRle(masks, { categories: ['car'] });
// @ts-expect-error: masks of COCO have a size
await fromCocoRle({ counts: '' });
// @ts-expect-error: a project is bytes
await openProject('clip.tracecut');
// @ts-expect-error: its files are bytes
await saveProject(masks, { files: { 'a.txt': 'words' } });
// @ts-expect-error: formats by the names that they have
await encodeVideo(masks, null, { format: 'avi' });
// @ts-expect-error: styles too
await encodeVideo(masks, [], { style: 'outline' });
// @ts-expect-error: pictures have frames
await encodeImages(masks, null);
// @ts-expect-error: a context is drawn with, not a canvas
drawLabels({ width: 1, height: 1 }, masks, 0);
// @ts-expect-error: an editor has its masks
editMasks();

export { code, own, stroke };
