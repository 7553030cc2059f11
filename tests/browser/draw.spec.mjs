// Colours of the pixels that the drawing functions paint. Wrong input is tested in Node (tests/node/options.test.mjs).

import { expect, test, useEmptyPage } from './fixtures.mjs';

const CLEAR = [0, 0, 0, 0];
const OBJECT_1 = [0xe6, 0x9f, 0x00];
const OBJECT_2 = [0x56, 0xb4, 0xe9];
const RED = [0xff, 0x2b, 0x3d];

const drawing = useEmptyPage((page) => page.evaluate(prepare));

/** Runs in the page: makes a small result of known content, and `paint`. */
async function prepare() {
  const tracecut = await import('/model/library.js');
  const [width, height] = [40, 30];
  // Object 1 is a square, object 2 a column at the frame border.
  const labelAt = (x, y) => (x >= 10 && x < 20 && y >= 10 && y < 20 ? 1 : x >= 36 ? 2 : 0);
  // Four trajectories of three frames: two of object 1 (one ends early), one of the background, one of object 2.
  const result = {
    width,
    height,
    numFrames: 3,
    labels: () => Uint8Array.from({ length: width * height }, (_, p) => labelAt(p % width, Math.floor(p / width))),
    trajectories: {
      count: 4,
      startFrame: Uint32Array.of(0, 0, 0, 1),
      offset: Uint32Array.of(0, 3, 5, 8, 10),
      x: Float32Array.of(5, 10, 15, 12, 12, 30, 30, 30, 38, 38),
      y: Float32Array.of(12, 12, 12, 18, 18, 4, 4, 4, 20, 25),
    },
    clusters: { count: 4, label: Uint32Array.of(1, 1, 0, 3), object: Uint8Array.of(0, 1, 1, 2) },
    edges: () => ({ i: Uint32Array.of(0, 0, 2), j: Uint32Array.of(2, 3, 3), d: Float32Array.of(0.95, 0.2, 0.7) }),
  };
  const createCanvas = (zoom, isElement = false) => {
    const size = [zoom * width, zoom * height];
    return isElement
      ? Object.assign(document.createElement('canvas'), { width: size[0], height: size[1] })
      : new OffscreenCanvas(...size);
  };
  const stateOf = (context) =>
    JSON.stringify([context.globalAlpha, context.lineWidth, context.fillStyle, context.getTransform()]);
  // Draws on a canvas of `zoom` times the frame's size and returns the colours at places of the frame (pixel centres) by their names.
  const paint = ({ zoom = 1, places, isElement }, draw) => {
    const context = createCanvas(zoom, isElement).getContext('2d', { willReadFrequently: true });
    tracecut.fitFrame(context, result);
    const state = stateOf(context);
    draw(context);
    if (stateOf(context) !== state) throw new Error(`the state was ${state} and is ${stateOf(context)}`);
    const colorAt = (place) => [
      ...context.getImageData(...place.map((value) => Math.floor(zoom * (value + 0.5))), 1, 1).data,
    ];
    return Object.fromEntries(Object.entries(places).map(([name, place]) => [name, colorAt(place)]));
  };
  Object.assign(globalThis, { tracecut, result, createCanvas, paint });
}

/** Paints with a function of the package that takes `(context, result, frame, options)`. */
function paintWith(name, frame, options, settings) {
  return drawing.page.evaluate(
    ([method, t, drawOptions, paintOptions]) =>
      paint(paintOptions, (context) => tracecut[method](context, result, t, drawOptions)),
    [name, frame, options, settings],
  );
}

function expectColor(color, expected, tolerance = 3) {
  const differences = expected.map((level, k) => Math.abs(level - color[k]));
  expect(Math.max(...differences), `${color} (expected about ${expected})`).toBeLessThanOrEqual(tolerance);
}

test('masks are filled and outlined, on both kinds of canvas, and leave other pixels as they are', async () => {
  const places = { inside: [14, 14], edge: [9.5, 14], outside: [25, 5], second: [38, 14] };
  for (const isElement of [true, false]) {
    const colors = await paintWith('drawLabels', 1, {}, { places, zoom: 8, isElement });
    expectColor(colors.inside, [...OBJECT_1, 128]);
    expectColor(colors.edge, OBJECT_1);
    expect(colors.edge[3]).toBeGreaterThan(200);
    expect(colors.outside).toEqual(CLEAR);
    expectColor(colors.second, [...OBJECT_2, 128]);
  }
  const opaque = await paintWith('drawLabels', 1, { opacity: 1, outline: false, objects: [1] }, { places });
  expect([opaque.inside, opaque.second]).toEqual([[...OBJECT_1, 255], CLEAR]);
  const white = await paintWith('drawLabels', 1, { opacity: 0, colors: ['', '#ffffff'] }, { places, zoom: 8 });
  expect(white.inside).toEqual(CLEAR);
  expectColor(white.edge, [255, 255, 255]);
});

