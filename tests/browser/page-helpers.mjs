// Functions for tests that run in pages: clips whose frames show their numbers, frames of players, pixels, errors, bytes as text.
// `openLibrary` and `openSample` (fixtures.mjs) make them global in their pages; others import them from
// `/tests/browser/page-helpers.mjs`.

const SIZE = { width: 128, height: 64 };

/**
 * Draws a number below 256 as eight fields, four in a row, white where the number has a bit. The left edge is red, which
 * shows how a picture is turned.
 */
export function drawNumber(context, number) {
  const { width, height } = context.canvas;
  context.fillStyle = '#000';
  context.fillRect(0, 0, width, height);
  for (let bit = 0; bit < 8; bit += 1) {
    context.fillStyle = (number >> bit) & 1 ? '#fff' : '#000';
    context.fillRect(((bit % 4) * width) / 4, (Math.floor(bit / 4) * height) / 2, width / 4, height / 2);
  }
  context.fillStyle = '#f00';
  context.fillRect(0, 0, width / 16, height);
}

/** Returns the pixels of a picture, drawn at a size. */
export function pixelsOf(image, width = image.width, height = image.height) {
  const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
  context.imageSmoothingQuality = 'high';
  context.drawImage(image, 0, 0, width, height);
  return context.getImageData(0, 0, width, height).data;
}

/** Returns the number that a picture shows. */
export function numberOf({ data, width, height }) {
  let number = 0;
  for (let bit = 0; bit < 8; bit += 1) {
    const x = Math.round((((bit % 4) + 0.5) * width) / 4);
    const y = Math.round(((Math.floor(bit / 4) + 0.5) * height) / 2);
    if (data[4 * (y * width + x) + 1] > 127) number |= 1 << bit;
  }
  return number;
}

/** Returns the name of the picture's red edge. */
export function redEdge({ data, width, height }) {
  const isRed = ([x, y]) => data[4 * (y * width + x)] > 127 && data[4 * (y * width + x) + 1] < 100;
  const [right, bottom] = [width - 2, height - 2];
  const places = {
    left: [2, bottom / 2],
    right: [right, bottom / 2],
    top: [right / 2, 2],
    bottom: [right / 2, bottom],
  };
  return Object.keys(places)
    .filter((name) => isRed(places[name].map(Math.round)))
    .join();
}

/** Returns a canvas element on which numbers can be drawn, and its context. */
export function numberCanvas() {
  const canvas = Object.assign(document.createElement('canvas'), SIZE);
  return { canvas, context: canvas.getContext('2d') };
}

/**
 * Encodes a video file of pictures: `draw(context, k)` draws the one that is shown at `times[k]`, the last one as long as the
 * one before. Without `hasLength` the file does not say how long it is.
 */
export async function encodeClip({
  times,
  draw,
  container = 'WebM',
  codec = 'vp8',
  rotation = 0,
  width = SIZE.width,
  height = SIZE.height,
  keyEvery = 1,
  bitrate = 2e6,
  hasLength = true,
}) {
  const media = await import('/dist/vendor/media.js');
  const format = new media[`${container}OutputFormat`]({ appendOnly: !hasLength });
  const output = new media.Output({ format, target: new media.BufferTarget() });
  const source = new media.VideoSampleSource({ codec, bitrate, keyFrameInterval: keyEvery });
  output.addVideoTrack(source, { rotation });
  await output.start();
  const context = new OffscreenCanvas(width, height).getContext('2d');
  for (const [k, timestamp] of times.entries()) {
    draw(context, k);
    const duration = (times[k + 1] ?? 2 * timestamp - times[k - 1]) - timestamp;
    const sample = new media.VideoSample(context.canvas, { timestamp, duration });
    await source.add(sample);
    sample.close();
  }
  await output.finalize();
  return new Blob([output.target.buffer]);
}

/** Returns a WAV file of one channel with these samples. @param {Int16Array} samples */
export function wav(samples, rate = 8000) {
  const size = 2 * samples.length;
  const file = new DataView(new ArrayBuffer(44 + size));
  for (const [at, word] of Object.entries({ 0: 'RIFF', 8: 'WAVEfmt ', 36: 'data' }))
    new Uint8Array(file.buffer).set(new TextEncoder().encode(word), at);
  for (const [at, value] of Object.entries({ 4: 36 + size, 16: 16, 24: rate, 28: 2 * rate, 40: size }))
    file.setUint32(at, value, true);
  for (const [at, value] of Object.entries({ 20: 1, 22: 1, 32: 2, 34: 16 })) file.setUint16(at, value, true);
  samples.forEach((sample, k) => file.setInt16(44 + 2 * k, sample, true));
  return file.buffer;
}

/** Encodes a video file whose frame `k` shows the number `k` at `times[k]`. */
export const makeClip = (options) => encodeClip({ draw: drawNumber, ...options });

/** Returns the numbers from 0 to `count` - 1. */
export const range = (count) => Array.from({ length: count }, (_, k) => k);

/** Returns the times of `count` frames at `rate` frames per second. */
export const evenTimes = (count, rate) => range(count).map((k) => k / rate);

/** Returns the numbers, times, durations and indices of the frames of a source, and the size of the last one. */
export async function numbersOf(source, options) {
  const frames = { numbers: [], times: [], durations: [], indices: [], size: '' };
  for await (const { width, height, pixels, index, time, duration } of tracecut.videoFrames(source, options)) {
    frames.numbers.push(numberOf(await pixels()));
    frames.times.push(time);
    frames.durations.push(duration);
    frames.indices.push(index);
    frames.size = `${width}x${height}`;
  }
  return frames;
}

/**
 * Returns the frame that a player shows at a time.
 *
 * @param {Blob} blob a video
 * @param {number} [time] seconds, after the first frame; the first one if not given
 */
export async function playedFrame(blob, time = 0) {
  const video = document.createElement('video');
  const failed = new Promise((_, reject) => (video.onerror = () => reject(new Error(video.error?.message))));
  const presented = () => Promise.race([failed, new Promise((resolve) => video.requestVideoFrameCallback(resolve))]);
  const first = presented();
  Object.assign(video, { muted: true, src: URL.createObjectURL(blob) });
  // Only a video in view is presented.
  Object.assign(video.style, { position: 'fixed', top: 0, left: 0, zIndex: 1000 });
  document.body.append(video);
  await first;
  if (time) {
    const presentedAgain = presented();
    video.currentTime = time;
    await presentedAgain;
  }
  const { videoWidth: width, videoHeight: height, duration } = video;
  const data = pixelsOf(video, width, height);
  URL.revokeObjectURL(video.src);
  video.remove();
  const colorAt = ([x, y]) => [...data.subarray(4 * (y * width + x), 4 * (y * width + x) + 4)];
  return { width, height, duration, data, colorAt };
}

/** Returns code and message of the error that a promise rejects with, null if it does not. */
export async function failure(promise) {
  try {
    await promise;
    return null;
  } catch (error) {
    return { code: error.code ?? error.name, message: error.message };
  }
}

/** Returns code and message of the error that a promise rejects with, as one text. */
export async function errorText(promise) {
  const error = await failure(promise);
  return error ? `${error.code}: ${error.message}` : 'no error';
}

/** Returns the bytes of a blob as text, which travels from a page in far less time than an array of numbers. */
export async function base64Of(blob) {
  const reader = new FileReader();
  const loaded = new Promise((resolve) => (reader.onload = resolve));
  reader.readAsDataURL(blob);
  await loaded;
  return reader.result.split(',')[1];
}
