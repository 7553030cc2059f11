// Messages of the page: formatted numbers, headlines, and errors with advice.

import type { ObjectFacts, Times } from './presence.js';

/** An error of the page (the package has `TraceCutError`); both have a `code`. */
export class PageError extends Error {
  name = 'PageError';

  /**
   * @param code a key of {@link ADVICE}
   * @param detail shown below the advice
   */
  constructor(
    public code: string,
    detail = '',
  ) {
    super(detail || code);
  }
}

/** Title and advice for each error code of the page and the package. */
const ADVICE: Record<string, [string, string]> = {
  'unreadable-video': [
    'Can’t play this video',
    'The browser has no decoder for it, or the file is damaged. Convert it to MP4 (H.264) or WebM, or try another browser.',
  ],
  'unreadable-image': ['Can’t read one of these images', 'Use PNG, JPEG, WebP or GIF files, without the damaged one.'],
  'unknown-file': ['Not a video or an image', 'Open a video (MP4, WebM, …), an animated GIF or an image sequence.'],
  'one-image': ['One picture has no motion', 'Open a video, or all frames of a folder at once.'],
  'mixed-files': ['Videos and images together', 'Open one video or one image sequence, not both.'],
  'many-videos': [
    'One video at a time',
    'Open them one by one, or use the command line: “tracecut segment a.mp4 b.mp4 --out masks”.',
  ],
  'other-frames': ['The clip has changed', 'Run again, then save.'],
  'one-frame': [
    'Only one frame',
    'Motion needs at least two frames of the same scene. Open a longer video or a whole image sequence.',
  ],
  animated: [
    'This browser can’t read animated images',
    'Convert it to MP4 (H.264) or WebM, or open its frames as images.',
  ],
  'mixed-sizes': ['Images of different sizes', 'Use images of the same width and height.'],
  'no-project': ['Not a TraceCut project', 'Open the video itself, or a project file saved here.'],
  'too-large-to-keep': ['The clip is too large to store', 'Save the project as a file before you leave.'],
  'no-frames': ['No frame could be read', 'Choose an earlier start, or convert the video to MP4 (H.264) or WebM.'],
  unsupported: [
    'This browser is too old',
    'TraceCut needs WebAssembly SIMD: Chrome or Edge 91, Firefox 89, Safari 16.4, or newer.',
  ],
  'wasm-load': [
    'TraceCut did not load',
    'Reload the page. If that doesn’t help, the site is incomplete: the folder “dist” must be next to the page.',
  ],
  'too-few-frames': [
    'Too few frames',
    'Motion needs at least two frames of the same scene. Choose more frames or an earlier start.',
  ],
  'frame-size': ['Unsupported frame size', 'Choose another working size under “Clip”.'],
  'too-large': ['Too much to process at once', 'Choose fewer or smaller frames.'],
  'frame-size-changed': ['The frame size changes midway', 'Use a video or images of one size.'],
  param: ['Invalid setting', 'Reset it under “Settings”, then run again.'],
  data: ['Invalid values in the computation', 'Reset the settings or choose other frames, then run again.'],
  state: ['No longer available', 'Run again.'],
  busy: ['Still busy', 'Wait a moment, then try again.'],
  closed: ['The run was stopped', 'Run again.'],
  'frame-bytes': ['Incomplete frame', 'Convert the video to MP4 (H.264) or WebM, or choose other frames.'],
  decode: ['Can’t decode this file', 'Use intact PNG or JPEG files.'],
  codec: ['This browser can’t decode this video', 'Convert it to MP4 (H.264) or WebM, or try another browser.'],
  'no-video': ['No video in this file', 'Open a video file: MP4, WebM, MOV or MKV.'],
  truncated: ['The file is damaged', 'Choose frames before the damage, or copy or convert the file again.'],
  fetch: ['Can’t read the file', 'Copy it to this device and open it again.'],
  'no-place': ['No part selected', 'Click the part to split off first. Use “Add” for missing objects.'],
  unfinished: ['The run is not finished', 'Run it to the end.'],
  poisoned: ['The computation failed', 'Run again. If it fails again, choose fewer frames or a smaller working size.'],
  memory: ['Out of memory', 'Choose fewer frames or a smaller working size under “Clip”.'],
};

const STAGE_NAMES: Record<string, string> = {
  frames: 'Reading frames',
  windows: 'Finding objects',
  flow: 'Tracking motion',
  trajectories: 'Tracking motion',
  superpixels: 'Drawing outlines',
  cut: 'Drawing outlines',
  masks: 'Drawing outlines',
  other: 'Grouping motion',
};

export const stageName = (stage: string) => STAGE_NAMES[stage] ?? STAGE_NAMES.other;

