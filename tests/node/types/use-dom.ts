// Never run: the browser's own types fit, and are given.

import { createSession, drawLabels, encodeVideo, segmentVideo } from 'tracecut';
import { drawCutout, fitFrame } from 'tracecut/draw';
import { encodeImages } from 'tracecut/export';
import type { MaskSource } from 'tracecut';

declare const masks: MaskSource;
const session = await createSession({ wasm: await fetch('tracecut.wasm'), decoder: new URL('https://example.org/') });
await session.push(new ImageData(1, 1));
await session.push(new OffscreenCanvas(1, 1));
await session.push(document.createElement('canvas'));
await session.push(document.createElement('video'));
await session.push(await createImageBitmap(new Blob()));
await session.push(new VideoFrame(new OffscreenCanvas(1, 1), { timestamp: 0 }));
await session.push(new File([], 'a.png'));
await session.run({ signal: AbortSignal.timeout(1000) });
const film: Blob = await encodeVideo(masks, [document.createElement('img')], { signal: new AbortController().signal });
const address: string = URL.createObjectURL(film);
const stream: ReadableStream<Uint8Array<ArrayBuffer>> = await encodeImages(masks, [await createImageBitmap(film)]);
const archive: Blob = await new Response(stream).blob();
segmentVideo(film.stream().pipeThrough(new TransformStream<Uint8Array, Uint8Array>()));
segmentVideo(new MediaStream());
segmentVideo(new MediaStreamTrack());
const videoFrames = new TransformStream<VideoFrame, VideoFrame>().readable;
await segmentVideo(videoFrames).readable.pipeTo(
  new WritableStream({ write: ({ settled }) => console.log(settled.to) }),
);
for (const canvas of [document.createElement('canvas'), new OffscreenCanvas(1, 1)]) {
  const context = canvas.getContext('2d') as CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D;
  const unit: number = fitFrame(context, { width: 1, height: 1 });
  drawLabels(context, masks, 0, { outlineWidth: unit });
  drawCutout(context, canvas, { width: 1, height: 1, alpha: new Uint8Array(1) }, { background: canvas });
}
export { address, archive };
