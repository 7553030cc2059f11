// The link to the lab, which opens the clip that is open here.

import { byId } from '../dom.js';
import type { Source, Trim } from '../../model/source.js';
import type { Page } from '../page.js';

/** Cache that the lab reads the clip from. */
const CACHE = 'tracecut-lab';

export function labPanel({ store }: Pick<Page, 'store'>) {
  const link = byId<HTMLAnchorElement>('lab-open');
  link.addEventListener('click', async (event) => {
    const { source, trim } = store.state;
    if (!source?.files) return;
    event.preventDefault();
    // Without storage the lab opens its sample.
    const isKept = await handOver(source, trim).then(
      () => true,
      () => false,
    );
    location.href = isKept ? `${link.href}#clip` : link.href;
  });
}

/** Stores the files of a clip, and the start of the trim in seconds. */
async function handOver({ files = [], times, fps }: Source, { start }: Trim) {
  // Images have no times: those before the start are left out.
  const [sentFiles, seconds] = files.length > 1 ? [files.slice(start), 0] : [files, times?.[start] ?? start / fps];
  await caches.delete(CACHE);
  const cache = await caches.open(CACHE);
  for (const [k, file] of sentFiles.entries()) {
    const headers = { 'content-type': file.type, 'x-name': encodeURIComponent(file.name), 'x-start': String(seconds) };
    await cache.put(`./lab/clip-${k}`, new Response(file, { headers }));
  }
}
