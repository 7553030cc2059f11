// A project of a synthetic clip with five objects, created in the page: opens without a run.

/** Runs in the page: creates the video and its project, of this size, as bytes. */
async function createFive({ width, height, frames, parts = 0, doubts = [], scale = 1, hasSound = false }) {
  const media = await import('/dist/vendor/media.js');
  const { saveProject } = await import('/dist/edit.js');
  const output = new media.Output({ format: new media.WebMOutputFormat(), target: new media.BufferTarget() });
  const video = new media.VideoSampleSource({ codec: 'vp8', bitrate: 2e6 });
  output.addVideoTrack(video);
  await output.start();
  const side = Math.round(Math.min(width, height) / 7);
  // The first ones side by side, if there are parts of one thing; all others stand apart and move the other way.
  const placeOf = (k, t) => (k < parts ? [20 + k * side + 3 * t, 4 + t] : apart(k, parts > 0 ? -2 * t : t));
  const apart = (k, t) => [
    Math.round(((k + 0.5) * (width - side)) / 5.5 + t),
    Math.round((k * (height - side)) / 5 + t),
  ];
  for (let t = 0; t < frames; t += 1) {
    const canvas = new OffscreenCanvas(scale * width, scale * height);
    const context = canvas.getContext('2d');
    context.scale(scale, scale);
    for (let y = 0; y < height; y += 8)
      for (let x = 0; x < width; x += 8) {
        context.fillStyle = `hsl(${((x * 7 + y * 3) % 80) + 60} 30% ${40 + ((x * 13 + y * 29) % 30)}%)`;
        context.fillRect(x, y, 8, 8);
      }
    for (let k = 0; k < 5; k += 1) {
      context.fillStyle = `hsl(${70 * k} 80% 50%)`;
      context.fillRect(...placeOf(k, t), side, side);
    }
    const sample = new media.VideoSample(canvas, { timestamp: t / 10, duration: 0.1 });
    await video.add(sample);
    sample.close();
  }
  await output.finalize();
  let bytes = new Uint8Array(output.target.buffer);
  if (hasSound) {
    const { encodeVideo, videoFrames } = await import('/dist/index.js');
    const [rate, count] = [8000, 8000];
    const wav = new DataView(new ArrayBuffer(44 + 2 * count));
    const words = { 0: 'RIFF', 8: 'WAVEfmt ', 36: 'data' };
    for (const [at, word] of Object.entries(words)) new Uint8Array(wav.buffer).set(new TextEncoder().encode(word), at);
    const longs = { 4: 36 + 2 * count, 16: 16, 24: rate, 28: 2 * rate, 40: 2 * count };
    for (const [at, value] of Object.entries(longs)) wav.setUint32(at, value, true);
    for (const [at, value] of Object.entries({ 20: 1, 22: 1, 32: 2, 34: 16 })) wav.setUint16(at, value, true);
    for (let k = 0; k < count; k += 1) wav.setInt16(44 + 2 * k, 9000 * Math.sin(k / 5), true);
    const times = Array.from({ length: frames }, (_, t) => t / 10);
    const none = { width: 16, height: 9, numFrames: frames, labels: () => new Uint8Array(144), times };
    const options = { quality: 'very-high', sound: { source: wav.buffer, end: frames / 10 } };
    const blob = await encodeVideo(none, videoFrames(new Blob([bytes])), options);
    bytes = new Uint8Array(await blob.arrayBuffer());
  }
  const labels = (t) => {
    const mask = new Uint8Array(width * height);
    for (let k = 0; k < 5; k += 1) {
      const [left, top] = placeOf(k, t);
      for (let y = top; y < top + side; y += 1) mask.fill(k + 1, y * width + left, y * width + left + side);
    }
    return mask;
  };
  // Lines of points over the ground, which stands still, and over each object.
  const lines = [];
  for (let y = 4; y < height; y += 16)
    for (let x = 4; x < width; x += 16) {
      const label = labels(0)[y * width + x];
      const [left, top] = placeOf(label - 1, 0);
      const at = (t) => (label === 0 ? [x, y] : placeOf(label - 1, t).map((v, axis) => v + [x - left, y - top][axis]));
      lines.push({ label, points: Array.from({ length: frames }, (_, t) => at(t)) });
    }
  const trajectories = {
    count: lines.length,
    startFrame: new Uint32Array(lines.length),
    offset: Uint32Array.from({ length: lines.length + 1 }, (_, k) => k * frames),
    x: Float32Array.from(lines.flatMap(({ points }) => points.map(([x]) => x))),
    y: Float32Array.from(lines.flatMap(({ points }) => points.map(([, y]) => y))),
    label: Uint8Array.from(lines, ({ label }) => label),
  };
  const times = Float64Array.from({ length: frames }, (_, t) => t / 10);
  const source = {
    width,
    height,
    numFrames: frames,
    shots: [{ first: 0, last: frames - 1 }],
    times,
    end: frames / 10,
    labels,
    ...(parts > 0 ? { trajectories } : {}),
    doubts,
  };
  const trim = { start: 0, frames, step: 1, side: Math.max(width, height) };
  const about = { name: 'five.webm', trim, changed: [], types: { 'five.webm': 'video/webm' } };
  const project = await saveProject(source, { about, files: { 'five.webm': bytes } });
  return [[...bytes], [...project]];
}

/** Files by their options. */
const cache = new Map();

/**
 * @param {import('@playwright/test').Page} page
 * @param {{width: number, height: number, frames: number, parts?: number, doubts?: object[], scale?: number, hasSound?: boolean}} options
 *   size of the masks; `parts` of the objects touch and move alike; the video is larger by `scale`
 * @returns {Promise<{video: object, project: object}>} files for `setInputFiles`
 */
export async function fiveObjects(page, options) {
  const key = JSON.stringify(options);
  if (!cache.has(key)) cache.set(key, await page.evaluate(createFive, options));
  const [video, project] = cache.get(key);
  return {
    video: { name: 'five.webm', mimeType: 'video/webm', buffer: Buffer.from(video) },
    project: { name: 'five.tracecut', mimeType: 'application/zip', buffer: Buffer.from(project) },
  };
}

/** Runs in the page: where the canvas is, in CSS pixels, and the shares of the window that it and its box have. */
export function pictureBox() {
  const { width, height, top, left } = document.querySelector('#canvas').getBoundingClientRect();
  const box = document.querySelector('#screen').getBoundingClientRect();
  const ofBox = (box.width * box.height) / (innerWidth * innerHeight);
  return { width, height, top, left, across: width / innerWidth, down: height / innerHeight, ofBox };
}

export const WIDE = { width: 480, height: 270, frames: 8 };
export const UPRIGHT = { width: 270, height: 480, frames: 8 };
