// Sound in videos that are written: copied from the source where the format can hold it, else converted to Opus; as long
// as the video and in time with it.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { useServerAndBrowser } from '../site.mjs';
import { useEmptyPage } from './empty-page.mjs';

const site = useServerAndBrowser();
const shared = useEmptyPage(site, async (page) => {
  await page.evaluate(prepare);
  await page.evaluate(prepareClicks);
});

/** Runs in the page: three seconds of a rising tone, as Opus in WebM, and how tracks are read. */
async function prepare() {
  const media = await import('/dist/vendor/media.js');
  const { encodeVideo } = await import('/dist/index.js');
  const { soundInfo } = await import('/dist/export.js');
  const output = new media.Output({ format: new media.WebMOutputFormat(), target: new media.BufferTarget() });
  const track = new media.EncodedAudioPacketSource('opus');
  output.addAudioTrack(track);
  await output.start();
  const chunks = [];
  const encoder = new AudioEncoder({
    output: (chunk, meta) => chunks.push([chunk, meta]),
    error: (error) => {
      throw error;
    },
  });
  const sampleRate = 48000;
  encoder.configure({ codec: 'opus', sampleRate, numberOfChannels: 1, bitrate: 64000 });
  const data = Float32Array.from({ length: 3 * sampleRate }, (_, k) => 0.3 * Math.sin(k * k * 1e-6));
  const tone = { format: 'f32', sampleRate, numberOfFrames: data.length, numberOfChannels: 1, timestamp: 0, data };
  encoder.encode(new AudioData(tone));
  await encoder.flush();
  for (const [chunk, meta] of chunks) await track.add(media.EncodedPacket.fromEncodedChunk(chunk), meta);
  await output.finalize();
  const source = new Blob([output.target.buffer]);
  const read = async (blob) => {
    const input = new media.Input({ source: new media.BlobSource(blob), formats: media.ALL_FORMATS });
    const packets = async (one) => {
      const list = [];
      for await (const { timestamp, duration, data: bytes } of new media.EncodedPacketSink(one).packets())
        list.push({ timestamp, end: timestamp + duration, bytes: [...bytes.subarray(0, 12)] });
      return list;
    };
    const [video, sound] = [await input.getPrimaryVideoTrack(), await input.getPrimaryAudioTrack()];
    return {
      video: video && (await packets(video)),
      sound: sound && (await packets(sound)),
      codec: (await sound?.getCodec()) ?? null,
    };
  };
  const times = Array.from({ length: 20 }, (_, k) => 0.5 + k / 25);
  const frames = times.map(() => new ImageData(64, 48));
  const masks = { width: 64, height: 48, numFrames: 20, labels: () => new Uint8Array(64 * 48), times };
  globalThis.kit = { encodeVideo, soundInfo, source, read, masks, frames };
}

for (const [format, style] of [
  ['webm', 'overlay'],
  ['mp4', 'overlay'],
  ['webm', 'cutout'],
]) {
  test(`sound is in a ${format} video (${style}), from the same seconds and as long`, async () => {
    const { page } = shared;
    const { own, made, info } = await page.evaluate(
      async (options) => {
        const { encodeVideo, soundInfo, source, read, masks, frames } = globalThis.kit;
        const blob = await encodeVideo(masks, frames, { ...options, sound: { source, start: 0.5, end: 1.3 } });
        return { own: await read(source), made: await read(blob), info: await soundInfo(source) };
      },
      { format, style },
    );
    assert.deepEqual(info, {
      codec: 'opus',
      channels: 1,
      sampleRate: 48000,
      formats: ['webm', 'mp4', 'wav'],
      converted: [],
    });
    assert.equal(made.codec, 'opus');
    assert.equal(made.video.length, 20);
    // WebM says of no frame how long it lasts.
    assert.ok(Math.abs(made.video.at(-1).timestamp - 0.76) < 0.002, `last frame at ${made.video.at(-1).timestamp} s`);
    assert.ok(Math.abs(made.sound.at(-1).end - 0.8) < 0.025, `sound of ${made.sound.at(-1).end} s`);
    assert.ok(made.sound[0].timestamp < 0.025);
    const first = own.sound.findIndex(({ bytes }) => String(bytes) === String(made.sound[0].bytes));
    assert.ok(Math.abs(own.sound[first].timestamp - 0.5) < 0.025, `begins at ${own.sound[first].timestamp} s`);
    made.sound.forEach(({ bytes, timestamp }, k) => {
      assert.deepEqual(bytes, own.sound[first + k].bytes, `packet ${k}`);
      assert.ok(Math.abs(timestamp - Math.max(0, own.sound[first + k].timestamp - 0.5)) < 0.002, `packet ${k}`);
    });
  });
}

