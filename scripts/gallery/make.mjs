// Makes a clip of the gallery from its video, in a browser: the project that holds both, and its poster.

/** Width of a poster, in pixels. */
const POSTER = 240;

/** One in `EACH` trajectories is kept. */
const EACH = 3;

/** @param {{id: string, film: string, poster?: number}} clip its name, its video as Base64, the frame that is shown of it */
export async function makeClip({ id, film, poster: shownFirst }) {
  const { segmentVideo } = await import('/dist/index.js');
  const { saveProject } = await import('/dist/edit.js');
  const bytes = Uint8Array.from(atob(film), (letter) => letter.charCodeAt(0));
  const video = new Blob([bytes], { type: 'video/webm' });
  const frames = await framesOf(video);
  const masks = await segmentVideo(video).collect();
  const name = `${id}.webm`;
  const about = {
    name,
    take: { start: 0, frames: masks.numFrames, step: 1, side: masks.width },
    changed: [],
    types: { [name]: 'video/webm' },
  };
  const project = await saveProject(withFewer(masks), { about, files: { [name]: bytes } });
  const first = shownFirst ?? frames.length >> 1;
  const poster = await picture([[frames[first], masks, first]], POSTER, 0.6);
  const shown = [0.02, 0.2, 0.4, 0.6, 0.8, 0.98].map((share) => Math.floor(share * masks.numFrames));
  const facts = {
    id,
    width: masks.width,
    height: masks.height,
    frames: masks.numFrames,
    seconds: Number(masks.end.toFixed(3)),
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
    1.5 * masks.width,
    0.8,
    'image/png',
    2,
  );
  return { facts, look: base64(look), files: { [`${id}.tracecut`]: base64(project), [`${id}.webp`]: base64(poster) } };
}

async function framesOf(video) {
  const { videoFrames } = await import('/dist/index.js');
  const frames = [];
  for await (const { frame } of videoFrames(video)) frames.push(frame);
  return frames;
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
  const size = list[0][0];
  const [wide, high] = [width / columns, Math.round((width / columns / size.width) * size.height)];
  const sheet = new OffscreenCanvas(width, high * Math.ceil(list.length / columns));
  const onto = sheet.getContext('2d');
  onto.imageSmoothingQuality = 'high';
  for (const [k, [frame, masks, t]] of list.entries()) {
    const canvas = new OffscreenCanvas(size.width, size.height);
    const context = canvas.getContext('2d');
    context.putImageData(new ImageData(frame.data, size.width, size.height), 0, 0);
    drawLabels(context, masks, t);
    onto.drawImage(canvas, (k % columns) * wide, Math.floor(k / columns) * high, wide, high);
  }
  return new Uint8Array(await (await sheet.convertToBlob({ type, quality })).arrayBuffer());
}

/** @param {Uint8Array} bytes */
function base64(bytes) {
  return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(''));
}
