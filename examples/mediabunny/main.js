// Draws the objects of a video on a canvas, and writes the canvas to a WebM file with alpha, with mediabunny.

import { BufferTarget, CanvasSource, Output, QUALITY_HIGH, WebMOutputFormat } from 'mediabunny';
import { segmentVideo, videoFrames } from 'tracecut';
import { drawCutout } from 'tracecut/draw';

const [input, link] = document.querySelectorAll('input, a');

input.addEventListener('change', async () => {
  const [file] = input.files;
  const masks = await segmentVideo(file, { size: 480 }).collect();
  const { width, height } = masks;
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext('2d');
  const output = new Output({ format: new WebMOutputFormat(), target: new BufferTarget() });
  const track = new CanvasSource(canvas, { codec: 'vp9', bitrate: QUALITY_HIGH, alpha: 'keep' });
  output.addVideoTrack(track);
  await output.start();
  for await (const { frame, index, time, duration } of videoFrames(file, { size: 480 })) {
    context.clearRect(0, 0, width, height);
    const alpha = masks.labels(index).map((label) => (label > 0 ? 255 : 0));
    drawCutout(context, frame, { width, height, alpha });
    await track.add(time, duration);
  }
  await output.finalize();
  link.href = URL.createObjectURL(new Blob([output.target.buffer], { type: 'video/webm' }));
  link.hidden = false;
});
