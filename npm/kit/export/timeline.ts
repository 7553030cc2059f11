// A timeline for video editors: its constant frame rate, and the Final Cut Pro 7 XML and the text that describe it.
// Format: Apple, "Final Cut Pro XML Interchange Format", version 5, which Premiere Pro and DaVinci Resolve import.

import { computeDurations } from '../../check/masks.js';

/** A frame rate as editors state it: `timebase` frames per second, times 1000/1001 if `ntsc`. */
export type EditorRate = { timebase: number; ntsc: boolean };

/** Frame rates of timelines in Premiere Pro or DaVinci Resolve. */
const EDITOR_RATES: EditorRate[] = [
  ...[24, 25, 30, 48, 50, 60, 100, 120].map((timebase) => ({ timebase, ntsc: false })),
  ...[24, 30, 48, 60, 120].map((timebase) => ({ timebase, ntsc: true })),
];

/** Largest difference of durations from the median that is rounding: files that store milliseconds, at 120 frames per second. */
const MAX_ROUNDING = 0.2;

/** Largest difference of frame rates that are taken as equal. */
const MAX_RATE_DIFFERENCE = 0.005;

/** Most repetitions of every frame of a clip with fewer frames per second than any editor has. */
const MAX_REPEATS = 5;

/** Computes frames per second. */
export function toFrameRate({ timebase, ntsc }: EditorRate): number {
  return ntsc ? (timebase * 1000) / 1001 : timebase;
}

/**
 * A clip at a constant frame rate: `repeats` has how often each frame is shown, 0 if another one takes its place;
 * `length` is their sum.
 */
export type Timeline = { rate: EditorRate; repeats: number[]; length: number };

/**
 * Computes the timeline of a clip.
 * @param times of the frames, in seconds
 * @param end of the last frame
 */
export function planTimeline(times: Float64Array, end: number): Timeline {
  const durations = computeDurations(times, end);
  const rate = chooseRate(durations);
  const first = Number(times[0]);
  const toSlot = (time: number) => Math.round((time - first) * toFrameRate(rate));
  const length = Math.max(1, toSlot(end));
  const starts = [...times].map((time) => Math.min(length - 1, toSlot(time)));
  const repeats = starts.map((start, t) => (starts[t + 1] ?? length) - start);
  return { rate, repeats, length };
}

/** Chooses the editors' rate at which most frames are shown equally often. */
function chooseRate(durations: number[]): EditorRate {
  const median = Number([...durations].sort((a, b) => a - b)[durations.length >> 1]);
  const usual = durations.filter((duration) => Math.abs(duration - median) <= MAX_ROUNDING * median);
  const frameRate = usual.length / usual.reduce((sum, duration) => sum + duration, 0);
  for (let repeats = 1; repeats <= MAX_REPEATS; repeats += 1) {
    const difference = (rate: EditorRate) => Math.abs(toFrameRate(rate) / (repeats * frameRate) - 1);
    const nearest = EDITOR_RATES.reduce((best, rate) => (difference(rate) < difference(best) ? rate : best));
    if (difference(nearest) <= MAX_RATE_DIFFERENCE) return nearest;
  }
  return EDITOR_RATES.find(({ timebase, ntsc }) => !ntsc && timebase >= frameRate) ?? { timebase: 120, ntsc: false };
}

/** Files of a timeline, relative to its own. */
export type TimelineFiles = {
  width: number;
  height: number;
  /** First frame. */
  image: string;
  alpha: 'straight' | 'none';
  sound: { file: string; sampleRate: number; channels: number } | null;
};

