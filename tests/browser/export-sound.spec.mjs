// Sound of saved videos: copied from the source if the format can hold it, else converted to Opus; as long as the video and in
// time with it.

import { expect, test, useEmptyPage } from './fixtures.mjs';

const soundPage = useEmptyPage(async (page) => {
  await page.evaluate(defineVideo);
  await page.evaluate(defineClicks);
});

/** Runs in the page: defines the video to encode (frames from 0.5 s to 1.3 s), three seconds of a rising tone, and a reader. */
async function defineVideo() {
  const media = await import('/dist/vendor/media.js');
  const { encodeVideo } = await import('/dist/index.js');
  const { encodeImages, soundInfo } = await import('/dist/export.js');
  const { errorText } = await import('/tests/browser/page-helpers.mjs');
  const encodeTone = async () => {
    const output = new media.Output({ format: new media.WebMOutputFormat(), target: new media.BufferTarget() });
    const track = new media.EncodedAudioPacketSource('opus');
    output.addAudioTrack(track);
    await output.start();
    const chunks = [];
    const encoder = new AudioEncoder({ output: (...chunk) => chunks.push(chunk), error: console.error });
    const sampleRate = 48000;
    encoder.configure({ codec: 'opus', sampleRate, numberOfChannels: 1, bitrate: 64000 });
    const data = Float32Array.from({ length: 3 * sampleRate }, (_, k) => 0.3 * Math.sin(k * k * 1e-6));
    const size = { sampleRate, numberOfFrames: data.length, numberOfChannels: 1 };
    encoder.encode(new AudioData({ format: 'f32', ...size, timestamp: 0, data }));
    await encoder.flush();
    for (const [chunk, meta] of chunks) await track.add(media.EncodedPacket.fromEncodedChunk(chunk), meta);
    await output.finalize();
    return new Blob([output.target.buffer]);
  };
  const read = async (blob) => {
    const input = new media.Input({ source: new media.BlobSource(blob), formats: media.ALL_FORMATS });
    const readPackets = async (track) => {
      const packets = [];
      for await (const { timestamp, duration, data } of new media.EncodedPacketSink(track).packets())
        packets.push({ timestamp, end: timestamp + duration, bytes: data.subarray(0, 12).join() });
      return packets;
    };
    const [video, sound] = [await input.getPrimaryVideoTrack(), await input.getPrimaryAudioTrack()];
    return {
      video: video && (await readPackets(video)),
      sound: sound && (await readPackets(sound)),
      codec: (await sound?.getCodec()) ?? null,
    };
  };
  const times = Array.from({ length: 20 }, (_, k) => 0.5 + k / 25);
  const frames = times.map(() => new ImageData(64, 48));
  const masks = { width: 64, height: 48, numFrames: 20, labels: () => new Uint8Array(64 * 48), times };
  Object.assign(globalThis, {
    errorText,
    encodeVideo,
    encodeImages,
    soundInfo,
    tone: await encodeTone(),
    read,
    masks,
    frames,
  });
}