test('outlines are centred between pixels, as wide as requested at every zoom', async () => {
  const widths = await drawing.page.evaluate(() =>
    [1, 2].map((outlineWidth) =>
      [4, 16].map((zoom) => {
        const context = createCanvas(zoom).getContext('2d', { willReadFrequently: true });
        const unit = tracecut.fitFrame(context, result);
        const options = { opacity: 0, objects: [1], outlineWidth: 4 * outlineWidth * unit };
        tracecut.drawLabels(context, result, 0, options);
        const row = context.getImageData(0, zoom * 15, zoom * 15, 1).data;
        const isLine = Array.from({ length: row.length / 4 }, (_, x) => row[4 * x] > 150 && row[4 * x + 3] > 150);
        return [isLine.indexOf(true) - 10 * zoom, isLine.lastIndexOf(true) + 1 - 10 * zoom].join();
      }),
    ),
  );
  expect(widths).toEqual([
    ['-2,2', '-2,2'],
    ['-4,4', '-4,4'],
  ]);
});

test('points are at their trajectories, followed by their tails', async () => {
  const draw = (frame, options, places) =>
    paintWith('drawTrajectories', frame, { radius: 1, ...options }, { places, zoom: 8 });
  const places = { point: [15, 12], tail: [12.5, 12], ended: [12, 18], background: [30, 4], early: [20, 25] };
  const { point, tail, ended, background, early } = await draw(2, {}, places);
  expectColor(point, [...OBJECT_1, 255]);
  expectColor(tail, OBJECT_1, 4);
  expect(tail[3]).toBeGreaterThan(100);
  expect(tail[3]).toBeLessThan(255);
  expect([ended, early]).toEqual([CLEAR, CLEAR]);
  expectColor(background, [0xa3, 0xa7, 0xad, 255]);
  const withoutTails = { point: [10, 12], tail: [7.5, 12], second: [38, 20] };
  const single = await draw(1, { tail: 0, objects: [1] }, withoutTails);
  expectColor(single.point, [...OBJECT_1, 255]);
  expect([single.tail, single.second]).toEqual([CLEAR, CLEAR]);
  expectColor((await draw(1, { color: 'rgb(10 20 30)' }, withoutTails)).point, [10, 20, 30, 255]);
  expectColor((await draw(1, { color: 'cluster' }, withoutTails)).second, [0xcc, 0x79, 0xa7, 255]);
});

test('discontinuities are red above the threshold', async () => {
  // Between the points at (10, 12), (30, 4) and (38, 20).
  const places = { strong: [20, 8], calm: [24, 16], weak: [34, 12], outside: [5, 5] };
  const { strong, calm, weak, outside } = await paintWith('drawDiscontinuities', 1, {}, { places, zoom: 8 });
  expectColor(strong, RED, 4);
  expectColor(weak, RED, 4);
  expect(strong[3]).toBeGreaterThan(weak[3]);
  expect(calm[0]).toBe(calm[1]);
  expect(calm[3]).toBeGreaterThan(0);
  expect(calm[3]).toBeLessThan(80);
  expect(outside).toEqual(CLEAR);
  const options = { threshold: 0.8, calm: null, color: '#00ff00' };
  const green = await paintWith('drawDiscontinuities', 1, options, { places, zoom: 8 });
  expectColor(green.strong, [0, 255, 0], 4);
  expect([green.calm, green.weak]).toEqual([CLEAR, CLEAR]);
});

test('superpixels have mean or random colours, lines between them, and their edges', async () => {
  const [mean, random, edges, deleted] = await drawing.page.evaluate(() => {
    // Two halves at half the frame's size separated by a contour, with one edge that bridges a gap and one that was deleted.
    const { Constraint, Gabriel, Deleted } = tracecut.EdgeKind;
    const superpixels = {
      width: 20,
      height: 15,
      scaleX: 2,
      scaleY: 2,
      count: 2,
      label: Uint32Array.from({ length: 300 }, (_, p) => Number(p % 20 >= 10)),
      edges: {
        x0: [9.5, 0, 0],
        y0: [0, 3, 11],
        x1: [9.5, 19, 19],
        y1: [14, 3, 11],
        kind: [Constraint, Gabriel, Deleted],
      },
    };
    const image = new OffscreenCanvas(40, 30);
    const imageContext = image.getContext('2d');
    imageContext.fillStyle = 'rgb(200 100 50)';
    imageContext.fillRect(0, 0, 20, 30);
    const halves = { left: [5, 12], right: [30, 12], border: [19.4, 12] };
    const places = { ...halves, constraint: [19.5, 20], gabriel: [10, 6.5], deleted: [10, 22.5] };
    return [
      { image },
      {},
      { fill: 'none', borders: false, edges: true },
      { fill: 'none', borders: false, deleted: true },
    ].map((options) =>
      paint({ places, zoom: 8 }, (context) => tracecut.drawSuperpixels(context, superpixels, options)),
    );
  });
  expectColor(mean.left, [200, 100, 50, 255]);
  expectColor(mean.right, [0, 0, 0, 255]);
  expect(mean.border[0]).toBeLessThan(120);
  expect(mean.border[3]).toBeGreaterThan(150);
  expect(random.left.slice(0, 3)).not.toEqual(random.right.slice(0, 3));
  expectColor(edges.constraint, [0xff, 0x3b, 0x30, 255]);
  expectColor(edges.gabriel, [0x30, 0xd1, 0x58, 255]);
  expect([edges.left, edges.deleted, deleted.gabriel]).toEqual([CLEAR, CLEAR, CLEAR]);
  expect(deleted.deleted[3]).toBeGreaterThan(60);
});

