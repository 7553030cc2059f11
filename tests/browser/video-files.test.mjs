// Video files as cameras, browsers and programs write them, beside those of the intake table (tests/intake): each picture
// once, with the file's own time, and damage is told.

import assert from 'node:assert/strict';
import { existsSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { before, describe, test } from 'node:test';
import { CLIP, ensureClips } from '../intake/clips.mjs';
import { FILM, H264, useFilms, withFfmpeg } from './video-clips.mjs';
import { openSample, run, text, useSite } from './support.mjs';
import { giveFile, useLibrary } from './video-support.mjs';

const { width, height, count } = FILM;
const upTo = (most) => Array.from({ length: most }, (_, k) => k);
const even = (first = 0, lasts = 0.04) => upTo(count).map((k) => first + k * lasts);

/** Runs in the page: which picture of the film each frame of the file is, and what is told of it. */
async function seenOf({ takes = {}, tells = false }) {
  const pictureOf = ({ data, width: across, height: down }) => {
    let [sum, pixels] = [0, 0];
    for (let at = 0; at < data.length; at += 4) {
      if (data[at] - data[at + 1] < 40) continue;
      sum += (at / 4) % across;
      pixels += 1;
    }
    return { picture: Math.round(((240 / across) * (sum / pixels) + 0.5 - 54) / 3), size: `${across}x${down}` };
  };
  const seen = { pictures: [], sizes: new Set(), times: [], durations: [], damage: null, fault: null, info: null };
  const onDamage = tells ? ({ frames, error }) => (seen.damage = { frames, code: error.code }) : undefined;
  try {
    for await (const { pixels, time, duration } of tracecut.videoFrames(file, { ...takes, onDamage })) {
      const { picture, size } = pictureOf(await pixels());
      seen.pictures.push(picture);
      seen.sizes.add(size);
      seen.times.push(time);
      seen.durations.push(duration);
    }
  } catch ({ code, message, frames }) {
    seen.fault = { code, message, frames };
  }
  seen.info = await tracecut.videoInfo(file, { onDamage() {} }).catch(({ code, message }) => ({ code, message }));
  return { ...seen, sizes: [...seen.sizes], info: { ...seen.info, times: seen.info.times && [...seen.info.times] } };
}

function assertTimes(found, expected) {
  assert.equal(found.length, expected.length);
  found.forEach((time, k) =>
    assert.ok(Math.abs(time - expected[k]) < 0.0011, `frame ${k} at ${time} s, not ${expected[k]} s`),
  );
}

describe('pictures of files', { timeout: 240_000, ...withFfmpeg }, () => {
  const library = useLibrary();
  const films = useFilms();
  const { film, ffmpeg } = films;
  /** A file that a test made, or one of the intake table. */
  const path = (name) => (existsSync(films.path(name)) ? films.path(name) : join(ensureClips(), name));
  before(() => film('plain.mp4', H264));

  async function seen(name, options = {}) {
    await giveFile(library.page, path(name));
    return library.page.evaluate(seenOf, options);
  }

  /** That a file has all pictures, each once, at these times. */
  async function assertWhole(name, times) {
    const found = await seen(name);
    assert.equal(found.fault, null);
    assert.deepEqual(found.pictures, upTo(count));
    assert.deepEqual(found.sizes, [`${width}x${height}`]);
    assertTimes(found.times, times);
    assertTimes(found.info.times, times);
  }

  test('a recording without durations: the last picture lasts as long as the one before', async () => {
    const { durations } = await seen('alpha.webm');
    assert.ok(Math.abs(durations.at(-1) - durations.at(-2)) < 1e-6, durations.join());
  });

  test('equal times follow one after the other', async () => {
    const twice = 'settb=1/1000,setpts=N*40-40*eq(N\\,5)';
    film('equal.webm', ['-vf', twice, '-fps_mode', 'passthrough', '-enc_time_base', '1:1000', '-b:v', '2M']);
    await assertWhole('equal.webm', even());
  });

  test('VP8 with pictures that are never shown', async () => {
    const hidden = ['-auto-alt-ref', '1', '-lag-in-frames', '16', '-b:v', '200k', '-cpu-used', '4'];
    const raw = ['-f', 'lavfi', '-i', 'testsrc2=s=96x72:r=25:d=1.6', '-c:v', 'libvpx', ...hidden];
    ffmpeg([...raw, '-pass', '1', '-f', 'null', '-']);
    ffmpeg([...raw, '-pass', '2', 'hidden.webm']);
    const found = await seen('hidden.webm');
    assert.deepEqual([found.fault, found.info.numFrames], [null, 40]);
    assertTimes(
      found.times,
      upTo(40).map((k) => k / 25),
    );
  });

  test('pixels of a transport stream that are not square', async () => {
    ffmpeg(['-i', path('sar.mp4'), '-c', 'copy', '-f', 'mpegts', 'wide.ts']);
    assert.deepEqual((await seen('wide.ts')).sizes, [`${CLIP.width}x${CLIP.height}`]);
  });

  test('a size that changes on the way: later pictures are scaled, also where they alone are taken', async () => {
    const { times, sizes } = await seen('size-changes.webm', { takes: { start: 0.4 } });
    assertTimes(times, even().slice(10));
    assert.deepEqual(sizes, [`${CLIP.width}x${CLIP.height}`]);
  });

  test('of a transport stream, which does not say which track is the default, the largest', async () => {
    ffmpeg(['-i', path('two-tracks.mp4'), '-map', '0', '-c', 'copy', '-f', 'mpegts', 'two.ts']);
    const { sizes, times } = await seen('two.ts');
    assert.deepEqual([sizes, times.length], [[`${CLIP.width}x${CLIP.height}`], count]);
  });

  test('files are known by their content, hidden ones are left out, the others in the order of their numbers', async () => {
    await giveFile(library.page, path('delays.png'));
    const kinds = await library.page.evaluate(async () => {
      const named = (name, ...parts) => new File(parts, name, { type: 'video/mp4' });
      const files = [
        named('IMG_10', file),
        named('._img_2', file),
        named('img_2', 'GET / HTTP/1.1 '.repeat(99)),
        named('a'),
      ];
      return (await tracecut.sortFiles(files)).map((found) => [found.file.name, found.kind, found.type]);
    });
    assert.deepEqual(kinds, [
      ['a', null, null],
      ['img_2', null, null],
      ['IMG_10', 'image', 'image/png'],
    ]);
  });

  test('a transport stream that begins between two key pictures has those from the first one on', async () => {
    film('long.ts', [...H264, '-g', '5', '-f', 'mpegts']);
    const bytes = readFileSync(path('long.ts'));
    const whole = await seen('long.ts');
    assert.deepEqual(whole.pictures, upTo(count));
    // From the second packet of the video on: the first key picture is lost.
    const start = 188 * Math.ceil((0.3 * bytes.length) / 188);
    writeFileSync(films.path('tapped.ts'), bytes.subarray(start));
    const found = await seen('tapped.ts');
    assert.equal(found.fault, null);
    assert.ok([5, 10].includes(found.pictures[0]), found.pictures.join());
    assert.deepEqual(found.pictures, upTo(count).slice(found.pictures[0]));
    assertTimes(found.times, whole.times.slice(found.pictures[0]));
    assert.equal(found.info.numFrames, found.pictures.length);
  });

  test('animated images have each of their pictures once; a browser that cannot decode them says so', async () => {
    film('moving.avif', ['-c:v', 'libaom-av1', '-cpu-used', '8', '-crf', '20']);
    await assertWhole('moving.avif', even());
    for (const name of ['delays.webp', 'delays.png', 'moving.avif']) {
      await giveFile(library.page, path(name));
      const fault = await library.page.evaluate(async () => {
        const { ImageDecoder } = globalThis;
        delete globalThis.ImageDecoder;
        const found = await failure(tracecut.videoInfo(file));
        globalThis.ImageDecoder = ImageDecoder;
        return found;
      });
      assert.equal(fault?.code, 'unsupported', name);
      assert.match(fault.message, new RegExp(`image/${name.split('.')[1]}`));
    }
  });

  test('without a decoder for animations a still image is one frame', async () => {
    film('still.png', ['-frames:v', '1']);
    await giveFile(library.page, path('still.png'));
    const found = await library.page.evaluate(async () => {
      const { ImageDecoder } = globalThis;
      delete globalThis.ImageDecoder;
      const sizes = [];
      for await (const { width, height } of tracecut.videoFrames(file)) sizes.push([width, height]);
      globalThis.ImageDecoder = ImageDecoder;
      return sizes;
    });
    assert.deepEqual(found, [[width, height]]);
  });

  test('kinds that no browser reads, and codecs that this one does not, are named', async () => {
    film('old.avi', ['-c:v', 'mjpeg']);
    const { fault } = await seen('old.avi');
    assert.equal(fault.code, 'no-video');
    assert.match(fault.message, /video\/x-msvideo cannot be read here; convert it/);
    film('old.mp4', ['-c:v', 'mpeg4']);
    const { fault: codec, info } = await seen('old.mp4');
    assert.deepEqual([codec.code, info.decodable, info.numFrames], ['codec', false, count]);
    assert.match(codec.message, /^the codec mp4v cannot be decoded by this browser; convert it/);
    ffmpeg(['-f', 'lavfi', '-i', 'sine=d=1', 'sound.mp4']);
    assert.match((await seen('sound.mp4')).fault.message, /no video track, only sound/);
  });

  test('a video without colour information is read as BT.601', async () => {
    const tagged = ['-colorspace', 'smpte170m', '-color_primaries', 'smpte170m', '-color_trc', 'smpte170m'];
    film('tagged.mp4', [...H264, ...tagged]);
    const means = [];
    for (const name of ['plain.mp4', 'tagged.mp4']) {
      await giveFile(library.page, path(name));
      means.push(
        await library.page.evaluate(async () => {
          const sums = [0, 0, 0];
          for await (const { pixels } of tracecut.videoFrames(file, { maxFrames: 1 })) {
            const { data } = await pixels();
            data.forEach((level, at) => at % 4 < 3 && (sums[at % 4] += (4 * level) / data.length));
          }
          return sums;
        }),
      );
    }
    means[0].forEach((mean, c) => assert.ok(Math.abs(mean - means[1][c]) < 1, `${means[0]} against ${means[1]}`));
  });

  describe('damage', () => {
    for (const name of ['cut-off.mp4', 'cut-off.webm'])
      test(`${name}: the frames before come, then an error that counts them`, async () => {
        const { times, fault } = await seen(name);
        assert.deepEqual([times.length, fault.code, fault.frames], [8, 'truncated', 8]);
        assert.match(fault.message, /breaks off after frame 8.*cut off or damaged$/);
      });

    test('none is told of where what is taken ends before it, or nothing is wrong', async () => {
      const taken = await seen('cut-off.webm', { takes: { maxFrames: 5 }, tells: true });
      assert.deepEqual([taken.times.length, taken.damage], [5, null]);
      const whole = await seen('vp9.webm', { tells: true });
      assert.deepEqual([whole.times.length, whole.damage], [count, null]);
    });

    test('of an animated GIF; the facts are of the frames before too', async () => {
      const bytes = readFileSync(path('delays.gif'));
      writeFileSync(films.path('cut.gif'), bytes.subarray(0, Math.floor(0.6 * bytes.length)));
      const { times, damage, info } = await seen('cut.gif', { tells: true });
      assert.ok(times.length > 5 && times.length < count, `${times.length}`);
      assert.deepEqual([damage, info.numFrames], [{ frames: times.length, code: 'truncated' }, times.length]);
      assert.equal((await seen('cut.gif')).fault.code, 'truncated');
    });

    /** Overwrites the middle of a packet of an H.264 file without B-frames in between, found by its number. */
    function scramble(name, from, packet) {
      const bytes = readFileSync(path(from));
      const listed = ffmpeg(['-i', from, '-c', 'copy', '-f', 'h264', '-bsf:v', 'filter_units=pass_types=1-5', '-']);
      assert.ok(listed.length > 0);
      // The data of the file lie in the order of decoding, each picture behind its length.
      let at = bytes.indexOf('mdat') + 4;
      for (let k = 0; k < packet; k += 1) at += 4 + bytes.readUInt32BE(at);
      const size = bytes.readUInt32BE(at);
      for (let k = at + 40; k < at + size; k += 1) bytes[k] = (37 * k) & 255;
      writeFileSync(films.path(name), bytes);
    }

    test('in the middle of a file: what the decoder had not given yet comes too', async () => {
      film('order.mp4', [
        ...H264,
        '-bf',
        '2',
        '-g',
        '8',
        '-x264-params',
        'b-adapt=0',
        '-bsf:v',
        'filter_units=remove_types=6',
      ]);
      // Decoded: 0, 3, 1, 2, 6, 4, 5, …
      scramble('scrambled.mp4', 'order.mp4', 4);
      const { pictures, fault } = await seen('scrambled.mp4');
      assert.deepEqual(pictures, [0, 1, 2, 3]);
      assert.deepEqual([fault.code, fault.frames], ['truncated', 4]);
    });

    test('inside of a cluster of a WebM file', async () => {
      film('whole.webm', ['-c:v', 'libvpx-vp9', '-pix_fmt', 'yuv420p', '-b:v', '2M']);
      const bytes = readFileSync(path('whole.webm'));
      const start = Math.floor(0.6 * bytes.length);
      bytes.fill(0, start, Math.min(bytes.length, start + 9000));
      writeFileSync(films.path('holed.webm'), bytes);
      const { pictures, fault } = await seen('holed.webm');
      assert.ok(pictures.length > 2 && pictures.length < count, `${pictures.length}`);
      assert.deepEqual(pictures, upTo(pictures.length));
      assert.equal(fault.code, 'truncated');
    });

    test('of a clip that is segmented: the result, or the error, has the masks before it', async () => {
      await giveFile(library.page, path('cut-off.mp4'));
      const found = await library.page.evaluate(async () => {
        const facts = ({ numFrames, truncated }) => ({ numFrames, truncated });
        let told = null;
        const onDamage = ({ frames, total }) => (told = { frames, total });
        const size = 64;
        const result = await tracecut.segmentVideo(file, { size, onDamage }).collect();
        const error = await tracecut
          .segmentVideo(file, { size })
          .collect()
          .catch((fault) => fault);
        const again = tracecut.VideoResult.fromJSON(JSON.stringify(result));
        const windows = [];
        const fault = await failure(
          (async () => {
            for await (const { times } of tracecut.segmentVideo(file, { size, window: 4, overlap: 1 }))
              windows.push(times.length);
          })(),
        );
        const whole = await tracecut.segmentVideo(file, { size, maxFrames: 3 }).collect();
        return {
          ...{ told, windows, fault, code: error.code, frames: error.frames },
          results: [result, error.result, again].map(facts),
          whole: facts(whole),
        };
      });
      const { numFrames, truncated } = found.results[0];
      assert.ok(numFrames > 4 && numFrames < count, `${numFrames}`);
      assert.equal(truncated.frames, numFrames);
      assert.match(truncated.reason, /cut off or damaged/);
      assert.deepEqual(found.results, Array(3).fill(found.results[0]));
      assert.deepEqual(found.told, { frames: numFrames, total: count });
      assert.deepEqual([found.code, found.frames, found.fault.code], ['truncated', numFrames, 'truncated']);
      assert.ok(found.windows.length > 1, `${found.windows}`);
      assert.deepEqual(found.whole, { numFrames: 3, truncated: null });
    });
  });

  test('nothing is left open, and nothing is complained about', () => assert.deepEqual(library.faults, []));
});

describe('the page', { timeout: 240_000, ...withFfmpeg }, () => {
  const site = useSite({ sample: 'tiny' });
  const path = (name) => join(ensureClips(), name);
  /** A file as a system gives it that does not know its kind. */
  const untyped = (name, from = name) => ({ name, mimeType: '', buffer: readFileSync(path(from)) });

  let page, faults;
  before(async () => ({ page, faults } = await openSample(site)));

  test('opens videos of any name, shows their average frame rate and names files that are not videos', async () => {
    for (const file of [untyped('CAM0001.MTS'), untyped('clip', 'vfr.mp4')]) {
      assert.equal(await run(page, [file]), 'done', `${file.name}: ${await text(page, '#error')}`);
      assert.match(await text(page, '#counter'), /\/ 16$/);
      assert.match(await text(page, '#headline'), /^1 moving object$/);
    }
    assert.equal(await page.textContent('#clip-facts'), `${CLIP.width} × ${CLIP.height}, 0.9 s at 17.14 fps`);
    const notes = { name: 'clip.mp4', mimeType: 'video/mp4', buffer: Buffer.from('not a video '.repeat(50)) };
    assert.equal(await run(page, [notes]), 'done');
    assert.equal(await text(page, '#notice'), 'Couldn’t open clip.mp4. Not a video or an image.');
    assert.match(await text(page, '#headline'), /^1 moving object$/, 'the result stays');
    assert.deepEqual(faults, []);
  });

  test('leaves out the hidden files of a folder, and has the others in the order of their numbers', async () => {
    const pictures = readdirSync(path('order')).map((name) => untyped(name, `order/${name}`));
    const hidden = pictures.map(({ name }) => ({ name: `._${name}`, mimeType: '', buffer: Buffer.from('Mac OS X') }));
    assert.equal(await run(page, [...hidden, ...pictures.reverse()]), 'done', await text(page, '#error'));
    assert.match(await text(page, '#counter'), /\/ 12$/);
    assert.match(await text(page, '#headline'), /^1 moving object$/);
    const notes = { name: 'notes.txt', mimeType: 'text/plain', buffer: Buffer.from('which frames are good') };
    assert.equal(await run(page, [...pictures, notes]), 'done');
    assert.match(await text(page, '#notice'), /^Couldn’t open .*\. Not a video or an image\.$/);
  });
});