test('a source without sound gives a video without; one that can be neither copied nor converted is refused', async () => {
  const { page } = shared;
  const { silent, messages } = await page.evaluate(async () => {
    const { encodeVideo, read, masks, frames } = globalThis.kit;
    const mute = await encodeVideo(masks, frames);
    const silent = await read(await encodeVideo(masks, frames, { sound: { source: mute } }));
    const wav = new Uint8Array(44 + 1600);
    const view = new DataView(wav.buffer);
    const word = (at, text) => wav.set(new TextEncoder().encode(text), at);
    word(0, 'RIFF');
    view.setUint32(4, 36 + 1600, true);
    word(8, 'WAVEfmt ');
    for (const [at, value] of [
      [16, 16],
      [24, 8000],
      [28, 16000],
      [40, 1600],
    ])
      view.setUint32(at, value, true);
    for (const [at, value] of [
      [20, 1],
      [22, 1],
      [32, 2],
      [34, 16],
    ])
      view.setUint16(at, value, true);
    word(36, 'data');
    const failure = (options) =>
      encodeVideo(masks, frames, options).then(
        () => 'no error',
        (error) => `${error.code}: ${error.message}`,
      );
    const { AudioDecoder } = globalThis;
    delete globalThis.AudioDecoder;
    const formats = (await globalThis.kit.soundInfo(wav)).formats;
    const refused = await failure({ sound: { source: wav } });
    globalThis.AudioDecoder = AudioDecoder;
    const messages = [
      `${formats} ${refused}`,
      await failure({ sound: { source: 7 } }),
      await failure({ sound: { source: wav, start: -1 } }),
      await failure({ sound: { source: wav, start: 2, end: 1 } }),
    ];
    return { silent, messages };
  });
  assert.equal(silent.sound, null);
  assert.equal(silent.video.length, 20);
  [
    /^mp4 unsupported: sound: WebM files cannot hold pcm-s16 as it is, and this browser .* Opus; try format: 'mp4'/,
    /^param: sound\.source = 7 \(expected a Blob/,
    /^param: sound\.start = -1 \(expected seconds/,
    /^param: sound\.end = 1 \(expected more than start = 2/,
  ].forEach((pattern, k) => assert.match(messages[k], pattern));
});

/** Runs in the page, after `prepare`: how clips with clicks are made, and when there are clicks in a file. */
async function prepareClicks() {
  const media = await import('/dist/vendor/media.js');
  /** A file with packets of sound. */
  const muxed = async (codec, packets, decoderConfig) => {
    const output = new media.Output({ format: new media.Mp4OutputFormat(), target: new media.BufferTarget() });
    const track = new media.EncodedAudioPacketSource(codec);
    output.addAudioTrack(track);
    await output.start();
    for (const { data, timestamp, duration } of packets)
      await track.add(new media.EncodedPacket(data, 'key', timestamp, duration), { decoderConfig });
    await output.finalize();
    return new Blob([output.target.buffer]);
  };
  /** Bursts of 4 ms, as samples in MP4. */
  const pcm = (sampleRate, channels, clicks, seconds) => {
    const samples = new Int16Array(seconds * sampleRate * channels);
    for (const click of clicks)
      for (let k = Math.round((click - 0.002) * sampleRate); k < (click + 0.002) * sampleRate; k += 1)
        samples.fill(20000 * Math.sin((k / sampleRate) * 2 * Math.PI * 1500), k * channels, (k + 1) * channels);
    const size = Math.round(sampleRate / 40);
    const packets = Array.from({ length: Math.floor((seconds * sampleRate) / size) }, (_, n) => ({
      data: new Uint8Array(samples.buffer, 2 * n * size * channels, 2 * size * channels),
      timestamp: (n * size) / sampleRate,
      duration: size / sampleRate,
    }));
    // What is before the first click is not in the file.
    const late = packets.filter(({ timestamp }) => timestamp > clicks[0] - 0.05);
    return muxed('pcm-s16', late, { codec: 'pcm-s16', sampleRate, numberOfChannels: channels });
  };
  /** AAC by hand: silent packets, and loud ones of one coefficient, whose tone swells for a packet and fades in the next. */
  const aac = (clicks, seconds) => {
    const sampleRate = 44100;
    const packet = (isLoud) => {
      const bits = [];
      const put = (value, count) => bits.push(...value.toString(2).padStart(count, '0'));
      put(0, 7); // A single channel.
      put(isLoud ? 190 : 100, 8); // Its gain.
      put(0, 4); // Long windows.
      put(isLoud ? 10 : 0, 6); // Bands of four coefficients.
      put(0, 1);
      if (isLoud) {
        put(1, 4); // The code book of all bands.
        put(10, 5);
        put(0, 10); // All bands have the same gain.
      }
      put(0, 3);
      if (isLoud) for (let quad = 0; quad < 10; quad += 1) quad === 8 ? put(0b10100, 5) : put(0, 1);
      put(7, 3); // The end.
      while (bits.length % 8 > 0) bits.push('0');
      return Uint8Array.from({ length: bits.length / 8 }, (_, k) => parseInt(bits.slice(8 * k, 8 * k + 8).join(''), 2));
    };
    const duration = 1024 / sampleRate;
    const loud = clicks.map((click) => Math.round(click / duration) - 1);
    const packets = Array.from({ length: Math.floor(seconds / duration) }, (_, n) => ({
      data: packet(loud.includes(n)),
      timestamp: n * duration,
      duration,
    }));
    const description = new Uint8Array([0x12, 0x08]);
    return muxed('aac', packets, { codec: 'mp4a.40.2', sampleRate, numberOfChannels: 1, description });
  };
  /** When clicks sound, in seconds: the middles of what is loud, decoded as the file says. */
  const clicksOf = async (blob) => {
    const input = new media.Input({ source: new media.BlobSource(blob), formats: media.ALL_FORMATS });
    const track = await input.getPrimaryAudioTrack();
    const values = [];
    const decoder = new AudioDecoder({
      output: (data) => {
        const plane = new Float32Array(data.numberOfFrames);
        data.copyTo(plane, { planeIndex: 0, format: 'f32-planar' });
        plane.forEach((one, k) => values.push([data.timestamp / 1e6 + k / data.sampleRate, one * one]));
        data.close();
      },
      error: (error) => {
        throw error;
      },
    });
    decoder.configure(await track.getDecoderConfig());
    for await (const packet of new media.EncodedPacketSink(track).packets())
      decoder.decode(packet.toEncodedAudioChunk());
    await decoder.flush();
    const most = values.reduce((top, [, energy]) => Math.max(top, energy), 0);
    const groups = [];
    for (const [time, energy] of values.filter(([, one]) => one > most / 30)) {
      const last = groups.at(-1);
      if (last && time - last.end < 0.06)
        Object.assign(last, { end: time, sum: last.sum + energy * time, all: last.all + energy });
      else groups.push({ end: time, sum: energy * time, all: energy });
    }
    return { loud: Math.sqrt(most), times: groups.map(({ sum, all }) => sum / all) };
  };
  Object.assign(globalThis.kit, { pcm, aac, clicksOf });
}

for (const [kind, channels, sampleRate] of [
  ['aac', 1, 44100],
  ['pcm', 2, 44100],
  ['pcm', 1, 48000],
  ['pcm', 2, 64000],
  ['pcm', 6, 8000],
]) {
  for (const style of ['cutout', 'overlay']) {
    if (style === 'overlay' && kind === 'pcm') continue;
    test(`clicks in ${kind} (${channels} × ${sampleRate} Hz) are Opus in WebM (${style}), in time`, async () => {
      const { page } = shared;
      const { info, made, before, after, ends } = await page.evaluate(
        async ({ kind, channels, sampleRate, style }) => {
          const { encodeVideo, soundInfo, masks, frames, pcm, aac, clicksOf, read } = globalThis.kit;
          // Those before and after the stretch that is kept are left out.
          const clicks = kind === 'aac' ? [0.2, 0.63, 0.9, 1.12, 1.6] : [0.63, 0.9, 1.12, 1.6];
          const source = await (kind === 'aac' ? aac(clicks, 2) : pcm(sampleRate, channels, clicks, 2));
          const sound = { source, start: 0.5, end: 1.3 };
          const blob = await encodeVideo(masks, frames, { style, sound });
          const { codec, sound: packets } = await read(blob);
          return {
            info: await soundInfo(source),
            made: codec,
            before: await clicksOf(source),
            after: await clicksOf(blob),
            ends: [packets[0].timestamp, packets.at(-1).end],
          };
        },
        { kind, channels, sampleRate, style },
      );
      assert.deepEqual([info.formats, info.converted], [['webm', 'mp4', 'wav'], ['webm']]);
      assert.equal(made, 'opus');
      assert.ok(ends[0] < 0.001 && Math.abs(ends[1] - 0.8) < 0.03, `from ${ends[0]} to ${ends[1]} s`);
      const wanted = before.times.filter((time) => time > 0.5 && time < 1.3).map((time) => time - 0.5);
      assert.equal(before.times.length, kind === 'aac' ? 5 : 4);
      assert.equal(after.times.length, 3, String(after.times));
      wanted.forEach((time, k) =>
        assert.ok(Math.abs(after.times[k] - time) < 0.01, `${after.times[k]} s, not ${time} s`),
      );
      assert.ok(after.loud > 0.3 * before.loud, `as loud as ${after.loud}, not ${before.loud}`);
    });
  }
}

for (const [kind, channels, sampleRate, fps, numFrames] of [
  ['pcm', 1, 44100, 30000 / 1001, 20],
  ['aac', 2, 48000, 25, 20],
  ['pcm', 2, 48000, 30, 70],
]) {
  test(`images for editors have ${kind} sound as WAV, as long as ${numFrames} frames at ${fps.toFixed(2)}`, async () => {
    const { page } = shared;
    const made = await page.evaluate(
      async ({ kind, channels, sampleRate, fps, numFrames }) => {
        const { encodeImages, soundInfo } = await import('/dist/export.js');
        const { unzipSync } = await import('/dist/vendor/zip.js');
        const { pcm, aac, clicksOf } = globalThis.kit;
        const clicks = [0.2, 0.63, 0.9, 1.12, 1.6];
        const source = await (kind === 'aac' ? aac(clicks, 2) : pcm(sampleRate, channels, clicks, 2));
        const times = Array.from({ length: numFrames }, (_, k) => 0.5 + k / fps);
        const masks = { width: 8, height: 8, numFrames, labels: () => new Uint8Array(64), times };
        const frames = times.map(() => new ImageData(8, 8));
        const stream = await encodeImages(masks, frames, { format: 'editor', sound: { source, start: 0.5 } });
        const files = unzipSync(new Uint8Array(await new Response(stream).arrayBuffer()));
        const wav = files['sound.wav'];
        const xml = new DOMParser().parseFromString(new TextDecoder().decode(files['timeline.xml']), 'text/xml');
        return {
          info: await soundInfo(source),
          header: [...wav.subarray(0, 44)],
          size: wav.length,
          clicks: (await clicksOf(new Blob([wav]))).times,
          isWellFormed: xml.querySelector('parsererror') === null,
          tracks: xml.querySelectorAll('audio > track').length,
          rate: xml.querySelector('audio samplerate').textContent,
        };
      },
      { kind, channels, sampleRate, fps, numFrames },
    );
    const header = new DataView(Uint8Array.from(made.header).buffer);
    const text = String.fromCharCode(...made.header);
    assert.deepEqual([text.slice(0, 4), text.slice(8, 16), text.slice(36, 40)], ['RIFF', 'WAVEfmt ', 'data']);
    const { channels: heard, sampleRate: rate } = made.info;
    const facts = [20, 22, 34].map((at) => header.getUint16(at, true));
    assert.deepEqual(facts, [1, heard, 16]);
    assert.equal(header.getUint32(24, true), rate);
    const bytes = Math.round((numFrames / fps) * rate) * heard * 2;
    assert.deepEqual(
      [header.getUint32(40, true), header.getUint32(4, true), made.size],
      [bytes, bytes + 36, bytes + 44],
    );
    assert.deepEqual([made.isWellFormed, made.tracks, made.rate], [true, heard, String(rate)]);
    const wanted = [0.63, 0.9, 1.12, 1.6].map((time) => time - 0.5).filter((time) => time < numFrames / fps);
    assert.equal(made.clicks.length, wanted.length, String(made.clicks));
    wanted.forEach((time, k) =>
      assert.ok(Math.abs(made.clicks[k] - time) < 0.01, `${made.clicks[k]} s, not ${time} s`),
    );
  });
}
