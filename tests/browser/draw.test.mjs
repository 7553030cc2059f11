// The drawing helpers, on canvas elements and on OffscreenCanvas: which pixels have which colours.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { useServerAndBrowser } from '../site.mjs';
import { useEmptyPage } from './empty-page.mjs';

const site = useServerAndBrowser();
const KINDS = ['HTMLCanvasElement', 'OffscreenCanvas'];

const OBJECT_1 = [0xe6, 0x9f, 0x00];
const RED = [0xff, 0x2b, 0x3d];

const shared = useEmptyPage(site, (page) => page.evaluate(prepare));

/** Runs in the page: a small world of known content, and canvases of both kinds. */
async function prepare() {
  const tracecut = await import('/model/library.js');
  const [width, height] = [40, 30];
  /** Object 1 is a square, object 2 a column at the rim. */
  const label = (x, y) => (x >= 10 && x < 20 && y >= 10 && y < 20 ? 1 : x >= 36 ? 2 : 0);
  const labels = () => Uint8Array.from({ length: width * height }, (_, p) => label(p % width, Math.floor(p / width)));
  /** Four trajectories of three frames: two of object 1 (one ends early), one of the background, one of object 2. */
  const result = {
    width,
    height,
    numFrames: 3,
    labels,
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
  const canvas = (kind, w, h) =>
    kind === 'OffscreenCanvas'
      ? new OffscreenCanvas(w, h)
      : Object.assign(document.createElement('canvas'), { width: w, height: h });
  /** Draws on a canvas of `zoom` times the frame's size, and reads colours at places of the frame (pixel centres). */
  const drawn = (kind, zoom, draw, places) => {
    const context = canvas(kind, zoom * width, zoom * height).getContext('2d', { willReadFrequently: true });
    tracecut.fitFrame(context, result);
    const before = [
      context.globalAlpha,
      context.lineWidth,
      context.fillStyle,
      JSON.stringify(context.getTransform()),
    ].join();
    draw(context, tracecut);
    const after = [
      context.globalAlpha,
      context.lineWidth,
      context.fillStyle,
      JSON.stringify(context.getTransform()),
    ].join();
    if (before !== after) throw new Error(`settings were ${before} and are ${after}`);
    return places.map(([x, y]) => [
      ...context.getImageData(Math.floor(zoom * (x + 0.5)), Math.floor(zoom * (y + 0.5)), 1, 1).data,
    ]);
  };
  globalThis.kit = { tracecut, result, canvas, drawn };
}

function near(color, wanted, what, slack = 3) {
  assert.ok(
    wanted.every((value, k) => Math.abs(value - color[k]) <= slack),
    `${what}: ${color} (expected about ${wanted})`,
  );
}

const CLEAR = [0, 0, 0, 0];

for (const kind of KINDS) {
  describe(`on a canvas of kind ${kind}`, () => {
    test('masks are filled and outlined, and nothing else is touched', async () => {
      const { page } = shared;
      const look = (options, zoom = 1) =>
        page.evaluate(
          ([k, chosen, z]) => {
            const { drawn, result } = globalThis.kit;
            const places = [
              [14, 14],
              [9.5, 14],
              [25, 5],
              [38, 14],
              [12, 9.5],
            ];
            return drawn(k, z, (context, { drawLabels }) => drawLabels(context, result, 1, chosen), places);
          },
          [kind, options, zoom],
        );
      const [inside, edge, outside, other] = await look({}, 8);
      near(inside, [...OBJECT_1, 128], 'half filled');
      near(edge, OBJECT_1, 'outline');
      assert.ok(edge[3] > 200, `the outline's opacity is ${edge[3]}`);
      assert.deepEqual(outside, CLEAR);
      near(other, [0x56, 0xb4, 0xe9, 128], 'object 2');
      const [whole, , , hidden] = await look({ opacity: 1, outline: false, objects: [1] });
      assert.deepEqual([whole, hidden], [[...OBJECT_1, 255], CLEAR]);
      const [hollow, line] = await look({ opacity: 0, colors: ['', '#ffffff'] }, 8);
      assert.deepEqual(hollow, CLEAR);
      near(line, [255, 255, 255], 'an outline in a colour of the caller');
    });

    test('outlines lie between pixels, as wide as asked at every zoom', async () => {
      const { page } = shared;
      const widths = await page.evaluate(
        (k) =>
          [1, 2].map((width) =>
            [4, 16].map((zoom) => {
              const { canvas, result, tracecut } = globalThis.kit;
              const context = canvas(k, zoom * result.width, zoom * result.height).getContext('2d', {
                willReadFrequently: true,
              });
              const unit = tracecut.fitFrame(context, result);
              tracecut.drawLabels(context, result, 0, { opacity: 0, objects: [1], outlineWidth: 4 * width * unit });
              const row = context.getImageData(0, zoom * 15, zoom * 15, 1).data;
              const painted = Array.from(
                { length: row.length / 4 },
                (_, x) => row[4 * x] > 150 && row[4 * x + 3] > 150,
              );
              return [painted.indexOf(true) - 10 * zoom, painted.lastIndexOf(true) + 1 - 10 * zoom];
            }),
          ),
        kind,
      );
      assert.deepEqual(widths, [
        [
          [-2, 2],
          [-2, 2],
        ],
        [
          [-4, 4],
          [-4, 4],
        ],
      ]);
    });

    test('points lie where their trajectories are, with their tails behind them', async () => {
      const { page } = shared;
      const look = (frame, options, places) =>
        page.evaluate(
          ([k, f, chosen, spots]) => {
            const { drawn, result } = globalThis.kit;
            return drawn(
              k,
              8,
              (context, { drawTrajectories }) => drawTrajectories(context, result, f, { radius: 1, ...chosen }),
              spots,
            );
          },
          [kind, frame, options, places],
        );
      const [now, tail, gone, background, far] = await look(2, {}, [
        [15, 12],
        [12.5, 12],
        [12, 18],
        [30, 4],
        [20, 25],
      ]);
      near(now, [...OBJECT_1, 255], 'the point');
      near(tail, OBJECT_1, 'the tail', 4);
      assert.ok(tail[3] > 100 && tail[3] < 255, `the tail's opacity is ${tail[3]}`);
      assert.deepEqual([gone, far], [CLEAR, CLEAR]);
      near(background, [0xa3, 0xa7, 0xad, 255], 'the background');
      const [alone, untold, second] = await look(1, { tail: 0, objects: [1] }, [
        [10, 12],
        [7.5, 12],
        [38, 20],
      ]);
      near(alone, [...OBJECT_1, 255], 'an object alone');
      assert.deepEqual([untold, second], [CLEAR, CLEAR], 'no tail, no other object');
      const [plain, cluster] = [
        await look(1, { color: 'rgb(10 20 30)' }, [[10, 12]]),
        await look(1, { color: 'cluster' }, [[38, 20]]),
      ];
      near(plain[0], [10, 20, 30, 255], 'a colour for all');
      near(cluster[0], [0xcc, 0x79, 0xa7, 255], 'the colour of cluster 3');
    });

    test('discontinuities are red above the threshold', async () => {
      const { page } = shared;
      const look = (options) =>
        page.evaluate(
          ([k, chosen]) => {
            const { drawn, result } = globalThis.kit;
            // Between the points at (10, 12), (30, 4) and (38, 20).
            return drawn(k, 8, (context, { drawDiscontinuities }) => drawDiscontinuities(context, result, 1, chosen), [
              [20, 8],
              [24, 16],
              [34, 12],
              [5, 5],
            ]);
          },
          [kind, options],
        );
      const [strong, calm, weak, none] = await look({});
      for (const color of [strong, weak]) near(color, RED, 'a cut', 4);
      assert.ok(strong[3] > weak[3], `${strong[3]} of ${weak[3]}`);
      assert.ok(calm[0] === calm[1] && calm[3] > 0 && calm[3] < 80, `${calm} is faint`);
      assert.deepEqual(none, CLEAR);
      const [still, gone, below] = await look({ threshold: 0.8, calm: null, color: '#00ff00' });
      near(still, [0, 255, 0], 'in a colour of the caller', 4);
      assert.deepEqual([gone, below], [CLEAR, CLEAR]);
    });

    test('superpixels have their colours, lines between them, and their edges', async () => {
      const { page } = shared;
      const colors = await page.evaluate((k) => {
        const { drawn, tracecut } = globalThis.kit;
        // Two halves at half the frame's size, parted by a contour, with one edge that bridges a gap and one that parts
        // nothing.
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
            kind: [tracecut.EdgeKind.Constraint, tracecut.EdgeKind.Gabriel, tracecut.EdgeKind.Deleted],
          },
        };
        const image = new OffscreenCanvas(40, 30);
        const own = image.getContext('2d');
        own.fillStyle = 'rgb(200 100 50)';
        own.fillRect(0, 0, 20, 30);
        const look = (options) =>
          drawn(k, 8, (context) => tracecut.drawSuperpixels(context, superpixels, options), [
            [5, 12],
            [30, 12],
            [19.4, 12],
            [19.5, 20],
            [10, 6.5],
            [10, 22.5],
          ]);
        return [
          look({ image }),
          look({}),
          look({ fill: 'none', borders: false, edges: true }),
          look({ fill: 'none', borders: false, deleted: true }),
        ];
      }, kind);
      const [mean, random, edges, deleted] = colors;
      near(mean[0], [200, 100, 50, 255], 'the mean on the left');
      near(mean[1], [0, 0, 0, 255], 'the mean on the right');
      assert.ok(mean[2][0] < 120 && mean[2][3] > 150, `${mean[2]} is a line`);
      assert.notDeepEqual(random[0].slice(0, 3), random[1].slice(0, 3));
      near(edges[3], [0xff, 0x3b, 0x30, 255], 'a contour');
      near(edges[4], [0x30, 0xd1, 0x58, 255], 'a Gabriel edge');
      assert.deepEqual([edges[0], edges[5], deleted[4]], [CLEAR, CLEAR, CLEAR]);
      assert.ok(deleted[5][3] > 60, `${deleted[5]} is an edge deleted`);
    });

    test('maps draw their values, cells the value of the nearest point', async () => {
      const { page } = shared;
      const { boundary, thin, heat, flow, cells } = await page.evaluate((k) => {
        const { drawn, result, tracecut } = globalThis.kit;
        const grid = { width: 20, height: 15, scaleX: 2, scaleY: 2 };
        const half = (left, right) => Float32Array.from({ length: 300 }, (_, p) => (p % 20 < 10 ? left : right));
        const places = [
          [5, 15],
          [35, 15],
        ];
        const look = (draw) => drawn(k, 1, draw, places);
        return {
          boundary: look((context) => tracecut.drawBoundaries(context, { ...grid, pb: half(0, 0.6) })),
          thin: look((context) =>
            tracecut.drawBoundaries(context, { ...grid, thin: half(1, 0.2) }, { of: 'thin', white: 0.2, black: 1 }),
          ),
          heat: look((context) => tracecut.drawSaliency(context, { ...grid, saliency: half(0, 1) })),
          flow: look((context) => tracecut.drawFlow(context, { ...grid, u: half(0, 3), v: half(0, 0) }, { scale: 3 })),
          cells: drawn(
            k,
            1,
            (context) =>
              tracecut.drawCells(context, result, 1, { color: (i) => (i === 2 ? null : '#102030'), reach: 3 }),
            [
              [10, 13],
              [12, 17],
              [30, 4],
              [25, 25],
            ],
          ),
        };
      }, kind);
      assert.deepEqual(boundary, [
        [255, 255, 255, 255],
        [0, 0, 0, 255],
      ]);
      assert.deepEqual(thin, [
        [0, 0, 0, 255],
        [255, 255, 255, 255],
      ]);
      near(heat[0], [0x0b, 0x0b, 0x24, 255], 'no saliency');
      near(heat[1], [0xfd, 0xf3, 0xa0, 255], 'all saliency');
      near(flow[0], [255, 255, 255, 255], 'no motion');
      near(flow[1], [0xe8, 0x46, 0x3c, 255], 'motion to the right');
      assert.deepEqual(cells, [[0x10, 0x20, 0x30, 255], [0x10, 0x20, 0x30, 255], CLEAR, CLEAR]);
    });
  });
}

