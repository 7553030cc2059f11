// The link to the lab, which opens the clip that is open here.

import { byId } from '../dom.js';
import type { Source, Take } from '../../model/source.js';
import type { Page } from '../page.js';

/** Cache in which the lab looks for the clip. */
const CACHE = 'tracecut-lab';

export function labPanel({ store }: Pick<Page, 'store'>) {
  const link = byId<HTMLAnchorElement>('lab-open');
  link.addEventListener('click', async (event) => {
    const { source, take } = store.state;
    if (!source?.files) return;
    event.preventDefault();
    // Without storage the lab opens its sample.
    const isKept = await handOver(source, take).then(
      () => true,
      () => false,
    );
    location.href = isKept ? `${link.href}#clip` : link.href;
  });
}

/** Stores the files of a clip, and the time at which the part of it that is taken starts, in seconds. */
async function handOver({ files = [], times, fps }: Source, { start }: Take) {
  // Images have no times: those before the part stay here.
  const [taken, seconds] = files.length > 1 ? [files.slice(start), 0] : [files, times?.[start] ?? start / fps];
  await caches.delete(CACHE);
  const cache = await caches.open(CACHE);
  for (const [k, file] of taken.entries()) {
    const headers = { 'content-type': file.type, 'x-name': encodeURIComponent(file.name), 'x-start': String(seconds) };
    await cache.put(`./lab/clip-${k}`, new Response(file, { headers }));
  }
}
