// The cut-out view: kept objects on a backdrop, with smoothed and soft edges, on screen and in saved files.

import { plainFrame } from '../moving.mjs';
import { readPng } from '../png.mjs';
import { expect, test, useSample } from './fixtures.mjs';
import { accessibilityFaults, giveBytes, openLook, openSave, pngFile, saveExport, seek } from './studio-page.mjs';

const FRAME = 12;
const GREEN = [0, 0xb1, 0x40, 255];

const sample = useSample({ bypassCSP: true });

/** Runs in the page: colours on screen and of the frame, deep inside objects 1 and 2 and in the background. */
function readColors() {
  const { viewer, segmentation } = globalThis.tracecutStudio.app;
  viewer.draw();
  const { width, height } = segmentation.result;
  const mask = segmentation.mask(viewer.view.frame);
  const reach = 5;
  const isInside = (label, p) => {
    const [x, y] = [p % width, Math.floor(p / width)];
    if (x < reach || y < reach || x >= width - reach || y >= height - reach) return false;
    const steps = [-reach, 0, reach];
    return steps.every((dy) => steps.every((dx) => mask[p + dy * width + dx] === label));
  };
  const colorReader = (image, columns, rows) => {
    const data = pixelsOf(image, columns, rows);
    return (x, y) => [0, 1, 2, 3].map((channel) => data[4 * (Math.floor(y) * columns + Math.floor(x)) + channel]);
  };
  const { canvas, view } = viewer;
  const scale = canvas.width / width;
  const [screenColor, frameColor] = [
    colorReader(canvas, canvas.width, canvas.height),
    colorReader(view.image, width, height),
  ];
  return [1, 2, 0].map((label) => {
    const at = mask.findIndex((_, p) => isInside(label, p));
    const [x, y] = [at % width, Math.floor(at / width)];
    return { onScreen: screenColor((x + 0.5) * scale, (y + 0.5) * scale), ofFrame: frameColor(x, y) };
  });
}

const colors = () => sample.page.evaluate(readColors);

function expectOwnColor({ onScreen, ofFrame }) {
  expect(
    Math.max(...ofFrame.map((value, k) => Math.abs(value - onScreen[k]))),
    `${onScreen}, not ${ofFrame}`,
  ).toBeLessThanOrEqual(24);
}

test('shows the objects in their own colours, transparent around', async () => {
  const { page } = sample;
  await seek(page, FRAME);
  await expect(page.locator('#backdrop-row')).toBeHidden();
  await page.check('[name="view"][value="cutout"]', { force: true });
  await expect(page.locator('#backdrop-row')).toBeVisible();
  const [first, second, background] = await colors();
  expect(background.onScreen[3]).toBe(0);
  expectOwnColor(first);
  expectOwnColor(second);
  expect(await accessibilityFaults(page)).toEqual([]);
});

test('shows objects on green, a colour, the frame blurred, grey or dark, or a picture', async () => {
  const { page } = sample;
  const groundOn = async (backdrop) => {
    await page.selectOption('#backdrop', backdrop);
    return (await colors())[2];
  };
  expect((await groundOn('green')).onScreen).toEqual(GREEN);
  await page.selectOption('#backdrop', 'colour');
  await page.fill('#backdrop-colour', '#204080');
  expect((await colors())[2].onScreen).toEqual([0x20, 0x40, 0x80, 255]);
  const blurred = await groundOn('blurred');
  expect(blurred.onScreen[3]).toBe(255);
  expect(blurred.onScreen).not.toEqual(blurred.ofFrame);
  const grey = await groundOn('desaturated');
  expect(Math.max(...grey.onScreen.slice(0, 3)) - Math.min(...grey.onScreen.slice(0, 3))).toBeLessThanOrEqual(2);
  expect(grey.onScreen).not.toEqual(grey.ofFrame);
  const dark = await groundOn('dimmed');
  for (const c of [0, 1, 2]) expect(Math.abs(dark.onScreen[c] - 0.35 * dark.ofFrame[c])).toBeLessThanOrEqual(2);
  const [chooser] = await Promise.all([page.waitForEvent('filechooser'), page.selectOption('#backdrop', 'picture')]);
  await chooser.setFiles([
    pngFile(
      'sky.png',
      plainFrame(30, 30, () => [90, 160, 250]),
    ),
  ]);
  await expect(page.locator('#backdrop')).toHaveValue('picture');
  await expect.poll(async () => (await colors())[2].onScreen).toEqual([90, 160, 250, 255]);
});

test('smoothed masks are shown and saved', async () => {
  const { page } = sample;
  const onScreen = () => page.evaluate(() => globalThis.tracecutStudio.app.viewer.edgedMask().labels.join(''));
  const unsmoothed = await onScreen();
  await openLook(page);
  await page.fill('#edge-smooth', '1');
  await expect(page.locator('#edge-smooth-text')).toHaveText('±1');
  const smooth = await onScreen();
  expect(smooth === unsmoothed).toBe(false);
  await openSave(page);
  const { bytes } = await saveExport(page, 'png');
  const savedMask = readPng(bytes)
    .pixels.map((value) => Number(value > 0))
    .join('');
  expect(savedMask === smooth.replace(/[1-9]/g, '1')).toBe(true);
  await page.click('#export-close');
  await page.fill('#edge-smooth', '0');
  expect((await onScreen()) === unsmoothed).toBe(true);
});