test('a real run is drawn in the colours of its labels, in the page and by file alike', async () => {
  const { page } = shared;
  const { wrong, painted, files } = await page.evaluate(async () => {
    const { tracecut } = globalThis.kit;
    const clip = await tracecut.synthClip({ width: 128, height: 72, frames: 8, seed: 5 });
    const session = await tracecut.createSession();
    for (let k = 0; k < 8; k += 1) await session.push(clip.frame(k));
    const result = await session.run();
    const context = new OffscreenCanvas(128, 72).getContext('2d', { willReadFrequently: true });
    tracecut.drawLabels(context, result, 4, { opacity: 1, outline: false });
    const { data } = context.getImageData(0, 0, 128, 72);
    const bitmap = await createImageBitmap(new Blob([await tracecut.maskPng(result, 4, { transparent: true })]));
    context.clearRect(0, 0, 128, 72);
    context.drawImage(bitmap, 0, 0);
    const decoded = context.getImageData(0, 0, 128, 72).data;
    let [bad, count] = [0, 0];
    result.labels(4).forEach((label, p) => {
      const color = `#${[...data.subarray(4 * p, 4 * p + 3)].map((v) => v.toString(16).padStart(2, '0')).join('')}`;
      if (label > 0) count += 1;
      if (label > 0 ? color !== tracecut.objectColor(label) || data[4 * p + 3] !== 255 : data[4 * p + 3] !== 0)
        bad += 1;
    });
    for (const draw of ['drawTrajectories', 'drawDiscontinuities']) tracecut[draw](context, result, 4);
    tracecut.drawSuperpixels(context, await result.superpixels(4), { image: bitmap, edges: true });
    tracecut.drawBoundaries(context, await result.boundaries(4));
    tracecut.drawSaliency(context, await result.saliencyMap(4));
    tracecut.drawFlow(context, await session.flow(4));
    session.close();
    return { wrong: bad, painted: count, files: decoded.every((value, at) => value === data[at]) };
  });
  assert.ok(painted > 200, `${painted} pixels of objects`);
  assert.equal(wrong, 0);
  assert.ok(files, 'the browser decodes the PNG file to the same pixels');
});

