// `node scripts/site.mjs [folder]`: the page as a folder for any static host (out/site if not given); works from any
// sub-path.

import { cpSync, mkdirSync, rmSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { build } from './build.mjs';
import { precacheList, serviceWorker } from './precache.mjs';
import { root } from './tools.mjs';

const target = resolve(process.argv[2] ?? join(root, 'out', 'site'));
await build();
for (const name of precacheList().files.filter((file) => file !== './')) {
  const from = name.startsWith('./dist/') ? join(root, name) : join(root, 'www', name);
  const to = join(target, name);
  rmSync(to, { force: true });
  mkdirSync(join(to, '..'), { recursive: true });
  cpSync(from, to);
}
writeFileSync(join(target, 'service-worker.js'), serviceWorker());
console.log(`The site is in ${target}.`);