test('edges grow, shrink and fade, and small pieces go; videos have the same edges', async () => {
  const { page } = sample;
  const measure = () =>
    page.evaluate(() => {
      const { alpha, labels } = globalThis.tracecutStudio.app.viewer.view.mask();
      return {
        area: alpha.reduce((sum, value) => sum + value, 0) / 255,
        soft: alpha.filter((value) => value > 0 && value < 255).length,
        labelled: labels.filter((label) => label > 0).length,
      };
    });
  await expect(page.locator('#edges-reset')).toBeHidden();
  const plain = await measure();
  expect(plain.soft).toBe(0);
  await page.fill('#edge-grow', '3');
  expect((await measure()).area).toBeGreaterThan(1.05 * plain.area);
  await page.fill('#edge-grow', '-3');
  expect((await measure()).area).toBeLessThan(0.95 * plain.area);
  await page.fill('#edge-grow', '0');
  await page.fill('#edge-feather', '6');
  await expect(page.locator('#edge-feather-text')).toHaveText('6\u00a0px');
  const soft = await measure();
  expect(soft.soft).toBeGreaterThan(500);
  expect(Math.abs(soft.area / plain.area - 1)).toBeLessThan(0.1);
  await openSave(page);
  const { bytes } = await saveExport(page, 'cutout-webm');
  await page.click('#export-close');
  await giveBytes(page, 'video', bytes);
  const differing = await page.evaluate(compareWithScreen, FRAME);
  expect(differing).toBeLessThan(0.02);
  // No piece of the sample is as small as the end of the slider.
  await page.evaluate(() => (document.querySelector('#edge-smallest').max = 5));
  await openLook(page);
  await page.fill('#edge-smallest', '4.5');
  expect((await measure()).labelled).toBeLessThan(plain.labelled);
  await page.click('#edges-reset');
  expect(await measure()).toEqual(plain);
  await expect(page.locator('#edges-reset')).toBeHidden();
});

/** Runs in the page: the share of pixels of a video's frame that differ from the canvas. */
async function compareWithScreen(frame) {
  const { videoFrames } = await import('/dist/index.js');
  const { viewer } = globalThis.tracecutStudio.app;
  for await (const { index, width, height, pixels } of videoFrames(video)) {
    if (index < frame) continue;
    const { data } = await pixels();
    const screen = pixelsOf(viewer.canvas, width, height);
    let differing = 0;
    for (let at = 0; at < data.length; at += 4)
      differing += [0, 1, 2].some((c) => Math.abs(screen[at + c] - data[at + c]) > 40);
    return differing / (data.length / 4);
  }
  return 1;
}

test('objects that are not kept are neither shown nor saved', async () => {
  const { page } = sample;
  await page.selectOption('#backdrop', 'green');
  await page.uncheck('[data-object="1"] input');
  const [first, second] = await colors();
  expect(first.onScreen).toEqual(GREEN);
  expectOwnColor(second);
  await openSave(page);
  await expect(page.locator('#export-kept')).toHaveText(/^Only Object 2, Object 3 will be saved/);
  await expect(page.locator('[data-export="cutout-webm"]')).toHaveText('Green WebM');
  expect((await saveExport(page, 'cutout-webm')).name).toBe('sample-clip-green.webm');
  await page.click('#export-close');
  await page.check('[name="view"][value="overlay"]', { force: true });
  await expect(page.locator('#backdrop-row')).toBeHidden();
  await page.click('#show-all');
});

test('the background is saved without the objects', async () => {
  const { page } = sample;
  await seek(page, FRAME);
  await openSave(page);
  const { name, bytes } = await saveExport(page, 'background-png');
  expect(name).toBe('sample-clip-background-0013.png');
  const zip = await saveExport(page, 'background-zip');
  expect(zip.name).toBe('sample-clip-background.zip');
  await giveBytes(page, 'png', bytes);
  await giveBytes(page, 'zip', zip.bytes);
  const { files, changed, unchanged } = await page.evaluate(compareBackground, FRAME);
  expect(files).toEqual([16, true]);
  expect(changed).toBeGreaterThan(0.9);
  expect(unchanged).toBeGreaterThan(0.9);
  await page.click('#export-close');
});

/** Runs in the page: number of files of the ZIP and if the frame is in it; changed share of objects, unchanged share of the rest. */
async function compareBackground(frame) {
  const { unzipSync } = await import('/dist/vendor/zip.js');
  const files = unzipSync(new Uint8Array(await zip.arrayBuffer()));
  const { job, segmentation } = globalThis.tracecutStudio.app;
  const bitmap = await createImageBitmap(png);
  const [background, ofFrame] = [bitmap, await job.images.open(frame)].map(
    (image) => new Uint32Array(pixelsOf(image).buffer),
  );
  const counts = { objects: 0, changed: 0, rest: 0, unchanged: 0 };
  segmentation.mask(frame).forEach((label, p) => {
    counts[label > 0 ? 'objects' : 'rest'] += 1;
    if (label > 0) counts.changed += background[p] !== ofFrame[p];
    else counts.unchanged += background[p] === ofFrame[p];
  });
  const name = `${String(frame + 1).padStart(4, '0')}.png`;
  return {
    files: [Object.keys(files).length, files[name].join() === new Uint8Array(await png.arrayBuffer()).join()],
    changed: counts.changed / counts.objects,
    unchanged: counts.unchanged / counts.rest,
  };
}
