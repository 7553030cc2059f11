// Every sentence the page builds: numbers, the summary of a result, and errors with what to do about them.

import type { Facts, Times } from './presence.js';

/** An error of the page itself (the library's own is `TraceCutError`); both carry a `code`. */
export class PageError extends Error {
  name = 'PageError';

  /**
   * @param code a key of {@link ADVICE}
   * @param detail what exactly was found, for the message
   */
  constructor(
    public code: string,
    detail = '',
  ) {
    super(detail || code);
  }
}

/** Title and advice for each error code, from the page and from the library. */
const ADVICE: Record<string, [string, string]> = {
  'unreadable-video': [
    'This file cannot be played as a video here',
    'The browser has no decoder for it, or the file is damaged. Convert it to MP4 (H.264) or WebM, or try another browser.',
  ],
  'unreadable-image': [
    'One of these images cannot be read',
    'Use whole PNG, JPEG, WebP or GIF files, and leave the damaged one out.',
  ],
  'unknown-file': [
    'This is neither a video nor an image',
    'Open a video (MP4, WebM, …), an animated GIF, several images of one sequence, or one image.',
  ],
  'mixed-files': ['These files do not go together', 'Open one video, or several images of one sequence, but not both.'],
  'many-videos': [
    'This page takes one video at a time',
    'Open them one by one. The command line takes several: “tracecut segment a.mp4 b.mp4 --out masks”.',
  ],
  'other-frames': ['The clip gives other frames than before', 'Run it again, then save it.'],
  'one-frame': [
    'There is only one frame',
    'Motion needs at least two pictures of the same scene. Open a longer video, or choose all images of a sequence.',
  ],
  animated: [
    'This browser cannot take animated images apart',
    'Convert it to MP4 (H.264) or WebM, or open its frames as images.',
  ],
  'mixed-sizes': [
    'These images differ in size',
    'All images of a sequence must have the same width and height. Leave out the ones that differ.',
  ],
  'no-project': [
    'This is no project of TraceCut',
    'Open the video itself, or a file that was saved here as a project.',
  ],
  'too-large-to-keep': ['The clip is too large to keep', 'Save the project as a file before you leave.'],
  'no-frames': ['No frame could be read', 'Choose an earlier start, or convert the video to MP4 (H.264) or WebM.'],
  unsupported: [
    'This browser is too old for TraceCut',
    'It needs WebAssembly with SIMD: Chrome or Edge 91, Firefox 89, Safari 16.4, or newer.',
  ],
  'wasm-load': [
    'The segmentation code did not load',
    'Reload the page. If that does not help, the site is incomplete: the folder “dist” must lie beside the page.',
  ],
  'too-few-frames': [
    'There are too few frames',
    'Motion needs at least two pictures of the same scene. Choose more frames, or an earlier start.',
  ],
  'frame-size': ['These frames have a size that cannot be processed', 'Choose another working size under “Clip”.'],
  'too-large': ['There is more than can be processed at once', 'Choose fewer frames, or smaller pictures.'],
  'frame-size-changed': ['The frames change size on the way', 'Use a video or images of one size.'],
  param: ['A setting has a value that does not work', 'Reset it under “Settings”, then run again.'],
  data: ['The computation met values that it cannot use', 'Reset the settings, or choose other frames, and run again.'],
  state: ['Something was asked for that is not there any more', 'Run it again.'],
  busy: ['Something else is still under way', 'Wait a moment, then run it again.'],
  closed: ['The run was ended', 'Run it again.'],
  'frame-bytes': ['A frame is incomplete', 'Convert the video to MP4 (H.264) or WebM, or choose other frames.'],
  decode: ['A file cannot be decoded', 'Use whole PNG or JPEG files.'],
  codec: ['This browser cannot decode this video', 'Convert it to MP4 (H.264) or WebM, or try another browser.'],
  'no-video': ['There is no picture in this file', 'Open a video file: MP4, WebM, MOV or MKV.'],
  truncated: ['This file is cut off or damaged', 'Choose frames before the damage, or copy or convert the file again.'],
  fetch: ['The file cannot be read', 'Copy it to this device, and open it again.'],
  'no-place': [
    'No part was chosen',
    'Click the part of the object that is another thing, then split; what was missed is added by “Add”.',
  ],
  unfinished: ['The clip was not segmented to its end', 'Run it again, to the end.'],
  poisoned: [
    'The computation broke down',
    'Run it again; if it happens again, choose fewer frames or a smaller working size. Other clips are not affected.',
  ],
  memory: ['The computation ran out of memory', 'Choose fewer frames or a smaller working size under “Clip”.'],
};

/** What a run does, in the words of the headline, by stages. */
const DOING: Record<string, string> = {
  frames: 'Reading frames',
  windows: 'Finding what moves',
  flow: 'Following what moves',
  trajectories: 'Following what moves',
  superpixels: 'Drawing the outlines',
  cut: 'Drawing the outlines',
  masks: 'Drawing the outlines',
  boundaries: 'Drawing the outlines',
  imageEdges: 'Drawing the outlines',
  other: 'Finding what moves together',
};

