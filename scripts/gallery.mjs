// `node scripts/gallery.mjs [names]`: renews the page's gallery, www/demo/gallery/, or these clips of it. Paints the
// scenes, encodes them, runs the package over the files with its usual settings, and saves what it found as projects.
// Pictures to look at go to out/gallery/.

import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { launchBrowser } from './browser.mjs';
import { build } from './build.mjs';
import { SCENES } from './gallery/scenes.mjs';
import { serve } from './serve.mjs';
import { root } from './tools.mjs';

const FOLDER = join(root, 'www', 'demo', 'gallery');
const LOOKS = join(root, 'out', 'gallery');

/** A blank page of the server's, with what makes clips beside it. */
async function pageAt(url, browser) {
  const page = await browser.newPage();
  await page.route(`${url}gallery-maker/*`, (route) => {
    const name = new URL(route.request().url()).pathname.split('/').pop();
    if (!name) return route.fulfill({ contentType: 'text/html', body: '<!doctype html><title>gallery</title>' });
    const body = readFileSync(join(root, 'scripts', 'gallery', name));
    return route.fulfill({ contentType: 'text/javascript', body });
  });
  await page.goto(`${url}gallery-maker/`);
  return page;
}

/** Runs in the page: one clip, its files as Base64. */
async function made(id) {
  const { makeClip } = await import('/gallery-maker/make.mjs');
  return makeClip(id);
}

const only = process.argv.slice(2);
await build();
for (const folder of [FOLDER, LOOKS]) mkdirSync(folder, { recursive: true });
const [server, browser] = [await serve(), await launchBrowser()];
const index = join(FOLDER, 'index.json');
try {
  const page = await pageAt(server.url, browser);
  const before = only.length > 0 ? JSON.parse(readFileSync(index, 'utf8')).clips : [];
  const clips = [];
  for (const { id, objects } of SCENES) {
    const old = before.find((clip) => clip.id === id);
    if (only.length > 0 && !only.includes(id)) {
      if (old) clips.push(old);
      continue;
    }
    const { facts, files, look } = await page.evaluate(made, id);
    for (const [name, base64] of Object.entries(files))
      writeFileSync(join(FOLDER, name), Buffer.from(base64, 'base64'));
    writeFileSync(join(LOOKS, `${id}.png`), Buffer.from(look, 'base64'));
    console.log(
      `${id}: ${facts.objects} objects (${objects} wanted), ${(facts.bytes / 1000).toFixed(0)} KB`,
      facts.sizes,
    );
    delete facts.sizes;
    clips.push(facts);
  }
  writeFileSync(index, `${JSON.stringify({ clips }, null, 2)}\n`);
} finally {
  await browser.close();
  await server.close();
}
