// A page with the library and nothing else, and what makes clips in it whose frames carry their numbers.

import { before } from 'node:test';
import { useServerAndBrowser } from '../site.mjs';

/**
 * One page for all tests of a file; read `page`, `url` and `faults` in the tests.
 *
 * @param {(page: import('playwright-core').Page) => Promise<unknown>} [prepare]
 * @returns {{page: import('playwright-core').Page, url: string, faults: string[]}}
 */
export function useLibrary(prepare = async () => {}) {
  const site = useServerAndBrowser();
  const shared = { page: null, url: '', faults: [] };
  before(async () => {
    await site.ready();
    Object.assign(shared, await openLibrary(site), { url: site.url });
    await prepare(shared.page);
  });
  return shared;
}

/** A fresh page of the site with the library under `tracecut` and the helpers below. */
export async function openLibrary({ url, browser }) {
  const page = await (await browser.newContext()).newPage();
  const faults = [];
  page.setDefaultTimeout(180_000);
  page.on('pageerror', (error) => faults.push(`page error: ${error.message}`));
  // Such as the demuxer's complaint about frames that nobody closed.
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type()) && !/404|net::ERR/.test(message.text()))
      faults.push(message.text());
  });
  // A text of the site's own, shown as a page: what a test makes up itself may not ask other servers of this machine.
  await page.goto(`${url}dist/index.js`);
  await page.evaluate(async () => {
    document.body.innerHTML = '<input type="file" id="file" multiple>';
    globalThis.tracecut = await import('/model/library.js');
  });
  await page.evaluate(helpers);
  return { page, faults };
}

/** Hands a file of this machine to the page, where it is `globalThis.file` afterwards. */
export async function giveFile(page, path) {
  await page.setInputFiles('#file', path);
  await page.evaluate(() => (globalThis.file = document.querySelector('#file').files[0]));
}

/** Runs in the page. */
function helpers() {
  const SIDE = { width: 128, height: 64 };

  /**
   * Eight fields, four in a row: white where the number has a bit. The left edge of the picture is red: one sees how it
   * is turned.
   */
  globalThis.drawNumber = (context, number) => {
    const { width, height } = context.canvas;
    context.fillStyle = '#000';
    context.fillRect(0, 0, width, height);
    for (let bit = 0; bit < 8; bit += 1) {
      context.fillStyle = (number >> bit) & 1 ? '#fff' : '#000';
      context.fillRect(((bit % 4) * width) / 4, (Math.floor(bit / 4) * height) / 2, width / 4, height / 2);
    }
    context.fillStyle = '#f00';
    context.fillRect(0, 0, width / 16, height);
  };

  globalThis.numberOf = ({ data, width, height }) => {
    let number = 0;
    for (let bit = 0; bit < 8; bit += 1) {
      const x = Math.floor((((bit % 4) + 0.6) * width) / 4);
      const y = Math.floor(((Math.floor(bit / 4) + 0.5) * height) / 2);
      if (data[4 * (y * width + x) + 1] > 127) number |= 1 << bit;
    }
    return number;
  };

  /** Which of the picture's edges is red. */
  globalThis.redEdge = ({ data, width, height }) => {
    const at = (x, y) => data[4 * (y * width + x)] > 127 && data[4 * (y * width + x) + 1] < 100;
    const [right, bottom] = [width - 2, height - 2];
    const places = {
      left: [2, bottom / 2],
      right: [right, bottom / 2],
      top: [right / 2, 2],
      bottom: [right / 2, bottom],
    };
    return Object.keys(places)
      .filter((name) => at(...places[name].map(Math.round)))
      .join();
  };

  /** A video file whose frame `k` shows the number `k` at `times[k]`. */
  globalThis.makeClip = async ({
    times,
    container = 'WebM',
    codec = 'vp8',
    rotation = 0,
    width = SIDE.width,
    height = SIDE.height,
    keyEvery = 1,
  }) => {
    const media = await import('/dist/vendor/media.js');
    const output = new media.Output({
      format: new media[`${container}OutputFormat`](),
      target: new media.BufferTarget(),
    });
    const source = new media.VideoSampleSource({ codec, bitrate: 2e6, keyFrameInterval: keyEvery });
    output.addVideoTrack(source, { rotation });
    await output.start();
    const context = new OffscreenCanvas(width, height).getContext('2d');
    for (const [k, timestamp] of times.entries()) {
      globalThis.drawNumber(context, k);
      const duration = (times[k + 1] ?? timestamp + 0.04) - timestamp;
      const sample = new media.VideoSample(context.canvas, { timestamp, duration });
      await source.add(sample);
      sample.close();
    }
    await output.finalize();
    return new Blob([output.target.buffer]);
  };

  globalThis.evenTimes = (count, rate) => Array.from({ length: count }, (_, k) => k / rate);

  /** The numbers and times of the frames that a source gives. */
  globalThis.numbersOf = async (source, options) => {
    const seen = { numbers: [], times: [], durations: [], indices: [], size: '' };
    for await (const { width, height, pixels, index, time, duration } of tracecut.videoFrames(source, options)) {
      seen.numbers.push(globalThis.numberOf(await pixels()));
      seen.times.push(time);
      seen.durations.push(duration);
      seen.indices.push(index);
      seen.size = `${width}x${height}`;
    }
    return seen;
  };

  /** The code and words of what `promise` rejects with. */
  globalThis.failure = async (promise) => {
    try {
      await promise;
      return null;
    } catch (error) {
      return { code: error.code ?? error.name, message: error.message };
    }
  };
}
