// Draws the README's moving picture, docs/tracecut.webp: the sample clip with its trajectories, its superpixels and its
// masks, by the package and its drawing helpers in a browser.

import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { launchBrowser } from './browser.mjs';
import { build } from './build.mjs';
import { serve } from './serve.mjs';
import { root } from './tools.mjs';
import { animatedWebp } from './webp.mjs';

const PICTURE = { width: 400, height: 225, frames: 24, seed: 1, quality: 0.45, gap: 6 };
const FRAME_MS = 80;

/**
 * The frames of the picture, each a WebP file.
 * @param {typeof PICTURE} settings
 * @returns {Promise<Buffer[]>}
 */
export async function drawnFrames(settings) {
  const [server, browser] = [await serve(), await launchBrowser()];
  try {
    const page = await browser.newPage();
    await page.route(`${server.url}picture`, (route) =>
      route.fulfill({ contentType: 'text/html', body: '<!doctype html><title>picture</title>' }),
    );
    await page.goto(`${server.url}picture`);
    const files = await page.evaluate(draw, settings);
    return files.map((file) => Buffer.from(file, 'base64'));
  } finally {
    await browser.close();
    await server.close();
  }
}

/** Runs in the page. */
async function draw({ width, height, frames, seed, quality, gap }) {
  const { createSession, drawLabels, synthClip } = await import('/dist/index.js');
  const { drawSuperpixels, drawTrajectories } = await import('/dist/draw.js');
  const clip = await synthClip({ width, height, frames, seed });
  const session = await createSession();
  for (let t = 0; t < frames; t += 1) await session.push(clip.frame(t));
  const result = await session.run();
  const canvas = new OffscreenCanvas(3 * width + 2 * gap, height);
  const context = canvas.getContext('2d', { willReadFrequently: true });
  context.fillStyle = 'white';
  context.fillRect(0, 0, canvas.width, height);
  const files = [];
  for (let t = 0; t < frames; t += 1) {
    const { data } = clip.frame(t);
    const image = await createImageBitmap(new ImageData(data, width, height));
    const superpixels = await result.superpixels(t);
    const panels = [
      () => {
        context.fillStyle = 'rgb(0 0 0 / 0.5)';
        context.fillRect(0, 0, width, height);
        drawTrajectories(context, result, t, { tail: 12, width: 1.8, radius: 1.8 });
      },
      () => drawSuperpixels(context, superpixels, { fill: 'none', borders: false, edges: true, width: 1 }),
      () => drawLabels(context, result, t),
    ];
    for (const [k, panel] of panels.entries()) {
      context.setTransform(1, 0, 0, 1, k * (width + gap), 0);
      context.save();
      context.beginPath();
      context.rect(0, 0, width, height);
      context.clip();
      context.drawImage(image, 0, 0);
      panel();
      context.restore();
    }
    const file = new Uint8Array(await (await canvas.convertToBlob({ type: 'image/webp', quality })).arrayBuffer());
    files.push(btoa(Array.from(file, (byte) => String.fromCharCode(byte)).join('')));
  }
  session.close();
  return files;
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) {
  await build();
  const picture = animatedWebp(await drawnFrames(PICTURE), FRAME_MS);
  writeFileSync(join(root, 'docs', 'tracecut.webp'), picture);
  console.log(`docs/tracecut.webp: ${(picture.length / 1024).toFixed(0)} KB`);
}
