// Links with settings, and recipes to reproduce a result.

import type { ClipJob } from './clip-job.js';
import type { Settings } from './settings.js';

/** Returns the page's address with the changed settings. */
export function settingsLink(changed: ReadonlyMap<string, unknown>, href: string): string {
  const query = new URLSearchParams([...changed].sort().map(([name, value]) => [name, String(value)]));
  return `${href.replace(/#.*/, '')}${changed.size > 0 ? `#${query}` : ''}`;
}

/**
 * Reads settings from a link and ignores invalid ones.
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

/** Returns the settings and hashes that reproduce a result, as JSON. */
export async function createRecipe({
  version,
  job,
  masks,
  corrections,
}: {
  version: string;
  job: ClipJob;
  masks: { numFrames: number; labels: (t: number) => Uint8Array };
  corrections: number;
}): Promise<string> {
  const { source, trim, options } = job;
  return JSON.stringify(
    {
      tracecut: version,
      clip: { name: source.name, width: source.width, height: source.height },
      trim,
      parameters: options,
      ...(corrections > 0 ? { corrections } : {}),
      masks: { frames: masks.numFrames, sha256: await digestMasks(masks) },
    },
    null,
    2,
  );
}

/** Returns the SHA-256 of the frames' SHA-256 digests; null if not available. */
async function digestMasks(masks: { numFrames: number; labels: (t: number) => Uint8Array }): Promise<string | null> {
  if (!globalThis.crypto?.subtle) return null;
  const digests = new Uint8Array(32 * masks.numFrames);
  for (let t = 0; t < masks.numFrames; t++) {
    digests.set(new Uint8Array(await crypto.subtle.digest('SHA-256', new Uint8Array(masks.labels(t)))), 32 * t);
  }
  const combined = new Uint8Array(await crypto.subtle.digest('SHA-256', digests));
  return [...combined].map((byte) => byte.toString(16).padStart(2, '0')).join('');
}
