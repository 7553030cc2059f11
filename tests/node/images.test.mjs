// PNG files of cut-out objects, in an archive and as an animation, decoded by the definition of the format.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { encodeVideo } from 'tracecut';
import { encodeImages } from 'tracecut/export';
import { unzipSync, unzlibSync } from '../../dist/vendor/zip.js';
import { pngParts } from '../png.mjs';
import { rejects } from './support.mjs';

const [WIDTH, HEIGHT] = [9, 7];
const inside = (t, x, y) => x >= 2 + t && x < 5 + t && y >= 2 && y < 5;
const masks = {
  width: WIDTH,
  height: HEIGHT,
  numFrames: 3,
  times: [1, 1.25, 1.3],
  end: 2,
  labels: (t) =>
    Uint8Array.from({ length: WIDTH * HEIGHT }, (_, p) => Number(inside(t, p % WIDTH, Math.floor(p / WIDTH)))),
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

test('an archive has the cut-out of each frame, and the times', async () => {
  const bytes = await encode({});
  const files = unzipSync(bytes);
  assert.deepEqual(Object.keys(files), ['00000.png', '00001.png', '00002.png', 'images.json']);
  for (const t of [0, 1, 2]) {
    const chunks = pngParts(files[`0000${t}.png`]);
    assert.deepEqual(
      chunks.map(({ type }) => type),
      ['IHDR', 'IDAT', 'IEND'],
    );
    assert.deepEqual([...chunks[0].data], [0, 0, 0, WIDTH, 0, 0, 0, HEIGHT, 8, 6, 0, 0, 0]);
    assert.deepEqual(decodeRows(chunks[1].data, 4), cutoutOf(t), `frame ${t}`);
  }
  const about = JSON.parse(new TextDecoder().decode(files['images.json']));
  assert.deepEqual([about.times, about.end, about.width, about.files[2]], [masks.times, 2, WIDTH, '00002.png']);
  assert.deepEqual(await encode({}), bytes);
});

const text = (bytes) => new TextDecoder().decode(bytes);

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
    names.forEach((name, t) => {
      const chunks = pngParts(files[name]);
      assert.deepEqual([...chunks[0].data], [0, 0, 0, WIDTH, 0, 0, 0, HEIGHT, 8, 6, 0, 0, 0]);
      assert.deepEqual(decodeRows(chunks[1].data, 4), cutoutOf(t), name);
    });
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
  assert.deepEqual(
    chunks.map(({ type }) => type),
    ['IHDR', 'acTL', 'fcTL', 'IDAT', 'fcTL', 'fdAT', 'fcTL', 'fdAT', 'IEND'],
  );
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
  assert.deepEqual(
    await grey({}),
    masks.labels(0).map((label) => 255 * label),
  );
  const soft = await grey({ feather: 2 });
  assert.ok(
    soft.some((value) => value > 0 && value < 255),
    String(soft),
  );
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
  await rejects(
    encodeImages(masks, frames(), { format: 'gif' }),
    'param',
    /format = "gif" \(expected 'zip', 'apng', 'editor'/,
  );
  await rejects(encodeImages(masks, frames(), { style: 'overlay' }), 'param', /style = "overlay"/);
  await rejects(encodeImages(masks, null), 'param', /frames = null/);
  await rejects(encodeImages({ ...masks, end: 1 }, frames()), 'data', /masks\.end = 1/);
  await rejects(encode({}, masks, frames().slice(1)), 'data', /ended after 2 of 3/);
  const stop = new AbortController();
  const reading = encode({ signal: stop.signal, onProgress: () => stop.abort(new Error('enough')) });
  await assert.rejects(reading, /enough/);
});

test('videos need a browser; the error names what to use instead', async () => {
  await rejects(encodeVideo(masks, frames()), 'unsupported', /WebCodecs.*masksZip/);
});
