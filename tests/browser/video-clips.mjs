// Video files made with ffmpeg: a red square moves over a still background, so that each picture can be identified; and what
// the browser's player shows of a saved video.

import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from './fixtures.mjs';

const hasFfmpeg = spawnSync('ffmpeg', ['-version']).status === 0;

/** Skips the current test, or all of the enclosing file or `test.describe`, where ffmpeg is missing. */
export const needsFfmpeg = () => test.skip(!hasFfmpeg, 'ffmpeg is not installed');

export const FILM = { width: 240, height: 180, count: 16, side: 60 };

/** H.264 as phones write it. */
export const H264 = ['-c:v', 'libx264', '-crf', '16', '-pix_fmt', 'yuv420p'];

/** The film's pictures as bytes, red, green and blue of each pixel. */
export function filmBytes({ width, height, count, side } = FILM) {
  const noise = (x, y, salt) => {
    const h = Math.imul((x >> 2) + 7, 374761393) ^ Math.imul((y >> 2) + 3, 668265263) ^ Math.imul(salt, 2246822519);
    return (Math.imul(h ^ (h >>> 13), 1274126177) >>> 25) - 64;
  };
  const bytes = Buffer.alloc(3 * width * height * count);
  for (let k = 0, at = 0; k < count; k += 1)
    for (let y = 0; y < height; y += 1)
      for (let x = 0; x < width; x += 1, at += 3) {
        const [sx, sy] = [x - 24 - 3 * k, y - 40 - k];
        const inside = sx >= 0 && sx < side && sy >= 0 && sy < side;
        const light = noise(inside ? sx : x, inside ? sy : y, inside ? 2 : 1) / 2;
        bytes.set(
          (inside ? [200, 60, 50] : [90, 150, 90]).map((level) => level + light),
          at,
        );
      }
  return bytes;
}

/** A folder of its own for the files of a test file, gone after it. */
export function useFilms() {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-films-'));
  test.afterAll(() => rmSync(folder, { recursive: true, force: true }));
  const path = (name) => join(folder, name);
  /** Runs ffmpeg in the folder; gives what it writes to `-`. */
  const ffmpeg = (args) =>
    execFileSync('ffmpeg', ['-nostdin', '-v', 'error', '-y', ...args], { cwd: folder, maxBuffer: 2 ** 30 });
  /** Makes a file of the film, by these arguments for the output. */
  const film = (name, args, { rate = 25, ...size } = {}) => {
    const { width, height, count } = { ...FILM, ...size };
    const pixels = `film-${width}x${height}-${count}.rgb`;
    if (!existsSync(path(pixels))) writeFileSync(path(pixels), filmBytes({ ...FILM, ...size }));
    const raw = ['-f', 'rawvideo', '-pix_fmt', 'rgb24', '-s', `${width}x${height}`, '-r', String(rate)];
    ffmpeg([...raw, '-i', pixels, ...args, name]);
    return path(name);
  };
  return { path, film, ffmpeg };
}