export const PREVIEW_MESSAGES = {
  live: 'Coarse preview of the first frames.',
};

export const CLIP_MESSAGES = {
  remark: (window: number) => `windows of ${window} frames`,
  nothing: 'Nothing stands out from the background.',
  partial: (done: number, all: number) =>
    `Stopped early: ${done} of ${all} frames are ready to save. Continue to finish.`,
};

export function describeDamage({ frames, total }: { frames: number; total: number | null }): string {
  return total !== null && total > frames
    ? `The file is damaged: the first ${formatCount(frames)} of ${formatCount(total)} frames were used.`
    : `The file is damaged: the first ${formatCount(frames)} frames were used.`;
}

/** The formats that advice suggests. */
const SUGGESTED_FORMATS = /MP4 \(H\.264\)( \S+ WebM)?/;

/**
 * Returns title and advice for an error.
 * @param playsMp4 true if the browser can decode H.264; otherwise it is not suggested
 */
export function explain(
  error: unknown,
  playsMp4 = true,
): { code: string; title: string; advice: string; detail: string } {
  const code = (error as { code?: unknown })?.code;
  const detail = error instanceof Error ? error.message : String(error);
  const toMessage = ([title, advice]: [string, string]) => ({
    title,
    advice: playsMp4 ? advice : advice.replace(SUGGESTED_FORMATS, 'WebM'),
  });
  const advice = typeof code === 'string' ? ADVICE[code] : undefined;
  if (advice) return { code: String(code), ...toMessage(advice), detail: detail === code ? '' : detail };
  if (error instanceof RangeError) return { code: 'memory', ...toMessage(ADVICE.memory), detail };
  return {
    code: typeof code === 'string' ? code : 'unknown',
    title: 'Something went wrong',
    advice: 'Run again or open the sample. The browser console has details.',
    detail,
  };
}

/** Writes a number with commas between thousands: `1,234`. */
export function formatCount(n: number): string {
  return Math.round(n)
    .toString()
    .replace(/\B(?=(\d{3})+$)/g, ',');
}

/** Returns `1 frame`, `2 frames`. */
export function formatPlural(n: number, singular: string, pluralNoun = `${singular}s`): string {
  return `${formatCount(n)} ${n === 1 ? singular : pluralNoun}`;
}

/** Returns `840 KB`, `12.3 MB`. */
export function formatBytes(n: number): string {
  return n < 1e6 ? `${Math.max(1, Math.round(n / 1e3))}\u00a0KB` : `${(n / 1e6).toFixed(1)}\u00a0MB`;
}

/** Returns `0.4 s`, `12.3 s`, `2 min 5 s`. */
export function formatSeconds(ms: number): string {
  const s = ms / 1000;
  if (s < 100) return `${s.toFixed(1)}\u00a0s`;
  return `${Math.floor(s / 60)}\u00a0min ${Math.round(s % 60)}\u00a0s`;
}

/** Returns `about 12 s left`, rounded more coarsely for longer times. */
export function formatTimeLeft(ms: number): string {
  const s = ms / 1000;
  if (s < 1.5) return 'almost done';
  if (s > 90) return `about ${Math.round(s / 60)}\u00a0min left`;
  return `about ${s > 20 ? 5 * Math.round(s / 5) : Math.round(s)}\u00a0s left`;
}

/** Returns `, 0.8 s`; empty if frames have no times. */
export function formatFrameTime(times: Times, frame: number): string {
  return times.seconds ? `, ${times.format(frame)}` : '';
}

/**
 * @param share in 0..1
 * @returns `62%`, `0.4%`
 */
export function formatPercent(share: number): string {
  const p = share * 100;
  return `${p > 0 && p < 9.95 ? p.toFixed(1) : Math.round(p)}%`;
}

export function headline(
  result: { objects: readonly object[]; clusters: { count: number }; trajectories: { count: number } },
  facts: ObjectFacts[],
): string {
  if (result.trajectories.count === 0) return 'Nothing to track';
  return countObjects(facts);
}

export function countObjects(facts: ObjectFacts[]): string {
  const objects = facts.filter(({ object, first }) => object > 0 && first >= 0).length;
  if (objects < 1) return 'No moving objects';
  return formatPlural(objects, 'moving object');
}

/** Explains a result without moving objects; empty if it has some. `suggestChanges` says what to try. */
export function remark(result: {
  objects: readonly object[];
  clusters: { count: number };
  trajectories: { count: number };
}): string {
  if (result.trajectories.count === 0) {
    return 'The frames have too little texture to track.';
  }
  if (result.clusters.count < 2) {
    return 'Everything moves together, or nothing moves.';
  }
  if (result.objects.length === 0) {
    return 'There are several motions, but none stands out.';
  }
  return '';
}
