// What the page saves, saved through its dialog and opened again: all kinds once, the four large choices, and the words,
// recipe and link beside them.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { unzipSync } from 'fflate';
import { version } from '../../dist/node.js';
import { adjustMask } from '../../dist/node/edit.js';
import { WIDE, fiveObjects } from './five-objects.mjs';
import {
  SMALL,
  accessibilityFaults,
  bytesOf,
  ended,
  exportAs,
  openFix,
  openRedo,
  openSample,
  openSave,
  plainFrame,
  pngFile,
  redo,
  run,
  screenshot,
  setControl,
  text,
  useSite,
} from './support.mjs';

const FRAME = 12;

describe('exports', () => {
  const site = useSite();
  let page;
  let faults;
  let labels;

  test('are offered for the sample, in a dialog without accessibility faults', async () => {
    ({ page, faults } = await openSample(site, { bypassCSP: true, acceptDownloads: true }));
    const found = await page.evaluate(
      (frames) => Array.from({ length: frames }, (_, t) => [...globalThis.tracecutStudio.result.labels(t)]),
      SMALL.frames,
    );
    // Specks are left out: less than 0.02 % of the frame.
    labels = found.map((one) => [
      ...adjustMask({ labels: Uint8Array.from(one), width: SMALL.width, height: SMALL.height }, { smallest: 6 }).labels,
    ]);
    assert.notDeepEqual(labels, found, 'the sample has a speck');
    await page.evaluate((frame) => globalThis.tracecutStudio.app.timeline.seek(frame), FRAME);
    await setControl(page, '[data-setting="masks.fill"]', '0.5');
    await page.keyboard.press('e');
    await page.locator('#export').waitFor();
    await page.click('#export-more > summary');
    await screenshot(page, 'export');
    assert.deepEqual(await accessibilityFaults(page), []);
  });

  /** Saves one thing; its name and bytes. */
  async function save(id) {
    const coming = page.waitForEvent('download');
    await exportAs(page, id);
    const file = await coming;
    await page.waitForFunction(() => /^Saved/.test(document.querySelector('#export-status').textContent));
    return { name: file.suggestedFilename(), bytes: await bytesOf(file) };
  }

  test('the mask of a frame is a PNG in the objects’ colours', async () => {
    const { name, bytes } = await save('png');
    assert.equal(name, 'sample-clip-mask-0013.png');
    const wrong = await page.evaluate(countWrongPixels, [[...bytes], labels[FRAME]]);
    assert.equal(wrong, 0);
  });

  test('the background is the frame without its objects', async () => {
    const { name, bytes } = await save('background-png');
    assert.equal(name, 'sample-clip-background-0013.png');
    const object = await page.evaluate(deepInside, [labels[FRAME], 1]);
    const ground = await page.evaluate(deepInside, [labels[FRAME], 0]);
    const [[behind, beside], [before, unchanged]] = await page.evaluate(colorsOf, [
      [...bytes],
      FRAME,
      [object, ground],
    ]);
    assert.deepEqual(beside, unchanged);
    assert.notDeepEqual(behind, before);
    const zip = await save('background-zip');
    assert.equal(zip.name, 'sample-clip-background.zip');
    const files = unzipSync(zip.bytes);
    assert.equal(Object.keys(files).length, SMALL.frames);
    assert.deepEqual([...files['0013.png']], [...bytes]);
  });

  test('all masks are a ZIP of such files, with their times', async () => {
    const { name, bytes } = await save('zip');
    assert.equal(name, 'sample-clip-masks.zip');
    const files = unzipSync(bytes);
    const pictures = Object.keys(files)
      .filter((file) => file.endsWith('.png'))
      .sort();
    assert.equal(pictures.length, SMALL.frames);
    assert.equal(await page.evaluate(countWrongPixels, [[...files[pictures[7]]], labels[7]]), 0);
    const about = JSON.parse(new TextDecoder().decode(files['masks.json']));
    assert.ok(JSON.stringify(about).includes(version));
    assert.ok(Math.abs(about.times[3] - 3 / 15) < 1e-6, String(about.times));
  });

  const videos = {
    'overlay-webm': 'overlay.webm',
    'overlay-mp4': 'overlay.mp4',
    'cutout-webm': 'cutout.webm',
    'cutout-mp4': 'green.mp4',
  };
  for (const [id, file] of Object.entries(videos)) {
    test(`${file} plays, with the objects where they are`, async (t) => {
      if (id.endsWith('mp4') && !(await page.evaluate(canEncodeMp4))) return t.skip('this browser encodes no MP4');
      const { name, bytes } = await save(id);
      assert.equal(name, `sample-clip-${file}`);
      const object = labels[FRAME].indexOf(1);
      const inside = await page.evaluate(deepInside, [labels[FRAME], 1]);
      const outside = await page.evaluate(deepInside, [labels[FRAME], 0]);
      assert.ok(object >= 0);
      const { size, duration, colors } = await page.evaluate(frameOf, [
        [...bytes],
        file.endsWith('mp4') ? 'video/mp4' : 'video/webm',
        (FRAME + 0.5) / 15,
        [inside, outside],
      ]);
      assert.deepEqual(size, [SMALL.width, SMALL.height]);
      assert.ok(Math.abs(duration - SMALL.frames / 15) < 0.1, `${duration} s`);
      if (id.startsWith('cutout')) {
        assert.equal(colors[0][3], 255, 'the object is there');
        if (id === 'cutout-webm') assert.ok(colors[1][3] < 20, `ground ${colors[1]}`);
        else assert.ok(colors[1][1] > 130 && colors[1][0] < 60, `ground ${colors[1]}`);
      } else {
        assert.ok(colors[0][0] > colors[0][2] + 20, `the first object is tinted orange: ${colors[0]}`);
      }
    });
  }

  test('only the objects that are kept', async () => {
    await page.click('#export-close');
    await page.click('[data-object="1"] .keep');
    await openSave(page);
    assert.match(await text(page, '#export-kept'), /^Only Object 2.* will be saved/);
    const coco = JSON.parse((await save('coco')).bytes);
    assert.ok(coco.annotations.length > 0 && coco.annotations.every(({ track_id }) => track_id !== 1));
    await page.click('#export-close');
    await page.click('#show-all');
    await openSave(page);
    assert.equal(await text(page, '#export-kept'), '');
  });

  test('a video in the making is cancelled', async () => {
    let downloads = 0;
    page.on('download', () => (downloads += 1));
    await page.evaluate(() => {
      document.querySelector('[data-export="overlay-webm"]').click();
      document.querySelector('#export-cancel').click();
    });
    await page.waitForFunction(() => /^Cancelled/.test(document.querySelector('#export-status').textContent));
    assert.equal(await page.locator('#export-progress').isVisible(), false);
    assert.equal(downloads, 0);
  });

  test('a video in the making says how much longer it takes', async () => {
    const { shown, ended: end } = await page.evaluate(async () => {
      const { encode } = VideoEncoder.prototype;
      VideoEncoder.prototype.encode = function (...args) {
        const until = performance.now() + 400;
        while (performance.now() < until);
        return encode.apply(this, args);
      };
      const shown = [];
      const count = document.querySelector('#export-count');
      new MutationObserver(() => shown.push([performance.now(), count.textContent])).observe(count, {
        childList: true,
      });
      const begun = performance.now();
      document.querySelector('[data-export="overlay-webm"]').click();
      while (!/^Saved/.test(document.querySelector('#export-status').textContent))
        await new Promise((done) => setTimeout(done, 20));
      VideoEncoder.prototype.encode = encode;
      return { shown: shown.map(([at, words]) => [at - begun, words]), ended: performance.now() - begun };
    });
    const said = shown.filter(([, words]) => /left$/.test(words));
    assert.ok(said.length > 4, JSON.stringify(shown));
    assert.ok(said[0][0] > 2000 && said[0][0] < 3500, `first after ${said[0][0]} ms`);
    for (const [at, words] of said) {
      const [, left] = words.match(/^\d+ of 16 frames, about (\d+)\ss left$/);
      const real = (end - at) / 1000;
      // Half a second is what rounding does.
      assert.ok(left < 1.5 * real + 0.5 && left > real / 1.5 - 0.5, `${words}, in truth ${real} s`);
    }
  });

  test('the recipe names version, settings and a sum of the masks; the link carries the settings', async () => {
    await page.click('#recipe-box > summary');
    await page.waitForFunction(() => /sha256/.test(document.querySelector('#recipe').textContent));
    const recipe = JSON.parse(await page.textContent('#recipe'));
    assert.equal(recipe.tracecut, version);
    assert.deepEqual(recipe.parameters, {});
    assert.match(recipe.masks.sha256, /^[0-9a-f]{64}$/);
    await page.click('#export-close');
    await openRedo(page);
    await page.check('[name="trajectory.gridStep"][value="6"]', { force: true });
    await page.click('#redo-close');
    await page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
    await openSave(page);
    await page.click('#copy-link');
    await page.waitForFunction(() => /copied/.test(document.querySelector('#export-status').textContent));
    const link = await page.evaluate(() => navigator.clipboard.readText());
    assert.match(link, /#trajectory\.gridStep=6$/);
    const { page: other } = await site.open();
    await other.goto('about:blank');
    await other.goto(link);
    assert.equal(await ended(other), 'done');
    assert.deepEqual(await other.evaluate(() => globalThis.tracecutStudio.app.job.options), {
      trajectory: { gridStep: 6 },
    });
    assert.deepEqual(faults, []);
  });

  test('a still image has no masks to save', async () => {
    await page.click('#export-close');
    await run(page, [pngFile('plain.png', plainFrame(40, 30))]);
    assert.equal(await page.locator('#export-open').isVisible(), false);
    assert.match(await text(page, '#headline'), /still image/i);
  });
});

describe('words', () => {
  const site = useSite({ sample: 'tiny' });

  test('say plainly what happens; numbers stand in the help; one button is the next step', async () => {
    const { page } = await openSample(site);
    const primary = () =>
      page.evaluate(() =>
        [...document.querySelectorAll('.primary')].filter((one) => one.checkVisibility()).map(({ id }) => id),
      );
    assert.deepEqual(await primary(), ['open'], 'drop');
    assert.equal(await page.locator('#subline').isVisible(), false);
    assert.equal(await page.locator('#facts').isVisible(), false);
    await page.click('#help-open');
    await page.waitForSelector('#help[open]');
    assert.match(await text(page, '#facts'), /^4 frames of .* computed in/);
    await page.click('#help-close');
    await page.evaluate(() => {
      globalThis.heads = new Set();
      const head = document.querySelector('#headline');
      new MutationObserver(() => globalThis.heads.add(head.textContent)).observe(head, { childList: true });
    });
    await redo(page);
    await page.waitForSelector('#cancel', { state: 'visible' });
    await ended(page);
    const heads = await page.evaluate(() => [...globalThis.heads]);
    assert.ok(heads.includes('Grouping motion'), heads.join(' | '));
    for (const head of heads)
      assert.doesNotMatch(head, /window|flow|trajector|affinit|embedding|discontin|saliency|superpixel|cut/i);
    await openFive(page);
    assert.deepEqual(await primary(), ['export-open'], 'check');
    await openFix(page);
    assert.deepEqual(await primary(), ['correct-done'], 'fix');
    await page.click('#correct-done');
    await page.click('#export-open');
    await page.waitForSelector('#export[open]');
    assert.equal(await page.locator('#export .primary:visible').count(), 1, 'save');
  });

  test('saving has four large choices; all others are behind “More”', async () => {
    const { page, faults } = await openSample(site, { bypassCSP: true });
    await openFive(page);
    await page.click('#export-open');
    await page.waitForSelector('#export[open]');
    const seen = () => page.locator('[data-export]:visible').evaluateAll((all) => all.map((one) => one.dataset.export));
    assert.deepEqual(await seen(), ['transparent', 'green', 'blurred', 'zip']);
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'save');
    const corner = {};
    for (const [id, name] of [
      ['transparent', 'five-cutout.webm'],
      ['green', 'five-green.mp4'],
      ['blurred', 'five-blur.mp4'],
    ]) {
      const coming = page.waitForEvent('download');
      await exportAs(page, id);
      const file = await coming;
      assert.equal(file.suggestedFilename(), name);
      corner[id] = await page.evaluate(cornerOf, [...(await bytesOf(file))]);
      await page.waitForFunction(() => /^Saved/.test(document.querySelector('#export-status').textContent));
    }
    assert.deepEqual(
      [corner.transparent.alpha, corner.green.alpha, corner.blurred.alpha],
      [true, false, false],
      'what is transparent',
    );
    const [red, green, blue] = corner.green.colour;
    assert.ok(red < 60 && green > 140 && blue < 110, `green is ${corner.green.colour}`);
    assert.ok(corner.blurred.colour[0] > 60, `blurred is ${corner.blurred.colour}`);
    await page.click('#export-more > summary');
    assert.ok((await seen()).length > 12);
    assert.deepEqual(faults, []);
  });
});

