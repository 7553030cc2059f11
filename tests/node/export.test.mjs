// Masks as files: prompts, PNG files, archives and animations, opened again and compared with what other programs write.

import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { describe, test } from 'node:test';
import { encodeVideo, maskPng, masksZip, version } from 'tracecut';
import { objectColor, objectShape } from 'tracecut/draw';
import { cocoRle, encodeImages, fromCocoRle, labelMaps, labelsNpy, prompts } from 'tracecut/export';
import { blackenAround } from '../../dist/kit/export/video-painter.js';
import { unzipSync, unzlibSync } from '../../dist/vendor/zip.js';
import { pngParts, readPng } from '../png.mjs';
import { abortAt, each, mapPixels, rejects, resultOf } from './support.mjs';

/** Masks of digit pictures, one for each frame. */
function drawn(...frames) {
  const pictures = frames.map((rows) => rows.map((row) => [...row].map(Number)));
  const [height, width] = [pictures[0].length, pictures[0][0].length];
  return { width, height, numFrames: frames.length, labels: (t) => Uint8Array.from(pictures[t].flat()) };
}

const TWO_FRAMES = drawn(['0110', '0120', '0000'], ['0011', '0012', '0300']);

/** Every label once. */
const ALL_LABELS = { width: 16, height: 16, numFrames: 1, labels: () => Uint8Array.from({ length: 256 }, (_, k) => k) };

const text = (bytes) => new TextDecoder().decode(bytes);
const hex = (rgb) => `#${Buffer.from(rgb).toString('hex')}`;
/** White where a mask has a label, black elsewhere. */
const whiteOn = (labels, object) => labels.map((label) => (label === object ? 255 : 0));
const sum = (list) => list.reduce((total, value) => total + value, 0);

