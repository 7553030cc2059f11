// Files that end in damage: the page runs with the frames before it, and says so.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { before, describe, test } from 'node:test';
import { ensureClips } from '../intake/clips.mjs';
import { withFfmpeg } from './video-clips.mjs';
import {
  accessibilityFaults,
  bytesOf,
  gifFile,
  movingClip,
  openSample,
  openSave,
  plainFrame,
  run,
  screenshot,
  text,
  useSite,
} from './support.mjs';

describe('the page runs with the frames before the damage', () => {
  const site = useSite({ sample: 'tiny' });
  let page, faults;
  before(async () => ({ page, faults } = await openSample(site, { bypassCSP: true })));

  test('of a folder with a damaged PNG', async () => {
    const files = movingClip(10, [96, 64]);
    files[6] = { ...files[6], buffer: files[6].buffer.subarray(0, 60) };
    assert.equal(await run(page, files), 'done');
    assert.match(await text(page, '#notice'), /^The file is cut off or damaged\. 6 of 10 frames come before that/);
    assert.match(await text(page, '#counter'), /\/ 6$/);
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'damage');
  });

  test('of a GIF that is cut off', async () => {
    const frames = Array.from({ length: 10 }, (_, t) =>
      plainFrame(48, 32, (x, y) => [(9 * x + 5 * t) % 250, 7 * y, 0]),
    );
    const gif = gifFile('cut.gif', frames);
    assert.equal(await run(page, [{ ...gif, buffer: gif.buffer.subarray(0, 0.65 * gif.buffer.length) }]), 'done');
    assert.match(await text(page, '#notice'), /^The file is cut off or damaged\. [567] frames come before that/);
    assert.deepEqual(faults, []);
  });

  test('of a truncated video; the saved file has the same number of frames', withFfmpeg, async () => {
    const buffer = readFileSync(join(ensureClips(), 'cut-off.mp4'));
    assert.equal(
      await run(page, [{ name: 'cut.mp4', mimeType: 'video/mp4', buffer }]),
      'done',
      await text(page, 'main'),
    );
    assert.match(await text(page, '#notice'), /^The file is cut off or damaged\. 8 of 16 frames/);
    await openSave(page);
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('[data-export="coco"]')]);
    assert.equal(JSON.parse(await bytesOf(download)).images.length, 8);
  });
});
