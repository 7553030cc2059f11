// Files that people drop on the studio: videos without a name's ending, hidden files between images, damage.

import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { ensureClips } from '../intake.mjs';
import { movingFrames } from '../moving.mjs';
import { pngBytes } from '../png.mjs';
import { downloadBytes, expect, runEnd, test, useSample } from './fixtures.mjs';
import { needsFfmpeg } from './video-clips.mjs';

const studio = useSample({ sample: 'tiny' });

/** Gives files to the studio, and expects that the run of them succeeds. */
async function open(files) {
  const { page } = studio;
  await page.setInputFiles('#file', files);
  expect(await runEnd(page), await page.locator('main').innerText()).toBe('done');
  return page;
}

const clipFile = (name, source) => ({ name, mimeType: '', buffer: readFileSync(join(ensureClips(), source)) });

test('reads a video without a known type, and shows its average frame rate', async () => {
  needsFfmpeg();
  const page = await open([clipFile('clip', 'vfr.mp4')]);
  await expect(page.locator('#counter')).toHaveText(/\/ 16$/);
  await expect(page.locator('#headline')).toHaveText('1 moving object');
  await expect(page.locator('#clip-facts')).toHaveText('120 × 90, 0.9 s at 17.14 fps');
});

test('uses the frames of a truncated video before the damage, also in saved files', async () => {
  needsFfmpeg();
  const page = await open([clipFile('cut.mp4', 'cut-off.mp4')]);
  await expect(page.locator('#notice')).toHaveText(/^The file is damaged: the first 8 of 16 frames/);
  await page.click('#export-open');
  await page.evaluate(() => (document.querySelector('#export-more').open = true));
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('[data-export="coco"]')]);
  expect(JSON.parse(await downloadBytes(download)).images).toHaveLength(8);
});

test('sorts images by their numbers, without hidden files, and uses those before a damaged one', async () => {
  const images = movingFrames(10, [96, 64]).map((frame, k) => ({
    name: `frame${k + 1}.png`,
    mimeType: '',
    buffer: pngBytes(frame, { channels: 4 }),
  }));
  images[6].buffer = images[6].buffer.subarray(0, 60);
  const hidden = images.map(({ name }) => ({ name: `._${name}`, mimeType: '', buffer: Buffer.from('Mac OS X') }));
  const page = await open([...hidden, ...images.toReversed()]);
  await expect(page.locator('#notice')).toHaveText(/^The file is damaged: the first 6 of 10 frames/);
  await expect(page.locator('#counter')).toHaveText(/\/ 6$/);
});
