// Settings in a link, and what it takes to get the same result again.

import type { Job } from './job.js';
import type { Settings } from './settings.js';

/** @returns the page's address with what differs from the defaults */
export function linkOf(changed: ReadonlyMap<string, unknown>, href: string): string {
  const query = new URLSearchParams([...changed].sort().map(([name, value]) => [name, String(value)]));
  return `${href.replace(/#.*/, '')}${changed.size > 0 ? `#${query}` : ''}`;
}

/**
 * Takes settings from a link; what is unknown or not legal is passed over.
 * @param hash with its `#`
 */
export function readLink(settings: Settings, hash: string) {
  for (const [name, text] of new URLSearchParams(hash.slice(1))) {
    const kind = settings.parameters.get(name)?.kind;
    if (kind === 'boolean') settings.set(name, text === 'true');
    else if (kind === 'choice') settings.set(name, text);
    else if (kind && text !== '') settings.set(name, Number(text));
  }
}

/** @param run.version of the package */
export async function recipeOf({
  version,
  job,
  masks,
  corrections,
}: {
  version: string;
  job: Job;
  masks: { numFrames: number; labels: (t: number) => Uint8Array };
  corrections: number;
}): Promise<string> {
  const { source, take, options } = job;
  return JSON.stringify(
    {
      tracecut: version,
      clip: { name: source.name, width: source.width, height: source.height },
      take,
      parameters: options,
      ...(corrections > 0 ? { corrections } : {}),
      masks: { frames: masks.numFrames, sha256: await digest(masks) },
    },
    null,
    2,
  );
}

/** Returns the SHA-256 of the SHA-256 of each frame's labels; null where the browser offers none. */
async function digest(masks: { numFrames: number; labels: (t: number) => Uint8Array }): Promise<string | null> {
  if (!globalThis.crypto?.subtle) return null;
  const all = new Uint8Array(32 * masks.numFrames);
  for (let t = 0; t < masks.numFrames; t++) {
    all.set(new Uint8Array(await crypto.subtle.digest('SHA-256', new Uint8Array(masks.labels(t)))), 32 * t);
  }
  const sum = new Uint8Array(await crypto.subtle.digest('SHA-256', all));
  return [...sum].map((byte) => byte.toString(16).padStart(2, '0')).join('');
}