export const doing = (stage: string) => DOING[stage] ?? DOING.other;

/** What the page says about an image that is alone. */
export const STILL = {
  headline: 'A still image, and its boundaries',
  remark: 'One picture shows no motion. To see what moves, open a video, or all images of a sequence.',
};

/** What the page says about the first look at a clip. */
export const PREVIEW = {
  live: 'A coarse preview of the first frames is shown until their masks are there.',
};

/** What the page says about a clip that was taken window by window. */
export const LONG = {
  remark: (window: number) => `Taken in windows of ${window} frames; objects keep their numbers.`,
  nothing: 'Nothing in this clip moves differently from the background.',
  partial: (done: number, all: number) =>
    `Stopped early: ${done} of ${all} frames have masks, and can be saved. “Continue” goes on from there.`,
};

/** A file that ends in damage, and what was taken of it. */
export function damageWords({ frames, total }: { frames: number; total: number | null }): string {
  return total !== null && total > frames
    ? `The file is cut off or damaged. ${count(frames)} of ${count(total)} frames come before that: these were taken.`
    : `The file is cut off or damaged. ${count(frames)} frames come before that: these were taken.`;
}

/** What files are to be converted to. */
const FORMATS = /MP4 \(H\.264\)( \S+ WebM)?/;

/** @param playsMp4 whether there is a decoder for H.264: some browsers have none, and are not told to use it */
export function explain(
  error: unknown,
  playsMp4 = true,
): { code: string; title: string; advice: string; detail: string } {
  const code = (error as { code?: unknown })?.code;
  const detail = error instanceof Error ? error.message : String(error);
  const told = ([title, advice]: [string, string]) => ({
    title,
    advice: playsMp4 ? advice : advice.replace(FORMATS, 'WebM'),
  });
  const known = typeof code === 'string' ? ADVICE[code] : undefined;
  if (known) return { code: String(code), ...told(known), detail: detail === code ? '' : detail };
  if (error instanceof RangeError) return { code: 'memory', ...told(ADVICE.memory), detail };
  return {
    code: typeof code === 'string' ? code : 'unknown',
    title: 'Something went wrong',
    advice: 'Run it again, or open the sample. The browser’s console has the details.',
    detail,
  };
}

/** Writes a number with narrow spaces between thousands: `1 234`. */
export function count(n: number): string {
  return Math.round(n)
    .toString()
    .replace(/\B(?=(\d{3})+$)/g, '\u202f');
}

/** Returns `1 frame`, `2 frames`. */
export function plural(n: number, one: string, many = `${one}s`): string {
  return `${count(n)} ${n === 1 ? one : many}`;
}

/** Returns `840 KB`, `12.3 MB`. */
export function bytes(n: number): string {
  return n < 1e6 ? `${Math.max(1, Math.round(n / 1e3))}\u00a0KB` : `${(n / 1e6).toFixed(1)}\u00a0MB`;
}

/** Returns `0.4 s`, `12.3 s`, `2 min 5 s`. */
export function seconds(ms: number): string {
  const s = ms / 1000;
  if (s < 100) return `${s.toFixed(1)}\u00a0s`;
  return `${Math.floor(s / 60)}\u00a0min ${Math.round(s % 60)}\u00a0s`;
}

/** Returns `about 12 s left`: coarser, the more there is. */
export function remaining(ms: number): string {
  const s = ms / 1000;
  if (s < 1.5) return 'almost done';
  if (s > 90) return `about ${Math.round(s / 60)}\u00a0min left`;
  return `about ${s > 20 ? 5 * Math.round(s / 5) : Math.round(s)}\u00a0s left`;
}

/** Returns `, 0.8 s`; empty where frames have no time. */
export function atTime(times: Times, frame: number): string {
  return times.seconds ? `, ${times.at(frame)}` : '';
}

/**
 * @param share in 0..1
 * @returns `62 %`, `0.4 %`
 */
export function percent(share: number): string {
  const p = share * 100;
  return `${p > 0 && p < 9.95 ? p.toFixed(1) : Math.round(p)}\u00a0%`;
}

/** What the page sees, in one sentence. */
export function headline(
  result: { objects: readonly object[] | null; clusters: { count: number }; trajectories: { count: number } },
  facts: Facts[],
): string {
  if (result.trajectories.count === 0) return 'Nothing to follow';
  return countObjects(facts);
}

export function countObjects(facts: Facts[]): string {
  const objects = facts.filter(({ object, first }) => object > 0 && first >= 0).length;
  if (objects < 1) return 'No motion that differs from the background';
  return `${plural(objects, 'moving object')} and the background`;
}

/**
 * Why the result holds no moving object; empty when it does. What to do about it are buttons, see panels/nothing.ts.
 */
export function remark(result: {
  objects: readonly object[] | null;
  clusters: { count: number };
  trajectories: { count: number };
}): string {
  if (result.trajectories.count === 0) {
    return 'The pictures have no texture that could be followed.';
  }
  if (result.clusters.count < 2) {
    return 'Everything moves alike, or nothing moves.';
  }
  if (result.objects?.length === 0) {
    return 'There are several motions, but each goes with the background.';
  }
  return '';
}
