// Saves files at once, or streams them to disk if the browser can.

import { h } from './dom.js';

/** Time until the URL of a saved file is released, in milliseconds; chosen by eye. */
const URL_LIFETIME_MS = 60_000;

/** The browser's file picker, where it exists. */
type Picker = (options: { suggestedName: string }) => Promise<{ createWritable: () => Promise<WritableStream> }>;

/**
 * Chooses the destination of a stream: a picked file, or memory. Needs a recent click.
 * @returns saves a stream and resolves to its size in bytes
 */
export async function chooseDestination(
  file: string,
  type: string,
): Promise<(stream: ReadableStream<Uint8Array<ArrayBuffer>>, signal: AbortSignal) => Promise<number>> {
  const pick = (globalThis as { showSaveFilePicker?: Picker }).showSaveFilePicker;
  if (!pick)
    return async (stream) => {
      // Browsers store large blobs on disk.
      const blob = await new Response(stream, { headers: { 'Content-Type': type } }).blob();
      download(blob, file);
      return blob.size;
    };
  const handle = await pick.call(globalThis, { suggestedName: file });
  return async (stream, signal) => {
    let size = 0;
    const counted = stream.pipeThrough(
      new TransformStream({
        transform(piece, controller) {
          size += piece.length;
          controller.enqueue(piece);
        },
      }),
    );
    // Unfinished files are discarded.
    await counted.pipeTo(await handle.createWritable(), { signal });
    return size;
  };
}

export function download(blob: Blob, file: string) {
  const url = URL.createObjectURL(blob);
  h('a', { href: url, download: file }).click();
  setTimeout(() => URL.revokeObjectURL(url), URL_LIFETIME_MS);
}
