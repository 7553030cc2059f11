// Makes a clip of the gallery, in a browser: the video, the project that holds it, and its poster.

import { FRAME_RATE, SCENES, SIZE } from './scenes.mjs';

/** Width of a poster, in pixels. */
const POSTER = 240;

/** Of a video, in bits a second. */
const BITRATE = 700_000;

/** One in `EACH` trajectories is kept. */
const EACH = 3;

/** @param {string} id of a scene */
export async function makeClip(id) {
  const { segmentVideo } = await import('/dist/index.js');
  const { saveProject } = await import('/dist/edit.js');
  const scene = SCENES.find((one) => one.id === id);
  const paint = scene.open();
  const frames = Array.from({ length: scene.frames }, (_, t) => paint(t).pixels());
  const video = await encoded(frames);
  const masks = await segmentVideo(video).collect();
  const name = `${id}.webm`;
  const about = {
    name,
    take: { start: 0, frames: masks.numFrames, step: 1, side: SIZE.width },
    changed: [],
    types: { [name]: 'video/webm' },
  };
  const bytes = new Uint8Array(await video.arrayBuffer());
  const project = await saveProject(withFewer(masks), { about, files: { [name]: bytes } });
  const poster = await picture([[frames[scene.poster], masks, scene.poster]], POSTER, 0.6);
  const shown = [0.02, 0.2, 0.4, 0.6, 0.8, 0.98].map((share) => Math.floor(share * masks.numFrames));
  const facts = {
    id,
    ...SIZE,
    frames: masks.numFrames,
    seconds: masks.numFrames / FRAME_RATE,
    objects: masks.objects.length,
    bytes: project.length,
    sizes: {
      video: bytes.length,
      trajectories: masks.trajectories.x.length,
      poster: poster.length,
      found: masks.objects
        .map((o) => `${o.label}: ${o.firstFrame}-${o.lastFrame} ${Math.round(o.meanArea)}`)
        .join(', '),
    },
  };
  const look = await picture(
    shown.map((t) => [frames[t], masks, t]),
    1.5 * SIZE.width,
    0.8,
    'image/png',
    2,
  );
  return { facts, look: base64(look), files: { [`${id}.tracecut`]: base64(project), [`${id}.webp`]: base64(poster) } };
}

/** The frames as a video file, smaller than `encodeVideo` makes them. */
async function encoded(frames) {
  const { BufferTarget, CanvasSource, Output, Quality, WebMOutputFormat } = await import('/dist/vendor/media.js');
  const canvas = new OffscreenCanvas(SIZE.width, SIZE.height);
  const context = canvas.getContext('2d');
  const target = new BufferTarget();
  const output = new Output({ format: new WebMOutputFormat(), target });
  const quality = new Quality({ bitrate: BITRATE });
  const source = new CanvasSource(canvas, { codec: 'vp9', quality, latencyMode: 'quality', keyFrameInterval: 10 });
  output.addVideoTrack(source);
  await output.start();
  for (const [t, { data }] of frames.entries()) {
    context.putImageData(new ImageData(data, SIZE.width, SIZE.height), 0, 0);
    await source.add(t / FRAME_RATE, 1 / FRAME_RATE);
  }
  await output.finalize();
  return new Blob([target.buffer], { type: 'video/webm' });
}

/** The same masks with every third trajectory, in steps of an eighth of a pixel: they would be most of the file. */
function withFewer(masks) {
  const { count, startFrame, offset, x, y, label } = masks.trajectories;
  const kept = Array.from({ length: count }, (_, k) => k).filter((k) => k % EACH === 0);
  const places = (values) =>
    Float32Array.from(
      kept.flatMap((k) => [...values.subarray(offset[k], offset[k + 1])]),
      (v) => Math.round(8 * v) / 8,
    );
  const ends = [0];
  for (const k of kept) ends.push(ends[ends.length - 1] + offset[k + 1] - offset[k]);
  const of = (values) => kept.map((k) => values[k]);
  const trajectories = {
    count: kept.length,
    startFrame: Uint32Array.from(of(startFrame)),
    offset: Uint32Array.from(ends),
    x: places(x),
    y: places(y),
    label: Uint8Array.from(of(label)),
  };
  const { width, height, numFrames, times, end, shots } = masks;
  return { width, height, numFrames, times, end, shots, trajectories, labels: (t) => masks.labels(t) };
}

/** Frames with their masks, below each other or in columns. */
async function picture(list, width, quality, type = 'image/webp', columns = 1) {
  const { drawLabels } = await import('/dist/index.js');
  const [wide, high] = [width / columns, Math.round((width / columns / SIZE.width) * SIZE.height)];
  const sheet = new OffscreenCanvas(width, high * Math.ceil(list.length / columns));
  const onto = sheet.getContext('2d');
  onto.imageSmoothingQuality = 'high';
  for (const [k, [frame, masks, t]] of list.entries()) {
    const canvas = new OffscreenCanvas(SIZE.width, SIZE.height);
    const context = canvas.getContext('2d');
    context.putImageData(new ImageData(frame.data, SIZE.width, SIZE.height), 0, 0);
    drawLabels(context, masks, t);
    onto.drawImage(canvas, (k % columns) * wide, Math.floor(k / columns) * high, wide, high);
  }
  return new Uint8Array(await (await sheet.convertToBlob({ type, quality })).arrayBuffer());
}

/** @param {Uint8Array} bytes */
function base64(bytes) {
  return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(''));
}
