// What the browser's player shows of a saved video.

/**
 * Runs in the page: the frame that a player shows at a time.
 *
 * @param {Blob} blob a video
 * @param {number} time seconds, after the first frame
 */
async function playedFrame(blob, time) {
  const video = document.createElement('video');
  const failed = new Promise((_, reject) => (video.onerror = () => reject(new Error(video.error?.message))));
  const presented = () => Promise.race([failed, new Promise((resolve) => video.requestVideoFrameCallback(resolve))]);
  const first = presented();
  Object.assign(video, { muted: true, src: URL.createObjectURL(blob) });
  // Only a video in view is presented.
  Object.assign(video.style, { position: 'fixed', top: 0, left: 0, zIndex: 1000 });
  document.body.append(video);
  await first;
  const sought = presented();
  video.currentTime = time;
  await sought;
  const { videoWidth: width, videoHeight: height, duration } = video;
  const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
  context.drawImage(video, 0, 0);
  URL.revokeObjectURL(video.src);
  video.remove();
  const { data } = context.getImageData(0, 0, width, height);
  const colorAt = ([x, y]) => [...data.subarray(4 * (y * width + x), 4 * (y * width + x) + 4)];
  return { width, height, duration, data, colorAt };
}

/** Gives a page the function `playedFrame`. @param {import('@playwright/test').Page} page */
export function definePlayedFrame(page) {
  return page.evaluate(`globalThis.playedFrame = ${playedFrame}`);
}
