// Masks as files and prompts: opened again, and compared with what other programs write.

import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { describe, test } from 'node:test';
import { maskPng, masksZip, TraceCutError, version } from 'tracecut';
import { objectColor, objectShape } from 'tracecut/draw';
import { cocoRle, fromCocoRle, labelMaps, labelsNpy, prompts } from 'tracecut/export';
import { unzipSync } from '../../dist/vendor/zip.js';
import { readPng } from '../png.mjs';
import { framesOf, open, segment } from './support.mjs';

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
const sum = (list) => list.reduce((total, value) => total + value, 0);

function refuses(code, message) {
  return (error) => error instanceof TraceCutError && error.code === code && message.test(error.message);
}

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
    assert.deepEqual(
      [...pixels],
      [...TWO_FRAMES.labels(1)].map((label) => (label === 2 ? 255 : 0)),
    );
  });

  test('is empty where an object is in other frames only, and an error where it is in none', async () => {
    const twoPixels = { width: 2, height: 1, numFrames: 2, labels: (t) => Uint8Array.of(3 * t, 5) };
    assert.deepEqual([...readPng(await maskPng(twoPixels, 0, { object: 3 })).pixels], [0, 0]);
    await assert.rejects(maskPng(twoPixels, 0, { object: 77 }), refuses('param', /object = 77 .*an object: 3, 5/));
    const emptyMasks = { ...twoPixels, labels: () => new Uint8Array(2) };
    await assert.rejects(maskPng(emptyMasks, 0, { object: 1 }), refuses('param', /object = 1 .*there are none/));
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
    const { order, alpha, palette } = readPng(
      await maskPng(TWO_FRAMES, 0, { transparent: true, palette: ['#010203', '#040506'] }),
    );
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
    const options = (wrong, message) => assert.rejects(maskPng(TWO_FRAMES, 0, wrong), refuses('param', message));
    await options({ object: 256 }, /object = 256 .*0\.\.=255/);
    await options(
      { objects: [1] },
      /objects = a list of 1 .*a known option, such as object; the options are object, palette, transparent/,
    );
    await options({ transparent: 1 }, /transparent = 1 .*true or false/);
    await options({ palette: ['red'] }, /"red" \(expected #rrggbb\)/);
    await assert.rejects(maskPng(TWO_FRAMES, 2), refuses('param', /t = 2 \(expected a whole number, 0\.\.=1\)/));
    await assert.rejects(maskPng({ width: 2, height: 2 }, 0), refuses('data', /masks = an Object .*labels\(t\)/));
    const masks = (wrong, message) => assert.rejects(maskPng({ ...TWO_FRAMES, ...wrong }, 0), refuses('data', message));
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
    const files = unzipSync(
      await masksZip(TWO_FRAMES, {
        perObject: true,
        objects: [1, 3, 9],
        frameRate: 25,
        onProgress: (step) => progress.push(step),
      }),
    );
    const names = [1, 3].flatMap((label) => [0, 1].map((t) => `object-${label}/0000${t}.png`));
    assert.deepEqual(Object.keys(files).sort(), ['masks.json', ...names].sort());
    assert.deepEqual(
      [...readPng(files['object-3/00001.png']).pixels],
      [...TWO_FRAMES.labels(1)].map((label) => (label === 3 ? 255 : 0)),
    );
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
    const some = unzipSync(await masksZip(TWO_FRAMES, { objects: (label) => label === 2 }));
    assert.deepEqual(
      [...readPng(some['00000.png']).pixels],
      [...TWO_FRAMES.labels(0)].map((label) => (label === 2 ? 2 : 0)),
    );
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
    const controller = new AbortController();
    const zip = masksZip(TWO_FRAMES, { signal: controller.signal, onProgress: () => controller.abort() });
    await assert.rejects(zip, { name: 'AbortError' });
    const times = (wrong, message) =>
      assert.rejects(masksZip({ ...TWO_FRAMES, times: wrong }), refuses('data', message));
    await times([0], /has 1 times \(expected 2, one a frame\)/);
    await times([1, 1], /times\[1\] = 1 \(expected seconds, ascending\)/);
    const options = (wrong, message) => assert.rejects(masksZip(TWO_FRAMES, wrong), refuses('param', message));
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
    const labels = Uint8Array.from({ length: width * height }, (_, p) => {
      const [x, y] = [p % width, Math.floor(p / width)];
      return (x - 170) ** 2 + (y - 140) ** 2 < 100 ** 2 || x >= 395 ? 4 : 0;
    });
    const { annotations } = await cocoRle({ width, height, numFrames: 1, labels: () => labels });
    const [{ segmentation, area, bbox, track_id }] = annotations;
    assert.match(segmentation.counts, /^bmd0m0Z8:F:H6I8I6K4K6K4L4L4L4L4L4M2M4M2M4M2N2M4M2N2N2M4M2N2N/);
    const hash = createHash('sha256').update(segmentation.counts).digest('hex');
    assert.equal(hash, '8e6d0d69f08ca4259d93b78430620f7fbfa41716e59504035d2b60af8a6689f5');
    assert.deepEqual([area, bbox, track_id], [32897, [71, 0, 329, 300], 4]);
    assert.deepEqual(
      await fromCocoRle(segmentation),
      labels.map((label) => Number(label > 0)),
    );
  });

  test('have frames, times, objects and categories', async () => {
    const category = (label) => (label === 3 ? 'ball' : 'person');
    const coco = await cocoRle(
      { ...TWO_FRAMES, times: Float64Array.of(2, 2.5) },
      { category, video: 'clip.mp4', fileName: (t) => `frames/${t}.jpg` },
    );
    assert.deepEqual(coco.videos, [{ id: 1, name: 'clip.mp4', width: 4, height: 3, frame_times: [2, 2.5] }]);
    assert.deepEqual(coco.images[1], {
      id: 2,
      video_id: 1,
      frame_index: 1,
      width: 4,
      height: 3,
      file_name: 'frames/1.jpg',
      timestamp: 2.5,
    });
    assert.deepEqual(coco.categories, [
      { id: 1, name: 'person' },
      { id: 2, name: 'ball' },
    ]);
    assert.deepEqual(
      coco.tracks,
      [1, 2, 3].map((id) => ({ id, category_id: id === 3 ? 2 : 1, video_id: 1 })),
    );
    assert.deepEqual(
      coco.annotations.map((annotation) => [
        annotation.id,
        annotation.image_id,
        annotation.track_id,
        annotation.category_id,
        annotation.iscrowd,
      ]),
      [
        [2, 1, 1, 1, 0],
        [3, 1, 2, 1, 0],
        [258, 2, 1, 1, 0],
        [259, 2, 2, 1, 0],
        [260, 2, 3, 2, 0],
      ],
    );
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
    await assert.rejects(cocoRle({ ...clip, firstFrame: -1 }), refuses('data', /firstFrame = -1/));
  });

  test('are none where there is no object, and 255 for 255 objects', async () => {
    const emptyRle = await cocoRle(drawn(['00']));
    assert.deepEqual([emptyRle.annotations, emptyRle.tracks, emptyRle.images.length], [[], [], 1]);
    assert.ok(!('timestamp' in emptyRle.images[0] || 'frame_times' in emptyRle.videos[0]));
    const rle = await cocoRle(ALL_LABELS);
    assert.deepEqual(
      rle.annotations.map(({ track_id, area }) => [track_id, area]),
      Array.from({ length: 255 }, (_, k) => [k + 1, 1]),
    );
    assert.deepEqual(
      (await cocoRle(ALL_LABELS, { objects: [7] })).annotations.map(({ bbox }) => bbox),
      [[7, 0, 1, 1]],
    );
    const background = await cocoRle(ALL_LABELS, { objects: [0] });
    assert.equal(background.annotations[0].area, 1, 'the background if asked for');
  });

  test('that are damaged are refused with a message', async () => {
    const wrong = (segmentation, message) => assert.rejects(fromCocoRle(segmentation), refuses('data', message));
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
    assert.deepEqual([0, 1, 7, 8, 14, 15, 22].map(objectShape), [
      'disc',
      'disc',
      'disc',
      'square',
      'square',
      'diamond',
      'disc',
    ]);
    assert.throws(() => objectColor(256), refuses('param', /label = 256/));
    assert.throws(() => objectShape(-1), refuses('param', /label = -1/));
  });
});

