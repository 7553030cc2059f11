// The intake table, and its files: one clip of a moving square, stored as phones, browsers, camcorders and people store clips.
// Each row says what a file has to give on every surface, by the contract of docs/frames.md; the tests of the command line, of
// Node, of Python and of the page all read it. `node tests/intake.mjs` makes the files, which needs ffmpeg, and prints the table as
// JSON, for Python.

import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { cpSync, existsSync, mkdirSync, readFileSync, readdirSync, renameSync, rmSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { root } from '../scripts/tools.mjs';
import { crc32 } from './png.mjs';

/** The folder that all tests of one checkout share; another version of this file has another one. */
const SOURCE = readFileSync(fileURLToPath(import.meta.url));
export const FOLDER = join(root, 'out', 'intake', createHash('sha256').update(SOURCE).digest('hex').slice(0, 12));

/** The clip: a textured red square over a textured green ground that stands still. */
export const CLIP = { width: 120, height: 90, numFrames: 16, side: 36 };

/** Pictures of the clip in BT.709, whose masks the command line, Node and Python compare. */
export const NUM_FRAMES_BT709 = 25;

/** The square's left top corner in picture `k`; ffmpeg counts from one. */
export const placeOf = (k) => ({ x: 18 + 3 * k, y: 20 + k });
const PLACE = 'x=15+3*n:y=19+n';
const SIZE = `${CLIP.width}x${CLIP.height}`;
const SQUARE = `${CLIP.side}x${CLIP.side}`;

const H264 = '-c:v libx264 -crf 20 -pix_fmt yuv420p';
const VP8 = '-c:v libvpx -crf 20 -b:v 900k';
const VP9 = '-c:v libvpx-vp9 -crf 20 -b:v 900k -pix_fmt yuv420p';
/** Uneven times in milliseconds, with a pause after the first picture, as recordings of a canvas have them. */
export const recordedMs = (n) => n * 49 + ((n * n * 7) % 19) + (n >= 1 ? 250 : 0);
const RECORDED = String.raw`settb=1/1000,setpts=N*49+mod(N*N*7\,19)+gte(N\,1)*250`;
const MILLISECONDS = '-fps_mode passthrough -enc_time_base 1:1000';
/** Delays of animated images in milliseconds. */
export const DELAYS_MS = [40, 40, 120, 40, 40, 200, 40, 40, 40, 100, 40, 40, 40, 70, 40, 300];
const DELAYED = `settb=1/1000,setpts=${DELAYS_MS.slice(0, -1)
  .map((delay, k) => String.raw`gte(N\,${k + 1})*${delay}`)
  .join('+')}`;

/** Display matrices of an MP4 track (a, b, c, d, x, y) that bring pictures upright. */
const TURNS = {
  rot90: { stored: 'transpose=2', matrix: [0, 1, -1, 0, CLIP.height, 0] },
  rot180: { stored: 'hflip,vflip', matrix: [-1, 0, 0, -1, CLIP.width, CLIP.height] },
  rot270: { stored: 'transpose=1', matrix: [0, -1, 1, 0, 0, CLIP.width] },
  mirrored: { stored: 'hflip', matrix: [-1, 0, 0, 1, CLIP.width, 0] },
};

/** Returns whether there is an ffmpeg that can make the files. */
export const hasFfmpeg = () => spawnSync('ffmpeg', ['-version'], { stdio: 'ignore' }).status === 0;

/** Returns the folder of the files, which are made where they are not there yet. */
export function ensureClips(folder = FOLDER) {
  if (existsSync(folder)) return folder;
  const draft = `${folder}.${process.pid}`;
  rmSync(draft, { recursive: true, force: true });
  mkdirSync(draft, { recursive: true });
  makeClips(draft);
  try {
    renameSync(draft, folder);
  } catch {
    rmSync(draft, { recursive: true }); // Another process was first, and its tests read these files.
  }
  return folder;
}

function makeClips(folder) {
  const at = (name) => join(folder, name);
  const run = (line, ...more) => ffmpeg(folder, line, ...more);
  const bytes = (name) => readFileSync(at(name));
  const save = (name, data) => writeFileSync(at(name), data);

  mkdirSync(at('pictures'));
  const texture = (colour, size, seed) =>
    `-f lavfi -i color=${colour}:s=${size}:r=25,format=rgb24,noise=alls=90:all_seed=${seed},gblur=1,loop=-1:1`;
  const moving =
    `${texture('0x5a965a', SIZE, 1)} ${texture('0xe63c28', SQUARE, 2)} ` +
    `-filter_complex [0][1]overlay=${PLACE}:format=gbrp`;
  run(`${moving} -frames:v ${CLIP.numFrames} pictures/%05d.png`);
  const pictures = (rate = 25) => `-framerate ${rate} -i pictures/%05d.png`;

  run(`${pictures()} ${H264} plain.mp4`);
  run(`${pictures()} ${H264} -f mpegts CAM0001.MTS`);
  cpSync(at('CAM0001.MTS'), at('no-ending'));
  cpSync(at('plain.mp4'), at('wrong-ending.jpg'));

  // Times.
  run(`${pictures(5)} ${H264} fps5.mp4`);
  run(`${pictures(7)} ${H264} fps7.mp4`);
  const pauses = String.raw`setpts=(N+gte(N\,6)*9+gte(N\,11)*3)/30/TB`;
  run(`${pictures(30)} -vf ${pauses} -fps_mode passthrough -enc_time_base 1:30000 ${H264} -bf 0 vfr.mp4`);
  run(`${pictures()} -vf ${RECORDED} ${MILLISECONDS} ${VP8} -live 1 -f webm recording.webm`);
  save('recording.webm', withoutDefaultDuration(bytes('recording.webm')));
  run(
    `${pictures()} -vf format=rgba,${RECORDED} ${MILLISECONDS} -c:v libvpx -auto-alt-ref 0 -pix_fmt yuva420p -crf 20 -b:v 900k -live 1 -f webm alpha.webm`,
  );
  save('alpha.webm', withoutDefaultDuration(bytes('alpha.webm')));
  run(
    `${pictures()} -vf format=rgba -c:v libvpx-vp9 -auto-alt-ref 0 -pix_fmt yuva420p -crf 20 -b:v 900k alpha-vp9.webm`,
  );
  run(`${pictures()} ${H264} -bf 0 -g 1 whole.mp4`);
  run('-ss 0.16 -i whole.mp4 -c copy edit-list.mp4');
  run(
    `-i plain.mp4 -f lavfi -i sine=d=0.64 -f lavfi -i sine=frequency=880:d=0.64 -map 0:v -map 1:a -map 2:a -c:v copy -c:a aac two-sounds.mp4`,
  );

  // Turns, sizes, colours.
  for (const [name, { stored, matrix }] of Object.entries(TURNS)) {
    run(`${pictures()} -vf ${stored} ${H264} stored.mp4`);
    save(`${name}.mp4`, withMatrix(bytes('stored.mp4'), matrix));
  }
  run(`${pictures()} -vf scale=90:90,setsar=4/3 ${H264} sar.mp4`);
  run(`${pictures()} -vf scale=120:44,setsar=22/45 ${H264} sar-high.mp4`);
  run(`${pictures()} -frames:v 8 ${VP8} first.webm`);
  run(`-framerate 25 -start_number 9 -i pictures/%05d.png -vf scale=80:60 ${VP8} second.webm`);
  save('list.txt', 'file first.webm\nfile second.webm\n');
  run('-f concat -i list.txt -c copy size-changes.webm');
  const bt709 = '-color_range tv -colorspace bt709 -color_primaries bt709 -color_trc bt709';
  const saturated = 'format=yuv444p,eq=saturation=2.5,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p';
  run(`${moving},${saturated} -frames:v ${NUM_FRAMES_BT709} -c:v libx264 -crf 20 ${bt709} bt709.mp4`);
  run(`${pictures()} ${VP9} vp9.webm`);
  if (hasEncoder('libx265'))
    run(`${pictures()} -c:v libx265 -x265-params log-level=none -crf 20 -pix_fmt yuv420p -tag:v hvc1 hevc.mp4`);

  // Tracks.
  run('-framerate 1 -i pictures/00001.png -vf format=yuvj420p -frames:v 1 -update 1 cover.jpg');
  run('-i cover.jpg -i plain.mp4 -map 0 -map 1 -c copy cover.mkv');
  run('-i plain.mp4 -i cover.jpg -map 1 -map 0 -c copy -disposition:v:0 attached_pic attached.mp4');
  run(
    `-f lavfi -i color=gray:s=64x48:r=5:d=0.64 -i plain.mp4 -map 0:v -map 1:v -c:v:0 libx264 -pix_fmt yuv420p -c:v:1 copy -disposition:v:0 0 -disposition:v:1 default two-tracks.mp4`,
  );
  run('-f lavfi -i sine=d=0.5 -c:a aac only-sound.m4a');
  save('not-a-video.mp4', 'These are only words, whatever the name of the file says.\n'.repeat(40));
  save('empty.mp4', '');

  // Damage.
  run(`${pictures()} ${H264} -g 4 -movflags +faststart fast.mp4`);
  save('cut-off.mp4', firstShare(bytes('fast.mp4'), 0.6));
  save('no-index.mp4', firstShare(bytes('plain.mp4'), 0.6));
  run(`${pictures()} ${VP9} -g 4 whole.webm`);
  save('cut-off.webm', firstShare(bytes('whole.webm'), 0.6));
  run(`${pictures()} ${H264} -g 4 whole.mkv`);
  save('cut-off.mkv', firstShare(bytes('whole.mkv'), 0.6));
  run(`${pictures()} ${H264} -g 4 -movflags frag_keyframe+empty_moov fragments.mp4`);
  save('cut-off-fragments.mp4', firstShare(bytes('fragments.mp4'), 0.6));
  save('hole.mp4', withHole(bytes('fast.mp4')));
  // Decoded in the order 0 4 1 2 3 8 5: picture 8 is there, and those before it are not.
  const order = 'keyint=16:scenecut=0:bframes=3:b-adapt=0:b-pyramid=none';
  run(`${pictures()} ${H264} -x264-params ${order} order.mp4`);
  run('-i order.mp4 -c copy order.mkv');
  save('cut-off-order.mkv', withoutPacketsFrom(bytes('order.mkv'), packetOf(bytes('order.mp4'), 6)));

  // Animated images and folders.
  run(`${pictures()} -vf ${DELAYED} ${MILLISECONDS} -f apng -plays 0 delays.png`);
  save('delays.png', withLastDelay(bytes('delays.png'), DELAYS_MS.at(-1)));
  run(`${pictures()} -vf ${DELAYED} -fps_mode passthrough -enc_time_base 1:100 -c:v gif -f gif delays.gif`);
  if (hasEncoder('libwebp_anim'))
    run(`${pictures()} -vf ${DELAYED} ${MILLISECONDS} -c:v libwebp_anim -quality 60 -f webp delays.webp`);
  const jpegs = (to, count, filter = 'null') => {
    mkdirSync(at(to), { recursive: true });
    run(`${pictures()} -vf ${filter} -frames:v ${count} -q:v 3 ${to}/IMG_%d.JPG`);
  };
  jpegs('exif', 12, 'transpose=2');
  for (const name of readdirSync(at('exif'))) save(`exif/${name}`, withOrientation(bytes(`exif/${name}`), 6));
  jpegs('copied', 4);
  for (const name of readdirSync(at('copied'))) save(`copied/._${name}`, '\0\x05\x16\x07\0\x02\0\0Mac OS X        ');
  save('copied/.hidden.png', 'nothing');
  mkdirSync(at('copied/IMG_9.JPG.d'));
  // Ten comes after two, and large letters beside small ones.
  jpegs('order', 12);
  for (const k of [2, 5, 11]) renameSync(at(`order/IMG_${k}.JPG`), at(`order/img_${k}.jpg`));

  // Nothing moves that colours tell.
  const grey = (size, seed) => `${texture('gray', size, seed)}`;
  run(
    `${grey(SIZE, 1)} ${grey(SQUARE, 2)} -filter_complex [0][1]overlay=${PLACE},format=gray,format=yuv420p -frames:v 16 -c:v libx264 -crf 20 camouflage.mp4`,
  );
}

/** Runs ffmpeg with arguments that hold no spaces. */
function ffmpeg(folder, line) {
  execFileSync('ffmpeg', ['-v', 'error', '-nostdin', '-y', ...line.split(' ').filter(Boolean)], {
    cwd: folder,
    stdio: ['ignore', 'ignore', 'inherit'],
  });
}

const hasEncoder = (name) =>
  new RegExp(` ${name} `).test(execFileSync('ffmpeg', ['-hide_banner', '-encoders'], { encoding: 'utf8' }));

const firstShare = (bytes, share) => bytes.subarray(0, Math.floor(bytes.length * share));

/** The bytes of a packet of an MP4 with one track. */
function packetOf(bytes, index) {
  const size = (k) => bytes.readUInt32BE(bytes.indexOf('stsz') + 16 + 4 * k);
  let start = bytes.indexOf('mdat') + 4;
  for (let k = 0; k < index; k += 1) start += size(k);
  return bytes.subarray(start, start + size(index));
}

/** A file that ends in the middle of a packet. */
const withoutPacketsFrom = (bytes, packet) => bytes.subarray(0, bytes.indexOf(packet) + (packet.length >> 1));

/** Browsers write no DefaultDuration: the element becomes a Void. */
function withoutDefaultDuration(bytes) {
  const start = bytes.indexOf(Buffer.from('23e383', 'hex'));
  const length = bytes[start + 3] & 15;
  return Buffer.concat([
    bytes.subarray(0, start),
    Buffer.from([0xec, 0x82 + length]),
    Buffer.alloc(2 + length),
    bytes.subarray(start + 4 + length),
  ]);
}

/** An MP4 whose first track has another display matrix. */
function withMatrix(bytes, [a, b, c, d, x, y]) {
  const fixed = [a, b, 0, c, d, 0, x, y].map((value) => value * 65536);
  const start = bytes.indexOf('tkhd') + 4 + 4 + 20 + 16;
  const rotated = Buffer.from(bytes);
  [...fixed, 1 << 30].forEach((value, k) => rotated.writeInt32BE(value, start + 4 * k));
  return rotated;
}

/** An MP4 whose media data has 400 wrong bytes behind its middle. */
function withHole(bytes) {
  const start = bytes.indexOf('mdat') + 4;
  const middle = start + Math.floor((bytes.length - start) * 0.6);
  return Buffer.concat([bytes.subarray(0, middle), Buffer.alloc(400, 0x55), bytes.subarray(middle + 400)]);
}

/** Returns an animated PNG whose last picture is shown for this number of milliseconds. */
function withLastDelay(bytes, milliseconds) {
  const start = bytes.lastIndexOf('fcTL');
  const changed = Buffer.from(bytes);
  changed.writeUInt16BE(milliseconds, start + 4 + 20);
  changed.writeUInt16BE(1000, start + 4 + 22);
  changed.writeUInt32BE(crc32(changed.subarray(start, start + 4 + 26)), start + 4 + 26);
  return changed;
}

/** A JPEG with an EXIF block that holds the orientation alone. */
function withOrientation(bytes, orientation) {
  const tiff = Buffer.from('4d4d002a00000008' + '0001' + '0112000300000001' + '00000000' + '00000000', 'hex');
  tiff.writeUInt16BE(orientation, 18);
  const exif = Buffer.concat([Buffer.from('Exif\0\0'), tiff]);
  const head = Buffer.from([0xff, 0xe1, 0, 0]);
  head.writeUInt16BE(exif.length + 2, 2);
  return Buffer.concat([bytes.subarray(0, 2), head, exif, bytes.subarray(2)]);
}

/**
 * A row of the table.
 * @typedef {object} Case
 * @property {string} name
 * @property {string} file file or folder
 * @property {number} numFrames pictures before the damage, if there is any
 * @property {number[] | null} times of the pictures in seconds; null for images in a folder
 * @property {number} [lastDuration] seconds that the last picture is shown
 * @property {number} first number of the first picture in the clip of the moving square
 * @property {boolean} masks whether motion is found, so that masks show the square
 * @property {boolean} [isTruncated] the file is cut off or damaged after these pictures
 * @property {'no-video' | 'truncated' | 'unsupported'} [error] nothing can be had of the file, and the error has this code
 * @property {RegExp} [words] that the error has on every surface
 * @property {Record<string, string>} [except] surfaces that cannot give this, and why
 */

const steady = (rate, count = CLIP.numFrames, start = 0) => Array.from({ length: count }, (_, k) => start + k / rate);
const paused = Array.from({ length: CLIP.numFrames }, (_, k) => (k + (k >= 6 ? 9 : 0) + (k >= 11 ? 3 : 0)) / 30);
const recorded = Array.from({ length: CLIP.numFrames }, (_, k) => recordedMs(k) / 1000);
const delayed = DELAYS_MS.map((_, k) => DELAYS_MS.slice(0, k).reduce((sum, delay) => sum + delay, 0) / 1000);

/** A file with all pictures of the clip. */
const readable = (name, file, more = {}) => ({
  name,
  file,
  numFrames: CLIP.numFrames,
  times: steady(25),
  lastDuration: 0.04,
  first: 0,
  masks: true,
  ...more,
});

/** A file that ends, or is wrong, after some pictures. */
const damaged = (name, file, more = {}) =>
  readable(name, file, { isTruncated: true, lastDuration: undefined, ...more });

/** A file of which nothing can be had. */
const unreadable = (name, file, error, message, more = {}) => ({
  ...readable(name, file),
  error,
  words: message,
  ...more,
});

/** Pictures in a folder. */
const folder = (name, file, numFrames, more = {}) =>
  readable(name, file, { numFrames, times: null, lastDuration: undefined, ...more });

/** @type {Case[]} */
export const CASES = [
  readable('an MP4', 'plain.mp4'),
  readable('a transport stream of a camcorder', 'CAM0001.MTS', { times: steady(25, 16, 1.48) }),
  readable('a file without an ending', 'no-ending', { times: steady(25, 16, 1.48) }),
  readable('a video that is called a JPEG', 'wrong-ending.jpg'),
  readable('five frames a second', 'fps5.mp4', { times: steady(5), lastDuration: 0.2 }),
  readable('seven frames a second', 'fps7.mp4', { times: steady(7), lastDuration: 1 / 7 }),
  readable('pauses', 'vfr.mp4', { times: paused, lastDuration: 1 / 30 }),
  readable('a recording of a browser', 'recording.webm', { times: recorded, lastDuration: undefined }),
  readable('a transparent recording, VP8', 'alpha.webm', { times: recorded, lastDuration: undefined }),
  readable('a transparent clip, VP9', 'alpha-vp9.webm'),
  readable('an edit list that begins at the fifth picture', 'edit-list.mp4', {
    numFrames: 12,
    times: steady(25, 12),
    first: 4,
  }),
  readable('two sound tracks', 'two-sounds.mp4'),
  readable('turned by 90 degrees', 'rot90.mp4'),
  readable('turned by 180 degrees', 'rot180.mp4'),
  readable('turned by 270 degrees', 'rot270.mp4'),
  readable('mirrored', 'mirrored.mp4'),
  readable('pixels of 4:3', 'sar.mp4'),
  readable('pixels of 22:45', 'sar-high.mp4'),
  readable('a size that changes on the way', 'size-changes.webm'),
  readable('BT.709', 'bt709.mp4', { numFrames: NUM_FRAMES_BT709, times: steady(25, NUM_FRAMES_BT709) }),
  readable('VP9', 'vp9.webm'),
  readable('HEVC', 'hevc.mp4', { except: { page: 'Chromium decodes no HEVC' } }),
  readable('a poster before the video', 'cover.mkv'),
  readable('an attached picture', 'attached.mp4'),
  readable('a small track before the default one', 'two-tracks.mp4'),
  damaged('an MP4 that is cut off', 'cut-off.mp4', { numFrames: 8, times: steady(25, 8) }),
  damaged('a WebM that is cut off', 'cut-off.webm', { numFrames: 8, times: steady(25, 8) }),
  damaged('a Matroska file that is cut off', 'cut-off.mkv', { numFrames: 8, times: steady(25, 8) }),
  damaged('a fragmented MP4 that is cut off', 'cut-off-fragments.mp4', { numFrames: 8, times: steady(25, 8, 0.08) }),
  damaged('a Matroska file that has lost pictures which others are shown after', 'cut-off-order.mkv', {
    numFrames: 5,
    times: steady(25, 5),
    masks: false,
    except: { page: 'gives one of the pictures that are shown after lost ones' },
  }),
  damaged('a hole in an MP4', 'hole.mp4', { numFrames: 8, times: steady(25, 8) }),
  readable('an animated PNG', 'delays.png', { times: delayed, lastDuration: 0.3 }),
  readable('an animated GIF', 'delays.gif', { times: delayed, lastDuration: undefined, masks: false }),
  readable('an animated WebP', 'delays.webp', {
    times: delayed,
    lastDuration: undefined,
    except: { node: 'unsupported', python: 'unsupported' },
    words: /animated WebP/,
  }),
  folder('photos with an EXIF orientation', 'exif', 12),
  folder('hidden files beside the frames', 'copied', 4, { masks: false }),
  folder('names in the order of persons', 'order', 12),
  readable('camouflage', 'camouflage.mp4', { masks: false }),
  unreadable('only sound', 'only-sound.m4a', 'no-video', /no video track/),
  unreadable('words that are called a video', 'not-a-video.mp4', 'no-video', /not a video/),
  unreadable('an empty file', 'empty.mp4', 'no-video', /empty/),
  unreadable('an MP4 whose index is cut off', 'no-index.mp4', 'truncated', /cut off/),
];

/** Times differ by less than this, in seconds. */
const TIME_TOLERANCE_S = 0.001;
const LEAST_OVERLAP = 0.8;

/**
 * The outcome of a file on a surface.
 * @typedef {object} Outcome
 * @property {number} width
 * @property {number} height
 * @property {number} numFrames
 * @property {ArrayLike<number> | null} times
 * @property {number | null} [lastDuration]
 * @property {boolean} isTruncated
 * @property {ArrayLike<number>[]} masks those that were computed, or of the red pixels where frames alone were read
 */

/**
 * Holds what a surface gave against the table.
 * @param {Case} row
 * @param {Outcome} outcome
 */
export function checkOutcome(row, outcome) {
  const { width, height, numFrames } = outcome;
  assert.deepEqual({ width, height, numFrames }, { width: CLIP.width, height: CLIP.height, numFrames: row.numFrames });
  assert.equal(outcome.isTruncated, row.isTruncated ?? false, 'is truncated');
  checkTimes(row, outcome);
  if (!row.masks) return;
  for (const k of [0, row.numFrames - 1]) {
    const overlap = overlapWithSquare(outcome.masks[k], placeOf(row.first + k));
    assert.ok(overlap >= LEAST_OVERLAP, `the mask of picture ${k} overlaps with the square by ${overlap.toFixed(2)}`);
  }
}

function checkTimes(row, { times, lastDuration }) {
  if (!row.times) return assert.equal(times ?? null, null);
  assert.equal(times?.length, row.times.length);
  row.times.forEach((time, k) =>
    assert.ok(Math.abs(times[k] - time) < TIME_TOLERANCE_S, `picture ${k} is at ${times[k]} s (expected ${time})`),
  );
  if (row.lastDuration !== undefined)
    assert.ok(Math.abs(lastDuration - row.lastDuration) < TIME_TOLERANCE_S, `the last picture lasts ${lastDuration} s`);
}

/** The mask of a frame's red pixels, which are the square's. @param {{data: ArrayLike<number>}} frame RGBA */
export function maskOfRed({ data }) {
  const mask = new Uint8Array(data.length / 4);
  for (let p = 0; p < mask.length; p += 1) mask[p] = Number(data[4 * p] - data[4 * p + 1] > 40);
  return mask;
}

/** Intersection over union of what a mask labels with the square. */
function overlapWithSquare(mask, { x, y }) {
  let [both, either] = [0, 0];
  for (let p = 0; p < mask.length; p += 1) {
    const [column, row] = [p % CLIP.width, Math.floor(p / CLIP.width)];
    const isSquare = column >= x && column < x + CLIP.side && row >= y && row < y + CLIP.side;
    if (isSquare && mask[p]) both += 1;
    if (isSquare || mask[p]) either += 1;
  }
  return either === 0 ? 0 : both / either;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const cases = CASES.map((row) => ({ ...row, words: row.words?.source ?? null, place: placeOf(row.first) }));
  console.log(JSON.stringify({ folder: ensureClips(), clip: CLIP, cases }));
}