/** Opens the project of a clip with five objects. */
async function openFive(page, shape = WIDE) {
  await page.setInputFiles('#file', [(await fiveObjects(page, shape)).project]);
  await page.waitForFunction(
    (width) => globalThis.tracecutStudio.source?.width === width && document.body.dataset.state === 'done',
    shape.width,
  );
  assert.equal(await page.locator('.object').count(), 6);
}

/** Runs in the page: whether a video has an alpha channel, and the colour of its first frame's lower left corner. */
async function cornerOf(bytes) {
  const media = await import('/dist/vendor/media.js');
  const { videoFrames } = await import('/dist/index.js');
  const blob = new Blob([new Uint8Array(bytes)]);
  const input = new media.Input({ source: new media.BlobSource(blob), formats: media.ALL_FORMATS });
  const packets = new media.EncodedPacketSink(await input.getPrimaryVideoTrack());
  const { sideData } = await packets.getFirstPacket();
  for await (const { pixels } of videoFrames(blob)) {
    const frame = await pixels();
    const at = 4 * ((frame.height - 5) * frame.width + 4);
    return { alpha: Boolean(sideData.alpha), colour: [...frame.data.slice(at, at + 3)] };
  }
  return null;
}

/** Runs in the page: pixels of a PNG that are not in their label's colour; the background is black. */
async function countWrongPixels([bytes, labels]) {
  const { objectColor } = globalThis.tracecutStudio;
  const image = await createImageBitmap(new Blob([new Uint8Array(bytes)], { type: 'image/png' }));
  const ctx = new OffscreenCanvas(image.width, image.height).getContext('2d');
  ctx.drawImage(image, 0, 0);
  const { data } = ctx.getImageData(0, 0, image.width, image.height);
  if (labels.length * 4 !== data.length) return Infinity;
  const wanted = (label) => (label === 0 ? 0 : Number.parseInt(objectColor(label).slice(1), 16));
  return labels.filter((label, p) => ((data[4 * p] << 16) | (data[4 * p + 1] << 8) | data[4 * p + 2]) !== wanted(label))
    .length;
}