test('a result without masks is refused with a message', async (t) => {
  const session = await open(t);
  await session.setTrajectories({
    numFrames: 2,
    width: 9,
    height: 9,
    startFrame: [0, 0],
    offset: [0, 2, 4],
    x: [1, 2, 6, 6],
    y: [1, 2, 6, 6],
  });
  const result = await session.run();
  await assert.rejects(maskPng(result, 0), refuses('state', /no masks/));
  await assert.rejects(cocoRle(result), refuses('state', /no masks/));
});

test('a real run is written and read back to the pixel', async () => {
  const frames = await framesOf();
  const result = await segment(frames);
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
    Uint8Array.from({ length: width * height }, (_, p) => {
      const [x, y] = [p % width, Math.floor(p / width)];
      if (x >= 10 + t && x < [15, 31, 18][t] && y >= 10 && y < [15, 21, 16][t]) return 3;
      return x >= 45 && x < 48 + 3 * t && y >= 20 + t && y < 30 ? 7 : 0;
    }),
};

test('each object has its best frame, its box, three points on it and three beside it, and its mask', async () => {
  const { prompts: list, ...rest } = await prompts(BOXES);
  assert.deepEqual([rest.width, rest.height, rest.times], [width, height, undefined]);
  assert.deepEqual((await prompts({ ...BOXES, times: [1, 2, 4] })).times, [1, 2, 4]);
  assert.deepEqual(
    list.map(({ obj_id, frame_idx, box }) => [obj_id, frame_idx, box]),
    [
      [3, 1, [11, 10, 30, 20]],
      [7, 2, [45, 22, 53, 29]],
    ],
  );
  for (const { obj_id, frame_idx, points, labels, mask } of list) {
    const truth = BOXES.labels(frame_idx);
    assert.deepEqual(labels, [1, 1, 1, 0, 0, 0]);
    points.forEach(([x, y], k) => assert.equal(truth[y * width + x] === obj_id, labels[k] === 1));
    const pixels = await fromCocoRle(mask);
    assert.deepEqual(
      pixels,
      truth.map((label) => Number(label === obj_id)),
    );
  }
  assert.equal(list[0].points[0][1], 15, 'the first lies on the middle line');
});

test('of windows, frames have the numbers of the clip, and objects can be chosen', async () => {
  const { prompts: list } = await prompts({ ...BOXES, firstFrame: 50 }, { objects: [7] });
  assert.deepEqual(
    list.map(({ obj_id, frame_idx }) => [obj_id, frame_idx]),
    [[7, 52]],
  );
  assert.deepEqual((await prompts({ ...BOXES, labels: () => new Uint8Array(width * height) })).prompts, []);
  await assert.rejects(prompts({ ...BOXES, numFrames: 0 }), { code: 'data' });
  await assert.rejects(prompts(BOXES, { object: 7 }), { code: 'param' });
});
