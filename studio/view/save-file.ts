// Files as they are saved: at once, or piece by piece as they are made, straight to the disk where the browser can.

import { h } from './dom.js';

/** How long a file that was saved stays in memory for the browser to read, in milliseconds. */
const KEPT_MS = 60_000;

/** The part of the browser's file picker that is used; not every browser has one. */
type Picker = (options: { suggestedName: string }) => Promise<{ createWritable: () => Promise<WritableStream> }>;

/**
 * Where a stream goes: a file that the user chooses, or memory. To be asked while a click is fresh.
 * @returns saves it and gives its size in bytes
 */
export async function placeFor(
  file: string,
  type: string,
): Promise<(stream: ReadableStream<Uint8Array<ArrayBuffer>>, signal: AbortSignal) => Promise<number>> {
  const pick = (globalThis as { showSaveFilePicker?: Picker }).showSaveFilePicker;
  if (!pick)
    return async (stream) => {
      // The browser keeps what is large on the disk.
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
    // A file that is not finished is not kept.
    await counted.pipeTo(await handle.createWritable(), { signal });
    return size;
  };
}

export function download(blob: Blob, file: string) {
  const url = URL.createObjectURL(blob);
  h('a', { href: url, download: file }).click();
  setTimeout(() => URL.revokeObjectURL(url), KEPT_MS);
}