/** Runs in the page: defines sound files with clicks, and when there are clicks in a file. */
async function defineClicks() {
  const media = await import('/dist/vendor/media.js');
  const mux = async (codec, packets, decoderConfig) => {
    const output = new media.Output({ format: new media.Mp4OutputFormat(), target: new media.BufferTarget() });
    const track = new media.EncodedAudioPacketSource(codec);
    output.addAudioTrack(track);
    await output.start();
    for (const { data, timestamp, duration } of packets)
      await track.add(new media.EncodedPacket(data, 'key', timestamp, duration), { decoderConfig });
    await output.finalize();
    return new Blob([output.target.buffer]);
  };
  /** Bursts of 4 ms, uncompressed. The file begins shortly before the first click. */
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
    const late = packets.filter(({ timestamp }) => timestamp > clicks[0] - 0.05);
    return mux('pcm-s16', late, { codec: 'pcm-s16', sampleRate, numberOfChannels: channels });
  };
  /** AAC packets of one channel: silent ones, and loud ones of one coefficient, whose tone swells for a packet and fades in the next. */
  const [silentPacket, loudPacket] = [
    [0x00, 0xc8, 0x00, 0x07],
    [0x01, 0x7c, 0x05, 0x05, 0x40, 0x00, 0x00, 0xa3, 0x80],
  ].map((bytes) => Uint8Array.from(bytes));
  const aac = (clicks, seconds) => {
    const sampleRate = 44100;
    const duration = 1024 / sampleRate;
    const loud = clicks.map((click) => Math.round(click / duration) - 1);
    const packets = Array.from({ length: Math.floor(seconds / duration) }, (_, n) => ({
      data: loud.includes(n) ? loudPacket : silentPacket,
      timestamp: n * duration,
      duration,
    }));
    const description = new Uint8Array([0x12, 0x08]);
    return mux('aac', packets, { codec: 'mp4a.40.2', sampleRate, numberOfChannels: 1, description });
  };
  const encodeClicks = ({ kind, channels, sampleRate, clicks }) =>
    kind === 'aac' ? aac(clicks, 2) : pcm(sampleRate, channels, clicks, 2);
  /** Returns the loudness, and the time of each click in seconds: the middle of its energy. */
  const readClicks = async (blob) => {
    const input = new media.Input({ source: new media.BlobSource(blob), formats: media.ALL_FORMATS });
    const track = await input.getPrimaryAudioTrack();
    const energies = [];
    const decoder = new AudioDecoder({
      output: (data) => {
        const plane = new Float32Array(data.numberOfFrames);
        data.copyTo(plane, { planeIndex: 0, format: 'f32-planar' });
        plane.forEach((value, k) => energies.push([data.timestamp / 1e6 + k / data.sampleRate, value * value]));
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
    const highest = energies.reduce((most, [, energy]) => Math.max(most, energy), 0);
    const clicks = [];
    for (const [time, energy] of energies.filter(([, value]) => value > highest / 30)) {
      const last = clicks.at(-1);
      if (last && time - last.end < 0.06)
        Object.assign(last, {
          end: time,
          weightedTime: last.weightedTime + energy * time,
          energy: last.energy + energy,
        });
      else clicks.push({ end: time, weightedTime: energy * time, energy });
    }
    return { loudness: Math.sqrt(highest), times: clicks.map(({ weightedTime, energy }) => weightedTime / energy) };
  };
  Object.assign(globalThis, { encodeClicks, readClicks });
}

/** Expects clicks at these times, within 10 ms. */
function expectClicks(times, expected) {
  expect(times.length, String(times)).toBe(expected.length);
  expected.forEach((time, k) =>
    expect(Math.abs(times[k] - time), `${times[k]} s (expected ${time} s)`).toBeLessThan(0.01),
  );
}

for (const [format, style] of [
  ['webm', 'cutout'],
  ['mp4', 'overlay'],
]) {
  test(`copies sound into ${format} files (${style}), of the same seconds and as long as the video`, async () => {
    const { source, encoded, info } = await soundPage.page.evaluate(
      async (options) => {
        const blob = await encodeVideo(masks, frames, { ...options, sound: { source: tone, start: 0.5, end: 1.3 } });
        return { source: await read(tone), encoded: await read(blob), info: await soundInfo(tone) };
      },
      { format, style },
    );
    const formats = ['webm', 'mp4', 'wav'];
    expect(info).toEqual({ codec: 'opus', channels: 1, sampleRate: 48000, formats, converted: [] });
    expect([encoded.codec, encoded.video.length]).toEqual(['opus', 20]);
    expect(encoded.video.at(-1).timestamp).toBeCloseTo(0.76, 2);
    expect(Math.abs(encoded.sound.at(-1).end - 0.8)).toBeLessThan(0.025);
    expect(encoded.sound[0].timestamp).toBeLessThan(0.025);
    const first = source.sound.findIndex(({ bytes }) => bytes === encoded.sound[0].bytes);
    expect(Math.abs(source.sound[first].timestamp - 0.5)).toBeLessThan(0.025);
    encoded.sound.forEach(({ bytes, timestamp }, k) => {
      const original = source.sound[first + k];
      expect(bytes, `packet ${k}`).toBe(original.bytes);
      expect(Math.abs(timestamp - Math.max(0, original.timestamp - 0.5)), `packet ${k}`).toBeLessThan(0.002);
    });
  });
}

test('a source without sound gives a silent video; sound that cannot be written, and invalid options, are refused', async () => {
  const { silent, formats, messages } = await soundPage.page.evaluate(async () => {
    const mute = await encodeVideo(masks, frames);
    const silent = await read(await encodeVideo(masks, frames, { sound: { source: mute } }));
    const pcm = await encodeClicks({ kind: 'pcm', channels: 1, sampleRate: 8000, clicks: [0.5] });
    const failure = (sound) => errorText(encodeVideo(masks, frames, { sound }));
    const { AudioDecoder } = globalThis;
    delete globalThis.AudioDecoder;
    const { formats } = await soundInfo(pcm);
    const refused = await failure({ source: pcm });
    globalThis.AudioDecoder = AudioDecoder;
    const messages = [
      refused,
      await failure({ source: 7 }),
      await failure({ source: pcm, start: -1 }),
      await failure({ source: pcm, start: 2, end: 1 }),
    ];
    return { silent, formats, messages };
  });
  expect([silent.sound, silent.video.length]).toEqual([null, 20]);
  expect(formats).toEqual(['mp4']);
  [
    /^unsupported: sound: WebM files cannot hold pcm-s16 as it is, and this browser .* Opus; try format: 'mp4'/,
    /^param: sound\.source = 7 \(expected a Blob/,
    /^param: sound\.start = -1 \(expected seconds/,
    /^param: sound\.end = 1 \(expected more than start = 2/,
  ].forEach((pattern, k) => expect(messages[k]).toMatch(pattern));
});

for (const [kind, channels, sampleRate] of [
  ['aac', 1, 44100],
  ['pcm', 2, 44100],
  ['pcm', 2, 64000],
  ['pcm', 6, 8000],
]) {
  test(`converts ${kind} sound (${channels} × ${sampleRate} Hz) to Opus in WebM, in time`, async () => {
    // Some clicks are before and after the video.
    const clicks = kind === 'aac' ? [0.2, 0.63, 0.9, 1.12, 1.6] : [0.63, 0.9, 1.12, 1.6];
    const { info, codec, before, after, start, end } = await soundPage.page.evaluate(
      async (options) => {
        const source = await encodeClicks(options);
        const style = options.kind === 'aac' ? 'cutout' : 'overlay';
        const blob = await encodeVideo(masks, frames, { style, sound: { source, start: 0.5, end: 1.3 } });
        const { codec, sound } = await read(blob);
        const [start, end] = [sound[0].timestamp, sound.at(-1).end];
        return {
          info: await soundInfo(source),
          codec,
          before: await readClicks(source),
          after: await readClicks(blob),
          start,
          end,
        };
      },
      { kind, channels, sampleRate, clicks },
    );
    expect([info.formats, info.converted, codec]).toEqual([['webm', 'mp4', 'wav'], ['webm'], 'opus']);
    expect(start).toBeLessThan(0.001);
    expect(Math.abs(end - 0.8)).toBeLessThan(0.03);
    expect(before.times).toHaveLength(clicks.length);
    const expected = before.times.filter((time) => time > 0.5 && time < 1.3).map((time) => time - 0.5);
    expect(expected).toHaveLength(3);
    expectClicks(after.times, expected);
    expect(after.loudness).toBeGreaterThan(0.3 * before.loudness);
  });
}

for (const [kind, fps, numFrames] of [
  ['aac', 30000 / 1001, 20],
  // Longer than the sound.
  ['pcm', 30, 70],
]) {
  test(`images for editors have ${kind} sound as WAV, as long as ${numFrames} frames at ${fps.toFixed(2)} per second`, async () => {
    const clicks = [0.2, 0.63, 0.9, 1.12, 1.6];
    const wav = await soundPage.page.evaluate(
      async ({ numFrames, fps, ...sound }) => {
        const { unzipSync } = await import('/dist/vendor/zip.js');
        const source = await encodeClicks(sound);
        const times = Array.from({ length: numFrames }, (_, k) => 0.5 + k / fps);
        const masks = { width: 8, height: 8, numFrames, labels: () => new Uint8Array(64), times };
        const frames = times.map(() => new ImageData(8, 8));
        const stream = await encodeImages(masks, frames, { format: 'editor', sound: { source, start: 0.5 } });
        const files = unzipSync(new Uint8Array(await new Response(stream).arrayBuffer()));
        const bytes = files['sound.wav'];
        const xml = new DOMParser().parseFromString(new TextDecoder().decode(files['timeline.xml']), 'text/xml');
        return {
          info: await soundInfo(source),
          header: [...bytes.subarray(0, 44)],
          size: bytes.length,
          clicks: (await readClicks(new Blob([bytes]))).times,
          isWellFormed: xml.querySelector('parsererror') === null,
          tracks: xml.querySelectorAll('audio > track').length,
          rate: xml.querySelector('audio samplerate').textContent,
        };
      },
      { kind, channels: 2, sampleRate: 48000, clicks, fps, numFrames },
    );
    const { channels, sampleRate } = wav.info;
    const header = new DataView(Uint8Array.from(wav.header).buffer);
    const text = String.fromCharCode(...wav.header);
    expect([text.slice(0, 4), text.slice(8, 16), text.slice(36, 40)]).toEqual(['RIFF', 'WAVEfmt ', 'data']);
    expect([20, 22, 34].map((at) => header.getUint16(at, true))).toEqual([1, channels, 16]);
    const bytes = Math.round((numFrames / fps) * sampleRate) * channels * 2;
    const sizes = [sampleRate, bytes, bytes + 36, bytes + 44];
    expect([...[24, 40, 4].map((at) => header.getUint32(at, true)), wav.size]).toEqual(sizes);
    expect([wav.isWellFormed, wav.tracks, wav.rate]).toEqual([true, channels, String(sampleRate)]);
    const expected = clicks.map((time) => time - 0.5).filter((time) => time > 0 && time < numFrames / fps);
    expectClicks(wav.clicks, expected);
  });
}