test('maps have the colours of their values, and cells that of the nearest point', async () => {
  const maps = await drawing.page.evaluate(() => {
    const grid = { width: 20, height: 15, scaleX: 2, scaleY: 2 };
    const halves = (first, second) => Float32Array.from({ length: 300 }, (_, p) => (p % 20 < 10 ? first : second));
    const paintMap = (draw) => Object.values(paint({ places: { left: [5, 15], right: [35, 15] } }, draw));
    const { drawBoundaries, drawSaliency, drawFlow, drawCells } = tracecut;
    const thinOptions = { of: 'thin', white: 0.2, black: 1 };
    const cellPlaces = { first: [10, 13], second: [12, 17], third: [30, 4], far: [25, 25] };
    const cellOptions = { color: (i) => (i === 2 ? null : '#102030'), reach: 3 };
    return {
      boundary: paintMap((context) => drawBoundaries(context, { ...grid, pb: halves(0, 0.6) })),
      thin: paintMap((context) => drawBoundaries(context, { ...grid, thin: halves(1, 0.2) }, thinOptions)),
      saliency: paintMap((context) => drawSaliency(context, { ...grid, saliency: halves(0, 1) })),
      flow: paintMap((context) => drawFlow(context, { ...grid, u: halves(0, 3), v: halves(0, 0) }, { scale: 3 })),
      cells: Object.values(paint({ places: cellPlaces }, (context) => drawCells(context, result, 1, cellOptions))),
    };
  });
  const [black, white, cell] = [
    [0, 0, 0, 255],
    [255, 255, 255, 255],
    [0x10, 0x20, 0x30, 255],
  ];
  expect(maps.boundary).toEqual([white, black]);
  expect(maps.thin).toEqual([black, white]);
  expectColor(maps.saliency[0], [0x0b, 0x0b, 0x24, 255]);
  expectColor(maps.saliency[1], [0xfd, 0xf3, 0xa0, 255]);
  expectColor(maps.flow[0], white);
  expectColor(maps.flow[1], [0xe8, 0x46, 0x3c, 255]);
  expect(maps.cells).toEqual([cell, cell, CLEAR, CLEAR]);
});

test('a result is drawn in the colours of its labels, on a canvas and in a PNG file', async () => {
  const outcome = await drawing.page.evaluate(async () => {
    const clip = await tracecut.synthClip({ width: 96, height: 54, frames: 6, seed: 4 });
    const session = await tracecut.createSession();
    for (let k = 0; k < 6; k += 1) await session.push(clip.frame(k));
    const segmentation = await session.run();
    const context = new OffscreenCanvas(96, 54).getContext('2d', { willReadFrequently: true });
    tracecut.drawLabels(context, segmentation, 2, { opacity: 1, outline: false });
    const { data } = context.getImageData(0, 0, 96, 54);
    const file = new Blob([await tracecut.maskPng(segmentation, 2, { transparent: true })]);
    const bitmap = await createImageBitmap(file);
    context.clearRect(0, 0, 96, 54);
    context.drawImage(bitmap, 0, 0);
    const decoded = context.getImageData(0, 0, 96, 54).data;
    let [numWrong, numPainted] = [0, 0];
    segmentation.labels(2).forEach((label, p) => {
      const [r, g, b, alpha] = data.subarray(4 * p, 4 * p + 4);
      const color = `#${[r, g, b].map((level) => level.toString(16).padStart(2, '0')).join('')}`;
      if (label > 0) numPainted += 1;
      if (label > 0 ? color !== tracecut.objectColor(label) || alpha !== 255 : alpha !== 0) numWrong += 1;
    });
    // All maps of a result can be drawn.
    for (const draw of ['drawTrajectories', 'drawDiscontinuities']) tracecut[draw](context, segmentation, 2);
    tracecut.drawSuperpixels(context, await segmentation.superpixels(2), { image: bitmap, edges: true });
    tracecut.drawBoundaries(context, await segmentation.boundaries(2));
    tracecut.drawSaliency(context, await segmentation.saliencyMap(2));
    tracecut.drawFlow(context, await session.flow(2));
    session.close();
    return { numWrong, numPainted, isSameInFile: decoded.every((level, at) => level === data[at]) };
  });
  expect(outcome.numPainted).toBeGreaterThan(200);
  expect(outcome).toMatchObject({ numWrong: 0, isSameInFile: true });
});

test('a studio whose package is missing shows an error', async ({ browser, sites }) => {
  const page = await browser.newPage();
  await page.route('**/dist/**', (route) => route.fulfill({ status: 404, body: 'not found' }));
  await page.goto(await sites('package'));
  await expect(page.locator('#error')).toHaveText(/\w{4,}/);
  await page.close();
});
