// Video files as cameras, browsers and programs write them: each picture once, with the file's own time, upright, in
// square pixels, and damage is told.

import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { before, describe, test } from 'node:test';
import { FILM, H264, UNEVEN, unevenTimes, useFilms, withFfmpeg } from './film.mjs';
import { ended, openSample, run, text, useSite } from './support.mjs';
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
  const { film, ffmpeg, path } = films;
  before(() => film('plain.mp4', H264));

  async function seen(name, options = {}) {
    await giveFile(library.page, path(name));
    return library.page.evaluate(seenOf, options);
  }

  /** That a file has all pictures, each once, at these times. */
  async function assertWhole(name, times, size = `${width}x${height}`) {
    const found = await seen(name);
    assert.equal(found.fault, null);
    assert.deepEqual(found.pictures, upTo(count));
    assert.deepEqual(found.sizes, [size]);
    assertTimes(found.times, times);
    assertTimes(found.info.times, times);
    const { info } = found;
    assert.deepEqual([`${info.width}x${info.height}`, info.numFrames, info.decodable], [size, count, true]);
    const end = found.times.at(-1) + found.durations.at(-1);
    assert.ok(Math.abs(info.duration - (end - found.times[0])) < 1e-6, `${info.duration} s`);
    assert.ok(Math.abs(info.frameRate - count / info.duration) < 1e-5, `${info.frameRate} frames a second`);
    return found;
  }

  test('a transparent recording without durations: the last picture lasts as long as the one before', async () => {
    const webm = ['-vf', `format=rgba,${UNEVEN}`, '-fps_mode', 'passthrough', '-enc_time_base', '1:1000'];
    const alpha = ['-c:v', 'libvpx', '-auto-alt-ref', '0', '-pix_fmt', 'yuva420p', '-b:v', '2M', '-live', '1'];
    film('alpha.webm', [...webm, ...alpha, '-f', 'webm']);
    const bytes = readFileSync(path('alpha.webm'));
    // Browsers write no DefaultDuration: an element Void takes its place.
    const at = bytes.indexOf(Buffer.from('23e383', 'hex'));
    const length = bytes[at + 3] & 15;
    bytes.set([0xec, 0x82 + length, ...Buffer.alloc(2 + length)], at);
    writeFileSync(path('alpha.webm'), bytes);
    const { durations } = await assertWhole('alpha.webm', unevenTimes());
    assert.ok(Math.abs(durations.at(-1) - durations.at(-2)) < 1e-6, durations.join());
  });

  test('a transparent VP9 video', async () => {
    film('alpha-vp9.webm', ['-vf', 'format=rgba', '-c:v', 'libvpx-vp9', '-pix_fmt', 'yuva420p', '-b:v', '2M']);
    await assertWhole('alpha-vp9.webm', even());
  });

  test('a variable rate: the average is the frame rate', async () => {
    const pauses = 'setpts=(N+gte(N\\,6)*9+gte(N\\,11)*3)/30/TB';
    film('vfr.mp4', ['-vf', pauses, '-fps_mode', 'passthrough', '-enc_time_base', '1:30000', ...H264], { rate: 30 });
    const times = upTo(count).map((k) => (k + (k >= 6 ? 9 : 0) + (k >= 11 ? 3 : 0)) / 30);
    const { info } = await assertWhole('vfr.mp4', times);
    assert.ok(Math.abs(info.frameRate - (count * 30) / 28) < 1e-3, `${info.frameRate}`);
  });

  test('equal times follow one after the other', async () => {
    const twice = 'settb=1/1000,setpts=N*40-40*eq(N\\,5)';
    film('equal.webm', ['-vf', twice, '-fps_mode', 'passthrough', '-enc_time_base', '1:1000', '-b:v', '2M']);
    await assertWhole('equal.webm', even());
  });

  test('VP8 with pictures that are never shown', async () => {
    const hidden = ['-auto-alt-ref', '1', '-lag-in-frames', '16', '-b:v', '200k'];
    const raw = ['-f', 'lavfi', '-i', 'testsrc2=s=240x180:r=25:d=4', '-c:v', 'libvpx', ...hidden];
    ffmpeg([...raw, '-pass', '1', '-f', 'null', '-']);
    ffmpeg([...raw, '-pass', '2', 'hidden.webm']);
    const found = await seen('hidden.webm');
    assert.deepEqual([found.fault, found.info.numFrames], [null, 100]);
    assertTimes(
      found.times,
      upTo(100).map((k) => k / 25),
    );
  });

  test('pixels that are not square, wide and high', async () => {
    film('wide.mp4', ['-vf', 'scale=180:180,setsar=4/3', ...H264]);
    await assertWhole('wide.mp4', even());
    film('high.mp4', ['-vf', 'scale=240:90,setsar=1/2', ...H264]);
    await assertWhole('high.mp4', even());
    ffmpeg(['-i', path('wide.mp4'), '-c', 'copy', '-f', 'mpegts', 'wide.ts']);
    await assertWhole('wide.ts', even((await seen('wide.ts')).times[0]));
  });

  test('a size that changes on the way: later pictures are scaled, also where they alone are taken', async () => {
    film('first.webm', ['-frames:v', '8', '-c:v', 'libvpx', '-b:v', '2M']);
    film('second.webm', [
      '-vf',
      'trim=start_frame=8,setpts=PTS-STARTPTS,scale=160:120',
      '-c:v',
      'libvpx',
      '-b:v',
      '2M',
    ]);
    writeFileSync(path('list.txt'), 'file first.webm\nfile second.webm\n');
    ffmpeg(['-f', 'concat', '-i', 'list.txt', '-c', 'copy', 'resize.webm']);
    await assertWhole('resize.webm', even());
    const { pictures, sizes } = await seen('resize.webm', { takes: { start: 0.4 } });
    assert.deepEqual([pictures, sizes], [[10, 11, 12, 13, 14, 15], ['240x180']]);
  });

  test('a poster before the video, and a small track before the default one', async () => {
    film('poster.jpg', ['-vf', 'negate', '-frames:v', '1']);
    ffmpeg(['-i', 'poster.jpg', '-i', 'plain.mp4', '-map', '0', '-map', '1', '-c', 'copy', 'poster.mkv']);
    await assertWhole('poster.mkv', even());
    const small = [
      '-f',
      'lavfi',
      '-i',
      'color=gray:s=64x48:r=5:d=0.64',
      '-i',
      'plain.mp4',
      '-map',
      '0:v',
      '-map',
      '1:v',
    ];
    const coded = ['-c:v:0', 'libx264', '-pix_fmt', 'yuv420p', '-c:v:1', 'copy'];
    ffmpeg([...small, ...coded, '-disposition:v:0', '0', '-disposition:v:1', 'default', 'two.mp4']);
    await assertWhole('two.mp4', even());
    // A transport stream does not say which one is the default: the largest.
    ffmpeg([...small, ...coded, '-f', 'mpegts', 'two.ts']);
    assert.deepEqual((await seen('two.ts')).pictures, upTo(count));
  });

  test('files are known by their content: a camcorder, one without an ending, one with a wrong one', async () => {
    ffmpeg(['-i', 'plain.mp4', '-c', 'copy', '-f', 'mpegts', 'CAM0001.MTS']);
    const { times } = await seen('CAM0001.MTS');
    await assertWhole('CAM0001.MTS', even(times[0]));
    for (const name of ['ending', 'wrong.txt']) {
      writeFileSync(path(name), readFileSync(path('plain.mp4')));
      await assertWhole(name, even());
    }
    film('moving.png', ['-f', 'apng']);
    await giveFile(library.page, path('moving.png'));
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
    writeFileSync(path('tapped.ts'), bytes.subarray(start));
    const found = await seen('tapped.ts');
    assert.equal(found.fault, null);
    assert.ok([5, 10].includes(found.pictures[0]), found.pictures.join());
    assert.deepEqual(found.pictures, upTo(count).slice(found.pictures[0]));
    assertTimes(found.times, whole.times.slice(found.pictures[0]));
    assert.equal(found.info.numFrames, found.pictures.length);
  });

  test('animated images have each of their pictures once; a browser that cannot take them apart says so', async () => {
    const delays = 'settb=1/1000,setpts=N*40+gte(N\\,6)*200';
    film('moving.webp', [
      '-vf',
      delays,
      '-c:v',
      'libwebp_anim',
      '-quality',
      '90',
      '-loop',
      '0',
      '-fps_mode',
      'passthrough',
    ]);
    const times = upTo(count).map((k) => 0.04 * k + (k >= 6 ? 0.2 : 0));
    await assertWhole('moving.webp', times);
    film('moving.avif', ['-c:v', 'libaom-av1', '-cpu-used', '8', '-crf', '20']);
    await assertWhole('moving.avif', even());
    for (const name of ['moving.webp', 'moving.avif', 'moving.png']) {
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

  test('a video that does not say its colours has those of one that says BT.601', async () => {
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
    before(() => {
      film('fast.mp4', [...H264, '-g', '4', '-movflags', '+faststart']);
      film('whole.webm', ['-c:v', 'libvpx-vp9', '-pix_fmt', 'yuv420p', '-b:v', '2M']);
      film('live.webm', ['-c:v', 'libvpx', '-b:v', '2M', '-live', '1']);
    });

    for (const name of ['fast.mp4', 'whole.webm', 'live.webm'])
      test(`${name} that is cut off: the frames before come, with onDamage and without`, async () => {
        const cut = `cut-${name}`;
        films.cut(cut, name, 0.6);
        const plain = await seen(cut);
        const { length } = plain.pictures;
        assert.ok(length > 2 && length < count, `${length} frames`);
        assert.deepEqual(plain.pictures, upTo(length));
        assert.deepEqual([plain.fault.code, plain.fault.frames], ['truncated', length]);
        assert.match(plain.fault.message, new RegExp(`breaks off after frame ${length}.*cut off or damaged$`));
        const told = await seen(cut, { tells: true });
        assert.deepEqual([told.pictures, told.fault], [plain.pictures, null]);
        assert.deepEqual(told.damage, { frames: length, code: 'truncated' });
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
      writeFileSync(path(name), bytes);
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
      const bytes = readFileSync(path('whole.webm'));
      for (let k = 0.6 * bytes.length; k < 0.6 * bytes.length + 9000; k += 1) bytes[Math.floor(k)] = 0;
      writeFileSync(path('holed.webm'), bytes);
      const { pictures, fault } = await seen('holed.webm');
      assert.ok(pictures.length > 2 && pictures.length < count, `${pictures.length}`);
      assert.deepEqual(pictures, upTo(pictures.length));
      assert.equal(fault.code, 'truncated');
    });

    test('of a clip that is segmented: the result, or the error, has the masks before it', async () => {
      await giveFile(library.page, path('cut-fast.mp4'));
      const found = await library.page.evaluate(async () => {
        const facts = ({ numFrames, truncated }) => ({ numFrames, truncated });
        let told = null;
        const onDamage = ({ frames, total }) => (told = { frames, total });
        const result = await tracecut.segmentVideo(file, { onDamage }).collect();
        const error = await tracecut
          .segmentVideo(file)
          .collect()
          .catch((fault) => fault);
        const again = tracecut.VideoResult.fromJSON(JSON.stringify(result));
        const windows = [];
        const fault = await failure(
          (async () => {
            for await (const { times } of tracecut.segmentVideo(file, { window: 4, overlap: 1 }))
              windows.push(times.length);
          })(),
        );
        const whole = await tracecut.segmentVideo(file, { maxFrames: 3 }).collect();
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
  const { film, ffmpeg, path } = useFilms();
  /** A file as a system gives it that does not know its kind. */
  const untyped = (name, from = name) => ({ name, mimeType: '', buffer: readFileSync(path(from)) });

  test('opens videos whatever they are called, and names what is neither video nor image', async () => {
    film('plain.mp4', H264);
    ffmpeg(['-i', 'plain.mp4', '-c', 'copy', '-f', 'mpegts', 'CAM0001.MTS']);
    film('alpha.webm', ['-c:v', 'libvpx', '-auto-alt-ref', '0', '-pix_fmt', 'yuva420p', '-b:v', '2M']);
    const { page, faults } = await openSample(site);
    const files = [untyped('CAM0001.MTS'), untyped('cam.ts', 'CAM0001.MTS'), untyped('clip', 'plain.mp4')];
    for (const file of [...files, untyped('alpha.webm')]) {
      assert.equal(await run(page, [file]), 'done', `${file.name}: ${await text(page, '#error')}`);
      assert.match(await text(page, '#counter'), /\/ 16$/);
      assert.match(await text(page, '#headline'), /^1 moving object /);
    }
    const notes = { name: 'clip.mp4', mimeType: 'video/mp4', buffer: Buffer.from('not a video '.repeat(50)) };
    assert.equal(await run(page, [notes]), 'error');
    assert.equal(await text(page, '#error-title'), 'This is neither a video nor an image');
    assert.match(await text(page, '#error-detail'), /clip\.mp4/);
    assert.deepEqual(faults, []);
    await page.context().close();
  });

  test('says the average frame rate, and how long the clip is', async () => {
    const pauses = 'setpts=(N+gte(N\\,6)*9+gte(N\\,11)*3)/30/TB';
    film('vfr.mp4', ['-vf', pauses, '-fps_mode', 'passthrough', '-enc_time_base', '1:30000', ...H264], { rate: 30 });
    const { page } = await openSample(site);
    assert.equal(await run(page, [untyped('vfr.mp4')]), 'done');
    assert.equal(await page.textContent('#clip-facts'), '240 × 180, 0.9 s at 17.14 fps');
    await page.context().close();
  });

  test('leaves out the hidden files of a folder, and has the others in the order of their numbers', async () => {
    film('f%d.png', []);
    const pictures = upTo(count).map((k) => ({
      ...untyped(`f${k + 1}.png`),
      name: k % 2 ? `F${k + 1}.png` : `f${k + 1}.png`,
    }));
    const hidden = pictures.map(({ name }) => ({ name: `._${name}`, mimeType: '', buffer: Buffer.from('Mac OS X') }));
    const { page } = await openSample(site);
    assert.equal(await run(page, [...hidden, ...pictures.reverse()]), 'done', await text(page, '#error'));
    assert.match(await text(page, '#counter'), /\/ 16$/);
    assert.match(await text(page, '#headline'), /^1 moving object /);
    const notes = { name: 'notes.txt', mimeType: 'text/plain', buffer: Buffer.from('which frames are good') };
    assert.equal(await run(page, [...pictures, notes]), 'error');
    assert.equal(await text(page, '#error-title'), 'This is neither a video nor an image');
    assert.match(await text(page, '#error-detail'), /notes\.txt/);
    await ended(page);
    await page.context().close();
  });
});