describe('a mask as a PNG file', () => {
  test('has the labels as pixels and the palette of the objects', async () => {
    const { pixels, palette, alpha, ...head } = readPng(await maskPng(TWO_FRAMES, 1));
    assert.deepEqual(head, { width: 4, height: 3, depth: 8, colorType: 3, order: 'IHDR PLTE IDAT IEND' });
    assert.deepEqual([...pixels], [...TWO_FRAMES.labels(1)]);
    assert.equal(alpha, null);
    assert.equal(hex(palette.subarray(0, 3)), '#000000');
    for (const label of [1, 2, 3, 255])
      assert.equal(hex(palette.subarray(3 * label, 3 * label + 3)), objectColor(label));
  });

  test('is one object in white on black', async () => {
    const { pixels, palette, colorType } = readPng(await maskPng(TWO_FRAMES, 1, { object: 2 }));
    assert.deepEqual([colorType, palette], [0, null]);
    assert.deepEqual(pixels, whiteOn(TWO_FRAMES.labels(1), 2));
  });

  test('is empty where an object is in other frames only, and an error where it is in none', async () => {
    const twoPixels = { width: 2, height: 1, numFrames: 2, labels: (t) => Uint8Array.of(3 * t, 5) };
    assert.deepEqual([...readPng(await maskPng(twoPixels, 0, { object: 3 })).pixels], [0, 0]);
    await rejects(maskPng(twoPixels, 0, { object: 77 }), 'param', /object = 77 .*an object: 3, 5/);
    const emptyMasks = { ...twoPixels, labels: () => new Uint8Array(2) };
    await rejects(maskPng(emptyMasks, 0, { object: 1 }), 'param', /object = 1 .*there are none/);
  });

  test('is one object on nothing, alone and in archives', async () => {
    const single = await maskPng(TWO_FRAMES, 1, { object: 2, transparent: true });
    const { order, alpha, pixels } = readPng(single);
    assert.equal(order, 'IHDR tRNS IDAT IEND');
    assert.deepEqual([...alpha], [0, 0], 'the grey value that is clear');
    assert.ok(pixels.includes(255) && pixels.includes(0));
    const files = unzipSync(await masksZip(TWO_FRAMES, { perObject: true, transparent: true }));
    assert.deepEqual(files['object-2/00001.png'], single);
  });

  test('is called after its frame in the clip, where the masks are a window of it', async () => {
    const files = unzipSync(await masksZip({ ...TWO_FRAMES, firstFrame: 40 }));
    assert.deepEqual(Object.keys(files), ['00040.png', '00041.png', 'masks.json']);
    const { firstFrame, files: names } = JSON.parse(new TextDecoder().decode(files['masks.json']));
    assert.deepEqual([firstFrame, names], [40, ['00040.png', '00041.png']]);
  });

  test('can have a clear background, and colours of the caller', async () => {
    const options = { transparent: true, palette: ['#010203', '#040506'] };
    const { order, alpha, palette } = readPng(await maskPng(TWO_FRAMES, 0, options));
    assert.equal(order, 'IHDR PLTE tRNS IDAT IEND');
    assert.deepEqual([...alpha], [0]);
    assert.deepEqual([...palette.subarray(0, 6)], [1, 2, 3, 4, 5, 6]);
    assert.equal(hex(palette.subarray(6, 9)), objectColor(2), 'labels that the list does not reach keep theirs');
  });

  test('holds all 255 labels, and the smallest of frames', async () => {
    assert.deepEqual([...readPng(await maskPng(ALL_LABELS, 0)).pixels], [...ALL_LABELS.labels(0)]);
    const dot = readPng(await maskPng(drawn(['0']), 0));
    assert.deepEqual([dot.width, dot.height, [...dot.pixels]], [1, 1, [0]]);
  });

  test('refuses invalid input with a message', async () => {
    const options = (wrong, message) => rejects(maskPng(TWO_FRAMES, 0, wrong), 'param', message);
    await options({ object: 256 }, /object = 256 .*0\.\.=255/);
    await options(
      { objects: [1] },
      /objects = a list of 1 .*a known option, such as object; the options are object, palette, transparent/,
    );
    await options({ transparent: 1 }, /transparent = 1 .*true or false/);
    await options({ palette: ['red'] }, /"red" \(expected #rrggbb\)/);
    await rejects(maskPng(TWO_FRAMES, 2), 'param', /t = 2 \(expected a whole number, 0\.\.=1\)/);
    await rejects(maskPng({ width: 2, height: 2 }, 0), 'data', /masks = an Object .*labels\(t\)/);
    const masks = (wrong, message) => rejects(maskPng({ ...TWO_FRAMES, ...wrong }, 0), 'data', message);
    await masks({ width: 0 }, /masks\.width = 0/);
    await masks({ labels: () => new Uint8Array(11) }, /has 11 labels \(expected 12\)/);
    await masks({ labels: () => new Uint16Array(12).fill(256) }, /\[0\] = 256 .*0\.\.=255/);
    await masks({ labels: () => 'labels' }, /"labels" .*4 × 3 labels/);
  });
});

describe('a ZIP of masks', () => {
  test('has a file for each frame, and a JSON file with times, labels and colours', async () => {
    const files = unzipSync(await masksZip({ ...TWO_FRAMES, times: [0.5, 0.75], end: 1.5 }));
    assert.deepEqual(Object.keys(files), ['00000.png', '00001.png', 'masks.json']);
    for (const t of [0, 1]) assert.deepEqual([...readPng(files[`0000${t}.png`]).pixels], [...TWO_FRAMES.labels(t)]);
    assert.deepEqual(JSON.parse(text(files['masks.json'])), {
      generator: 'tracecut',
      version,
      width: 4,
      height: 3,
      numFrames: 2,
      times: [0.5, 0.75],
      durations: [0.25, 0.75],
      frameRate: 2,
      labels: [1, 2, 3],
      palette: { 0: '#000000', 1: objectColor(1), 2: objectColor(2), 3: objectColor(3) },
      files: ['00000.png', '00001.png'],
    });
  });

  test('has a folder for each object if asked, and leaves out those not chosen', async () => {
    const progress = [];
    const options = { perObject: true, objects: [1, 3, 9], frameRate: 25, onProgress: (step) => progress.push(step) };
    const files = unzipSync(await masksZip(TWO_FRAMES, options));
    const names = [1, 3].flatMap((label) => [0, 1].map((t) => `object-${label}/0000${t}.png`));
    assert.deepEqual(Object.keys(files).sort(), ['masks.json', ...names].sort());
    assert.deepEqual(readPng(files['object-3/00001.png']).pixels, whiteOn(TWO_FRAMES.labels(1), 3));
    const { labels, times, durations, frameRate, files: listed } = JSON.parse(text(files['masks.json']));
    assert.deepEqual({ labels, times, durations }, { labels: [1, 3], times: [0, 0.04], durations: [0.04, 0.04] });
    assert.equal(frameRate, 25);
    assert.deepEqual(Object.values(listed).flat(), names);
    assert.deepEqual(progress, [
      { done: 1, total: 2 },
      { done: 2, total: 2 },
    ]);
    const shots = [
      { first: 0, last: 0 },
      { first: 1, last: 1 },
    ];
    assert.deepEqual(JSON.parse(text(unzipSync(await masksZip({ ...TWO_FRAMES, shots }))['masks.json'])).shots, shots);
    const onlySecond = unzipSync(await masksZip(TWO_FRAMES, { objects: (label) => label === 2 }));
    const expected = TWO_FRAMES.labels(0).map((label) => (label === 2 ? 2 : 0));
    assert.deepEqual(readPng(onlySecond['00000.png']).pixels, expected);
  });

  test('is byte-identical at any time and in any time zone', async (t) => {
    const zone = process.env.TZ;
    t.after(() => (zone === undefined ? delete process.env.TZ : (process.env.TZ = zone)));
    const archives = [];
    for (const place of ['UTC', 'Asia/Tokyo', 'America/Los_Angeles']) {
      process.env.TZ = place;
      archives.push(Buffer.from(await masksZip(TWO_FRAMES)).toString('base64'));
    }
    assert.equal(new Set(archives).size, 1);
  });

  test('of masks without objects is one of empty masks', async () => {
    const files = unzipSync(await masksZip(drawn(['00', '00']), { perObject: true }));
    assert.deepEqual(Object.keys(files), ['masks.json']);
    const { labels, times } = JSON.parse(text(files['masks.json']));
    assert.deepEqual([labels, times], [[], null]);
  });

  test('stops on request, and refuses impossible times', async () => {
    await assert.rejects(masksZip(TWO_FRAMES, abortAt()), { name: 'AbortError' });
    const times = (wrong, message) => rejects(masksZip({ ...TWO_FRAMES, times: wrong }), 'data', message);
    await times([0], /has 1 times \(expected 2, one a frame\)/);
    await times([1, 1], /times\[1\] = 1 \(expected seconds, ascending\)/);
    const options = (wrong, message) => rejects(masksZip(TWO_FRAMES, wrong), 'param', message);
    await options({ frameRate: 0 }, /frameRate = 0/);
    await options({ objects: [256] }, /objects = 256/);
    await options({ objects: 1 }, /objects = 1 \(expected a list of labels/);
  });
});

describe('masks as COCO run lengths', () => {
  // What pycocotools 2.0.11 makes of these pictures: counts, area, box.
  const KNOWN = [
    [['1'], '01', 1, [0, 0, 1, 1]],
    [['010', '011', '000'], '322OO', 3, [1, 0, 2, 2]],
    [['11111', '10001', '10101', '10001', '11111'], '063LNO0124', 17, [0, 0, 5, 5]],
    [['111', '111'], '06', 6, [0, 0, 3, 2]],
    [['0110', '0110', '0110'], '363', 6, [1, 0, 2, 3]],
  ];

  test('equal pycocotools, and give the mask back', async () => {
    for (const [rows, counts, area, bbox] of KNOWN) {
      const masks = drawn(rows);
      const { annotations } = await cocoRle(masks);
      const [annotation] = annotations;
      assert.deepEqual(annotation.segmentation, { size: [masks.height, masks.width], counts });
      assert.deepEqual([annotation.area, annotation.bbox], [area, bbox]);
      assert.deepEqual(await fromCocoRle(annotation.segmentation), masks.labels(0));
    }
    assert.deepEqual([...(await fromCocoRle({ size: [1, 1], counts: '1' }))], [0]);
    const plain = await fromCocoRle({ size: [2, 3], counts: [1, 2, 3] });
    assert.deepEqual([...plain], [0, 1, 0, 1, 0, 0], 'plain lengths');
  });

  test('equal pycocotools where runs are long', async () => {
    const [width, height] = [400, 300];
    const isInside = (x, y) => (x - 170) ** 2 + (y - 140) ** 2 < 100 ** 2 || x >= 395;
    const labels = mapPixels(width, height, (x, y) => 4 * isInside(x, y));
    const { annotations } = await cocoRle({ width, height, numFrames: 1, labels: () => labels });
    const [{ segmentation, area, bbox, track_id }] = annotations;
    assert.match(segmentation.counts, /^bmd0m0Z8:F:H6I8I6K4K6K4L4L4L4L4L4M2M4M2M4M2N2M4M2N2N2M4M2N2N/);
    const hash = createHash('sha256').update(segmentation.counts).digest('hex');
    assert.equal(hash, '8e6d0d69f08ca4259d93b78430620f7fbfa41716e59504035d2b60af8a6689f5');
    assert.deepEqual([area, bbox, track_id], [32897, [71, 0, 329, 300], 4]);
    const pixels = labels.map((label) => Number(label > 0));
    assert.deepEqual(await fromCocoRle(segmentation), pixels);
  });

  test('have frames, times, objects and categories', async () => {
    const category = (label) => (label === 3 ? 'ball' : 'person');
    const coco = await cocoRle(
      { ...TWO_FRAMES, times: Float64Array.of(2, 2.5) },
      { category, video: 'clip.mp4', fileName: (t) => `frames/${t}.jpg` },
    );
    assert.deepEqual(coco.videos, [{ id: 1, name: 'clip.mp4', width: 4, height: 3, frame_times: [2, 2.5] }]);
    const facts = { id: 2, video_id: 1, frame_index: 1, width: 4, height: 3 };
    assert.deepEqual(coco.images[1], { ...facts, file_name: 'frames/1.jpg', timestamp: 2.5 });
    assert.deepEqual(coco.categories, [
      { id: 1, name: 'person' },
      { id: 2, name: 'ball' },
    ]);
    const tracks = [1, 2, 3].map((id) => ({ id, category_id: id === 3 ? 2 : 1, video_id: 1 }));
    assert.deepEqual(coco.tracks, tracks);
    assert.deepEqual(each(coco.annotations, 'id', 'image_id', 'track_id', 'category_id', 'iscrowd'), [
      [2, 1, 1, 1, 0],
      [3, 1, 2, 1, 0],
      [258, 2, 1, 1, 0],
      [259, 2, 2, 1, 0],
      [260, 2, 3, 2, 0],
    ]);
    assert.ok(coco.annotations.every(({ track_id, attributes }) => attributes.track_id === track_id));
    assert.equal(coco.info.version, version);
  });

  test('of overlapping windows give the clip, put together', async () => {
    const times = [0, 0.1, 0.2, 0.3, 0.4];
    const labels = (t) => Uint8Array.of(1, t, 0);
    const clip = { width: 3, height: 1, numFrames: 5, times, labels };
    const part = (first, numFrames, from, to) => ({
      ...clip,
      ...{ numFrames, firstFrame: first, settled: { from, to }, times: times.slice(first, first + numFrames) },
      labels: (t) => labels(first + t),
    });
    const parts = [part(0, 3, 0, 2), part(1, 4, 1, 4), clip].map((masks) => cocoRle(masks));
    const [a, b, everyPart] = await Promise.all(parts);
    assert.deepEqual([...a.images, ...b.images], everyPart.images);
    assert.deepEqual([...a.annotations, ...b.annotations], everyPart.annotations);
    assert.deepEqual([...a.videos[0].frame_times, ...b.videos[0].frame_times], everyPart.videos[0].frame_times);
    assert.equal(new Set(everyPart.annotations.map(({ id }) => id)).size, everyPart.annotations.length);
    await rejects(cocoRle({ ...clip, firstFrame: -1 }), 'data', /firstFrame = -1/);
  });

  test('are none where there is no object, and 255 for 255 objects', async () => {
    const emptyRle = await cocoRle(drawn(['00']));
    assert.deepEqual([emptyRle.annotations, emptyRle.tracks, emptyRle.images.length], [[], [], 1]);
    assert.ok(!('timestamp' in emptyRle.images[0] || 'frame_times' in emptyRle.videos[0]));
    const rle = await cocoRle(ALL_LABELS);
    const expected = Array.from({ length: 255 }, (_, k) => [k + 1, 1]);
    assert.deepEqual(each(rle.annotations, 'track_id', 'area'), expected);
    assert.deepEqual(each((await cocoRle(ALL_LABELS, { objects: [7] })).annotations, 'bbox'), [[7, 0, 1, 1]]);
    const background = await cocoRle(ALL_LABELS, { objects: [0] });
    assert.equal(background.annotations[0].area, 1, 'the background if asked for');
  });

  test('that are damaged are refused with a message', async () => {
    const wrong = (segmentation, message) => rejects(fromCocoRle(segmentation), 'data', message);
    await wrong({ size: [2, 2], counts: '1' }, /cover 1 pixels \(expected 4\)/);
    await wrong({ size: [2, 2], counts: 'P' }, /counts = "P"/);
    await wrong({ size: [2, 2], counts: '~' }, /counts = "~"/);
    await wrong({ size: [2, 2], counts: [5] }, /counts\[0\] = 5/);
    await wrong({ size: [2, 2], counts: '22O' }, /counts\[2\] = -1/);
    await wrong({ size: [2], counts: '1' }, /expected an object \{size: \[height, width\], counts\}/);
    await wrong('1', /segmentation = "1"/);
  });
});

describe('masks as arrays', () => {
  test('are all frames one after the other, with their times', () => {
    const { data, times, ...size } = labelMaps({ ...TWO_FRAMES, times: [1, 2] });
    assert.deepEqual(size, { width: 4, height: 3, numFrames: 2 });
    assert.deepEqual([...data], [...TWO_FRAMES.labels(0), ...TWO_FRAMES.labels(1)]);
    assert.deepEqual(times, Float64Array.of(1, 2));
    assert.equal(labelMaps(TWO_FRAMES).times, null);
    assert.deepEqual([...labelMaps(TWO_FRAMES, { frameRate: 4 }).times], [0, 0.25]);
  });

  test('are a file that NumPy reads', () => {
    const file = labelsNpy(TWO_FRAMES);
    const header = Buffer.from(file).readUInt16LE(8);
    assert.equal(Buffer.from(file).toString('latin1', 0, 8), '\x93NUMPY\x01\0');
    assert.equal((10 + header) % 64, 0);
    assert.match(
      text(file.subarray(10, 10 + header)),
      /^\{'descr': '\|u1', 'fortran_order': False, 'shape': \(2, 3, 4\), \} +\n$/,
    );
    assert.deepEqual(file.subarray(10 + header), labelMaps(TWO_FRAMES).data);
  });
});

describe('the palette', () => {
  test('gives each of 256 labels its own colour, the first ones well separated', () => {
    const colors = Array.from({ length: 256 }, (_, label) => objectColor(label));
    assert.equal(new Set(colors).size, 256);
    assert.deepEqual(colors.slice(0, 3), ['#a3a7ad', '#e69f00', '#56b4e9']);
    assert.ok(colors.every((color) => /^#[0-9a-f]{6}$/.test(color)));
    const distance = (a, b) =>
      Math.hypot(
        ...[1, 3, 5].map((k) => Number.parseInt(a.slice(k, k + 2), 16) - Number.parseInt(b.slice(k, k + 2), 16)),
      );
    const least = (list) => Math.min(...list.flatMap((a, k) => list.slice(k + 1).map((b) => distance(a, b))));
    assert.ok(least(colors.slice(0, 30)) > 50, `${least(colors.slice(0, 30))}`);
    assert.ok(least(colors) > 25, `${least(colors)}`);
    const fingerprint = createHash('sha256').update(colors.join()).digest('hex').slice(0, 16);
    assert.equal(fingerprint, 'd1478f8c4117cf8f', 'colours in files must not change from release to release unnoticed');
  });

  test('changes the shape of points where hues come close', () => {
    const shapes = { 0: 'disc', 1: 'disc', 7: 'disc', 8: 'square', 14: 'square', 15: 'diamond', 22: 'disc' };
    for (const [label, shape] of Object.entries(shapes)) assert.equal(objectShape(Number(label)), shape, label);
    assert.throws(() => objectColor(256), { code: 'param', message: /label = 256/ });
    assert.throws(() => objectShape(-1), { code: 'param', message: /label = -1/ });
  });
});

test('a real run is written and read back to the pixel', async () => {
  const result = await resultOf();
  assert.ok(result.objects.length >= 1);
  const files = unzipSync(await masksZip(result));
  const { annotations } = await cocoRle(result);
  for (let t = 0; t < result.numFrames; t += 1) {
    const labels = result.labels(t);
    assert.deepEqual(readPng(files[`${String(t).padStart(5, '0')}.png`]).pixels, labels);
    const again = new Uint8Array(labels.length);
    for (const { image_id, track_id, segmentation, area } of annotations) {
      if (image_id !== t + 1) continue;
      const decoded = await fromCocoRle(segmentation);
      assert.equal(sum(decoded), area);
      decoded.forEach((inside, p) => inside && (again[p] = track_id));
    }
    assert.deepEqual(again, labels);
  }
});

const [width, height] = [60, 40];

/** Object 3 is largest in frame 1, object 7 in frame 2; both lie in other places in each frame. */
const BOXES = {
  width,
  height,
  numFrames: 3,
  labels: (t) =>
    mapPixels(width, height, (x, y) => {
      if (x >= 10 + t && x < [15, 31, 18][t] && y >= 10 && y < [15, 21, 16][t]) return 3;
      return x >= 45 && x < 48 + 3 * t && y >= 20 + t && y < 30 ? 7 : 0;
    }),
};

test('each object has its best frame, its box, three points on it and three beside it, and its mask', async () => {
  const { prompts: list, ...rest } = await prompts(BOXES);
  assert.deepEqual([rest.width, rest.height, rest.times], [width, height, undefined]);
  assert.deepEqual((await prompts({ ...BOXES, times: [1, 2, 4] })).times, [1, 2, 4]);
  assert.deepEqual(each(list, 'obj_id', 'frame_idx', 'box'), [
    [3, 1, [11, 10, 30, 20]],
    [7, 2, [45, 22, 53, 29]],
  ]);
  for (const { obj_id, frame_idx, points, labels, mask } of list) {
    const truth = BOXES.labels(frame_idx);
    assert.deepEqual(labels, [1, 1, 1, 0, 0, 0]);
    points.forEach(([x, y], k) => assert.equal(truth[y * width + x] === obj_id, labels[k] === 1));
    const pixels = truth.map((label) => Number(label === obj_id));
    assert.deepEqual(await fromCocoRle(mask), pixels);
  }
  assert.equal(list[0].points[0][1], 15, 'the first lies on the middle line');
});

test('of windows, frames have the numbers of the clip, and objects can be chosen', async () => {
  const { prompts: list } = await prompts({ ...BOXES, firstFrame: 50 }, { objects: [7] });
  assert.deepEqual(each(list, 'obj_id', 'frame_idx'), [[7, 52]]);
  assert.deepEqual((await prompts({ ...BOXES, labels: () => new Uint8Array(width * height) })).prompts, []);
  await assert.rejects(prompts({ ...BOXES, numFrames: 0 }), { code: 'data' });
  await assert.rejects(prompts(BOXES, { object: 7 }), { code: 'param' });
});

const [WIDTH, HEIGHT] = [9, 7];
const inside = (t, x, y) => x >= 2 + t && x < 5 + t && y >= 2 && y < 5;
const masks = {
  width: WIDTH,
  height: HEIGHT,
  numFrames: 3,
  times: [1, 1.25, 1.3],
  end: 2,
  labels: (t) => mapPixels(WIDTH, HEIGHT, (x, y) => inside(t, x, y)),
};
const frameOf = (t, width = WIDTH, height = HEIGHT) => {
  const data = new Uint8ClampedArray(4 * width * height);
  for (let p = 0; p < width * height; p += 1)
    data.set([(7 * (p % width)) % 256, (9 * Math.floor(p / width)) % 256, 50 * t, 255], 4 * p);
  return { data, width, height };
};
const frames = () => [0, 1, 2].map((t) => frameOf(t));

async function encode(options, clip = masks, pictures = frames()) {
  return new Uint8Array(await new Response(await encodeImages(clip, pictures, options)).arrayBuffer());
}

/** Returns the pixels of deflated rows. */
function decodeRows(data, channels) {
  const raw = unzlibSync(data);
  const size = WIDTH * channels;
  const pixels = new Uint8Array(HEIGHT * size);
  for (let y = 0; y < HEIGHT; y += 1) {
    const filter = raw[y * (size + 1)];
    for (let k = 0; k < size; k += 1) {
      const leftValue = k < channels ? 0 : pixels[y * size + k - channels];
      const up = y > 0 ? pixels[(y - 1) * size + k] : 0;
      assert.ok([0, 1, 2, 3].includes(filter), `filter ${filter}`);
      const prediction = [0, leftValue, up, (leftValue + up) >> 1][filter];
      pixels[y * size + k] = raw[y * (size + 1) + 1 + k] + prediction;
    }
  }
  return pixels;
}

/** Returns the pixels of the cut-out of a frame. */
const cutoutOf = (t) => {
  const { data } = frameOf(t);
  return Uint8Array.from({ length: 4 * WIDTH * HEIGHT }, (_, k) => {
    const p = k >> 2;
    if (!inside(t, p % WIDTH, Math.floor(p / WIDTH))) return 0;
    return k % 4 === 3 ? 255 : data[k];
  });
};

/** Checks a PNG file of the cut-out of a frame. */
function checkCutout(file, t) {
  const [head, { data }, ...rest] = pngParts(file);
  assert.deepEqual([...head.data], [0, 0, 0, WIDTH, 0, 0, 0, HEIGHT, 8, 6, 0, 0, 0]);
  assert.deepEqual(decodeRows(data, 4), cutoutOf(t), `frame ${t}`);
  assert.deepEqual(each(rest, 'type'), ['IEND']);
}

test('an archive has the cut-out of each frame, and the times', async () => {
  const bytes = await encode({});
  const files = unzipSync(bytes);
  assert.deepEqual(Object.keys(files), ['00000.png', '00001.png', '00002.png', 'images.json']);
  for (const t of [0, 1, 2]) checkCutout(files[`0000${t}.png`], t);
  const about = JSON.parse(new TextDecoder().decode(files['images.json']));
  assert.deepEqual([about.times, about.end, about.width, about.files[2]], [masks.times, 2, WIDTH, '00002.png']);
  assert.deepEqual(await encode({}), bytes);
});

/** Returns the elements of an XML text as `[path, content]`; fails if they are not nested. */
function elementsOf(xml) {
  const path = [];
  const elements = [];
  for (const [, closing, name, attributes, content] of xml.matchAll(/<(\/?)([a-z]+)([^<>]*)>([^<]*)/gi)) {
    if (closing) assert.equal(path.pop(), name);
    else {
      path.push(name);
      elements.push([path.join('/'), content.trim()]);
      if (attributes.endsWith('/')) path.pop();
    }
  }
  assert.deepEqual(path, []);
  return elements;
}

for (const [fps, timebase, ntsc] of [
  [30, 30, 'FALSE'],
  [30000 / 1001, 30, 'TRUE'],
  [25, 25, 'FALSE'],
  [24000 / 1001, 24, 'TRUE'],
  [60000 / 1001, 60, 'TRUE'],
]) {
  test(`an archive for editors has one image a frame at ${fps.toFixed(2)} frames a second, and a timeline`, async () => {
    const clip = { ...masks, times: [0, 1, 2].map((t) => 1 + t / fps), end: 1 + 3 / fps };
    const files = unzipSync(await encode({ format: 'editor' }, clip));
    const names = [1, 2, 3].map((number) => `cutout/00000${number}.png`);
    assert.deepEqual(Object.keys(files), [...names, 'timeline.xml', 'README.txt']);
    names.forEach((name, t) => checkCutout(files[name], t));
    const xml = text(files['timeline.xml']);
    assert.match(xml, /^<\?xml version="1.0" encoding="UTF-8"\?>\n<!DOCTYPE xmeml>\n<xmeml version="5">/);
    const elements = elementsOf(xml);
    const contents = (end) => new Set(elements.filter(([path]) => path.endsWith(end)).map(([, content]) => content));
    assert.deepEqual([...contents('rate/timebase')], [String(timebase)]);
    assert.deepEqual([...contents('rate/ntsc')], [ntsc]);
    assert.deepEqual([...contents('duration'), ...contents('clipitem/end')], ['3', '3']);
    assert.deepEqual([...contents('pathurl'), ...contents('alphatype')], ['./cutout/000001.png', 'straight']);
    assert.deepEqual([...contents('width'), ...contents('height')], [String(WIDTH), String(HEIGHT)]);
    assert.match(
      text(files['README.txt']),
      new RegExp(`${ntsc === 'TRUE' ? fps.toFixed(3) : fps}.* frames per second`),
    );
  });
}

test('images for editors repeat frames that last longer, and leave out those that are too short', async () => {
  const archive = async (times, end) => {
    const clip = { ...masks, times, end };
    const files = unzipSync(await encode({ format: 'editor' }, clip));
    const images = Object.entries(files).filter(([name]) => name.endsWith('.png'));
    const decoded = images.map(([, bytes]) =>
      [0, 1, 2].findIndex((t) => String(decodeRows(pngParts(bytes)[1].data, 4)) === String(cutoutOf(t))),
    );
    return { shown: decoded, xml: text(files['timeline.xml']), readme: text(files['README.txt']) };
  };
  const uneven = await archive([0, 0.04, 0.16], 0.2);
  assert.deepEqual(uneven.shown, [0, 1, 1, 1, 2]);
  assert.match(uneven.xml, /<timebase>25<.*<duration>5</s);
  assert.match(uneven.readme, /repeat the one before: 2\n/);
  const short = await archive([0, 0.01, 0.05], 0.09);
  assert.deepEqual(short.shown, [1, 2]);
  assert.match(short.readme, /left out: 1\n/);
  // Editors have no 12.5 frames per second.
  assert.deepEqual((await archive([0, 0.08, 0.16], 0.24)).shown, [0, 0, 1, 1, 2, 2]);
  // Files that store milliseconds.
  const rounded = await archive([0, 0.033, 0.067], 0.1);
  assert.deepEqual(rounded.shown, [0, 1, 2]);
  assert.match(rounded.xml, /<timebase>30</);
});

test('an animation has the durations of all frames, including the last', async () => {
  const chunks = pngParts(await encode({ format: 'apng' }));
  assert.equal(each(chunks, 'type').join(' '), 'IHDR acTL fcTL IDAT fcTL fdAT fcTL fdAT IEND');
  const numbers = (data, ...at) => at.map((k) => new DataView(data.buffer).getUint32(k));
  assert.deepEqual(numbers(chunks[1].data, 0, 4), [3, 0]);
  const heads = chunks.filter(({ type }) => type === 'fcTL').map(({ data }) => data);
  const delays = heads.map(({ buffer }) => new DataView(buffer).getUint16(20) / new DataView(buffer).getUint16(22));
  assert.deepEqual(delays, [0.25, 0.05, 0.7]);
  const counted = chunks.filter(({ type }) => ['fcTL', 'fdAT'].includes(type)).map(({ data }) => numbers(data, 0)[0]);
  assert.deepEqual(counted, [0, 1, 2, 3, 4]);
  assert.deepEqual(decodeRows(chunks[3].data, 4), cutoutOf(0));
  assert.deepEqual(decodeRows(chunks[7].data.slice(4), 4), cutoutOf(2));
});

test('opacity alone is grey, soft at feathered edges', async () => {
  const grey = async (edges) => {
    const [head, data] = pngParts(unzipSync(await encode({ style: 'alpha', edges }))['00000.png']);
    assert.equal(head.data[9], 0);
    return decodeRows(data.data, 1);
  };
  assert.deepEqual(await grey({}), whiteOn(masks.labels(0), 1));
  const soft = (await grey({ feather: 2 })).filter((value) => value > 0 && value < 255);
  assert.notEqual(soft.length, 0);
});

test('objects that are not chosen are left out; smaller masks are enlarged', async () => {
  const changedMasks = { ...masks, labels: (t) => masks.labels(t).map((label, p) => (p === 0 ? 2 : label)) };
  const alphaOf = async (objects) => {
    const files = unzipSync(await encode({ objects, style: 'alpha' }, changedMasks));
    return decodeRows(pngParts(files['00001.png'])[1].data, 1);
  };
  assert.equal((await alphaOf([1]))[0], 0);
  assert.equal((await alphaOf([2]))[0], 255);
  const large = [0, 1, 2].map((t) => frameOf(t, 3 * WIDTH, 3 * HEIGHT));
  const [head] = pngParts(unzipSync(await encode({}, masks, large))['00002.png']);
  assert.deepEqual([head.data[3], head.data[7]], [3 * WIDTH, 3 * HEIGHT]);
});

test('reads a frame when its bytes are read, and ends the source if reading stops', async () => {
  let read = 0;
  let ended = false;
  async function* slow() {
    try {
      for (let t = 0; t < 3; t += 1) {
        read += 1;
        yield frameOf(t);
      }
    } finally {
      ended = true;
    }
  }
  const reader = (await encodeImages(masks, slow(), { format: 'apng' })).getReader();
  await new Promise((resolve) => setImmediate(resolve));
  assert.equal(read, 0);
  await reader.read();
  assert.equal(read, 1);
  await reader.cancel();
  assert.deepEqual([read, ended], [1, true]);
});

test('invalid input is refused, and an abort is reported', async () => {
  const gif = encodeImages(masks, frames(), { format: 'gif' });
  await rejects(gif, 'param', /format = "gif" \(expected 'zip', 'apng', 'editor'/);
  await rejects(encodeImages(masks, frames(), { style: 'overlay' }), 'param', /style = "overlay"/);
  await rejects(encodeImages(masks, null), 'param', /frames = null/);
  await rejects(encodeImages({ ...masks, end: 1 }, frames()), 'data', /masks\.end = 1/);
  await rejects(encode({}, masks, frames().slice(1)), 'data', /ended after 2 of 3/);
  await assert.rejects(encode(abortAt({ reason: new Error('enough') })), /enough/);
});

test('videos need a browser; the error names what to use instead', async () => {
  await rejects(encodeVideo(masks, frames()), 'unsupported', /WebCodecs.*masksZip/);
});

test('the colours of a transparent video end four pixels from its objects, across and down', () => {
  const [width, height] = [30, 20];
  const objects = ['0100', '0010', '0011'];
  const pixels = (valueAt) =>
    Array.from({ length: width * height }, (_, p) => valueAt(p % width, Math.floor(p / width)));
  const alpha = Uint8Array.from(pixels((x, y) => Number(objects[y - 8]?.[x - 12] ?? 0)));
  const data = new Uint8ClampedArray(4 * width * height).fill(200);
  blackenAround({ data, width, height }, { x: 13, y: 8, width: 3, height: 3 }, alpha);
  const places = pixels((x, y) => [x, y]).filter((_, p) => alpha[p]);
  pixels((x, y) => {
    const isNear = ([a, b]) => Math.abs(a - x) <= 4 && Math.abs(b - y) <= 4;
    assert.equal(data[4 * (y * width + x)], places.some(isNear) ? 200 : 0, `${x}, ${y}`);
  });
});
