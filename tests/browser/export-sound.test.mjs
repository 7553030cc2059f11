// Sound in videos that are written: copied from the source, as long as the video, where the format can hold it.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { useServerAndBrowser } from '../site.mjs';
import { emptyPage } from './empty.mjs';

const site = useServerAndBrowser();

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
  test(`sound is in a ${format} video (${style}), from the same seconds and as long`, async (t) => {
    const page = await emptyPage(t, site);
    await page.evaluate(prepare);
    const { own, made, info } = await page.evaluate(
      async (options) => {
        const { encodeVideo, soundInfo, source, read, masks, frames } = globalThis.kit;
        const blob = await encodeVideo(masks, frames, { ...options, sound: { source, start: 0.5, end: 1.3 } });
        return { own: await read(source), made: await read(blob), info: await soundInfo(source) };
      },
      { format, style },
    );
    assert.deepEqual(info, { codec: 'opus', channels: 1, sampleRate: 48000, formats: ['webm', 'mp4'] });
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

test('a source without sound gives a video without; one that the format cannot hold is refused', async (t) => {
  const page = await emptyPage(t, site);
  await page.evaluate(prepare);
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
    const messages = [
      await failure({ sound: { source: wav } }),
      await failure({ sound: { source: 7 } }),
      await failure({ sound: { source: wav, start: -1 } }),
      await failure({ sound: { source: wav, start: 2, end: 1 } }),
    ];
    return { silent, messages };
  });
  assert.equal(silent.sound, null);
  assert.equal(silent.video.length, 20);
  [
    /^unsupported: sound: WebM files cannot hold pcm-s16 as it is; try format: 'mp4'/,
    /^param: sound\.source = 7 \(expected a Blob/,
    /^param: sound\.start = -1 \(expected seconds/,
    /^param: sound\.end = 1 \(expected more than start = 2/,
  ].forEach((pattern, k) => assert.match(messages[k], pattern));
});