/** Formats a timeline as XML. Editors know an image sequence by its first file. */
export function formatTimelineXml({ rate, length }: Timeline, files: TimelineFiles): string {
  const { width, height, image, alpha, sound } = files;
  const rateXml = `<rate><timebase>${rate.timebase}</timebase><ntsc>${rate.ntsc ? 'TRUE' : 'FALSE'}</ntsc></rate>`;
  const pictures = [
    ...['<samplecharacteristics>', rateXml, `<width>${width}</width>`, `<height>${height}</height>`],
    ...['<anamorphic>FALSE</anamorphic>', '<pixelaspectratio>square</pixelaspectratio>'],
    ...['<fielddominance>none</fielddominance>', '</samplecharacteristics>'],
  ].join('');
  const nameOf = (file: string) => file.slice(file.lastIndexOf('/') + 1);
  const fileXml = (id: string, file: string, media: string) => `<file id="${id}"><name>${nameOf(file)}</name>
    <pathurl>./${file}</pathurl>${rateXml}<duration>${length}</duration>
    <media>${media}</media></file>`;
  const track = (id: string, file: string, facts: string, source: string) => `<track><clipitem id="${id}">
  <name>${nameOf(file)}</name><enabled>TRUE</enabled><duration>${length}</duration>${rateXml}
  <start>0</start><end>${length}</end><in>0</in><out>${length}</out>${facts}
  ${source}
</clipitem></track>`;
  const video = `<video><duration>${length}</duration>${pictures}</video>`;
  const audio = ({ file, sampleRate, channels }: NonNullable<TimelineFiles['sound']>) => {
    const samples = `<samplecharacteristics><depth>16</depth><samplerate>${sampleRate}</samplerate></samplecharacteristics>`;
    const media = `<audio>${samples}<channelcount>${channels}</channelcount></audio>`;
    // Each channel has a track; the first one describes the file.
    const tracks = Array.from({ length: channels }, (_, c) =>
      track(
        `sound-${c + 1}`,
        file,
        `<sourcetrack><mediatype>audio</mediatype><trackindex>${c + 1}</trackindex></sourcetrack>`,
        c === 0 ? fileXml('file-2', file, media) : '<file id="file-2"/>',
      ),
    );
    return `
<audio><numOutputChannels>${channels}</numOutputChannels><format>${samples}</format>
${tracks.join('\n')}
</audio>`;
  };
  return `<?xml version="1.0" encoding="UTF-8"?>
<!DOCTYPE xmeml>
<xmeml version="5">
<sequence id="cutout"><name>Cut-out</name><duration>${length}</duration>${rateXml}
<media>
<video><format>${pictures}</format>
${track('images', image, `<alphatype>${alpha}</alphatype>`, fileXml('file-1', image, video))}
</video>${sound ? audio(sound) : ''}
</media>
</sequence>
</xmeml>
`;
}

/** Formats what a person needs to know to import the files. */
export function formatReadme({ rate, repeats, length }: Timeline, files: TimelineFiles): string {
  const { width, height, image, alpha, sound } = files;
  const folder = image.split('/')[0];
  const name = rate.ntsc ? `${toFrameRate(rate).toFixed(3)} (${rate.timebase}000/1001)` : String(rate.timebase);
  const shown = repeats.filter((count) => count > 0).length;
  const changes = [
    ...(length > shown ? [`images that repeat the one before: ${length - shown}`] : []),
    ...(shown < repeats.length ? [`frames left out: ${repeats.length - shown}`] : []),
  ];
  return `Images for video editors, made with TraceCut

Frame rate   ${name} frames per second
Size         ${width} x ${height} pixels
Images       ${length}, in the folder "${folder}"${alpha === 'none' ? '' : `; ${alpha} alpha`}
Sound        ${sound ? `${sound.file}, ${sound.sampleRate} Hz, 16 bit, ${sound.channels === 1 ? 'mono' : 'stereo'}` : 'none'}
${changes.length > 0 ? `Constant     ${changes.join('; ')}\n` : ''}
Unpack the archive first.

DaVinci Resolve: set the timeline frame rate of the project, and drag the folder "${folder}" into the media pool.
If the frame rate or the alpha of the clip is another, set it in Clip Attributes.

Premiere Pro: import the first image with Image Sequence ticked, and set the frame rate in Interpret Footage.

Both also import timeline.xml. If files are offline, link them: the first image as an image sequence.
`;
}