/** Runs in the page: a pixel all around which the label is the same. */
function deepInside([labels, wanted]) {
  const { width } = globalThis.tracecutStudio.result;
  for (let reach = 12; reach > 0; reach -= 1) {
    const at = labels.findIndex((_, p) => {
      for (let dy = -reach; dy <= reach; dy += reach)
        for (let dx = -reach; dx <= reach; dx += reach) if (labels[p + dy * width + dx] !== wanted) return false;
      return true;
    });
    if (at >= 0) return [at % width, Math.floor(at / width)];
  }
  return [0, 0];
}

/** Runs in the page: colours of places in a picture's file, and in the frame itself. */
async function colorsOf([bytes, frame, places]) {
  const file = await createImageBitmap(new Blob([new Uint8Array(bytes)], { type: 'image/png' }));
  const own = await globalThis.tracecutStudio.app.job.images.open(frame);
  return [file, own].map((picture) => {
    const ctx = new OffscreenCanvas(picture.width, picture.height).getContext('2d', { willReadFrequently: true });
    ctx.drawImage(picture, 0, 0);
    return places.map(([x, y]) => [...ctx.getImageData(x, y, 1, 1).data]);
  });
}

/** Runs in the page: what a player shows of a file at a time. */
async function frameOf([bytes, type, time, places]) {
  const video = document.createElement('video');
  const event = (name) =>
    new Promise((done, failed) =>
      Object.assign(video, { [`on${name}`]: done, onerror: () => failed(new Error(video.error?.message)) }),
    );
  const loaded = event('loadeddata');
  Object.assign(video, { muted: true, src: URL.createObjectURL(new Blob([new Uint8Array(bytes)], { type })) });
  await loaded;
  const sought = event('seeked');
  video.currentTime = time;
  await sought;
  const { videoWidth, videoHeight, duration } = video;
  const ctx = new OffscreenCanvas(videoWidth, videoHeight).getContext('2d', { willReadFrequently: true });
  // The picture may come a little after the word that it has.
  for (let left = 100; left > 0; left -= 1) {
    ctx.drawImage(video, 0, 0);
    if (ctx.getImageData(...places[0], 1, 1).data[3] > 0) break;
    await new Promise((done) => setTimeout(done, 20));
  }
  return {
    size: [videoWidth, videoHeight],
    duration,
    colors: places.map(([x, y]) => [...ctx.getImageData(x, y, 1, 1).data]),
  };
}

/** Runs in the page. */
async function canEncodeMp4() {
  const media = await import('/dist/vendor/media.js');
  return media.canEncodeVideo ? media.canEncodeVideo('avc', { width: 480, height: 270 }) : true;
}