test('what cannot be drawn is refused in words, and the canvas left as it was', async () => {
  const { page } = shared;
  const messages = await page.evaluate(() => {
    const { result, tracecut } = globalThis.kit;
    const context = new OffscreenCanvas(40, 30).getContext('2d');
    const failure = (call) => {
      try {
        call();
        return 'no error';
      } catch (error) {
        return `${error.code}: ${error.message}`;
      }
    };
    return [
      () => tracecut.drawLabels(context, result, 3),
      () => tracecut.drawLabels(context, result, 0, { opacity: 2 }),
      () => tracecut.drawLabels(context, result, 0, { colors: () => 'orange' }),
      () => tracecut.drawLabels(context, result, 0, { fill: 1 }),
      () => tracecut.drawLabels(null, result, 0),
      () => tracecut.drawTrajectories(context, {}, 0),
      () => tracecut.drawTrajectories(context, result, 0, { tail: -1 }),
      () => tracecut.drawTrajectories(context, result, 0, { color: 3 }),
      () => tracecut.drawDiscontinuities(context, result, 0, { threshold: 'high' }),
      () => tracecut.drawSuperpixels(context, {}),
      () => tracecut.drawSuperpixels(context, { label: [0], count: 1, width: 1, height: 1 }, { fill: 'mean' }),
      () => tracecut.drawBoundaries(context, { width: 1, height: 1, pb: new Float32Array(2) }),
      () => tracecut.drawCells(context, result, 0, {}),
      () => tracecut.fitFrame(context, { width: 0, height: 1 }),
    ]
      .map(failure)
      .concat(String(context.getTransform().isIdentity), String(context.globalAlpha));
  });
  const expected = [
    /^param: t = 3 \(expected a whole number, 0\.\.=2\)/,
    /^param: opacity = 2 \(expected a number, 0\.\.=1\)/,
    /^param: colour = "orange" \(expected #rrggbb\)/,
    /^param: fill = 1 \(expected a known option; the options are opacity/,
    /^param: context = null/,
    /^data: result = an Object/,
    /^param: tail = -1/,
    /^param: color = 3/,
    /^param: threshold = "high"/,
    /^data: superpixels = an Object/,
    /^param: image = undefined/,
    /^data: map = an Object/,
    /^param: color = undefined/,
    /^param: frame = an Object/,
    /^true$/,
    /^1$/,
  ];
  assert.equal(messages.length, expected.length);
  expected.forEach((pattern, k) => assert.match(messages[k], pattern));
});

test('a page whose package is missing says so in words', async (t) => {
  const context = await site.browser.newContext();
  t.after(() => context.close());
  const page = await context.newPage();
  await page.route('**/dist/**', (route) => route.fulfill({ status: 404, body: 'not found' }));
  await page.goto(site.url);
  await page.waitForFunction(() => document.body.dataset.state === 'error' || document.body.dataset.phase === 'error');
  assert.match(await page.locator('#error').innerText(), /\w{4,}/);
});
